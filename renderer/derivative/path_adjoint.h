#pragma once

#include "renderer/derivative/derivative_accumulator.h"
#include "renderer/derivative/motion_adjoint.h"
#include "renderer/derivative/near_motion.h"
#include "renderer/derivative/path_recorder.h"
#include "renderer/render_options.h"

namespace pathfit::renderer {

/// Adds adjoints to a DerivativeAccumulator: the target of MotionAdjoint for interior paths.
class AccumulatorTarget {
 public:
  explicit AccumulatorTarget(DerivativeAccumulator& sum) : sum_(sum) {}
  void Add(std::int32_t block, const ColorGradient& g) {
    auto& entry = sum_.Entry(block);
    for (int c = 0; c < 3; ++c) {
      entry[0][c] += g[c].x;
      entry[1][c] += g[c].y;
      entry[2][c] += g[c].z;
    }
  }
  void AddScalar(std::int32_t block, int component, const Rgb& d) {
    sum_.Entry(block)[static_cast<std::size_t>(component)] += Rgba(d, 0.0);
  }

 private:
  DerivativeAccumulator& sum_;
};

/// Where a path starts: the sensor ray and, in material form, the slope of the pixel's filter.
struct PixelSample {
  Ray ray;
  double u = 0.0, v = 0.0;  ///< pixel coordinates
  double weight = 1.0;      ///< filter over sampling density; 1 where the filter is sampled
  double slope_u = 0.0, slope_v = 0.0;  ///< material form: derivative of log filter by u, v,
                                        ///< times weight
};

/// What a sweep refers to.
struct AdjointContext {
  const PathContext& path;
  const CameraModel& camera;
  const ActiveParameters& active;
  DerivativeForm form = DerivativeForm::kImage;
  const NearMotion* near_motion = nullptr;  ///< pixel estimates only
};

/// Adds the derivative of pixel.weight times the path's radiance by every active parameter to
/// `sum`, by one reverse sweep.
///
/// Image form: the pixel is fixed, so the camera vertex slides along the camera ray when its
/// triangle or the camera moves; so do the vertices behind mirrors and glass up to the first vertex
/// that is not. All later vertices are in material form: barycentrics fixed, the factor G J of each
/// segment attached, sampling densities and MIS weights detached. Material form: all vertices are
/// material points; the camera vertex has the factors H(u), pixel area per surface area and J.
/// Behind a mirror or glass that follows a rough vertex directions are kept fixed, and motion is
/// not differentiated. Visibility is constant here; its change is the boundary estimators' part.
/// Source: path_space 1.4, 1.5, 1.12; [Zhang2020].
void AccumulatePathAdjoint(const AdjointContext& context,
                           const PixelSample& pixel,
                           PathRecorder& path,
                           DerivativeAccumulator& sum);

/// Gradient of weight * sky radiance by the world direction.
ColorGradient SkyGradient(const LightSet::Environment& environment,
                          const Vec3& direction,
                          const Rgb& weight);

/// The same for a camera ray that sees the environment.
void AccumulateMissAdjoint(const AdjointContext& context,
                           const PixelSample& pixel,
                           DerivativeAccumulator& sum);

}  // namespace pathfit::renderer
