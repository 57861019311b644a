#pragma once

#include <optional>
#include <string>
#include <vector>

#include "optim/parameter/unknown_spec.h"
#include "optim/problem/fit_views.h"
#include "renderer/geometry/mesh_folds.h"
#include "renderer/scene/parameter_layout.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

struct MeshLevels {
  renderer::Scene scene;
  std::vector<std::string> messages;  ///< what was done with each mesh, and why not
};

/// The scene with the meshes whose vertices are among the unknowns `free` brought to the detail
/// that the fitted views resolve: edges of kEdgePixels pixels of their median footprint on the
/// mesh, but from kMinVertices vertices to as many as the views have pixels for, and shorter where
/// parts are too thin for them (RemeshKeepingThinParts). Those near that already, and without
/// folds, stay as they are; so do meshes that ask for it (MeshDetail::kKeep) and such as cannot be
/// remeshed without loss, which is said. Depends on the arguments only.
MeshLevels RefineMeshes(renderer::Scene scene,
                        const std::vector<UnknownSpec>& unknowns,
                        const std::vector<int>& free,
                        const FitViews& views);

/// The same between rounds of one level: parts of these meshes that the last steps have stretched,
/// crushed or folded get new triangles (MendEdges), so that a thing can grow out of a coarse
/// surface. Empty: nothing is to be mended. Depends on the arguments only.
std::optional<renderer::Scene> MendMeshes(const renderer::Scene& scene,
                                          const std::vector<UnknownSpec>& unknowns,
                                          const std::vector<int>& free,
                                          const FitViews& views);

/// The scene with those of these meshes that noise has crumpled made anew: such as have
/// kManyNeedles needles (renderer::CountNeedles) or more, and kManyPerVertex, get edges kBlunting
/// times as long as the level wants, and then as long, so that what is one triangle wide is gone.
/// Whether photos show it the caller has to ask. As with RefineMeshes, textures made for them have
/// to be made again. Empty: there is none. Depends on the arguments only.
std::optional<renderer::Scene> BluntMeshes(const renderer::Scene& scene,
                                           const std::vector<UnknownSpec>& unknowns,
                                           const std::vector<int>& free,
                                           const FitViews& views);

/// Of all meshes whose vertices are in the layout.
renderer::MeshFolds CountFolds(const renderer::Scene& scene,
                               const renderer::ParameterLayout& layout);

/// Smooths the folds of these meshes away where they have more than in `before`.
void UnfoldNew(const renderer::Scene& before,
               const renderer::ParameterLayout& layout,
               renderer::Scene& scene);

inline constexpr double kEdgePixels = 2.5;
inline constexpr double kMinVertices = 300.0;
inline constexpr int kManyNeedles = 5;
inline constexpr double kManyPerVertex = 0.01;
inline constexpr double kBlunting = 1.6;

}  // namespace pathfit::optim
