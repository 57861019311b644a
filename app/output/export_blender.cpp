#include "app/output/export_blender.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include <fmt/format.h>

#include "app/output/fields.h"
#include "app/output/vector_json.h"
#include "renderer/core/check.h"

namespace pathfit::app {
namespace {

using renderer::Camera;
using renderer::Mat3;
using renderer::Scene;
using renderer::Transform;
using renderer::Vec3;

Json CameraJson(const Camera& camera) {
  const Transform pose = renderer::CameraPose(camera);
  return {{"name", camera.name},
          {"size", Json::array({camera.width, camera.height})},
          {"focal", camera.fx},
          {"aspect", camera.fy / camera.fx},
          {"centre", Json::array({camera.cx, camera.cy})},
          {"parallel", camera.projection == renderer::ProjectionKind::kOrthographic},
          {"rotation", RowsJson(pose.linear)},
          {"position", Components(pose.translation)},
          {"exposure", std::log2(camera.gain)}};
}

/// Null for what the script does not set up.
Json LightJson(const renderer::Emitter& emitter) {
  const Mat3 turn = renderer::RotationFromVector(emitter.rotation);
  Json light = {{"name", emitter.name},
                {"follows", emitter.frame == renderer::LightFrame::kCamera}};
  if (const auto* environment = std::get_if<renderer::EnvironmentEmitter>(&emitter.light)) {
    light["type"] = "environment";
    light["rotation"] = RowsJson(turn * environment->frame_from_light);
  } else if (const auto* point = std::get_if<renderer::PointEmitter>(&emitter.light)) {
    light["type"] = "point";
    light["position"] = Components(point->position);
    light["intensity"] = Components(point->intensity);
  } else if (const auto* sun = std::get_if<renderer::DirectionalEmitter>(&emitter.light)) {
    light["type"] = "sun";
    light["direction"] = Components(turn * sun->direction);
    light["intensity"] = Components(sun->irradiance);
  } else {
    return nullptr;
  }
  return light;
}

// What follows DATA in the script.
constexpr const char* kScript = R"py(

import math
import os
import sys

import bpy
import numpy
from mathutils import Matrix, Vector

if "bool" not in vars(numpy):
    numpy.bool = bool  # Blender 3.4's glTF import asks for it, and newer NumPy has dropped it

HERE = os.path.dirname(os.path.abspath(__file__))
# Ours is y up, Blender's z: as its glTF import turns meshes.
UP = Matrix(((1, 0, 0), (0, 0, -1), (0, 1, 0)))
# Blender's panorama begins a quarter turn from ours.
QUARTER = Matrix.Rotation(math.pi / 2, 3, "Z")

scene = bpy.data.scenes.new("pathfit")
bpy.context.window.scene = scene


def keep(owner, path, frame, index=-1):
    owner.keyframe_insert(path, index=index, frame=frame)


def hold(owner):
    """Values jump from frame to frame: every frame is another photo."""
    for curve in owner.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT"


def add_meshes():
    for mesh in DATA["meshes"]:
        bpy.ops.import_scene.gltf(filepath=os.path.join(HERE, mesh["file"]))
        for item in bpy.context.selected_objects:
            if item.type != "MESH":
                continue
            for slot in item.material_slots:
                set_up_material(slot.material, item.data, mesh)


def set_up_material(material, data, mesh):
    material.use_backface_culling = False
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    colour = shader.inputs["Base Color"]
    if data.color_attributes and not colour.is_linked:
        attribute = nodes.new("ShaderNodeVertexColor")
        attribute.layer_name = data.color_attributes[0].name
        links.new(attribute.outputs["Color"], colour)
    if mesh["matt"]:
        # Fitted as ideally diffuse; the other shader's diffuse part is brighter where it is grazed.
        matt = nodes.new("ShaderNodeBsdfDiffuse")
        matt.inputs["Color"].default_value = colour.default_value
        if colour.is_linked:
            links.new(colour.links[0].from_socket, matt.inputs["Color"])
        output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
        links.new(matt.outputs["BSDF"], output.inputs["Surface"])
    if "radiance" in mesh:
        set_up_area_light(nodes, links, shader, mesh)


def set_up_area_light(nodes, links, shader, mesh):
    if "Emission Strength" in shader.inputs:
        shader.inputs["Emission Strength"].default_value = 0.0  # what the file says is set up here
    strength = max(mesh["radiance"])
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = strength
    if strength > 0:
        emission.inputs["Color"].default_value = [value / strength for value in mesh["radiance"]] + [1.0]
    shines = emission.outputs["Emission"]
    if not mesh["two_sided"]:
        front = nodes.new("ShaderNodeMixShader")  # nothing in the other place: black
        links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], front.inputs["Fac"])
        links.new(shines, front.inputs[1])
        shines = front.outputs["Shader"]
    surface = next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"]
    both = nodes.new("ShaderNodeAddShader")
    links.new(surface.links[0].from_socket, both.inputs[0])
    links.new(shines, both.inputs[1])
    links.new(both.outputs["Shader"], surface)


def rotation_of(camera):
    return UP @ Matrix(camera["rotation"])


def add_cameras():
    for frame, camera in enumerate(DATA["cameras"], 1):
        width, height = camera["size"]
        data = bpy.data.cameras.new(camera["name"])
        data.sensor_fit = "HORIZONTAL"
        if camera["parallel"]:
            data.type = "ORTHO"
            data.ortho_scale = width / camera["focal"]
        else:
            data.sensor_width = 36.0
            data.lens = 36.0 * camera["focal"] / width
        data.shift_x = (0.5 * width - camera["centre"][0]) / width
        data.shift_y = (camera["centre"][1] - 0.5 * height) / width
        data.clip_start, data.clip_end = DATA["near"], DATA["far"]
        data.display_size = DATA["camera_size"]
        item = bpy.data.objects.new(camera["name"], data)
        item.matrix_world = Matrix.Translation(UP @ Vector(camera["position"])) @ rotation_of(camera).to_4x4()
        scene.collection.objects.link(item)
        scene.timeline_markers.new(camera["name"], frame=frame).camera = item
        scene.view_settings.exposure = camera["exposure"]
        keep(scene, "view_settings.exposure", frame)
        if frame == 1:
            scene.camera = item
            render = scene.render
            render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
            # Pixels that are not square.
            render.pixel_aspect_x = max(1.0, camera["aspect"])
            render.pixel_aspect_y = max(1.0, 1.0 / camera["aspect"])
    hold(scene)


def add_environment(light):
    world = scene.world = bpy.data.worlds.new(light["name"])
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    picture = nodes.new("ShaderNodeTexEnvironment")
    picture.image = bpy.data.images.load(os.path.join(HERE, "environment.exr"))
    spaces = picture.image.colorspace_settings
    known = spaces.bl_rna.properties["name"].enum_items.keys()
    spaces.name = "Linear" if "Linear" in known else "Linear Rec.709"  # since 4.0
    mapping = nodes.new("ShaderNodeMapping")
    mapping.vector_type = "POINT"
    links.new(nodes.new("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], picture.inputs["Vector"])
    links.new(picture.outputs["Color"], nodes["Background"].inputs["Color"])
    turn = mapping.inputs["Rotation"]
    for frame, camera in enumerate(DATA["cameras"], 1):
        world_from_light = Matrix(light["rotation"])
        if light["follows"]:
            world_from_light = Matrix(camera["rotation"]) @ world_from_light
        look_up = QUARTER @ UP @ world_from_light.transposed() @ UP.transposed()
        turn.default_value = look_up.to_euler("XYZ")
        keep(turn, "default_value", frame)
        if not light["follows"]:
            break
    hold(world.node_tree)


def add_lamp(light):
    strength = max(light["intensity"])
    data = bpy.data.lights.new(light["name"], "SUN" if light["type"] == "sun" else "POINT")
    if strength > 0:
        data.color = [value / strength for value in light["intensity"]]
    # A sun has W/m2; the watts of a lamp spread over all directions.
    data.energy = strength if light["type"] == "sun" else 4 * math.pi * strength
    if light["type"] == "sun":
        data.angle = 0.0
    else:
        data.shadow_soft_size = 0.0
    item = bpy.data.objects.new(light["name"], data)
    scene.collection.objects.link(item)
    for frame, camera in enumerate(DATA["cameras"], 1):
        rotation, position = UP, Vector((0, 0, 0))
        if light["follows"]:
            rotation, position = rotation_of(camera), UP @ Vector(camera["position"])
        if light["type"] == "sun":
            item.rotation_euler = (rotation @ Vector(light["direction"])).to_track_quat("-Z", "Y").to_euler()
            keep(item, "rotation_euler", frame)
        else:
            item.location = rotation @ Vector(light["position"]) + position
            keep(item, "location", frame)
        if not light["follows"]:
            break
    hold(item)


def main():
    scene.render.engine = "CYCLES"
    scene.render.film_transparent = not DATA["environment_visible"]
    scene.view_settings.view_transform = "Standard"  # what was fitted; Filmic would be another picture
    scene.cycles.use_denoising = False  # not in every build
    scene.cycles.max_bounces = DATA["max_bounces"]
    scene.frame_start, scene.frame_end = 1, max(1, len(DATA["cameras"]))
    add_meshes()
    add_cameras()
    for light in DATA["lights"]:
        add_environment(light) if light["type"] == "environment" else add_lamp(light)
    scene.frame_set(1)
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    if words[:1] == ["--render"]:
        scene.frame_set(int(words[1]))
        scene.render.resolution_percentage = int(words[3]) if len(words) > 3 else 100
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.cycles.samples = 64
        scene.render.filepath = os.path.abspath(words[2])
        bpy.ops.render.render(write_still=True)


main()
)py";

}  // namespace

std::vector<std::string> BlenderGaps(const Scene& scene) {
  std::vector<std::string> gaps;
  for (const renderer::Emitter& emitter : scene.emitters) {
    if (const auto* area = std::get_if<renderer::AreaEmitter>(&emitter.light)) {
      if (area->texture >= 0) {
        gaps.push_back("light '" + emitter.name +
                       "' shines evenly in Blender: its texture is not set up there");
      }
    } else if (LightJson(emitter).is_null()) {
      gaps.push_back("light '" + emitter.name +
                     "' is not set up in Blender: only environments, points, directional and area "
                     "lights are");
    }
  }
  if (std::ranges::any_of(scene.sensors, [](const Camera& c) { return !c.lights_off.empty(); })) {
    gaps.emplace_back(
        "some lights shine in some of the photos only (lights.json says in which); in Blender all "
        "do in every frame");
  }
  const auto differs = [&](auto number) {
    return std::ranges::any_of(
        scene.sensors, [&](const Camera& c) { return number(c) != number(scene.sensors.front()); });
  };
  if (std::ranges::any_of(scene.sensors, [](const Camera& c) { return !c.distortion.IsNone(); })) {
    gaps.emplace_back("Blender's cameras have no lens distortion: its pictures are undistorted");
  }
  if (std::ranges::any_of(scene.sensors, [](const Camera& c) { return !c.vignetting.IsNone(); })) {
    gaps.emplace_back("Blender's cameras have no vignetting: its pictures are evenly bright");
  }
  if (differs([](const Camera& c) { return c.width; }) ||
      differs([](const Camera& c) { return c.height; })) {
    gaps.emplace_back("the photos have several sizes; Blender renders all in that of the first");
  }
  for (const renderer::Material& material : scene.materials) {
    if (!std::holds_alternative<renderer::LambertBsdf>(material.bsdf) &&
        !std::holds_alternative<renderer::MetallicRoughnessBsdf>(material.bsdf)) {
      gaps.push_back("material '" + material.name +
                     "' is of a kind that glTF does not have; Blender shows it matt");
    }
  }
  return gaps;
}

std::string BlenderScript(const Scene& scene,
                          const std::vector<std::string>& mesh_files,
                          int max_bounces) {
  PATHFIT_CHECK(mesh_files.size() == scene.meshes.size());
  Json data = {
      {"environment_visible", scene.environment_visible},
      {"max_bounces", std::max(0, max_bounces - 1)},  // Cycles counts reflections after the first
      {"meshes", Json::array()},
      {"cameras", Json::array()},
      {"lights", Json::array()}};
  double farthest = 0.0;
  for (std::size_t i = 0; i < mesh_files.size(); ++i) {
    const auto& material = scene.materials.at(static_cast<std::size_t>(scene.meshes[i].material));
    const bool matt = !std::holds_alternative<renderer::MetallicRoughnessBsdf>(material.bsdf);
    Json mesh = {{"file", mesh_files[i]}, {"matt", matt}};
    if (const renderer::AreaEmitter* area = AreaLightOf(scene, i)) {
      mesh["radiance"] = Components(area->intensity);
      mesh["two_sided"] = area->two_sided;
    }
    data["meshes"].push_back(std::move(mesh));
    for (const Vec3& p : renderer::WorldMesh(scene.meshes[i]).positions) {
      for (const Camera& camera : scene.sensors) {
        farthest = std::max(farthest, Norm(p - renderer::CameraPose(camera).translation));
      }
    }
  }
  data["near"] = 1e-4 * farthest;
  data["far"] = 10.0 * farthest;
  data["camera_size"] = 0.05 * farthest;
  for (const Camera& camera : scene.sensors) data["cameras"].push_back(CameraJson(camera));
  for (const renderer::Emitter& emitter : scene.emitters) {
    Json light = LightJson(emitter);
    if (!light.is_null()) data["lights"].push_back(std::move(light));
  }
  // JSON inside a Python string: names cannot leave it.
  return "\"\"\"Sets up a fitted scene in Blender: blender --python blender_setup.py\n\n"
         "Frame i is the view of photo i. In the background: blender -b --python "
         "blender_setup.py -- --render FRAME PICTURE.exr [PERCENT]\n\"\"\"\n"
         "import json\n\nDATA = json.loads(" +
         JsonText(Json(JsonText(data, -1)), -1) + ")" + kScript;
}

}  // namespace pathfit::app
