#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/experiment/build_parts.h"
#include "optim/observation/visual_hull.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/mesh_repair.h"
#include "renderer/io/mesh_assembly.h"
#include "renderer/io/mesh_file.h"
#include "renderer/math/box.h"

namespace pathfit::app {
namespace {

using renderer::Mesh;
using renderer::SceneError;
using renderer::Triangle;
using renderer::Vec3;

Mesh MakeInline(const InlineGeometry& g) {
  Mesh mesh;
  std::ranges::transform(g.vertices, std::back_inserter(mesh.positions), ToVec3);
  std::ranges::transform(g.colors, std::back_inserter(mesh.colors), ToRgb);
  std::ranges::transform(g.normals, std::back_inserter(mesh.normals), ToVec3);
  for (const auto& uv : g.uvs) mesh.uvs.push_back({uv[0], uv[1]});
  for (const auto& t : g.triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
  if (!mesh.colors.empty()) mesh.color_triangles = mesh.triangles;
  if (!mesh.uvs.empty()) mesh.uv_triangles = mesh.triangles;
  if (!mesh.normals.empty()) {
    mesh.normal_triangles = mesh.triangles;
    renderer::NormalizeVertexNormals(mesh);
  }
  renderer::WeldPositions(mesh);
  return mesh;
}

/// The mesh of one geometry entry, before its transform.
class MeshMaker {
 public:
  explicit MeshMaker(const BuildContext& context) : context_(context) {}

  Mesh operator()(const FileGeometry& g) const {
    context_.files.push_back(g.path);
    return renderer::ReadMesh(g.path);
  }
  Mesh operator()(const SphereGeometry& g) const {
    Mesh mesh = renderer::MakeIcosphere(g.subdivisions, g.radius);
    renderer::SetSphereUvs(mesh);
    return mesh;
  }
  Mesh operator()(const RectangleGeometry&) const { return renderer::MakeRectangle(); }
  Mesh operator()(const CubeGeometry&) const {
    Mesh mesh = renderer::MakeCube();
    renderer::SetBoxUvs(mesh);
    return mesh;
  }
  Mesh operator()(const DiskGeometry& g) const { return renderer::MakeDisk(g.segments); }
  Mesh operator()(const InlineGeometry& g) const { return MakeInline(g); }
  Mesh operator()(const VisualHullGeometry& g) const {
    return optim::CarveVisualHull(context_.observations, g);
  }

 private:
  const BuildContext& context_;
};

int MaterialIndex(const std::string& name, const ExperimentConfig& config) {
  const auto found = std::ranges::find_if(
      config.materials, [&](const auto& material) { return material.name == name; });
  PATHFIT_CHECK(found != config.materials.end());  // the config is validated
  return static_cast<int>(found - config.materials.begin());
}

// The groups of a file that have materials of their own, and the rest.
std::vector<MeshPart> ReadParts(const GeometryConfig& geometry,
                                const ExperimentConfig& config,
                                const BuildContext& context) {
  const auto& path = std::get<FileGeometry>(geometry.geometry).path;
  context.files.push_back(path);
  const std::vector<renderer::MeshGroup> groups = renderer::ReadMeshGroups(path);
  std::vector<MeshPart> parts;
  std::string known;
  for (const renderer::MeshGroup& group : groups) known += (known.empty() ? "" : ", ") + group.name;
  for (const auto& [usemtl, material] : geometry.group_materials) {
    const auto group =
        std::ranges::find_if(groups, [&](const auto& g) { return g.name == usemtl; });
    if (group == groups.end()) {
      throw SceneError("geometry '" + geometry.name + "': " + path.string() + " has no usemtl '" +
                       usemtl + "' (known: " + known + ")");
    }
    parts.push_back({GroupMeshName(geometry.name, usemtl),
                     MaterialIndex(material, config),
                     group->mesh,
                     std::nullopt});
  }
  MeshPart rest{geometry.name, MaterialIndex(geometry.material, config), {}, std::nullopt};
  for (const renderer::MeshGroup& group : groups) {
    const bool is_named = std::ranges::any_of(
        geometry.group_materials, [&](const auto& named) { return named.first == group.name; });
    if (is_named) continue;
    if (rest.mesh.triangles.empty()) {
      rest.mesh = group.mesh;
    } else {
      renderer::AppendMesh(group.mesh, rest.mesh);
    }
  }
  if (!rest.mesh.triangles.empty()) {
    renderer::WeldPositions(rest.mesh);
    parts.insert(parts.begin(), std::move(rest));
  }
  return parts;
}

bool IsUnknown(const ExperimentConfig& config, const std::string& mesh, const char* property) {
  const std::string name = mesh + "." + property;
  return std::ranges::any_of(config.fit.unknowns, [&](const auto& unknown) {
    return (unknown.name == name || MatchesGlob(unknown.name, name)) && !unknown.hold;
  });
}

void SetNormals(GeometryConfig::Normals normals,
                const ExperimentConfig& config,
                const BuildContext& context,
                bool has_normal_map,
                MeshPart& part) {
  switch (normals) {
    case GeometryConfig::Normals::kFile:
      break;
    case GeometryConfig::Normals::kFlat:
      renderer::RemoveVertexNormals(part.mesh);
      break;
    case GeometryConfig::Normals::kSmooth:
      renderer::ComputeVertexNormals(part.mesh);
      break;
    case GeometryConfig::Normals::kDefault:
      // Normals that stay behind while the vertices move would be wrong.
      if (!has_normal_map && !part.mesh.normals.empty() &&
          IsUnknown(config, part.name, "vertices") && !IsUnknown(config, part.name, "normals")) {
        renderer::RemoveVertexNormals(part.mesh);
        context.notes.push_back("Mesh " + part.name +
                                " is shaded flat, since its vertices are unknown; normals: file "
                                "keeps the normals it came with.");
      }
  }
}

void SetColors(const std::string& mesh_name, const MaterialConfig& material, Mesh& mesh) {
  using Source = MaterialConfig::BaseColor;
  if (material.base_color_source == Source::kVertexConstant) {
    renderer::SetUniformVertexColors(ToRgb(material.base_color), mesh);
  } else if (material.base_color_source == Source::kVertexOfMesh && !mesh.HasColors()) {
    throw SceneError("geometry '" + mesh_name + "': material '" + material.name +
                     "' takes the mesh's own vertex colours, but it has none; give base_color: "
                     "{vertex: [r, g, b]}");
  }
}

// A mesh of the user's that cannot be used is said with its file, if it has one, and the way out.
void CheckMesh(const GeometryConfig& geometry, const MeshPart& part) {
  const auto* file = std::get_if<FileGeometry>(&geometry.geometry);
  if (file == nullptr && !std::holds_alternative<InlineGeometry>(geometry.geometry)) return;
  try {
    renderer::ValidateMesh(part.mesh, part.name);
  } catch (const SceneError& error) {
    throw SceneError((file == nullptr ? "" : file->path.string() + ": ") + error.what() +
                     (geometry.repair ? "" : "; `repair: true` mends what can be mended"));
  }
}

Vec3 MiddleOf(const std::vector<MeshPart>& parts) {
  renderer::Box box;
  for (const MeshPart& part : parts) {
    box.Include(renderer::BoxAround(part.mesh.positions));
  }
  return box.Middle();
}

}  // namespace

void AddMeshes(const GeometryConfig& geometry,
               const ExperimentConfig& config,
               const BuildContext& context,
               renderer::Scene& scene) {
  const TransformConfig& t = geometry.transform;
  const renderer::Mat3 rotation = RotationOf(t.axis, t.angle);
  const renderer::Transform world_from_file = {
      {rotation.x * t.scale[0], rotation.y * t.scale[1], rotation.z * t.scale[2]},
      ToVec3(t.translate)};
  std::vector<MeshPart> parts;
  if (IsGltf(geometry)) {
    parts = ReadGltfParts(geometry, config, context, world_from_file, scene);
  } else if (geometry.group_materials.empty()) {
    Mesh mesh = std::visit(MeshMaker(context), geometry.geometry);
    parts.push_back(
        {geometry.name, MaterialIndex(geometry.material, config), std::move(mesh), std::nullopt});
  } else {
    parts = ReadParts(geometry, config, context);
  }
  for (MeshPart& part : parts) {
    if (geometry.repair) {
      renderer::MeshRepairs repairs;
      part.mesh = renderer::RepairMesh(std::move(part.mesh), part.name, &repairs);
      const std::string done = renderer::Describe(repairs);
      if (!done.empty())
        context.notes.push_back("Mesh " + part.name + " was repaired: " + done + ".");
    }
    CheckMesh(geometry, part);
    const renderer::Material& look = scene.materials[static_cast<std::size_t>(part.material)];
    SetNormals(geometry.normals, config, context, look.normal_texture >= 0, part);
    renderer::ApplyTransform(world_from_file, part.mesh);
  }
  const Vec3 pivot = geometry.pivot ? ToVec3(*geometry.pivot) : MiddleOf(parts);
  for (MeshPart& part : parts) {
    const auto material = static_cast<std::size_t>(part.material);
    if (material < config.materials.size()) {
      SetColors(part.name, config.materials[material], part.mesh);
    }
    if (HasName(scene.meshes, part.name)) {
      throw SceneError("geometry '" + geometry.name + "': two meshes would be called '" +
                       part.name + "'");
    }
    if (part.emission) {
      part.emission->mesh = static_cast<int>(scene.meshes.size());
      renderer::Emitter& emitter = scene.emitters.emplace_back();
      emitter.name = part.name + "-emission";
      emitter.light = *part.emission;
    }
    renderer::SceneMesh& mesh = scene.meshes.emplace_back();
    mesh.name = part.name;
    mesh.mesh = std::move(part.mesh);
    mesh.material = part.material;
    mesh.pose.pivot = pivot;
  }
}

}  // namespace pathfit::app
