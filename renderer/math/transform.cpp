#include "renderer/math/transform.h"

#include <stdexcept>

namespace pathfit::renderer {

Mat3 RotationAboutAxis(const Vec3& unit_axis, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const auto rotate = [&](const Vec3& v) {
    return v * c + Cross(unit_axis, v) * s + unit_axis * (Dot(unit_axis, v) * (1.0 - c));
  };
  return {rotate({1, 0, 0}), rotate({0, 1, 0}), rotate({0, 0, 1})};
}

Transform LookAt(const Vec3& origin, const Vec3& target, const Vec3& up) {
  const Vec3 backward = origin - target;
  const Vec3 right = Cross(up, backward);
  if (!(SquaredNorm(backward) > 0.0) || !(SquaredNorm(right) > 0.0)) {
    throw std::invalid_argument("look_at: origin, target and up do not span a frame");
  }
  const Vec3 z = Normalized(backward);
  const Vec3 x = Normalized(right);
  return {{x, Cross(z, x), z}, origin};
}

}  // namespace pathfit::renderer
