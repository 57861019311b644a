#pragma once

#include <cmath>
#include <numbers>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Where a direction from a projector crosses its picture, and the radiant intensity there per unit
/// of intensity * texture.
template <class T>
struct ProjectorPoint {
  bool inside = false;  ///< false behind the projector and beside the picture: nothing is cast
  T u{}, v{};           ///< [0, 1], u to the right, v up
  T scale{};            ///< pi / cos^3 of the angle to the axis (1/sr)
};

/// `w` (any length) in the projector's own frame, looking along -z. A facing surface at depth z =
/// r cos t receives scale / r^2 = pi / (z^2 cos t), so that a plane across the axis at depth 1
/// receives pi times the picture wherever it lies. Template on the number type: double or
/// ceres::Jet.
template <class T>
ProjectorPoint<T> ProjectorPointTowards(const Vector3<T>& w,
                                        const T& tan_half_width,
                                        const T& tan_half_height) {
  using std::abs;
  const T depth = -w.z;
  if (!(depth > T(0.0)) || abs(w.x) > tan_half_width * depth ||
      abs(w.y) > tan_half_height * depth) {
    return {};
  }
  const T secant = Norm(w) / depth;
  return {true,
          T(0.5) + T(0.5) * w.x / (tan_half_width * depth),
          T(0.5) + T(0.5) * w.y / (tan_half_height * depth),
          T(std::numbers::pi) * secant * secant * secant};
}

/// The point and its gradients by a unit direction w in the projector's own frame (tangential).
/// Zero outside the picture; the jump at its border has no part in them.
struct ProjectorPartials {
  ProjectorPoint<double> point;
  Vec3 d_u, d_v, d_scale;
};
inline ProjectorPartials ProjectorDerivative(const Vec3& w,
                                             double tan_half_width,
                                             double tan_half_height) {
  ProjectorPartials p{ProjectorPointTowards(w, tan_half_width, tan_half_height), {}, {}, {}};
  if (p.point.inside) {
    const double inverse = -1.0 / w.z;  // of the depth
    p.d_u = Vec3{1.0, 0.0, w.x * inverse} * (0.5 * inverse / tan_half_width);
    p.d_v = Vec3{0.0, 1.0, w.y * inverse} * (0.5 * inverse / tan_half_height);
    p.d_scale = (w + Vec3{0.0, 0.0, inverse}) * (3.0 * p.point.scale);
  }
  return p;
}

}  // namespace pathfit::renderer
