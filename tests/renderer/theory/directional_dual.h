#pragma once

#include <cmath>

namespace pathfit::renderer {

/// A number and its derivative along one variable. Unlike Dual it nests: T may itself be a
/// DirectionalDual, which gives the second derivatives that curvature needs.
template <class T>
struct DirectionalDual {
  T v{};  ///< value
  T d{};  ///< derivative

  DirectionalDual() = default;
  DirectionalDual(double constant)  // NOLINT(google-explicit-constructor): constants mix freely
      : v(constant), d(0.0) {}
  DirectionalDual(const T& value, const T& derivative) : v(value), d(derivative) {}

  DirectionalDual& operator+=(const DirectionalDual& b) { return *this = *this + b; }
  DirectionalDual& operator-=(const DirectionalDual& b) { return *this = *this - b; }
  DirectionalDual& operator*=(const DirectionalDual& b) { return *this = *this * b; }
  friend DirectionalDual operator+(const DirectionalDual& a, const DirectionalDual& b) {
    return {a.v + b.v, a.d + b.d};
  }
  friend DirectionalDual operator-(const DirectionalDual& a, const DirectionalDual& b) {
    return {a.v - b.v, a.d - b.d};
  }
  friend DirectionalDual operator-(const DirectionalDual& a) { return {-a.v, -a.d}; }
  friend DirectionalDual operator*(const DirectionalDual& a, const DirectionalDual& b) {
    return {a.v * b.v, a.d * b.v + a.v * b.d};
  }
  friend DirectionalDual operator/(const DirectionalDual& a, const DirectionalDual& b) {
    const T ratio = a.v / b.v;
    return {ratio, (a.d - ratio * b.d) / b.v};
  }
  // Names of the standard library, found by argument.
  // NOLINTBEGIN(readability-identifier-naming)
  friend DirectionalDual sqrt(const DirectionalDual& a) {
    using std::sqrt;
    const T root = sqrt(a.v);
    return {root, a.d / (2.0 * root)};
  }
  friend DirectionalDual sin(const DirectionalDual& a) {
    using std::cos;
    using std::sin;
    return {sin(a.v), a.d * cos(a.v)};
  }
  friend DirectionalDual cos(const DirectionalDual& a) {
    using std::cos;
    using std::sin;
    return {cos(a.v), -(a.d * sin(a.v))};
  }
  // NOLINTEND(readability-identifier-naming)
};

}  // namespace pathfit::renderer
