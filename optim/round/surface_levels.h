#pragma once

#include <optional>
#include <string>
#include <vector>

#include "optim/parameter/unknown_spec.h"
#include "optim/problem/fit_views.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

struct SceneLevel {
  renderer::Scene scene;
  std::vector<std::string> messages;  ///< what was done with each mesh or property, and why not
};

/// `scene` with the properties of materials that the unknowns `free` want as vertex colours or
/// texels (UnknownSpec::promotion) as such, carried over from `before`: the same scene but for the
/// shapes of its meshes (round/mesh_levels.h). Meshes without UVs of their own get an atlas whose
/// texels are as large as a pixel of the photo that shows a place largest, where photos are `finer`
/// times as large as those of `views`: the largest that the fit will look at. The texture is halved
/// for smaller ones. Textures never shrink. Depends on the arguments only.
SceneLevel PromoteSurfaces(const renderer::Scene& before,
                           renderer::Scene scene,
                           const std::vector<UnknownSpec>& unknowns,
                           const std::vector<int>& free,
                           const FitViews& views,
                           double finer);

/// The scene that a level of a stage begins with: its meshes refined (RefineMeshes), its properties
/// promoted. `scale`: that of the photos in `views`.
SceneLevel SceneOfLevel(const renderer::Scene& before,
                        const FitSpec& spec,
                        const std::vector<int>& free,
                        const FitViews& views,
                        double scale);

/// That with which a level of crumpled meshes may begin again (BluntMeshes). Empty: none is.
std::optional<renderer::Scene> BluntSceneOfLevel(const renderer::Scene& before,
                                                 const FitSpec& spec,
                                                 const std::vector<int>& free,
                                                 const FitViews& views,
                                                 double scale);

inline constexpr double kTexelsPerPixel = 1.0;
inline constexpr int kLargestTexture = 2048;
inline constexpr int kSmallestTexture = 32;

}  // namespace pathfit::optim
