#include "renderer/derivative/active_parameters.h"

#include <algorithm>
#include <variant>

namespace pathfit::renderer {
namespace {

using MeshBlocks = ActiveParameters::MeshBlocks;
using MaterialBlocks = ActiveParameters::MaterialBlocks;
using LightBlocks = ActiveParameters::LightBlocks;
using CameraBlocks = ActiveParameters::CameraBlocks;

MeshBlocks BlocksOfMesh(const ParameterLayout& layout, const SceneMesh& mesh, int index) {
  MeshBlocks b;
  b.positions = layout.FirstBlock(ParameterKind::kVertexPositions, index);
  b.normals = layout.FirstBlock(ParameterKind::kVertexNormals, index);
  b.uvs = layout.FirstBlock(ParameterKind::kUvs, index);
  b.colors = layout.FirstBlock(ParameterKind::kVertexColors, index);
  b.translation = layout.FirstBlock(ParameterKind::kObjectTranslation, index);
  b.rotation = layout.FirstBlock(ParameterKind::kObjectRotation, index);
  b.scale = layout.FirstBlock(ParameterKind::kObjectScale, index);
  b.has_pose = b.translation >= 0 || b.rotation >= 0 || b.scale >= 0;
  b.moves = b.positions >= 0 || b.has_pose;
  b.rotation_matrix = RotationFromVector(mesh.pose.rotation);
  b.world_from_object = {b.rotation_matrix.x * mesh.pose.scale,
                         b.rotation_matrix.y * mesh.pose.scale,
                         b.rotation_matrix.z * mesh.pose.scale};
  b.rotation_jacobian = RotationLeftJacobian(mesh.pose.rotation);
  b.center = mesh.pose.pivot + mesh.pose.translation;
  b.inverse_scale = 1.0 / mesh.pose.scale;
  return b;
}

MaterialBlocks BlocksOfMaterial(const ParameterLayout& layout,
                                const Material& material,
                                int index,
                                const std::vector<std::int32_t>& textures) {
  MaterialBlocks b;
  for (const ParameterGroup& group : layout.groups()) {
    const ParameterTraits& traits = TraitsOf(group.kind);
    if (traits.list == ObjectList::kMaterials && group.object == index &&
        traits.IsConstant(material)) {
      b.constants.push_back({group.first_block, group.block_size == 1, traits.partial});
    }
  }
  const auto active = [&](int texture) {
    return texture >= 0 && textures[static_cast<std::size_t>(texture)] >= 0;
  };
  b.any = !b.constants.empty() || std::ranges::any_of(material.Textures(), active);
  return b;
}

LightBlocks BlocksOfLight(const ParameterLayout& layout,
                          const Emitter& emitter,
                          int index,
                          const CameraModel& camera,
                          const CameraBlocks& camera_blocks) {
  LightBlocks b;
  b.intensity = layout.FirstBlock(ParameterKind::kLightIntensity, index);
  b.texels = layout.FirstBlock(ParameterKind::kEnvironmentTexels, index);
  b.position = layout.FirstBlock(ParameterKind::kLightPosition, index);
  b.rotation = layout.FirstBlock(ParameterKind::kLightRotation, index);
  b.angles = layout.FirstBlock(ParameterKind::kSpotAngles, index);
  b.camera_frame = emitter.frame == LightFrame::kCamera;
  if (b.camera_frame) {
    b.world_from_frame = camera.Pose().linear;
  }
  b.rotation_jacobian = RotationLeftJacobian(emitter.rotation);
  b.moves = b.position >= 0 || b.rotation >= 0 || (b.camera_frame && camera_blocks.moves);
  return b;
}

CameraBlocks BlocksOfCamera(const Scene& scene,
                            const ParameterLayout& layout,
                            const CameraModel& camera,
                            int sensor) {
  CameraBlocks b;
  if (sensor < 0) {
    return b;
  }
  b.exposure = layout.FirstBlock(ParameterKind::kExposure, sensor);
  b.white_balance = layout.FirstBlock(ParameterKind::kWhiteBalance, sensor);
  b.vignetting = layout.FirstBlock(ParameterKind::kVignetting, sensor);
  b.position = layout.FirstBlock(ParameterKind::kCameraPosition, sensor);
  b.rotation = layout.FirstBlock(ParameterKind::kCameraRotation, sensor);
  b.focal = layout.FirstBlock(ParameterKind::kFocal, sensor);
  b.principal_point = layout.FirstBlock(ParameterKind::kPrincipalPoint, sensor);
  b.radial = layout.FirstBlock(ParameterKind::kRadialDistortion, sensor);
  b.tangential = layout.FirstBlock(ParameterKind::kTangentialDistortion, sensor);
  b.rotation_jacobian = RotationLeftJacobian(camera.camera().rotation);
  b.center = camera.Origin();
  const Camera& full = scene.sensors[static_cast<std::size_t>(sensor)];
  b.scale_x = camera.camera().fx / full.fx;
  b.scale_y = camera.camera().fy / full.fy;
  b.moves = b.position >= 0 || b.rotation >= 0;
  b.intrinsics = b.focal >= 0 || b.principal_point >= 0 || b.radial >= 0 || b.tangential >= 0;
  return b;
}

}  // namespace

std::vector<bool> ActiveParameters::MovingMeshes() const {
  std::vector<bool> moving;
  for (const MeshBlocks& mesh : meshes) moving.push_back(mesh.moves);
  return moving;
}

ActiveParameters ActiveParameters::Make(const Scene& scene,
                                        const ParameterLayout& layout,
                                        const CameraModel& camera,
                                        int sensor) {
  ActiveParameters active;
  active.camera = BlocksOfCamera(scene, layout, camera, sensor);
  active.any_geometry = active.camera.Any();
  for (std::size_t i = 0; i < scene.textures.size(); ++i) {
    active.textures.push_back(
        layout.FirstBlock(ParameterKind::kTextureTexels, static_cast<int>(i)));
  }
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    active.materials.push_back(
        BlocksOfMaterial(layout, scene.materials[i], static_cast<int>(i), active.textures));
    active.materials.back().bends = BendsRays(scene, layout, static_cast<int>(i));
    active.any_bends = active.any_bends || active.materials.back().bends;
  }
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    MeshBlocks b = BlocksOfMesh(layout, scene.meshes[i], static_cast<int>(i));
    b.any_geometry = b.moves || b.normals >= 0 || b.uvs >= 0;
    active.meshes.push_back(b);
    active.any_mesh_moves = active.any_mesh_moves || b.moves;
    active.any_geometry = active.any_geometry || b.any_geometry;
    MaterialBlocks& material = active.materials[static_cast<std::size_t>(scene.meshes[i].material)];
    material.any = material.any || b.colors >= 0 || b.uvs >= 0;
  }
  const std::vector<int>& lights_off = camera.camera().lights_off;
  for (int i = 0; i < static_cast<int>(scene.emitters.size()); ++i) {
    const Emitter& emitter = scene.emitters[static_cast<std::size_t>(i)];
    const LightBlocks& b = active.lights.emplace_back(
        IsOff(lights_off, i) ? LightBlocks{}
                             : BlocksOfLight(layout, emitter, i, camera, active.camera));
    active.any_light_moves = active.any_light_moves || b.moves;
    active.any_light = active.any_light || b.intensity >= 0 || b.texels >= 0 || b.angles >= 0;
    active.any_geometry = active.any_geometry || b.moves;
  }
  active.any_light =
      active.any_light ||
      std::any_of(active.textures.begin(), active.textures.end(), [](auto t) { return t >= 0; });
  active.any_material = std::any_of(
      active.materials.begin(), active.materials.end(), [](const auto& m) { return m.any; });
  active.all_paths =
      active.camera.Any() || active.camera.HasGains() || active.any_light || active.any_light_moves;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    active.touches.push_back(
        active.meshes[i].any_geometry ||
        active.materials[static_cast<std::size_t>(scene.meshes[i].material)].any);
  }
  for (int i = 0; i < static_cast<int>(scene.emitters.size()); ++i) {
    const auto* area = std::get_if<AreaEmitter>(&scene.emitters[static_cast<std::size_t>(i)].light);
    active.all_paths =
        active.all_paths || (area != nullptr && !IsOff(lights_off, i) &&
                             active.meshes[static_cast<std::size_t>(area->mesh)].any_geometry);
  }
  return active;
}

bool BendsRays(const Scene& scene, const ParameterLayout& layout, int material) {
  return std::holds_alternative<SmoothDielectricBsdf>(
             scene.materials[static_cast<std::size_t>(material)].bsdf) &&
         layout.FirstBlock(ParameterKind::kEta, material) >= 0;
}

}  // namespace pathfit::renderer
