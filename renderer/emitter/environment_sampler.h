#pragma once

#include <vector>

#include "renderer/emitter/emitter.h"
#include "renderer/math/distribution_1d.h"

namespace pathfit::renderer {

struct DirectionSample {
  Vec3 direction;    ///< unit, light's own frame
  double pdf = 0.0;  ///< per solid angle
  Vec2 uv;  ///< EnvironmentUv(direction); not set for a constant environment, which needs none
};

/// Importance sampling of an environment by the radiance of its texels (a share kEnvironmentFloor
/// is uniform over the texels' mean, so that a dark texel is still found). A constant environment
/// is sampled over the hemisphere of the receiver instead.
class EnvironmentSampler {
 public:
  explicit EnvironmentSampler(const EnvironmentEmitter& environment);

  /// `normal` in the light's own frame: used by constant environments only.
  [[nodiscard]] DirectionSample Sample(const Vec3& normal, double u0, double u1) const;

  /// The same of a map in steps, between which others' steps give memory time: each brings nearer
  /// what the next one reads.
  struct Draft {
    double u0 = 0.0;
    int row = 0, column = 0;
    double in_row = 0.0, in_column = 0.0;  // in [0, 1) of the texel
  };
  [[nodiscard]] bool IsMap() const { return width_ * height_ > 1; }
  [[nodiscard]] Draft ChooseRow(double u0, double u1) const;
  void LookForColumn(const Draft& draft) const;
  void ChooseColumn(Draft& draft) const;
  [[nodiscard]] DirectionSample Finish(const Draft& draft) const;

  /// Density of a direction by its map coordinates. `above`: on the receiver's side; constant
  /// environments draw no others.
  [[nodiscard]] double Pdf(const Vec2& uv, bool above) const;

 private:
  int width_, height_;
  Distribution1D rows_;
  std::vector<Distribution1D> columns_;  // by row
  std::vector<double> row_cos_;          // cos(theta) of the texel rows' upper borders
  std::vector<double> density_;          // per solid angle, of each texel
  const Rgb* texels_;  // only prefetched, which is harmless wherever it points: not read
};

}  // namespace pathfit::renderer
