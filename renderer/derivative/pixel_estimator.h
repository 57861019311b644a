#pragma once

#include <memory>
#include <span>
#include <vector>

#include "renderer/derivative/path_adjoint.h"
#include "renderer/render_stats.h"
#include "renderer/sampler/path_sampler.h"

namespace pathfit::renderer {

/// Estimates pixels, one after another; scratch space of one thread, which takes longer to make
/// than a pixel that shows nothing takes to estimate.
class PixelEstimator {
 public:
  /// `context` must have been made for the same camera. All arguments must outlive the object.
  PixelEstimator(const PathContext& context,
                 const CameraModel& camera,
                 const RenderOptions& options);
  ~PixelEstimator();
  PixelEstimator(const PixelEstimator&) = delete;
  PixelEstimator& operator=(const PixelEstimator&) = delete;

  /// Mean radiance and coverage of a pixel under its filter, before the sensor's gain. The numbers
  /// of a pixel are a function of (seed, view, pixel, sample) only.
  Rgba Estimate(int x, int y, RenderStats& stats);

 private:
  struct Scratch;

  const PathContext& context_;
  const CameraModel& camera_;
  const RenderOptions& options_;
  std::unique_ptr<Scratch> scratch_;
};

/// Estimates pixels and their interior derivative, one after another; scratch space of one thread.
///
/// In material form under a smooth filter, samples cover the filter's support evenly in groups of
/// four mirrored points that share all further numbers: the slope of the filter is odd, and grows
/// beyond bounds relative to the filter. [path_space 1.9]
class PixelDerivative {
 public:
  /// `touches`: by mesh, whether a path that meets it depends on a parameter; null if all paths do.
  /// All arguments must outlive the object.
  PixelDerivative(const AdjointContext& context,
                  const RenderOptions& options,
                  const std::vector<bool>* touches);
  ~PixelDerivative();
  PixelDerivative(const PixelDerivative&) = delete;
  PixelDerivative& operator=(const PixelDerivative&) = delete;

  /// The number of PixelEstimator (in image form, bit for bit); replaces sum().
  Rgba Estimate(int x, int y, RenderStats& stats);
  /// Of the last pixel: the sum of the derivative over its samples, not yet divided by their count.
  [[nodiscard]] DerivativeAccumulator& sum() { return sum_; }

 private:
  struct Recorded;  // a sample's path
  struct Level;     // paths that have been drawn again so many times, recorded side by side
  struct Scratch;   // of the paths of the first samples

  Level& LevelAt(std::size_t depth);
  void RecordTogether(std::span<Rgba> values);
  void RecordAgain(std::size_t depth, std::size_t count);
  void AddRecorded(std::size_t depth, std::size_t count);

  const AdjointContext& context_;
  const RenderOptions& options_;
  const bool spread_;  // over the filter's support
  const int pair_, points_;
  const PathRecorder recorder_;  // before it has heard anything
  std::unique_ptr<Scratch> scratch_;
  std::vector<std::unique_ptr<Level>> levels_;
  DerivativeAccumulator sum_;
  PathAdjoint adjoint_;
};

}  // namespace pathfit::renderer
