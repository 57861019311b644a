#pragma once

#include <cmath>

namespace pathfit::renderer {

/// Three components on one number type (double, dual numbers, ceres::Jet): kernels are templates on
/// T.
template <class T>
struct Vector3 {
  T x{}, y{}, z{};

  T& operator[](int i) { return i == 0 ? x : (i == 1 ? y : z); }
  const T& operator[](int i) const { return i == 0 ? x : (i == 1 ? y : z); }
  Vector3& operator+=(const Vector3& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  Vector3& operator-=(const Vector3& b) {
    x -= b.x;
    y -= b.y;
    z -= b.z;
    return *this;
  }
  Vector3& operator*=(const T& s) {
    x *= s;
    y *= s;
    z *= s;
    return *this;
  }
  friend Vector3 operator+(Vector3 a, const Vector3& b) { return a += b; }
  friend Vector3 operator-(Vector3 a, const Vector3& b) { return a -= b; }
  friend Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
  friend Vector3 operator*(Vector3 a, const T& s) { return a *= s; }
  friend Vector3 operator*(const T& s, Vector3 a) { return a *= s; }
  friend Vector3 operator/(const Vector3& a, const T& s) { return {a.x / s, a.y / s, a.z / s}; }
  friend bool operator==(const Vector3& a, const Vector3& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  }
};

template <class T>
T Dot(const Vector3<T>& a, const Vector3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Vector3<T> Cross(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T SquaredNorm(const Vector3<T>& a) {
  return Dot(a, a);
}
template <class T>
T Norm(const Vector3<T>& a) {
  using std::sqrt;
  return sqrt(Dot(a, a));
}
template <class T>
Vector3<T> Normalized(const Vector3<T>& a) {
  return a / Norm(a);
}

using Vec3 = Vector3<double>;

struct Vec2 {
  double x = 0.0, y = 0.0;
  friend Vec2 operator+(const Vec2& a, const Vec2& b) { return {a.x + b.x, a.y + b.y}; }
  friend Vec2 operator-(const Vec2& a, const Vec2& b) { return {a.x - b.x, a.y - b.y}; }
  friend Vec2 operator*(const Vec2& a, double s) { return {a.x * s, a.y * s}; }
  friend bool operator==(const Vec2&, const Vec2&) = default;
};

inline bool IsFinite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

}  // namespace pathfit::renderer
