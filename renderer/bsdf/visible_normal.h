#pragma once

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Microfacet normal of a GGX surface as seen from the unit direction `wo`, all in the frame of the
/// surface normal (+z), wo.z > 0. Source: [Dupuy2023], spherical caps.
Vec3 SampleVisibleNormal(const Vec3& wo, double alpha, double u0, double u1);

/// D(h) G1(wo) / cos_o: the density of SampleVisibleNormal per solid angle of h, but for the factor
/// max(wo . h, 0). Source: [Heitz2018, eq. 3].
double VisibleNormalFactor(double cos_h2, double cos_o, double alpha);

/// The antithetic partner: slopes negated, that is, h reflected about the surface normal.
inline Vec3 MirroredNormal(const Vec3& h) { return {-h.x, -h.y, h.z}; }

/// wo . (mirrored h) over wo . h for the normal h half way between wi and wo; zero where the
/// mirrored normal is seen from behind.
double MirroredFacing(double cos_i, double cos_o, double dot_io);

}  // namespace pathfit::renderer
