#pragma once

#include <span>
#include <vector>

#include "optim/problem/fit_views.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

struct SurfacePoint {
  renderer::Vec3 x;  ///< world
  renderer::Vec3 n;  ///< unit, world; of any side
};

/// By point: pixels per square metre of the fitted view that shows it largest, where the photo is
/// valid colour evidence and nothing of the scene is before it; 0: no view shows it. `stop_at`: the
/// search ends with the first view that reaches it, if all that matters is whether one does.
std::vector<double> PhotoDensities(const renderer::Scene& scene,
                                   const FitViews& views,
                                   std::span<const SurfacePoint> points,
                                   double stop_at);

/// By point: how many of the fitted photos show it, in the same sense, at `scale` times their size.
/// Keeps one photo's level at a time.
std::vector<int> PhotoCounts(const renderer::Scene& scene,
                             const ObservationSet& observations,
                             double scale,
                             std::span<const SurfacePoint> points);

}  // namespace pathfit::optim
