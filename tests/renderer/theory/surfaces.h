#pragma once

#include <cmath>

#include "renderer/math/vector.h"
#include "tests/renderer/theory/evolving_surface.h"

// The evolving surfaces of the paper's supplement and of path_space 6.1 and 6.2.
namespace pathfit::tests {

using renderer::CurveNormalVelocity;
using renderer::LocalPoint;
using renderer::MaterialPoint;
using renderer::Vec3;
using renderer::Vector3;

/// {(x, y, pi): pi < x, y < 1 + pi}, labelled so that it translates by (pi, pi, pi).  [S 6]
struct SquareGlobal {
  template <class T>
  Vector3<T> operator()(const LocalPoint<T>& at) const {
    return {at.xi1 + at.pi, at.xi2 + at.pi, at.pi};
  }
};
/// The same surface by x and y: points move straight up, the border moves over them.  [S 8]
struct SquareLocal {
  template <class T>
  Vector3<T> operator()(const LocalPoint<T>& at) const {
    return {at.xi1, at.xi2, at.pi};
  }
};
/// Sphere of radius pi: longitude xi1, cosine of the polar angle xi2.  [S 24]
struct ScalingSphere {
  template <class T>
  Vector3<T> operator()(const LocalPoint<T>& at) const {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const T ring = at.pi * sqrt(1.0 - at.xi2 * at.xi2);
    return {ring * cos(at.xi1), ring * sin(at.xi1), at.pi * at.xi2};
  }
};
/// Unit square hinged on the y axis, at angle pi.
struct RotatingSheet {
  template <class T>
  Vector3<T> operator()(const LocalPoint<T>& at) const {
    using std::cos;
    using std::sin;
    return {at.xi1 * cos(at.pi), at.xi2, at.xi1 * sin(at.pi)};
  }
};
/// Cylinder of radius pi about z: longitude xi1, height xi2.
struct ExpandingCylinder {
  template <class T>
  Vector3<T> operator()(const LocalPoint<T>& at) const {
    using std::cos;
    using std::sin;
    return {at.pi * cos(at.xi1), at.pi * sin(at.xi1), at.xi2};
  }
};
/// A curved patch that bends and shears: nothing about it is special.
struct WavingPatch {
  template <class T>
  Vector3<T> operator()(const LocalPoint<T>& at) const {
    using std::cos;
    using std::sin;
    return {at.xi1 + 0.3 * at.pi * sin(at.xi2),
            at.xi2 + 0.2 * at.pi * at.xi1 * at.xi2,
            0.4 * sin(at.xi1 + at.pi) * cos(at.xi2) + 0.1 * at.xi1 * at.xi1};
  }
};
/// The labels of the WavingPatch that Relabelled uses: they slide with pi.
template <class T>
LocalPoint<T> SlidLabels(const LocalPoint<T>& at) {
  return {at.xi1 + 0.2 * at.pi * at.xi2, at.xi2 - 0.3 * at.pi * at.xi1 * at.xi1, at.pi};
}
/// The same surface as WavingPatch under other labels.
struct RelabelledPatch {
  template <class T>
  Vector3<T> operator()(const LocalPoint<T>& at) const {
    return WavingPatch()(SlidLabels(at));
  }
};

/// phi = x^2 + y^2 + z^2.  [S 13]
struct SquaredDistance {
  template <class T>
  T operator()(const Vector3<T>& x, const T& /*pi*/) const {
    return Dot(x, x);
  }
};
struct UnitField {
  template <class T>
  T operator()(const Vector3<T>& /*x*/, const T& /*pi*/) const {
    return T(1.0);
  }
};
/// A field that also depends on the parameter itself.
struct WavingField {
  template <class T>
  T operator()(const Vector3<T>& x, const T& pi) const {
    using std::cos;
    using std::sin;
    return 1.0 + sin(x.x + 2.0 * pi) * x.y + x.z * cos(x.y * pi);
  }
};

}  // namespace pathfit::tests
