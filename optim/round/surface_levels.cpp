#include "optim/round/surface_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "optim/parameter/promotion.h"
#include "optim/problem/photo_density.h"
#include "optim/round/mesh_levels.h"
#include "optim/round/texel_fill.h"
#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/texel_places.h"
#include "renderer/geometry/triangle_tree.h"
#include "renderer/geometry/uv_atlas.h"
#include "renderer/geometry/uv_overlap.h"
#include "renderer/math/median.h"
#include "renderer/scene/texture_surface.h"

namespace pathfit::optim {
namespace {

using renderer::Index;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using renderer::TexelPlace;
using renderer::Texture;
using renderer::Vec2;
using renderer::Vec3;

// Densities by what photos resolve differ from chart to chart by these factors of the median.
constexpr double kLeastDensity = 0.5, kMostDensity = 2.0;

const char* NameOf(ParameterKind property) { return renderer::TraitsOf(property).property; }

/// Values of a property on the surfaces of a scene, for points of other meshes of the same
/// surfaces.
class PropertyField {
 public:
  PropertyField(const Scene& scene, const Promotion& promotion)
      : scene_(scene),
        material_(scene.materials[Index(promotion.material)]),
        traits_(renderer::TraitsOf(promotion.property)),
        number_(promotion.material),
        texture_(traits_.TextureOf(material_)) {}

  /// At a point of mesh number `index` of which `mesh` is another one.
  Rgb At(int index, const Mesh& mesh, std::int32_t triangle, std::array<double, 3> weights) {
    const Mesh& own = scene_.meshes[Index(index)].mesh;
    if (traits_.IsConstant(material_)) return Constant();
    if (!(own.triangles == mesh.triangles)) {
      std::unique_ptr<renderer::TriangleTree>& tree = trees_[index];
      if (!tree) tree = std::make_unique<renderer::TriangleTree>(own);
      const renderer::ClosestPoint at =
          tree->Closest(PointOf(mesh, triangle, weights),
                        renderer::TwiceArea(mesh, mesh.triangles[Index(triangle)]));
      triangle = at.triangle;
      weights = at.weights;
    }
    if (texture_ >= 0) {
      Vec2 uv;
      for (std::size_t k = 0; k < 3; ++k) {
        uv = uv + own.uvs[Index(own.uv_triangles[Index(triangle)][k])] * weights[k];
      }
      return TextureValue(scene_.textures[Index(texture_)], uv);
    }
    Rgb color{0.0, 0.0, 0.0};
    for (std::size_t k = 0; k < 3; ++k) {
      color += own.colors[Index(own.color_triangles[Index(triangle)][k])] * weights[k];
    }
    return color;
  }

  [[nodiscard]] int texture() const { return texture_; }

 private:
  [[nodiscard]] Rgb Constant() const {
    const auto numbers = traits_.read(scene_, number_);
    if (numbers.num_blocks == 0) return {1.0, 1.0, 1.0};
    const std::size_t last = numbers[0].size() - 1;  // one number counts for all channels
    return {numbers[0][0], numbers[0][std::min(last, std::size_t{1})], numbers[0][last]};
  }

  const Scene& scene_;
  const renderer::Material& material_;
  const renderer::ParameterTraits& traits_;
  int number_;  ///< of the material
  int texture_;
  std::map<int, std::unique_ptr<renderer::TriangleTree>> trees_;
};

class Promoter {
 public:
  Promoter(const Scene& before,
           const std::vector<UnknownSpec>& unknowns,
           const std::vector<int>& free,
           const FitViews& views,
           double finer,
           SceneLevel& levels)
      : before_(before),
        unknowns_(unknowns),
        free_(free),
        views_(views),
        finer_(finer),
        levels_(levels),
        scene_(levels.scene) {}

  void Run() {
    for (const int index : free_) {
      const UnknownSpec& unknown = unknowns_[Index(index)];
      if (unknown.promotion && unknown.kind == ParameterKind::kVertexColors) ToVertices(unknown);
    }
    for (std::size_t m = 0; m < scene_.materials.size(); ++m) ToTextures(static_cast<int>(m));
  }

 private:
  void Say(const Promotion& promotion, const std::string& text) {
    levels_.messages.push_back("material '" + scene_.materials[Index(promotion.material)].name +
                               "': " + NameOf(promotion.property) + " " + text);
  }

  void ToVertices(const UnknownSpec& unknown) {
    renderer::Material& material = scene_.materials[Index(unknown.promotion->material)];
    if (material.base_color_texture >= 0 || material.vertex_colors) return;
    material.vertex_colors = true;
    for (const int i : renderer::MeshesOfMaterial(scene_, unknown.promotion->material)) {
      SetUniformVertexColors(material.base_color, scene_.meshes[Index(i)].mesh);
    }
    Say(*unknown.promotion, "becomes one colour per vertex");
  }

  /// Textures of a material that unknowns promote to and that are in use or wanted now.
  void ToTextures(int material) {
    std::vector<const UnknownSpec*> wanted;
    for (std::size_t u = 0; u < unknowns_.size(); ++u) {
      const UnknownSpec& unknown = unknowns_[u];
      if (!unknown.promotion || unknown.promotion->material != material ||
          unknown.kind != ParameterKind::kTextureTexels || unknown.hold) {
        continue;
      }
      const bool is_free = std::ranges::find(free_, static_cast<int>(u)) != free_.end();
      if (is_free || !IsReplaced(before_, unknown, unknowns_)) wanted.push_back(&unknown);
      is_free_[&unknown] = is_free;
    }
    if (wanted.empty()) return;
    const std::vector<int> indices = renderer::MeshesOfMaterial(scene_, material);
    if (indices.empty()) {
      return Say(*wanted.front()->promotion, "stays as it is: no mesh is made of it");
    }
    std::vector<const Mesh*> meshes = MeshPointers(scene_, indices);
    bool has_shapes = true;  // of before
    for (const int i : indices) {
      const Mesh& old = before_.meshes[Index(i)].mesh;
      const Mesh& now = scene_.meshes[Index(i)].mesh;
      has_shapes = has_shapes && old.triangles == now.triangles && old.uvs == now.uvs &&
                   old.uv_triangles == now.uv_triangles;
    }
    const bool has_others = HasOtherTextures(material, indices);
    // Others bind the mesh to its UVs: places that share texels there have these in common, too.
    const bool has_uvs =
        renderer::HaveSeparateUvs(meshes) || (has_others && renderer::HaveUvsInPicture(meshes));
    const bool all_resized =
        has_uvs && has_shapes &&
        std::ranges::none_of(wanted, [&](const UnknownSpec* unknown) { return is_free_[unknown]; });
    if (all_resized) return;
    if (!has_uvs && has_others) {
      return Say(*wanted.front()->promotion,
                 "stays as it is: other textures lie on the mesh's UVs, which leave the picture");
    }
    auto densities = Densities(indices);
    const bool in_use = std::ranges::any_of(wanted, [&](const UnknownSpec* unknown) {
      return !IsReplaced(before_, *unknown, unknowns_);
    });
    if (!densities && in_use) densities = EvenDensities(indices, *wanted.front());
    if (!densities) {
      return Say(*wanted.front()->promotion, "stays as it is: no fitted photo shows it");
    }
    int width = 0, height = 0;
    std::string made;
    if (has_uvs) {
      SizeOnUvs(indices, *densities, *wanted.front(), width, height);
    } else {
      std::vector<Mesh*> edited;
      for (const int i : indices) edited.push_back(&scene_.meshes[Index(i)].mesh);
      const renderer::UvAtlas atlas =
          renderer::MakeUvAtlas(edited, *densities, {.max_side = kLargestTexture});
      width = atlas.width;
      height = atlas.height;
      made = " on an atlas of " + std::to_string(atlas.charts) + " charts";
      if (atlas.scale < 1.0) made += ", coarser than the photos by its largest size";
    }
    for (const UnknownSpec* unknown : wanted) {
      Carry(*unknown, indices, {width, height}, has_uvs && has_shapes, made);
    }
  }

  [[nodiscard]] bool IsPromotedTo(int texture) const {
    return std::ranges::any_of(unknowns_, [texture](const UnknownSpec& unknown) {
      return unknown.promotion && unknown.kind == ParameterKind::kTextureTexels &&
             unknown.object == texture;
    });
  }

  [[nodiscard]] bool HasOtherTextures(int material, const std::vector<int>& meshes) const {
    const renderer::Material& m = scene_.materials[Index(material)];
    for (const int texture : m.Textures()) {
      if (texture >= 0 && !IsPromotedTo(texture)) return true;
    }
    return std::ranges::any_of(meshes, [&](int mesh) {
      const renderer::AreaEmitter* light = AreaLightOf(scene_, Index(mesh));
      return light != nullptr && light->texture >= 0;
    });
  }

  /// Texels per metre that are wanted of each triangle at the finest scale, in its object's frame;
  /// nothing if no view shows any.
  [[nodiscard]] std::optional<std::vector<std::vector<double>>> Densities(
      const std::vector<int>& indices) const {
    std::vector<SurfacePoint> points;
    for (const int i : indices) {
      const Mesh world = renderer::WorldMesh(scene_.meshes[Index(i)]);
      for (std::size_t f = 0; f < world.triangles.size(); ++f) {
        points.push_back(
            WorldPoint(world, static_cast<std::int32_t>(f), {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}));
      }
    }
    const std::vector<double> pixels =
        PhotoDensities(scene_, views_, points, std::numeric_limits<double>::infinity());
    std::vector<double> seen;
    for (const double density : pixels) {
      if (density > 0.0) seen.push_back(density);
    }
    if (seen.empty()) return std::nullopt;
    const double median = std::sqrt(renderer::Median(seen));
    std::vector<std::vector<double>> densities;
    std::size_t next = 0;
    for (const int i : indices) {
      const renderer::SceneMesh& item = scene_.meshes[Index(i)];
      std::vector<double>& of_mesh = densities.emplace_back();
      for (std::size_t f = 0; f < item.mesh.triangles.size(); ++f) {
        const double own =
            std::clamp(std::sqrt(pixels[next++]), kLeastDensity * median, kMostDensity * median);
        of_mesh.push_back(kTexelsPerPixel * finer_ * own * item.pose.scale);
      }
    }
    return densities;
  }

  /// Where a mesh needs new UVs though nothing shows it: as many texels as there are.
  [[nodiscard]] std::vector<std::vector<double>> EvenDensities(const std::vector<int>& indices,
                                                               const UnknownSpec& unknown) const {
    double area = 0.0;
    for (const int i : indices) area += SurfaceArea(scene_.meshes[Index(i)].mesh);
    const double texels = static_cast<double>(scene_.textures[Index(unknown.object)].texels.size());
    std::vector<std::vector<double>> densities;
    for (const int i : indices) {
      densities.emplace_back(scene_.meshes[Index(i)].mesh.triangles.size(),
                             std::sqrt(texels / area));
    }
    return densities;
  }

  /// Of a picture on the UVs that there are, with the proportions of the texture.
  void SizeOnUvs(const std::vector<int>& indices,
                 const std::vector<std::vector<double>>& densities,
                 const UnknownSpec& unknown,
                 int& width,
                 int& height) const {
    double texels = 0.0;
    double covered = 0.0;
    for (std::size_t m = 0; m < indices.size(); ++m) {
      const Mesh& mesh = scene_.meshes[Index(indices[m])].mesh;
      for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        texels += 0.5 * Norm(renderer::TwiceArea(mesh, mesh.triangles[f])) * densities[m][f] *
                  densities[m][f];
        renderer::FlatTriangle flat;
        for (std::size_t k = 0; k < 3; ++k) flat[k] = mesh.uvs[Index(mesh.uv_triangles[f][k])];
        covered += 0.5 * std::abs(renderer::TwiceArea(flat));
      }
    }
    const Texture& texture = scene_.textures[Index(unknown.object)];
    const double proportion =
        static_cast<double>(texture.width) / static_cast<double>(texture.height);
    const double area = texels / covered;
    const double shrink =
        std::min(1.0, kLargestTexture / std::sqrt(area * std::max(proportion, 1.0 / proportion)));
    width = static_cast<int>(std::ceil(shrink * std::sqrt(area * proportion)));
    height = static_cast<int>(std::ceil(shrink * std::sqrt(area / proportion)));
  }

  struct TextureSize {
    int width, height;
  };

  /// Of the level: halves of the finest, but not below a least one and what there is.
  [[nodiscard]] TextureSize SizeOfLevel(const TextureSize& finest, const Texture& old) const {
    TextureSize size = finest;
    for (int halvings = static_cast<int>(std::lround(std::log2(finer_))); halvings > 0;
         --halvings) {
      const TextureSize half = {(size.width + 1) / 2, (size.height + 1) / 2};
      if (std::max(half.width, half.height) < kSmallestTexture || half.width < old.width) break;
      size = half;
    }
    return size;
  }

  void Carry(const UnknownSpec& unknown,
             const std::vector<int>& indices,
             const TextureSize& finest,
             bool same_uvs,
             const std::string& made) {
    const Promotion& promotion = *unknown.promotion;
    PropertyField field(before_, promotion);
    const Texture old = scene_.textures[Index(unknown.object)];
    const bool was_texture = field.texture() == unknown.object;
    TextureSize size{old.width, old.height};
    if (was_texture && same_uvs) {
      // Twice the size, as often as the photos ask for.
      if (!is_free_[&unknown]) return;
      const TextureSize wanted = SizeOfLevel(finest, old);
      while (std::numbers::sqrt2 * size.width < wanted.width &&
             2 * std::max(size.width, size.height) <= kLargestTexture) {
        size = {2 * size.width, 2 * size.height};
      }
      if (size.width == old.width) return;
    } else {
      size = SizeOfLevel(finest, was_texture ? old : Texture());
    }
    Texture& texture = scene_.textures[Index(unknown.object)];
    texture.width = size.width;
    texture.height = size.height;
    texture.wrap = renderer::TextureWrap::kClamp;
    std::vector<Rgb> texels(Index(size.width) * Index(size.height), old.texels.Items().front());
    if (was_texture && same_uvs) {
      for (std::size_t i = 0; i < texels.size(); ++i) {
        texels[i] =
            TextureValue(old,
                         {(static_cast<double>(i % Index(size.width)) + 0.5) / size.width,
                          1.0 - (static_cast<double>(i / Index(size.width)) + 0.5) / size.height});
      }
    } else {
      const std::vector<const Mesh*> meshes = MeshPointers(scene_, indices);
      const std::vector<TexelPlace> places = renderer::PlaceTexels(meshes, size.width, size.height);
      std::vector<char> known(texels.size(), 0);
      for (std::size_t i = 0; i < texels.size(); ++i) {
        if (places[i].mesh < 0) continue;
        known[i] = 1;
        const auto m = Index(places[i].mesh);
        texels[i] = field.At(indices[m], *meshes[m], places[i].triangle, places[i].weights);
      }
      FillBeside(size.width, size.height, std::move(known), texels);
    }
    ClampTo(promotion.property, texels);
    texture.texels = std::move(texels);
    renderer::Material& material = scene_.materials[Index(promotion.material)];
    const renderer::ParameterTraits& traits = renderer::TraitsOf(promotion.property);
    material.*traits.texture = unknown.object;
    if (traits.by_vertex_colors && material.vertex_colors) {
      material.vertex_colors = false;
      for (const int i : indices) {
        scene_.meshes[Index(i)].mesh.colors.clear();
        scene_.meshes[Index(i)].mesh.color_triangles.clear();
      }
    }
    const std::string text = std::to_string(size.width) + " x " + std::to_string(size.height);
    Say(promotion,
        was_texture ? "has " + text + " texels, had " + std::to_string(old.width) + " x " +
                          std::to_string(old.height) + made
                    : "becomes a texture of " + text + " texels" + made);
  }

  const Scene& before_;
  const std::vector<UnknownSpec>& unknowns_;
  const std::vector<int>& free_;
  const FitViews& views_;
  double finer_;
  SceneLevel& levels_;
  Scene& scene_;
  std::map<const UnknownSpec*, bool> is_free_;
};

/// For photos up to the largest of the fit's stages; those of `views` have `scale`.
SceneLevel PromoteForLevel(const Scene& before,
                           Scene scene,
                           const FitSpec& spec,
                           const std::vector<int>& free,
                           const FitViews& views,
                           double scale) {
  double largest = scale;
  for (const StageSpec& stage : spec.stages) largest = std::max(largest, stage.image_scale);
  return PromoteSurfaces(before, std::move(scene), spec.unknowns, free, views, largest / scale);
}

}  // namespace

SceneLevel PromoteSurfaces(const Scene& before,
                           Scene scene,
                           const std::vector<UnknownSpec>& unknowns,
                           const std::vector<int>& free,
                           const FitViews& views,
                           double finer) {
  SceneLevel levels{std::move(scene), {}};
  Promoter(before, unknowns, free, views, finer, levels).Run();
  return levels;
}

SceneLevel SceneOfLevel(const Scene& before,
                        const FitSpec& spec,
                        const std::vector<int>& free,
                        const FitViews& views,
                        double scale) {
  MeshLevels meshes = RefineMeshes(before, spec.unknowns, free, views);
  SceneLevel level = PromoteForLevel(before, std::move(meshes.scene), spec, free, views, scale);
  level.messages.insert(level.messages.begin(), meshes.messages.begin(), meshes.messages.end());
  return level;
}

std::optional<Scene> BluntSceneOfLevel(const Scene& before,
                                       const FitSpec& spec,
                                       const std::vector<int>& free,
                                       const FitViews& views,
                                       double scale) {
  std::optional<Scene> meshes = BluntMeshes(before, spec.unknowns, free, views);
  if (!meshes) return std::nullopt;
  return PromoteForLevel(before, std::move(*meshes), spec, free, views, scale).scene;
}

}  // namespace pathfit::optim
