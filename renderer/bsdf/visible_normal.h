#pragma once

#include <numbers>

#include "renderer/bsdf/microfacet_distribution.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Microfacet normal as seen from the unit direction `wo`, all in the frame of the surface normal
/// (+z), wo.z > 0. GGX by spherical caps [Dupuy2023]. Beckmann by slopes of the surface stretched
/// to alpha = 1: the one across wo has the distribution of all slopes, the one along wo that times
/// the area seen [Heitz2014b].
Vec3 SampleVisibleNormal(Ggx distribution, const Vec3& wo, double alpha, double u0, double u1);
Vec3 SampleVisibleNormal(Beckmann distribution, const Vec3& wo, double alpha, double u0, double u1);

/// D(h) G1(wo) / cos_o: the density of SampleVisibleNormal per solid angle of h, but for the factor
/// max(wo . h, 0). Source: [Heitz2018, eq. 3].
template <class Distribution>
double VisibleNormalFactor(double cos_h2, double cos_o, double alpha) {
  return 2.0 * Distribution::Density(cos_h2, alpha) /
         (cos_o + Distribution::ProjectedArea(cos_o, alpha));
}

/// The antithetic partner: slopes negated, that is, h reflected about the surface normal.
inline Vec3 MirroredNormal(const Vec3& h) { return {-h.x, -h.y, h.z}; }

/// wo . (mirrored h) over wo . h for the normal h half way between wi and wo; zero where the
/// mirrored normal is seen from behind.
double MirroredFacing(double cos_i, double cos_o, double dot_io);

}  // namespace pathfit::renderer
