#pragma once

#include <cmath>

#include "app/config/experiment_config.h"

namespace pathfit::app {

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

}  // namespace pathfit::app
