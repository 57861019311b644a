#include "optim/round/texel_fill.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "optim/parameter/promotion.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/texel_places.h"
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
using renderer::Vec3;

constexpr int kSweeps = 300;
constexpr double kOverRelaxation = 1.9;

/// Texels next to each other on a surface: on a chart, and across seams.
class TexelGraph {
 public:
  TexelGraph(std::span<const Mesh* const> meshes,
             const Texture& texture,
             const std::vector<TexelPlace>& places)
      : width_(Index(texture.width)), places_(places) {
    for (const renderer::SeamPoint& seam :
         renderer::SampleSeams(meshes, texture.width, texture.height)) {
      std::array<std::size_t, 2> ends{};
      for (std::size_t side = 0; side < 2; ++side) {
        const renderer::TextureLookup lookup = LookUpTexture(texture, seam.uv[side]);
        const auto nearest = std::ranges::max_element(lookup.weight) - lookup.weight.begin();
        ends[side] = Index(lookup.texel[static_cast<std::size_t>(nearest)]);
      }
      across_[ends[0]].push_back(ends[1]);
      across_[ends[1]].push_back(ends[0]);
    }
  }

  template <class Visit>
  void ForNeighbors(std::size_t i, const Visit& visit) const {
    const std::size_t x = i % width_;
    const auto beside = [&](std::size_t j) {
      if (places_[j].mesh >= 0 && places_[j].chart == places_[i].chart) visit(j);
    };
    if (x > 0) beside(i - 1);
    if (x + 1 < width_) beside(i + 1);
    if (i >= width_) beside(i - width_);
    if (i + width_ < places_.size()) beside(i + width_);
    const auto across = across_.find(i);
    if (across == across_.end()) return;
    for (const std::size_t j : across->second) {
      if (places_[j].mesh >= 0) visit(j);
    }
  }

 private:
  std::size_t width_;
  const std::vector<TexelPlace>& places_;
  std::map<std::size_t, std::vector<std::size_t>> across_;
};

std::vector<TexelSight> SightOf(const Scene& scene,
                                const std::vector<int>& indices,
                                const std::vector<TexelPlace>& places,
                                const FitViews& views) {
  std::vector<Mesh> worlds;
  for (const int i : indices) worlds.push_back(renderer::WorldMesh(scene.meshes[Index(i)]));
  std::vector<SurfacePoint> points;
  for (const TexelPlace& place : places) {
    if (place.mesh < 0) continue;
    points.push_back(WorldPoint(worlds[Index(place.mesh)], place.triangle, place.weights));
  }
  const std::vector<double> pixels =
      PhotoDensities(scene, views, points, std::numeric_limits<double>::min());
  std::vector<TexelSight> sight(places.size(), TexelSight::kOutside);
  std::size_t next = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].mesh < 0) continue;
    sight[i] = pixels[next++] > 0.0 ? TexelSight::kSeen : TexelSight::kUnseen;
  }
  return sight;
}

/// The unseen texels as means of their neighbours, by successive over-relaxation from what the
/// nearest seen ones say.
void Continue(const TexelGraph& graph,
              const std::vector<TexelSight>& sight,
              std::vector<Rgb>& texels) {
  std::vector<char> known(texels.size());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < texels.size(); ++i) {
    known[i] = sight[i] == TexelSight::kSeen ? 1 : 0;
  }
  std::vector<std::size_t> layer;
  for (std::size_t i = 0; i < texels.size(); ++i) {
    if (known[i] == 1) layer.push_back(i);
  }
  while (!layer.empty()) {
    std::vector<std::size_t> next;
    for (const std::size_t i : layer) {
      graph.ForNeighbors(i, [&](std::size_t j) {
        if (known[j] != 0 || sight[j] != TexelSight::kUnseen) return;
        known[j] = 1;
        texels[j] = texels[i];
        next.push_back(j);
        order.push_back(j);
      });
    }
    layer = std::move(next);
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const std::size_t i : order) {
      Rgb sum{0.0, 0.0, 0.0};
      double count = 0.0;
      graph.ForNeighbors(i, [&](std::size_t j) {
        sum += texels[j];
        count += 1.0;
      });
      if (count > 0.0) texels[i] += (sum * (1.0 / count) - texels[i]) * kOverRelaxation;
    }
  }
  // Over-relaxation may pass what it comes from on its way.
  Rgb low{1e300, 1e300, 1e300}, high = low * -1.0;
  for (std::size_t i = 0; i < texels.size(); ++i) {
    if (sight[i] != TexelSight::kSeen) continue;
    for (int c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], texels[i][c]);
      high[c] = std::max(high[c], texels[i][c]);
    }
  }
  for (const std::size_t i : order) {
    for (int c = 0; c < 3; ++c) texels[i][c] = std::clamp(texels[i][c], low[c], high[c]);
  }
}

}  // namespace

void FillBeside(int width, int height, std::vector<char> known, std::vector<Rgb>& texels) {
  std::vector<std::size_t> layer;
  const auto for_neighbors = [&](std::size_t i, const auto& visit) {
    const int x = static_cast<int>(i % Index(width));
    const int y = static_cast<int>(i / Index(width));
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if ((dx == 0 && dy == 0) || x + dx < 0 || y + dy < 0 || x + dx >= width ||
            y + dy >= height) {
          continue;
        }
        visit(Index(y + dy) * Index(width) + Index(x + dx));
      }
    }
  };
  constexpr char kQueued = 2;
  const auto queue_around = [&](std::size_t i, std::vector<std::size_t>& queue) {
    for_neighbors(i, [&](std::size_t j) {
      if (known[j] != 0) return;
      known[j] = kQueued;
      queue.push_back(j);
    });
  };
  for (std::size_t i = 0; i < texels.size(); ++i) {
    if (known[i] == 1) queue_around(i, layer);
  }
  while (!layer.empty()) {
    for (const std::size_t i : layer) {
      Rgb sum{0.0, 0.0, 0.0};
      double count = 0.0;
      for_neighbors(i, [&](std::size_t j) {
        if (known[j] != 1) return;
        sum += texels[j];
        count += 1.0;
      });
      texels[i] = sum * (1.0 / count);
    }
    for (const std::size_t i : layer) known[i] = 1;
    std::vector<std::size_t> next;
    for (const std::size_t i : layer) queue_around(i, next);
    layer = std::move(next);
  }
}

void ClampTo(ParameterKind property, std::vector<Rgb>& texels) {
  const renderer::ParameterTraits& traits = renderer::TraitsOf(property);
  for (Rgb& texel : texels) {
    for (int c = 0; c < 3; ++c) texel[c] = std::clamp(texel[c], traits.smallest, traits.largest);
  }
}

std::vector<const Mesh*> MeshPointers(const Scene& scene, const std::vector<int>& meshes) {
  std::vector<const Mesh*> pointers;
  for (const int i : meshes) pointers.push_back(&scene.meshes[Index(i)].mesh);
  return pointers;
}

Vec3 PointOf(const Mesh& mesh, std::int32_t triangle, const std::array<double, 3>& weights) {
  const renderer::Triangle& t = mesh.triangles[Index(triangle)];
  Vec3 x;
  for (std::size_t k = 0; k < 3; ++k) x += mesh.positions[Index(t[k])] * weights[k];
  return x;
}

SurfacePoint WorldPoint(const Mesh& world,
                        std::int32_t triangle,
                        const std::array<double, 3>& weights) {
  return {PointOf(world, triangle, weights),
          Normalized(renderer::TwiceArea(world, world.triangles[Index(triangle)]))};
}

std::vector<TexelSight> SightOfTexels(const Scene& scene, int texture, const FitViews& views) {
  const std::vector<int> indices = renderer::MeshesOfTexture(scene, texture);
  const Texture& picture = scene.textures[Index(texture)];
  const std::vector<const Mesh*> meshes = MeshPointers(scene, indices);
  return SightOf(
      scene, indices, renderer::PlaceTexels(meshes, picture.width, picture.height), views);
}

std::vector<std::string> FillUnseenTexels(const std::vector<UnknownSpec>& unknowns,
                                          const FitViews& views,
                                          Scene& scene) {
  std::vector<std::string> messages;
  for (const UnknownSpec& unknown : unknowns) {
    const bool is_texture = unknown.promotion && unknown.kind == ParameterKind::kTextureTexels &&
                            !IsReplaced(scene, unknown, unknowns);
    if (!is_texture || !renderer::IsAtlas(scene, unknown.object)) continue;
    const std::vector<int> indices = renderer::MeshesOfTexture(scene, unknown.object);
    const std::vector<const Mesh*> meshes = MeshPointers(scene, indices);
    Texture& texture = scene.textures[Index(unknown.object)];
    const std::vector<TexelPlace> places =
        renderer::PlaceTexels(meshes, texture.width, texture.height);
    const std::vector<TexelSight> sight = SightOf(scene, indices, places, views);
    if (std::ranges::find(sight, TexelSight::kSeen) == sight.end()) continue;
    std::vector<Rgb> texels = std::as_const(texture).texels.Items();
    Continue(TexelGraph(meshes, texture, places), sight, texels);
    std::vector<char> known(texels.size());
    for (std::size_t i = 0; i < texels.size(); ++i) {
      known[i] = sight[i] == TexelSight::kOutside ? 0 : 1;
    }
    FillBeside(texture.width, texture.height, std::move(known), texels);
    ClampTo(unknown.promotion->property, texels);
    texture.texels = std::move(texels);
    const auto unseen = std::ranges::count(sight, TexelSight::kUnseen);
    messages.push_back("texture '" + texture.name + "': " + std::to_string(unseen) + " of " +
                       std::to_string(unseen + std::ranges::count(sight, TexelSight::kSeen)) +
                       " texels on the surface are seen by no photo and filled from their "
                       "neighbours");
  }
  return messages;
}

}  // namespace pathfit::optim
