#pragma once

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// The normal by which a perfect mirror or smooth glass with interpolated normals reflects.
///
/// Near the outline of a coarse mesh the reflection about the interpolated normal dips below the
/// facet, where it would meet the mesh itself: a black rim whose border no edge of the mesh marks.
/// There the reflection is raised to kLift above the facet's plane and the normal bent accordingly;
/// what is seen in the mirror stays continuous in place, view and shape.
class MirrorNormal {
 public:
  /// Unit vectors on one side: `n` interpolated (it may point away from wo), `ng` of the facet,
  /// Dot(ng, wo) > 0.
  MirrorNormal(const Vec3& n, const Vec3& ng, const Vec3& wo)
      : n_(n), ng_(ng), wo_(wo), cos_o_(Dot(n, wo)), reflected_(n * (2.0 * cos_o_) - wo) {
    lift_ = kLift - Dot(ng, reflected_);
    if (!IsBent()) {
      bent_ = n;
      return;
    }
    const Vec3 raised = reflected_ + ng * lift_;
    raised_norm_ = Norm(raised);
    raised_ = raised * (1.0 / raised_norm_);
    const Vec3 half = wo + raised_;
    half_norm_ = Norm(half);
    bent_ = half * (1.0 / half_norm_);
  }

  [[nodiscard]] bool IsBent() const { return lift_ > 0.0; }
  [[nodiscard]] const Vec3& Value() const { return bent_; }

  /// Moves the adjoint of Value() to n, ng and wo. G: Vec3 or ColorGradient.
  template <class G>
  void Pull(G& d_n, G& d_ng, G& d_wo) const {
    if (!IsBent()) {
      return;
    }
    const G d_half = (d_n - Outer(bent_, Dot(bent_, d_n))) * (1.0 / half_norm_);
    const G d_raised = (d_half - Outer(raised_, Dot(raised_, d_half))) * (1.0 / raised_norm_);
    const auto along = Dot(ng_, d_raised);
    const G d_reflected = d_raised - Outer(ng_, along);
    const auto by_cos = Dot(n_, d_reflected) * 2.0;
    d_n = d_reflected * (2.0 * cos_o_) + Outer(wo_, by_cos);
    d_ng += d_raised * lift_ - Outer(reflected_, along);
    d_wo += d_half + Outer(n_, by_cos) - d_reflected;
  }

  static constexpr double kLift = 1e-3;  ///< cosine of the lowest reflection

 private:
  Vec3 n_, ng_, wo_;
  double cos_o_, lift_ = 0.0;
  Vec3 reflected_, raised_, bent_;
  double raised_norm_ = 1.0, half_norm_ = 1.0;
};

}  // namespace pathfit::renderer
