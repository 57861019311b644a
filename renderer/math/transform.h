#pragma once

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// 3x3 matrix by columns.
struct Mat3 {
  Vec3 x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};

  friend Vec3 operator*(const Mat3& m, const Vec3& v) { return m.x * v.x + m.y * v.y + m.z * v.z; }
  friend Mat3 operator*(const Mat3& a, const Mat3& b) { return {a * b.x, a * b.y, a * b.z}; }
  friend bool operator==(const Mat3&, const Mat3&) = default;
};
inline Mat3 Transposed(const Mat3& m) {
  return {{m.x.x, m.y.x, m.z.x}, {m.x.y, m.y.y, m.z.y}, {m.x.z, m.y.z, m.z.z}};
}
inline double Determinant(const Mat3& m) { return Dot(m.x, Cross(m.y, m.z)); }

/// x_in_b = linear * x_in_a + translation, named b_from_a. Rigid for cameras; meshes may also
/// scale.
struct Transform {
  Mat3 linear;
  Vec3 translation;

  [[nodiscard]] Vec3 Point(const Vec3& p) const { return linear * p + translation; }
  [[nodiscard]] Vec3 Direction(const Vec3& d) const { return linear * d; }
  friend Transform operator*(const Transform& a, const Transform& b) {
    return {a.linear * b.linear, a.Point(b.translation)};
  }
  friend bool operator==(const Transform&, const Transform&) = default;
};
/// Inverse of a rotation and translation (not of a scale).
inline Transform RigidInverse(const Transform& t) {
  const Mat3 rotation = Transposed(t.linear);
  return {rotation, -(rotation * t.translation)};
}

/// Rotation about a unit axis, right-handed, in radians.
Mat3 RotationAboutAxis(const Vec3& unit_axis, double angle);

/// Rotation matrix of a rotation vector (axis times radians), to rounding for any length.
Mat3 RotationFromVector(const Vec3& rotation);
/// Left Jacobian of the rotation group: a change dr of the rotation vector turns the rotated frame
/// by the small rotation vector RotationLeftJacobian(r) dr.
Mat3 RotationLeftJacobian(const Vec3& rotation);

/// Camera (x right, y up, looking along -z) at `origin` towards `target`. Units: metres of the
/// world. Fails: std::invalid_argument when the direction is zero or parallel to `up`.
Transform LookAt(const Vec3& origin, const Vec3& target, const Vec3& up);

}  // namespace pathfit::renderer
