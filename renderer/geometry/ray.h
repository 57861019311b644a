#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Largest magnitude of a world coordinate, metres: the ray caster's floats reach 3e38, and hold
/// products of three.
inline constexpr double kMaxCoordinate = 1e12;

/// Whether all coordinates are numbers up to kMaxCoordinate.
inline bool IsWithinBounds(const Vec3& x) {
  return std::abs(x.x) <= kMaxCoordinate && std::abs(x.y) <= kMaxCoordinate &&
         std::abs(x.z) <= kMaxCoordinate;
}

struct Ray {
  Vec3 origin;
  Vec3 direction;  ///< unit
};

/// A ray that ends; infinity allowed.
struct Segment {
  Ray ray;
  double length = 0.0;
};

/// A triangle of the scene.
struct TriangleId {
  std::int32_t mesh = -1;
  std::int32_t triangle = -1;
  [[nodiscard]] bool IsValid() const { return mesh >= 0; }
  friend auto operator<=>(const TriangleId&, const TriangleId&) = default;
};

/// A point on a triangle: barycentric weights of its second and third vertex, distance along the
/// ray in metres.
struct Hit {
  TriangleId id;
  double b1 = 0.0, b2 = 0.0;
  double distance = 0.0;
};

}  // namespace pathfit::renderer
