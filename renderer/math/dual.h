#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace pathfit::renderer {

/// Forward-mode dual number with N partial derivatives: local partials of small kernels.
template <int N>
struct Dual {
  double v = 0.0;
  std::array<double, N> d{};

  Dual() = default;
  Dual(double value)  // NOLINT(google-explicit-constructor): constants mix freely in kernels
      : v(value) {}
  /// The i-th independent variable.
  static Dual Variable(double value, int i) {
    Dual x(value);
    x.d[static_cast<std::size_t>(i)] = 1.0;
    return x;
  }

  friend Dual operator+(Dual a, const Dual& b) {
    a.v += b.v;
    for (std::size_t i = 0; i < N; ++i) a.d[i] += b.d[i];
    return a;
  }
  friend Dual operator-(Dual a, const Dual& b) {
    a.v -= b.v;
    for (std::size_t i = 0; i < N; ++i) a.d[i] -= b.d[i];
    return a;
  }
  friend Dual operator-(Dual a) {
    a.v = -a.v;
    for (double& x : a.d) x = -x;
    return a;
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual r(a.v * b.v);
    for (std::size_t i = 0; i < N; ++i) r.d[i] = a.d[i] * b.v + a.v * b.d[i];
    return r;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double inverse = 1.0 / b.v;
    Dual r(a.v * inverse);
    for (std::size_t i = 0; i < N; ++i) r.d[i] = (a.d[i] - r.v * b.d[i]) * inverse;
    return r;
  }
  friend Dual sqrt(const Dual& a) {
    const double s = std::sqrt(a.v);
    Dual r(s);
    for (std::size_t i = 0; i < N; ++i) r.d[i] = 0.5 * a.d[i] / s;
    return r;
  }
  friend Dual exp(const Dual& a) {
    Dual r(std::exp(a.v));
    for (std::size_t i = 0; i < N; ++i) r.d[i] = r.v * a.d[i];
    return r;
  }
  friend Dual erf(const Dual& a) {
    Dual r(std::erf(a.v));
    const double slope = 2.0 * std::numbers::inv_sqrtpi * std::exp(-a.v * a.v);
    for (std::size_t i = 0; i < N; ++i) r.d[i] = slope * a.d[i];
    return r;
  }
};

}  // namespace pathfit::renderer
