#pragma once

#include <cmath>

namespace pathfit::renderer {

/// Share of a spot's full intensity towards a direction whose cosine with the axis is `cos_axis`:
/// smoothstep 3 t^2 - 2 t^3 of t = (cos_axis - cos outer) / (cos inner - cos outer), 1 inside the
/// inner and 0 outside the outer cone. Angles in radians. Template on the number type: double or
/// ceres::Jet.
template <class T>
T SpotFalloff(const T& cos_axis, const T& inner_angle, const T& outer_angle) {
  using std::cos;
  const T cos_inner = cos(inner_angle);
  const T cos_outer = cos(outer_angle);
  if (!(cos_axis < cos_inner)) return T(1.0);
  if (!(cos_axis > cos_outer)) return T(0.0);
  const T t = (cos_axis - cos_outer) / (cos_inner - cos_outer);
  return t * t * (T(3.0) - T(2.0) * t);
}

/// SpotFalloff and its derivatives by its three arguments.
struct SpotFalloffPartials {
  double value = 0.0;
  double d_cos = 0.0, d_inner = 0.0, d_outer = 0.0;
};
inline SpotFalloffPartials SpotFalloffDerivative(double cos_axis,
                                                 double inner_angle,
                                                 double outer_angle) {
  const double cos_inner = std::cos(inner_angle);
  const double cos_outer = std::cos(outer_angle);
  if (!(cos_axis < cos_inner)) return {1.0};
  if (!(cos_axis > cos_outer)) return {0.0};
  const double width = cos_inner - cos_outer;
  const double t = (cos_axis - cos_outer) / width;
  const double slope = 6.0 * t * (1.0 - t) / width;
  return {t * t * (3.0 - 2.0 * t),
          slope,
          slope * t * std::sin(inner_angle),
          slope * (1.0 - t) * std::sin(outer_angle)};
}

}  // namespace pathfit::renderer
