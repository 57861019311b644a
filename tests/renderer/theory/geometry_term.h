#pragma once

#include <cmath>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// A surface point and its unit normal; also their rates of change, per unit of the parameter.
template <class T>
struct OrientedPoint {
  Vector3<T> x, n;
};

/// G(x, y) without visibility: |n_x . d| |n_y . d| / (d . d)^2, d = y - x. Unit 1/area.
/// [path_space 1.1]
template <class T>
T GeometryTerm(const OrientedPoint<T>& x, const OrientedPoint<T>& y) {
  using std::abs;
  const Vector3<T> d = y.x - x.x;
  const T squared = SquaredNorm(d);
  return abs(Dot(x.n, d) * Dot(y.n, d)) / (squared * squared);
}

/// G'/G.  [path_space 1.4]
template <class T>
T LogGeometryTermDerivative(const OrientedPoint<T>& x,
                            const OrientedPoint<T>& y,
                            const OrientedPoint<T>& x_rate,
                            const OrientedPoint<T>& y_rate) {
  const Vector3<T> d = y.x - x.x;
  const Vector3<T> d_rate = y_rate.x - x_rate.x;
  return (Dot(x_rate.n, d) + Dot(x.n, d_rate)) / Dot(x.n, d) +
         (Dot(y_rate.n, d) + Dot(y.n, d_rate)) / Dot(y.n, d) -
         4.0 * Dot(d, d_rate) / SquaredNorm(d);
}

/// A pinhole at `centre`: orthonormal `right`, `down`, `axis` (viewing direction), focal length in
/// pixels. Image coordinates are relative to the principal point, in pixels.
template <class T>
struct Pinhole {
  Vector3<T> centre, right, down, axis;
  T focal{};
};
/// Velocity of the pinhole and its angular velocity (the axes turn by Omega x axis).
template <class T>
struct PinholeMotion {
  Vector3<T> velocity, spin;
};
template <class T>
struct PinholeImage {
  T u{}, v{};
};

/// u(x).
template <class T>
PinholeImage<T> ImageOf(const Pinhole<T>& camera, const Vector3<T>& x) {
  const Vector3<T> y = x - camera.centre;
  const T scale = camera.focal / Dot(y, camera.axis);
  return {Dot(y, camera.right) * scale, Dot(y, camera.down) * scale};
}

/// f^2 |n . y| / y_z^3, y = x - c: pixel area per surface area. The pixel's W_e in area form is
/// this times its filter H(u(x)).  [path_space 1.1]
template <class T>
T PinholeWeight(const Pinhole<T>& camera, const OrientedPoint<T>& x) {
  using std::abs;
  const Vector3<T> y = x.x - camera.centre;
  const T depth = Dot(y, camera.axis);
  return camera.focal * camera.focal * abs(Dot(x.n, y)) / (depth * depth * depth);
}

/// d/dpi of a point's coordinates in the camera's frame, as a world vector: v_x - v_c - Omega x y.
template <class T>
Vector3<T> VelocitySeenBy(const Pinhole<T>& camera,
                          const PinholeMotion<T>& motion,
                          const Vector3<T>& x,
                          const Vector3<T>& velocity) {
  return velocity - motion.velocity - Cross(motion.spin, x - camera.centre);
}

/// u': image velocity of a point that moves with this velocity. Pixels per unit of the parameter.
template <class T>
PinholeImage<T> ImageVelocity(const Pinhole<T>& camera,
                              const PinholeMotion<T>& motion,
                              const Vector3<T>& x,
                              const Vector3<T>& velocity) {
  const Vector3<T> y = x - camera.centre;
  const Vector3<T> rate = VelocitySeenBy(camera, motion, x, velocity);
  const T depth = Dot(y, camera.axis);
  const T depth_rate = Dot(rate, camera.axis);
  const auto along = [&](const Vector3<T>& side) {
    return camera.focal * (Dot(rate, side) - Dot(y, side) * depth_rate / depth) / depth;
  };
  return {along(camera.right), along(camera.down)};
}

/// W'/W of PinholeWeight: (n'.y + n.y')/(n.y) - 3 y_z'/y_z. With a filter, add
/// FilterLogDerivative.  [path_space 1.4]
template <class T>
T LogPinholeWeightDerivative(const Pinhole<T>& camera,
                             const PinholeMotion<T>& motion,
                             const OrientedPoint<T>& x,
                             const OrientedPoint<T>& x_rate) {
  const Vector3<T> y = x.x - camera.centre;
  const Vector3<T> y_rate = x_rate.x - motion.velocity;
  const T depth_rate = Dot(VelocitySeenBy(camera, motion, x.x, x_rate.x), camera.axis);
  return (Dot(x_rate.n, y) + Dot(x.n, y_rate)) / Dot(x.n, y) -
         3.0 * depth_rate / Dot(y, camera.axis);
}

/// (grad H . u') / H of a filter with this value and gradient at u(x).
template <class T>
T FilterLogDerivative(const T& filter,
                      const PinholeImage<T>& gradient,
                      const PinholeImage<T>& velocity) {
  return (gradient.u * velocity.u + gradient.v * velocity.v) / filter;
}

}  // namespace pathfit::renderer
