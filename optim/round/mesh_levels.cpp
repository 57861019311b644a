#include "optim/round/mesh_levels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <utility>

#include "optim/round/remesh.h"
#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_folds.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/math/median.h"
#include "renderer/sensor/camera.h"

namespace pathfit::optim {
namespace {

using renderer::Mesh;
using renderer::ParameterKind;
using renderer::Scene;
using renderer::Vec3;

constexpr double kNear = 1.3;             // factor of the wanted edge that is near enough
constexpr double kPixelsPerVertex = 4.0;  // of all fitted views together
constexpr double kMaxVertices = 1e6;
constexpr double kMostMended = 0.8;  // of the wanted edge

/// What the views see of a mesh in the world.
struct Footprint {
  double size = 0.0;    ///< side of a pixel on the mesh, metres; 0: no view sees it
  double pixels = 0.0;  ///< that the mesh's box covers, over all views
};

Footprint FootprintOn(const Mesh& world, const FitViews& views) {
  // Enough vertices for a median.
  const std::size_t stride = 1 + world.positions.size() / 512;
  std::vector<double> medians;
  Footprint footprint;
  for (const int view : views.fitted) {
    const renderer::Camera& camera = views.levels[static_cast<std::size_t>(view)].camera();
    const renderer::CameraModel model(camera);
    std::vector<double> sizes;
    double low_u = camera.width, high_u = 0.0, low_v = camera.height, high_v = 0.0;
    for (std::size_t i = 0; i < world.positions.size(); i += stride) {
      const auto seen = model.Project(world.positions[i]);
      if (!seen || seen->u < 0.0 || seen->u > camera.width || seen->v < 0.0 ||
          seen->v > camera.height) {
        continue;
      }
      sizes.push_back(2.0 / (Norm(seen->du) + Norm(seen->dv)));
      low_u = std::min(low_u, seen->u);
      high_u = std::max(high_u, seen->u);
      low_v = std::min(low_v, seen->v);
      high_v = std::max(high_v, seen->v);
    }
    if (sizes.empty()) continue;
    medians.push_back(renderer::Median(sizes));
    footprint.pixels += (high_u - low_u) * (high_v - low_v);
  }
  if (!medians.empty()) footprint.size = renderer::Median(medians);
  return footprint;
}

/// Of triangles with equal sides; a vertex has two of them.
double VerticesOf(double area, double edge) { return area / (std::sqrt(0.75) * edge * edge); }
double EdgeOf(double area, double vertices) {
  return std::sqrt(area / (std::sqrt(0.75) * vertices));
}

/// By textures other than those that are made for the mesh, and can be made again.
bool UsesUvs(const Scene& scene, int index, const std::vector<UnknownSpec>& unknowns) {
  const auto& material = scene.materials[static_cast<std::size_t>(
      scene.meshes[static_cast<std::size_t>(index)].material)];
  const renderer::AreaEmitter* light = AreaLightOf(scene, static_cast<std::size_t>(index));
  const auto stays = [&](int texture) {
    return texture >= 0 && std::ranges::none_of(unknowns, [texture](const UnknownSpec& unknown) {
             return unknown.promotion && unknown.kind == ParameterKind::kTextureTexels &&
                    unknown.object == texture;
           });
  };
  return std::ranges::any_of(material.Textures(), stays) ||
         (light != nullptr && light->texture >= 0);
}

/// Why the mesh cannot have another one in its place; empty: it can.
std::string Obstacle(const Scene& scene,
                     int index,
                     const std::vector<UnknownSpec>& unknowns,
                     const renderer::MeshTopology& topology) {
  if (!topology.closed) return "its surface has borders";
  if (UsesUvs(scene, index, unknowns)) return "textures lie on its UVs";
  for (const UnknownSpec& unknown : unknowns) {
    const bool of_mesh = renderer::TraitsOf(unknown.kind).list == renderer::ObjectList::kMeshes &&
                         unknown.object == index;
    if (!of_mesh) continue;
    if (unknown.kind == ParameterKind::kVertexNormals || unknown.kind == ParameterKind::kUvs) {
      return "'" + unknown.name + "' belongs to its vertices";
    }
    if (renderer::TraitsOf(unknown.kind).of_surface && unknown.gaussian &&
        unknown.gaussian->mean.empty()) {
      return "the prior of '" + unknown.name + "' is about the start of each";
    }
  }
  return "";
}

/// Whose vertices are free and which may have others in their place.
std::vector<int> MeshesOfLevels(const std::vector<UnknownSpec>& unknowns,
                                const std::vector<int>& free) {
  std::vector<int> meshes;
  for (const int index : free) {
    const UnknownSpec& unknown = unknowns[static_cast<std::size_t>(index)];
    if (unknown.kind == ParameterKind::kVertexPositions && !unknown.hold &&
        unknown.mesh_detail == MeshDetail::kLevels) {
      meshes.push_back(unknown.object);
    }
  }
  return meshes;
}

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string Describe(const renderer::MeshFolds& folds) {
  return std::to_string(folds.folded_edges) + " folded edges and " +
         std::to_string(folds.crossing_triangles) + " crossing triangles";
}

/// Half of the surface has shorter edges: small thin parts may have most of all edges, spikes the
/// longest.
double TypicalEdge(const Mesh& mesh) {
  std::vector<std::pair<double, double>> sides;  // mean of a triangle's, its area
  double area = 0.0;
  for (const renderer::Triangle& triangle : mesh.triangles) {
    double around = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      around += Norm(mesh.positions[static_cast<std::size_t>(triangle[(k + 1) % 3])] -
                     mesh.positions[static_cast<std::size_t>(triangle[k])]);
    }
    sides.emplace_back(around / 3.0, Norm(renderer::TwiceArea(mesh, triangle)));
    area += sides.back().second;
  }
  std::ranges::sort(sides);
  double passed = 0.0;
  for (const auto& [side, weight] : sides) {
    passed += weight;
    if (passed >= 0.5 * area) return side;
  }
  return 0.0;
}

class Leveller {
 public:
  Leveller(const std::vector<UnknownSpec>& unknowns, const FitViews& views, MeshLevels& levels)
      : unknowns_(unknowns), views_(views), levels_(levels) {}

  void Level(int index) {
    renderer::SceneMesh& item = levels_.scene.meshes[static_cast<std::size_t>(index)];
    const Mesh& mesh = item.mesh;
    const auto topology = renderer::MeshTopology::Build(mesh);
    const std::string obstacle = Obstacle(levels_.scene, index, unknowns_, topology);
    if (!obstacle.empty()) {
      Say(item, "stays as it is: " + obstacle);
      return;
    }
    const double wanted = WantedEdge(item);
    if (wanted == 0.0) {
      Say(item, "stays as it is: no fitted view sees it");
      return;
    }
    const double edge = TypicalEdge(mesh);
    const renderer::MeshFolds folds = renderer::CountFolds(mesh);
    const bool is_near = edge < kNear * wanted && wanted < kNear * edge;
    if (is_near && folds.Total() == 0) return;
    Mesh made = mesh;
    // A folded surface has no side for vertices to be put back onto.
    if (folds.Total() > 0) renderer::Unfold(made);
    if (!is_near && !Make(item, wanted, made)) return;
    const renderer::MeshFolds left = renderer::Unfold(made);
    std::string text;
    if (!is_near) {
      text = std::to_string(mesh.positions.size()) + " -> " +
             std::to_string(made.positions.size()) + " vertices, edges of " +
             Number(wanted * item.pose.scale) + " m, ";
    }
    text += "at most " + Number(SurfaceDistance(mesh, made) * item.pose.scale) +
            " m from the surface before";
    if (folds.Total() > 0 || left.Total() > 0) {
      text += "; had " + Describe(folds) + ", has " + Describe(left);
    }
    if (!mesh.uvs.empty() && made.uvs.empty()) {
      // Of textures that are made for the mesh there will be others.
      text += UsesUvs(levels_.scene, index, {}) ? "; UVs are made anew"
                                                : "; UVs, which nothing uses, are dropped";
    }
    Say(item, text);
    item.mesh = std::move(made);
  }

  /// False: there is nothing to mend, or it cannot be.
  bool Mend(int index) {
    // Textures that can be made again wait for the next level: each time they lose some sharpness.
    if (UsesUvs(levels_.scene, index, {})) return false;
    return Replace(index, [](const Mesh& mesh, double wanted) {
      std::optional<Mesh> made = MendEdges(mesh, wanted);
      if (!made) return made;
      renderer::Unfold(*made);
      // New triangles that had to be smoothed that far are worse than worn ones.
      if (SurfaceDistance(mesh, *made) > kMostMended * wanted) made.reset();
      return made;
    });
  }

  /// False: there are few needles, or none can be taken off.
  bool Blunt(int index) {
    const Mesh& mesh = levels_.scene.meshes[static_cast<std::size_t>(index)].mesh;
    const double many =
        std::max(1.0 * kManyNeedles, kManyPerVertex * static_cast<double>(mesh.positions.size()));
    if (renderer::CountNeedles(mesh) < many) return false;
    return Replace(index, [](const Mesh& needled, double wanted) {
      Mesh made = Remesh(needled, kBlunting * wanted);
      renderer::Unfold(made);
      made = Remesh(made, wanted);
      renderer::Unfold(made);
      return std::optional(std::move(made));
    });
  }

 private:
  /// In the place of a mesh what `make` returns for it and the wanted edge. False: nothing, or the
  /// mesh has to stay.
  template <class Make>
  bool Replace(int index, const Make& make) {
    renderer::SceneMesh& item = levels_.scene.meshes[static_cast<std::size_t>(index)];
    const auto topology = renderer::MeshTopology::Build(item.mesh);
    if (!Obstacle(levels_.scene, index, unknowns_, topology).empty()) return false;
    const double wanted = WantedEdge(item);
    if (wanted == 0.0) return false;
    try {
      std::optional<Mesh> made = make(item.mesh, wanted);
      if (!made) return false;
      renderer::ValidateMesh(*made, item.name);
      item.mesh = std::move(*made);
      return true;
    } catch (const renderer::SceneError&) {
      return false;  // the next level says why
    }
  }

  void Say(const renderer::SceneMesh& item, const std::string& text) {
    levels_.messages.push_back("mesh '" + item.name + "': " + text);
  }

  /// In the object's frame; 0 where no view sees it.
  [[nodiscard]] double WantedEdge(const renderer::SceneMesh& item) const {
    const Mesh world = renderer::WorldMesh(item);
    const Footprint footprint = FootprintOn(world, views_);
    if (footprint.size == 0.0) return 0.0;
    const double area = SurfaceArea(world);
    const double pixels = footprint.pixels;
    const double most = std::clamp(pixels / kPixelsPerVertex, kMinVertices, kMaxVertices);
    const double vertices =
        std::clamp(VerticesOf(area, kEdgePixels * footprint.size), kMinVertices, most);
    return EdgeOf(area, vertices) / item.pose.scale;
  }

  /// False: it could not be made, and that was said.
  [[nodiscard]] bool Make(const renderer::SceneMesh& item, double edge, Mesh& mesh) {
    try {
      mesh = RemeshKeepingThinParts(mesh, edge);
      renderer::ValidateMesh(mesh, item.name);
      return true;
    } catch (const renderer::SceneError& error) {
      Say(item, std::string("stays as it is: ") + error.what());
      return false;
    }
  }

  const std::vector<UnknownSpec>& unknowns_;
  const FitViews& views_;
  MeshLevels& levels_;
};

std::optional<Scene> ReplaceMeshes(const Scene& scene,
                                   const std::vector<UnknownSpec>& unknowns,
                                   const std::vector<int>& free,
                                   const FitViews& views,
                                   bool (Leveller::*replace)(int)) {
  MeshLevels levels{scene, {}};
  Leveller leveller(unknowns, views, levels);
  bool any = false;
  for (const int mesh : MeshesOfLevels(unknowns, free)) {
    any = (leveller.*replace)(mesh) || any;
  }
  return any ? std::optional(std::move(levels.scene)) : std::nullopt;
}

}  // namespace

MeshLevels RefineMeshes(Scene scene,
                        const std::vector<UnknownSpec>& unknowns,
                        const std::vector<int>& free,
                        const FitViews& views) {
  MeshLevels levels{std::move(scene), {}};
  Leveller leveller(unknowns, views, levels);
  for (const int mesh : MeshesOfLevels(unknowns, free)) {
    leveller.Level(mesh);
  }
  return levels;
}

std::optional<Scene> MendMeshes(const Scene& scene,
                                const std::vector<UnknownSpec>& unknowns,
                                const std::vector<int>& free,
                                const FitViews& views) {
  return ReplaceMeshes(scene, unknowns, free, views, &Leveller::Mend);
}

std::optional<Scene> BluntMeshes(const Scene& scene,
                                 const std::vector<UnknownSpec>& unknowns,
                                 const std::vector<int>& free,
                                 const FitViews& views) {
  return ReplaceMeshes(scene, unknowns, free, views, &Leveller::Blunt);
}

renderer::MeshFolds CountFolds(const Scene& scene, const renderer::ParameterLayout& layout) {
  renderer::MeshFolds sum;
  for (const renderer::ParameterGroup& group : layout.groups()) {
    if (group.kind != ParameterKind::kVertexPositions) continue;
    const auto folds =
        renderer::CountFolds(scene.meshes[static_cast<std::size_t>(group.object)].mesh);
    sum.folded_edges += folds.folded_edges;
    sum.crossing_triangles += folds.crossing_triangles;
  }
  return sum;
}

void UnfoldNew(const Scene& before, const renderer::ParameterLayout& layout, Scene& scene) {
  for (const renderer::ParameterGroup& group : layout.groups()) {
    if (group.kind != ParameterKind::kVertexPositions) continue;
    const auto index = static_cast<std::size_t>(group.object);
    if (renderer::CountFolds(scene.meshes[index].mesh).Total() >
        renderer::CountFolds(before.meshes[index].mesh).Total()) {
      renderer::Unfold(scene.meshes[index].mesh);
    }
  }
}

}  // namespace pathfit::optim
