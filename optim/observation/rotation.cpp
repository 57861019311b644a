#include "optim/observation/rotation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

using renderer::Cross;
using renderer::Determinant;
using renderer::Dot;
using renderer::Mat3;

constexpr double kRotationTolerance = 1e-4;
constexpr int kPolarIterations =
    6;  // the error squares each time: 1e-4 is far below rounding after three

}  // namespace

Mat3 ExactRotation(const Mat3& matrix, const std::string& place) {
  const double error = std::max({std::abs(Dot(matrix.x, matrix.x) - 1.0),
                                 std::abs(Dot(matrix.y, matrix.y) - 1.0),
                                 std::abs(Dot(matrix.z, matrix.z) - 1.0),
                                 std::abs(Dot(matrix.x, matrix.y)),
                                 std::abs(Dot(matrix.y, matrix.z)),
                                 std::abs(Dot(matrix.z, matrix.x))});
  const double determinant = Determinant(matrix);
  if (!(error <= kRotationTolerance) || determinant <= 0.0) {
    char text[200];
    std::snprintf(text,
                  sizeof text,
                  ": the rotation part is not a rotation (columns and their products are off by "
                  "%.3g, determinant "
                  "%.6g; allowed: 1e-4, +1)",
                  error,
                  determinant);
    throw renderer::IoError(place + text);
  }
  Mat3 rotation = matrix;
  for (int i = 0; i < kPolarIterations; ++i) {
    // Newton's iteration for the polar factor: R <- (R + R^-T) / 2, the cofactors being the inverse
    // transpose.
    const double scale = 0.5 / Determinant(rotation);
    rotation = {rotation.x * 0.5 + Cross(rotation.y, rotation.z) * scale,
                rotation.y * 0.5 + Cross(rotation.z, rotation.x) * scale,
                rotation.z * 0.5 + Cross(rotation.x, rotation.y) * scale};
  }
  return rotation;
}

Mat3 RotationFromQuaternion(double w, double x, double y, double z, const std::string& place) {
  const double norm = std::sqrt(w * w + x * x + y * y + z * z);
  if (!(std::abs(norm - 1.0) <= kRotationTolerance)) {
    char text[120];
    std::snprintf(text, sizeof text, ": the quaternion has length %.6g (allowed: 1 to 1e-4)", norm);
    throw renderer::IoError(place + text);
  }
  const double s = 2.0 / (norm * norm);
  return {{1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
          {s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)},
          {s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)}};
}

}  // namespace pathfit::optim
