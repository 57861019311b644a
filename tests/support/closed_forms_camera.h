#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/quadrature.h"

// Known answers for a pixel: the cases C12-C17, C20, C25, C30 of path_space 6.3. Conventions:
// radiance 1 where none is named, u in pixels from the optical axis, f in pixels, camera at the
// origin looking along +z, `value` the pixel's measurement with a filter whose integral is 1.
namespace pathfit::tests {

/// A pixel filter in one variable: symmetric, zero beyond `radius`, integral 1.
struct Filter1D {
  enum class Kind { kBox, kTent, kGauss };
  Kind kind = Kind::kBox;
  double radius = 0.5;
  double sigma = 0.5;  ///< of the Gaussian, which is lowered to reach zero at the radius

  [[nodiscard]] double Value(double u) const {
    if (std::abs(u) > radius) return 0.0;
    if (kind == Kind::kBox) return 0.5 / radius;
    if (kind == Kind::kTent) return (1.0 - std::abs(u) / radius) / radius;
    return (Bell(u) - Bell(radius)) / GaussNorm();
  }
  [[nodiscard]] double Derivative(double u) const {
    if (std::abs(u) > radius || kind == Kind::kBox) return 0.0;
    if (kind == Kind::kTent) return (u < 0.0 ? 1.0 : -1.0) / (radius * radius);
    return -u / (sigma * sigma) * Bell(u) / GaussNorm();
  }
  /// Integral of the filter up to u.
  [[nodiscard]] double Cumulative(double u) const {
    const double x = std::clamp(u, -radius, radius);
    if (kind == Kind::kBox) return 0.5 + 0.5 * x / radius;
    if (kind == Kind::kTent) {
      const double rest = 1.0 - std::abs(x) / radius;
      return x < 0.0 ? 0.5 * rest * rest : 1.0 - 0.5 * rest * rest;
    }
    return 0.5 + (BellIntegral(x) - x * Bell(radius)) / GaussNorm();
  }

 private:
  [[nodiscard]] double Bell(double u) const { return std::exp(-0.5 * u * u / (sigma * sigma)); }
  /// From 0 to u.
  [[nodiscard]] double BellIntegral(double u) const {
    return sigma * std::sqrt(0.5 * std::numbers::pi) * std::erf(u / (sigma * std::numbers::sqrt2));
  }
  [[nodiscard]] double GaussNorm() const {
    return 2.0 * (BellIntegral(radius) - radius * Bell(radius));
  }
};

/// C12: bright half plane at depth z that ends at x and fills the pixel's side u < f x / z.
struct C12Answer {
  double value, d_x, d_z, d_yaw;
};
inline C12Answer C12FilterEdge(const Filter1D& filter, double f, double z, double x) {
  const double s = f * x / z;
  const double h = filter.Value(s);
  return {filter.Cumulative(s), h * f / z, -h * f * x / (z * z), -h * (f + s * s / f)};
}

/// C13: bright quad width x length around the axis at depth z, tilted about its width, inside one
/// pixel of area 1.
struct C13Answer {
  double value, d_z, d_tilt, d_f;
};
inline C13Answer C13TiltedQuad(double f, double width, double length, double z, double tilt) {
  const double depth_half = 0.5 * length * std::sin(tilt);
  const double b = z * z - depth_half * depth_half;
  const double area = f * f * width * length * std::cos(tilt) * z * z / (b * b);
  return {area,
          area * (2.0 / z - 4.0 * z / b),
          area * (-std::tan(tilt) + length * length * std::sin(tilt) * std::cos(tilt) / b),
          2.0 * area / f};
}

/// C13b: bright fronto-parallel quad width x length around (cx, cy, z) under filter(u) filter(v).
struct C13bAnswer {
  double value, d_cx, d_cy, d_z;
};
inline C13bAnswer C13bFilteredQuad(
    const Filter1D& filter, double f, double width, double length, double cx, double cy, double z) {
  struct Axis {
    double value, d_centre, d_z;
  };
  const auto along = [&](double centre, double size) -> Axis {
    const double u0 = f * (centre - 0.5 * size) / z;
    const double u1 = f * (centre + 0.5 * size) / z;
    const double h0 = filter.Value(u0);
    const double h1 = filter.Value(u1);
    return {
        filter.Cumulative(u1) - filter.Cumulative(u0), f / z * (h1 - h0), (h0 * u0 - h1 * u1) / z};
  };
  const Axis u = along(cx, width);
  const Axis v = along(cy, length);
  return {u.value * v.value,
          u.d_centre * v.value,
          u.value * v.d_centre,
          u.d_z * v.value + u.value * v.d_z};
}

/// Parts of a derivative in material form. `filter` is the pixel boundary under a box filter and
/// the interior's grad H . u' under a smooth one; the total is the sum.
struct MaterialSplit {
  double interior, filter;
};
/// C14: uniform plane fronto-parallel at depth z that moves in depth.
inline MaterialSplit C14MovingPlane(double z) { return {-2.0 / z, 2.0 / z}; }
/// C15: uniform plane of depth z0 + slope x that moves along x.
inline MaterialSplit C15TiltedPlane(double z0, double slope) { return {-slope / z0, slope / z0}; }

/// C15b: plane at depth z of radiance a + b X, X = x - s its own coordinate, seen by any symmetric
/// filter around u.
struct C15bAnswer {
  double value, d_s;
};
inline C15bAnswer C15bTexturedPlane(double a, double b, double f, double z, double s, double u) {
  return {a + b * (z * u / f - s), -b};
}

/// C16: closed diffuse furnace, every face emits and reflects: radiance after at most `bounces`
/// bounces, all of them if negative. Derivatives by any geometry are zero.
struct C16Answer {
  double value, d_albedo;
};
inline C16Answer C16Furnace(double emitted, double albedo, int bounces) {
  const double rest = 1.0 - albedo;
  if (bounces < 0) return {emitted / rest, emitted / (rest * rest)};
  const double tail = std::pow(albedo, bounces);
  return {emitted * (1.0 - tail * albedo) / rest,
          emitted * ((1.0 - tail * albedo) / (rest * rest) - (bounces + 1) * tail / rest)};
}

/// C17: diffuse convex body in a sky of radiance 1, wholly in the image: sum over all pixels of the
/// derivative is (albedo - 1) times that of its image's area.
struct C17Answer {
  double area, d_radius, d_distance;  ///< area in square pixels; the derivatives of the image's sum
};
inline C17Answer C17SphereInSky(double f, double albedo, double radius, double distance) {
  const double r2 = radius * radius;
  const double d2 = distance * distance;
  const double k = 2.0 * std::numbers::pi * f * f / ((d2 - r2) * (d2 - r2)) * (albedo - 1.0);
  return {std::numbers::pi * f * f * r2 / (d2 - r2), k * radius * d2, -k * r2 * distance};
}
/// The same for a cube seen straight on, by its half edge (its centre stays).
inline double C17CubeInSky(double f, double albedo, double half_edge, double distance) {
  const double depth = distance - half_edge;
  const double side = 2.0 * f * half_edge / depth;
  return (albedo - 1.0) * 2.0 * side * 2.0 * f * distance / (depth * depth);
}
/// The same for a sphere seen by an orthographic camera of one pixel per unit of area.
inline double C17OrthographicSphere(double albedo, double radius) {
  return (albedo - 1.0) * 2.0 * std::numbers::pi * radius;
}

/// C20: GGX mirror with Fresnel 1 in a sky of radiance 1, seen under the angle theta to its normal;
/// Smith shadowing, separable or height-correlated. A quadrature, good to 1e-9 for alpha >= 0.1.
inline double C20WhiteGgx(double alpha, double theta, bool correlated) {
  const double a2 = alpha * alpha;
  const double sine = std::sin(theta);
  const double cosine = std::cos(theta);
  const auto lambda = [&](double c) {
    return 0.5 * (std::sqrt(1.0 + a2 * (1.0 - c * c) / (c * c)) - 1.0);
  };
  const auto at = [&](double t, double phi) {  // half vector by tan of its angle and azimuth
    const double cos_h = 1.0 / std::sqrt(1.0 + t * t);
    const double dot = cos_h * (sine * t * std::cos(phi) + cosine);
    const double cos_i = 2.0 * dot * cos_h - cosine;
    const double l_i = lambda(cos_i);
    const double l_o = lambda(cosine);
    const double g = correlated ? 1.0 / (1.0 + l_i + l_o) : 1.0 / ((1.0 + l_i) * (1.0 + l_o));
    // D dw_h = a2 / (pi (a2 + t^2)^2 cos_h) t dt dphi, times G (o.h) / cos_o
    return a2 / (std::numbers::pi * (a2 + t * t) * (a2 + t * t) * cos_h) * g * dot / cosine * t;
  };
  const auto around = [&](double phi) {
    // The reflected direction is on the horizon where twice the half vector's angle is this.
    const double last = std::tan(0.5 * std::atan2(cosine, -sine * std::cos(phi)));
    return Integrate([&](double t) { return at(t, phi); }, 0.0, last, 48);
  };
  return 2.0 * Integrate(around, 0.0, std::numbers::pi, 8);
}

/// C20b: smooth dielectric at normal incidence: reflectance of a face and transmittance of a slab
/// with all its inner reflections.
struct C20bAnswer {
  double reflectance, d_reflectance, slab, d_slab;
};
inline C20bAnswer C20bDielectric(double eta) {
  const double e2 = eta * eta;
  return {std::pow((eta - 1.0) / (eta + 1.0), 2),
          4.0 * (eta - 1.0) / std::pow(eta + 1.0, 3),
          2.0 * eta / (e2 + 1.0),
          2.0 * (1.0 - e2) / ((e2 + 1.0) * (e2 + 1.0))};
}

/// C25: point light at the camera, diffuse plane seen at distance r under the angle theta to its
/// normal; h = r cos theta is the camera's height above it (d_h at fixed foot).
struct C25Answer {
  double value, d_r, d_theta, d_h;
};
inline C25Answer C25CollocatedLight(double intensity, double albedo, double r, double theta) {
  const double h = r * std::cos(theta);
  const double d = r * std::sin(theta);
  const double k = albedo * intensity / std::numbers::pi;
  const double value = k * std::cos(theta) / (r * r);
  return {value,
          -2.0 * value / r,
          -value * std::tan(theta),
          k * (d * d - 2.0 * h * h) / std::pow(r, 5)};
}

/// C30: C12 with radiance `front` before a background of radiance `back`. The material form splits
/// d_x into the background's primary boundary and the foreground's part, which is its interior for
/// a smooth filter and the pixel boundary at u = -radius for the box.
struct C30Answer {
  double d_x, primary, foreground;
};
inline C30Answer C30ForegroundEdge(
    const Filter1D& filter, double front, double back, double f, double z, double x) {
  const double h = filter.Value(f * x / z) * f / z;
  return {(front - back) * h, -back * h, front * h};
}

}  // namespace pathfit::tests
