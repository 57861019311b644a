#pragma once

#include <string>

#include "renderer/math/transform.h"

namespace pathfit::optim {

/// The rotation nearest to `matrix`. Throws IoError starting with `place` when the matrix differs
/// from a rotation by more than 1e-4 (largest entry of M^T M - I, or a reflection).
renderer::Mat3 ExactRotation(const renderer::Mat3& matrix, const std::string& place);

/// Rotation of a quaternion (w, x, y, z). Throws IoError when its length differs from 1 by more
/// than 1e-4.
renderer::Mat3 RotationFromQuaternion(
    double w, double x, double y, double z, const std::string& place);

}  // namespace pathfit::optim
