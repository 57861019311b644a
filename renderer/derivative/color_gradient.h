#pragma once

#include <array>

#include "renderer/math/rgb.h"
#include "renderer/math/transform.h"

namespace pathfit::renderer {

/// Gradient of a colour by a point or vector: one Vec3 per channel. Together with Vec3 (gradient of
/// a scalar) it is what MotionAdjoint pulls back to parameters; the functions below exist for both.
struct ColorGradient {
  std::array<Vec3, 3> c{};

  Vec3& operator[](int i) { return c[static_cast<std::size_t>(i)]; }
  const Vec3& operator[](int i) const { return c[static_cast<std::size_t>(i)]; }
  ColorGradient& operator+=(const ColorGradient& g) {
    for (std::size_t i = 0; i < 3; ++i) c[i] += g.c[i];
    return *this;
  }
  ColorGradient& operator-=(const ColorGradient& g) {
    for (std::size_t i = 0; i < 3; ++i) c[i] -= g.c[i];
    return *this;
  }
  ColorGradient& operator*=(double s) {
    for (std::size_t i = 0; i < 3; ++i) c[i] *= s;
    return *this;
  }
  friend ColorGradient operator+(ColorGradient a, const ColorGradient& b) { return a += b; }
  friend ColorGradient operator-(ColorGradient a, const ColorGradient& b) { return a -= b; }
  friend ColorGradient operator-(ColorGradient a) { return a *= -1.0; }
  friend ColorGradient operator*(ColorGradient a, double s) { return a *= s; }
};

/// The scalar type that belongs to a gradient type.
template <class G>
struct GradientTraits;
template <>
struct GradientTraits<Vec3> {
  using Scalar = double;
};
template <>
struct GradientTraits<ColorGradient> {
  using Scalar = Rgb;
};

/// vector * scalar: the gradient whose every channel points along v.
inline Vec3 Outer(const Vec3& v, double s) { return v * s; }
inline ColorGradient Outer(const Vec3& v, const Rgb& s) { return {{v * s.r, v * s.g, v * s.b}}; }
inline Rgb Dot(const ColorGradient& g, const Vec3& v) {
  return {Dot(g[0], v), Dot(g[1], v), Dot(g[2], v)};
}
inline Rgb Dot(const Vec3& v, const ColorGradient& g) { return Dot(g, v); }
inline ColorGradient Cross(const Vec3& v, const ColorGradient& g) {
  return {{Cross(v, g[0]), Cross(v, g[1]), Cross(v, g[2])}};
}
inline Vec3 TransposedTimes(const Mat3& m, const Vec3& g) {
  return {Dot(m.x, g), Dot(m.y, g), Dot(m.z, g)};
}
inline ColorGradient TransposedTimes(const Mat3& m, const ColorGradient& g) {
  return {{TransposedTimes(m, g[0]), TransposedTimes(m, g[1]), TransposedTimes(m, g[2])}};
}

}  // namespace pathfit::renderer
