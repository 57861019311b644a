#pragma once

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Each warp maps two uniform numbers to a direction around +z; densities are per steradian.
Vec3 SampleCosineHemisphere(double u0, double u1);
double CosineHemispherePdf(double cos_theta);

Vec3 SampleUniformHemisphere(double u0, double u1);
double UniformHemispherePdf();

/// Density 1 / (4 pi).
Vec3 SampleUniformSphere(double u0, double u1);

}  // namespace pathfit::renderer
