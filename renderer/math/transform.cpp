#include "renderer/math/transform.h"

#include <stdexcept>

namespace pathfit::renderer {
namespace {

/// a I + b [r]x + c r r^T.
Mat3 RotationSeries(const Vec3& r, double a, double b, double c) {
  const auto column = [&](const Vec3& e, double along) {
    return e * a + Cross(r, e) * b + r * (along * c);
  };
  return {column({1, 0, 0}, r.x), column({0, 1, 0}, r.y), column({0, 0, 1}, r.z)};
}

double SineRatio(double angle) { return angle > 0.0 ? std::sin(angle) / angle : 1.0; }

/// (1 - cos t) / t^2 without cancellation.
double VersineRatio(double angle) {
  const double half = SineRatio(0.5 * angle);
  return 0.5 * half * half;
}

/// (t - sin t) / t^3.
double CubicRatio(double angle) {
  if (angle > 1.0) return (angle - std::sin(angle)) / (angle * angle * angle);
  // The first term left out is below 1/23!.
  constexpr int kLastTerm = 9;
  const double t2 = angle * angle;
  double sum = 1.0;
  for (int k = kLastTerm; k > 0; --k) sum = 1.0 - sum * t2 / ((2.0 * k + 2.0) * (2.0 * k + 3.0));
  return sum / 6.0;
}

}  // namespace

Mat3 RotationAboutAxis(const Vec3& unit_axis, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const auto rotate = [&](const Vec3& v) {
    return v * c + Cross(unit_axis, v) * s + unit_axis * (Dot(unit_axis, v) * (1.0 - c));
  };
  return {rotate({1, 0, 0}), rotate({0, 1, 0}), rotate({0, 0, 1})};
}

Mat3 RotationFromVector(const Vec3& rotation) {
  const double angle = Norm(rotation);
  return RotationSeries(rotation, std::cos(angle), SineRatio(angle), VersineRatio(angle));
}

Mat3 RotationLeftJacobian(const Vec3& rotation) {
  const double angle = Norm(rotation);
  return RotationSeries(rotation, SineRatio(angle), VersineRatio(angle), CubicRatio(angle));
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
