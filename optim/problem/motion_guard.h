#pragma once

#include <optional>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/fit_views.h"
#include "renderer/scene/scene.h"
#include "renderer/sensor/camera.h"

namespace pathfit::optim {

/// Refuses steps that reach further than derivatives hold: an image is linear in a motion for less
/// than a pixel. What hardly changes the images may be moved far by noise alone, and no model of
/// small steps says where it ends.
class MotionGuard {
 public:
  /// The arguments must outlive it. `values`: the round's start, in units of the scene.
  MotionGuard(const renderer::Scene& scene,
              const ParameterSet& set,
              const FitViews& views,
              const std::vector<double>& values);

  /// Whether no mesh moves by more than kMaxPixels.
  [[nodiscard]] bool Admits(const std::vector<double>& values) const {
    return LargestMotion(values) <= kMaxPixels;
  }
  /// By how much the mesh that moves most does so in the fitted images, in pixels: root mean square
  /// over its points and the views that see them.
  [[nodiscard]] double LargestMotion(const std::vector<double>& values) const;

  static constexpr double kMaxPixels = 0.5;

 private:
  /// Where points of each mesh are seen by each fitted view, view by view; empty entries: nowhere.
  using Seen = std::vector<std::vector<std::optional<renderer::Vec2>>>;
  [[nodiscard]] Seen See(const std::vector<double>& values) const;

  const renderer::Scene& scene_;
  const ParameterSet& set_;
  const FitViews& views_;
  bool anything_moves_;
  Seen start_;
};

}  // namespace pathfit::optim
