#pragma once

#include <cmath>

#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"
#include "renderer/geometry/ray.h"

namespace pathfit::app {

// Vectors of the configuration, and the rotations and limits that several parts of it share.

/// No coordinate or length may be larger.
inline constexpr double kMaxLength = renderer::kMaxCoordinate;
/// No radiance or intensity may be larger: sums of squares still fit double precision.
inline constexpr double kMaxRadiance = 1e20;

inline bool IsZero(const Triple& v) { return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0; }
inline double Norm(const Triple& v) { return std::hypot(v[0], v[1], v[2]); }
inline Triple Minus(const Triple& a, const Triple& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Triple Cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// One of them is zero or they point the same way, within rounding.
inline bool AreParallel(const Triple& a, const Triple& b) {
  constexpr double kParallel = 1e-9;
  return Norm(Cross(a, b)) <= kParallel * Norm(a) * Norm(b);
}

/// Coordinates.
template <class... Members>
SchemaNode Point(std::string key, Members... members) {
  return Key(std::move(key), members...) | From(-kMaxLength, kMaxLength) | Unit("metres");
}

/// A colour that shines.
template <class... Members>
SchemaNode Light(std::string key, std::string unit, Members... members) {
  return Colour(std::move(key), members...) | From(0.0, kMaxRadiance) | Unit(std::move(unit));
}

inline WordsOf<FovAxis> FovAxes() {
  return {{"x", FovAxis::kX},
          {"y", FovAxis::kY},
          {"smaller", FovAxis::kSmaller},
          {"larger", FovAxis::kLarger},
          {"diagonal", FovAxis::kDiagonal}};
}

/// `rotate: {axis, angle_deg}` of a struct with `axis` and `angle`.
template <class T>
SchemaNode Rotation(std::string doc) {
  return Map("rotate",
             {Key("axis", &T::axis) | Doc("Axis of the rotation; its length does not matter.") |
                  Required(),
              Degrees("angle_deg", &T::angle) | Doc("Angle, right-handed about the axis.") |
                  Required()}) |
         Doc(std::move(doc)) | Check(+[](T& values, const CheckedMap& map) {
           if (map.Find("axis") == nullptr || !IsZero(values.axis)) return;
           map.Report("axis", "the axis must not be [0, 0, 0]");
         });
}

}  // namespace pathfit::app
