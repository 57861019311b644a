#include "app/output/export_result.h"

#include <cmath>
#include <optional>
#include <variant>

#include <fmt/format.h>

#include "app/output/export_cameras.h"
#include "app/output/report_images.h"
#include "app/output/run_directory.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/gltf_writer.h"
#include "renderer/io/image_file.h"
#include "renderer/io/ply_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using renderer::DirectionalEmitter;
using renderer::EnvironmentEmitter;
using renderer::Mat3;
using renderer::PointEmitter;
using renderer::Rgb;
using renderer::Scene;
using renderer::Vec3;

Json Components(const Rgb& c) { return Json::array({c.r, c.g, c.b}); }
Json Components(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }
Json RowsJson(const Mat3& m) {
  const Mat3 rows = renderer::Transposed(m);
  return Json::array({Components(rows.x), Components(rows.y), Components(rows.z)});
}

Json EnvironmentJson(const EnvironmentEmitter& environment, const Mat3& turn) {
  return {{"type", "environment"},
          {"size_px", Json::array({environment.width, environment.height})},
          {"files", Json::array({"environment.exr", "environment.hdr"})},
          {"file_values", "radiance: intensity times texels, linear Rec.709"},
          {"intensity", Components(environment.intensity)},
          {"frame_from_light", RowsJson(turn * environment.frame_from_light)},
          {"mapping",
           "a direction d in the light's own frame is at u = atan2(d.x, -d.z) / (2 pi) mod 1 from "
           "the left and v = acos(d.y) / pi from the top; frame_from_light (rows) turns d into "
           "`frame`"}};
}

// Name of the item, null without one.
template <class List>
Json NameIn(const List& list, int index) {
  return index < 0 ? Json() : Json(list.at(static_cast<std::size_t>(index)).name);
}

Json LightJson(const renderer::Emitter& emitter, const Scene& scene) {
  const Mat3 turn = renderer::RotationFromVector(emitter.rotation);
  if (const auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light)) {
    return EnvironmentJson(*environment, turn);
  }
  if (const auto* point = std::get_if<PointEmitter>(&emitter.light)) {
    return {{"type", "point"},
            {"position_m", Components(point->position)},
            {"intensity_w_per_sr", Components(point->intensity)}};
  }
  if (const auto* directional = std::get_if<DirectionalEmitter>(&emitter.light)) {
    return {{"type", "directional"},
            {"direction", Components(turn * directional->direction)},
            {"irradiance_w_per_m2", Components(directional->irradiance)}};
  }
  if (const auto* spot = std::get_if<renderer::SpotEmitter>(&emitter.light)) {
    return {{"type", "spot"},
            {"position_m", Components(spot->position)},
            {"direction", Components(turn * -spot->frame_from_light.z)},
            {"inner_angle_rad", spot->inner_angle},
            {"outer_angle_rad", spot->outer_angle},
            {"intensity_w_per_sr", Components(spot->intensity)}};
  }
  if (const auto* projector = std::get_if<renderer::ProjectorEmitter>(&emitter.light)) {
    return {{"type", "projector"},
            {"position_m", Components(projector->position)},
            {"frame_from_light", RowsJson(turn * projector->frame_from_light)},
            {"tan_half_size", Json::array({projector->tan_half_width, projector->tan_half_height})},
            {"intensity", Components(projector->intensity)},
            {"texture", NameIn(scene.textures, projector->texture)}};
  }
  const auto& area = std::get<renderer::AreaEmitter>(emitter.light);
  return {{"type", "area"},
          {"mesh", NameIn(scene.meshes, area.mesh)},
          {"radiance", Components(area.intensity)},
          {"texture", NameIn(scene.textures, area.texture)},
          {"two_sided", area.two_sided}};
}

renderer::Image TexelImage(int width,
                           int height,
                           const std::vector<Rgb>& texels,
                           const Rgb& scale) {
  renderer::Image image(width, height, 3);
  PATHFIT_CHECK(image.data.size() == 3 * texels.size());
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const Rgb value = scale * texels[i];
    for (int c = 0; c < 3; ++c) {
      image.data[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(value[c]);
    }
  }
  return image;
}

renderer::Image TextureImage(const renderer::Texture& texture) {
  return TexelImage(texture.width, texture.height, texture.texels, {1.0, 1.0, 1.0});
}

void WriteEnvironment(const fs::path& folder, const EnvironmentEmitter& environment) {
  const renderer::Image image =
      TexelImage(environment.width, environment.height, environment.texels, environment.intensity);
  renderer::WriteExr(folder / "environment.exr", image);
  renderer::WriteHdr(folder / "environment.hdr", image);
}

// The light that a mesh is, null if it does not shine.
const renderer::AreaEmitter* EmissionOf(std::size_t mesh, const Scene& scene) {
  for (const renderer::Emitter& emitter : scene.emitters) {
    const auto* area = std::get_if<renderer::AreaEmitter>(&emitter.light);
    if (area != nullptr && area->mesh == static_cast<int>(mesh)) return area;
  }
  return nullptr;
}

std::optional<renderer::Texture> TextureAt(int index, const Scene& scene) {
  if (index < 0) return std::nullopt;
  return scene.textures.at(static_cast<std::size_t>(index));
}

void WriteMesh(const fs::path& stem, std::size_t index, const Scene& scene) {
  const renderer::SceneMesh& scene_mesh = scene.meshes[index];
  const renderer::Material& material =
      scene.materials.at(static_cast<std::size_t>(scene_mesh.material));
  renderer::Mesh mesh = renderer::WorldMesh(scene_mesh);
  renderer::GlbMaterial glb{.name = material.name, .double_sided = material.two_sided};
  if (const auto* bsdf = std::get_if<renderer::MetallicRoughnessBsdf>(&material.bsdf)) {
    glb.bsdf = *bsdf;
    glb.roughness_texture = TextureAt(material.roughness_texture, scene);
    glb.metallic_texture = TextureAt(material.metallic_texture, scene);
  }
  if (const renderer::AreaEmitter* emission = EmissionOf(index, scene)) {
    glb.emission = emission->intensity;
    glb.emission_texture = TextureAt(emission->texture, scene);
  }
  std::string texture_file;
  if (!material.vertex_colors) {
    // Colours that the material does not use would be multiplied in by viewers.
    mesh.colors.clear();
    mesh.color_triangles.clear();
  }
  if (!material.vertex_colors && material.base_color_texture >= 0) {
    glb.base_color_texture = TextureAt(material.base_color_texture, scene);
    texture_file = stem.filename().string() + ".png";
    renderer::WritePng8(stem.parent_path() / texture_file,
                        EncodedImage(TextureImage(*glb.base_color_texture)));
  } else if (!material.vertex_colors) {
    glb.base_color = material.base_color;
  }
  renderer::WriteGlb(fs::path(stem) += ".glb", mesh, glb);
  if (!material.vertex_colors && texture_file.empty()) {
    renderer::SetUniformVertexColors(material.base_color, mesh);
  }
  renderer::WritePly(fs::path(stem) += ".ply", mesh, texture_file);
}

}  // namespace

std::string LightsJson(const Scene& scene) {
  Json lights = Json::array();
  for (const renderer::Emitter& emitter : scene.emitters) {
    Json light = {{"name", emitter.name},
                  {"frame", emitter.frame == renderer::LightFrame::kWorld ? "world" : "camera"}};
    light.update(LightJson(emitter, scene));
    lights.push_back(std::move(light));
  }
  const Json file = {
      {"axes", "right-handed, metres; camera frame: x right, y up, looking along -z"},
      {"lights", std::move(lights)}};
  return JsonText(file) + "\n";
}

std::string ExposureCsv(const Scene& scene, const std::vector<ExportedView>& views) {
  PATHFIT_CHECK(scene.sensors.size() == views.size());
  std::string csv = "image,validation,gain,exposure_ev\n";
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double gain = scene.sensors[i].gain;
    csv += fmt::format("{},{},{},{}\n",
                       CsvCell(views[i].name),
                       views[i].validation ? 1 : 0,
                       CsvCell(gain),
                       CsvCell(std::log2(gain)));
  }
  return csv;
}

void ExportResult(const fs::path& folder,
                  const Scene& scene,
                  const std::vector<ExportedView>& views,
                  const std::vector<ParameterSummary>& parameters) {
  PATHFIT_CHECK(scene.sensors.size() == views.size());
  renderer::CreateFolders(folder / "cameras");
  std::vector<std::string> mesh_names, image_names, image_paths;
  for (const renderer::SceneMesh& mesh : scene.meshes) mesh_names.push_back(mesh.name);
  const std::vector<std::string> files = ViewFolderNames(mesh_names);
  for (std::size_t i = 0; i < files.size(); ++i) {
    WriteMesh(folder / files[i], i, scene);
  }
  std::vector<std::string> texture_names;
  for (const renderer::Texture& texture : scene.textures) texture_names.push_back(texture.name);
  const std::vector<std::string> texture_files = ViewFolderNames(texture_names);
  for (std::size_t i = 0; i < texture_files.size(); ++i) {
    renderer::CreateFolders(folder / "textures");
    renderer::WriteExr(folder / "textures" / (texture_files[i] + ".exr"),
                       TextureImage(scene.textures[i]));
  }
  for (const renderer::Emitter& emitter : scene.emitters) {
    const auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light);
    if (environment != nullptr) WriteEnvironment(folder, *environment);
  }
  for (const ExportedView& view : views) {
    image_names.push_back(view.name);
    image_paths.push_back(view.image_path);
  }
  WriteCameras(folder / "cameras", scene.sensors, image_names, image_paths);
  renderer::WriteFileAtomically(folder / "lights.json", LightsJson(scene));
  renderer::WriteFileAtomically(folder / "exposure.csv", ExposureCsv(scene, views));
  renderer::WriteFileAtomically(folder / "parameters.csv", CsvTable(parameters));
}

}  // namespace pathfit::app
