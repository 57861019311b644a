#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "optim/parameter/unknown_spec.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/photo_density.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// What a texel of an atlas shows.
enum class TexelSight : std::uint8_t {
  kOutside,  ///< no surface
  kUnseen,   ///< a surface that no fitted photo shows
  kSeen
};
/// By texel. Precondition: the texture is an atlas (renderer::IsAtlas).
std::vector<TexelSight> SightOfTexels(const renderer::Scene& scene,
                                      int texture,
                                      const FitViews& views);

/// Fills the texels of all promoted textures that no photo shows: on the surface as a smooth
/// continuation of what is around them, also across seams; beside it by the nearest texel of a
/// chart. Returns what was filled, a sentence for each texture.
std::vector<std::string> FillUnseenTexels(const std::vector<UnknownSpec>& unknowns,
                                          const FitViews& views,
                                          renderer::Scene& scene);

/// Fills texels with known[i] == 0 from the nearest ones with 1, layer by layer.
void FillBeside(int width, int height, std::vector<char> known, std::vector<renderer::Rgb>& texels);

/// Puts texels into the range of the property that they stand for, which means of what lies at its
/// limit may pass by rounding.
void ClampTo(renderer::ParameterKind property, std::vector<renderer::Rgb>& texels);

std::vector<const renderer::Mesh*> MeshPointers(const renderer::Scene& scene,
                                                const std::vector<int>& meshes);

/// A point of a mesh by the weights of a triangle's corners.
renderer::Vec3 PointOf(const renderer::Mesh& mesh,
                       std::int32_t triangle,
                       const std::array<double, 3>& weights);
/// The same of a mesh in the world frame, with its triangle's normal.
SurfacePoint WorldPoint(const renderer::Mesh& world,
                        std::int32_t triangle,
                        const std::array<double, 3>& weights);

}  // namespace pathfit::optim
