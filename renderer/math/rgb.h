#pragma once

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {

/// Linear Rec.709 colour or radiance; arithmetic is per channel.
struct Rgb {
  double r = 0.0, g = 0.0, b = 0.0;

  static Rgb Constant(double v) { return {v, v, v}; }
  double& operator[](int i) { return i == 0 ? r : (i == 1 ? g : b); }
  const double& operator[](int i) const { return i == 0 ? r : (i == 1 ? g : b); }
  Rgb& operator+=(const Rgb& c) {
    r += c.r;
    g += c.g;
    b += c.b;
    return *this;
  }
  Rgb& operator*=(const Rgb& c) {
    r *= c.r;
    g *= c.g;
    b *= c.b;
    return *this;
  }
  Rgb& operator*=(double s) {
    r *= s;
    g *= s;
    b *= s;
    return *this;
  }
  friend Rgb operator+(Rgb a, const Rgb& c) { return a += c; }
  friend Rgb operator-(const Rgb& a, const Rgb& c) { return {a.r - c.r, a.g - c.g, a.b - c.b}; }
  friend Rgb operator*(Rgb a, const Rgb& c) { return a *= c; }
  friend Rgb operator*(Rgb a, double s) { return a *= s; }
  friend Rgb operator*(double s, Rgb a) { return a *= s; }
  friend Rgb operator/(const Rgb& a, double s) { return {a.r / s, a.g / s, a.b / s}; }
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

inline double MaxChannel(const Rgb& c) { return std::max({c.r, c.g, c.b}); }
inline bool IsBlack(const Rgb& c) { return c.r == 0.0 && c.g == 0.0 && c.b == 0.0; }
inline double Luminance(const Rgb& c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; }
inline bool IsFinite(const Rgb& c) {
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}

/// Radiance and coverage (alpha, 0..1) of a pixel, or a derivative of both.
struct Rgba {
  double r = 0.0, g = 0.0, b = 0.0, a = 0.0;

  Rgba() = default;
  Rgba(double red, double green, double blue, double alpha) : r(red), g(green), b(blue), a(alpha) {}
  Rgba(const Rgb& c, double alpha) : r(c.r), g(c.g), b(c.b), a(alpha) {}
  double& operator[](int i) { return i == 0 ? r : (i == 1 ? g : (i == 2 ? b : a)); }
  const double& operator[](int i) const { return i == 0 ? r : (i == 1 ? g : (i == 2 ? b : a)); }
  [[nodiscard]] Rgb Color() const { return {r, g, b}; }
  Rgba& operator+=(const Rgba& c) {
    r += c.r;
    g += c.g;
    b += c.b;
    a += c.a;
    return *this;
  }
  Rgba& operator*=(double s) {
    r *= s;
    g *= s;
    b *= s;
    a *= s;
    return *this;
  }
  friend Rgba operator+(Rgba x, const Rgba& y) { return x += y; }
  friend Rgba operator-(const Rgba& x, const Rgba& y) {
    return {x.r - y.r, x.g - y.g, x.b - y.b, x.a - y.a};
  }
  friend Rgba operator*(Rgba x, double s) { return x *= s; }
  friend bool operator==(const Rgba&, const Rgba&) = default;
};

}  // namespace pathfit::renderer
