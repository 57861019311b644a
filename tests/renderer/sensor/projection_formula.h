#pragma once

#include <array>

#include "renderer/sensor/camera.h"

namespace pathfit::tests {

/// Brown's polynomial written once more, on any number type with + and *.
template <class T>
std::array<T, 2> DistortByFormula(const std::array<T, 5>& k, const T& a, const T& b) {
  const T r2 = a * a + b * b;
  const T radial = T(1.0) + k[0] * r2 + k[1] * r2 * r2 + k[2] * r2 * r2 * r2;
  return {a * radial + T(2.0) * k[3] * a * b + k[4] * (r2 + T(2.0) * a * a),
          b * radial + k[3] * (r2 + T(2.0) * b * b) + T(2.0) * k[4] * a * b};
}

/// x in the camera frame, from a pose of plain numbers.
template <class T>
renderer::Vector3<T> InCamera(const renderer::Transform& pose, const renderer::Vector3<T>& x) {
  const renderer::Vector3<T> y{
      x.x - T(pose.translation.x), x.y - T(pose.translation.y), x.z - T(pose.translation.z)};
  const auto along = [&](const renderer::Vec3& axis) {
    return y.x * T(axis.x) + y.y * T(axis.y) + y.z * T(axis.z);
  };
  return {along(pose.linear.x), along(pose.linear.y), along(pose.linear.z)};
}

/// Pixel coordinates by the definition of both cameras, with the intrinsics of any number type.
template <class T>
std::array<T, 2> ProjectByFormula(const renderer::Camera& camera,
                                  const std::array<T, 9>& intrinsics,
                                  const renderer::Vector3<T>& x) {
  const renderer::Vector3<T> p = InCamera(renderer::CameraPose(camera), x);
  std::array<T, 2> d = {p.x, -p.y};
  if (camera.projection == renderer::ProjectionKind::kPerspective) {
    const std::array<T, 5> k = {
        intrinsics[4], intrinsics[5], intrinsics[6], intrinsics[7], intrinsics[8]};
    d = DistortByFormula(k, p.x / -p.z, p.y / p.z);
  }
  return {d[0] * intrinsics[0] + intrinsics[2], d[1] * intrinsics[1] + intrinsics[3]};
}

template <class T>
std::array<T, 9> Constants(const std::array<double, 9>& values) {
  std::array<T, 9> out;
  for (std::size_t i = 0; i < values.size(); ++i) out[i] = T(values[i]);
  return out;
}

}  // namespace pathfit::tests
