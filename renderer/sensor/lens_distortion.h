#pragma once

#include <array>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Brown lens distortion on normalised image coordinates (x right, y down), OpenCV's convention:
/// x_d = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2), and likewise y.
struct LensDistortion {
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, p1 = 0.0, p2 = 0.0;
  [[nodiscard]] bool IsNone() const {
    return k1 == 0.0 && k2 == 0.0 && k3 == 0.0 && p1 == 0.0 && p2 == 0.0;
  }
  friend bool operator==(const LensDistortion&, const LensDistortion&) = default;
};

/// Distorted point and its derivative by the undistorted one. The map is a gradient field: its
/// Jacobian is symmetric.
struct Distorted {
  Vec2 value;
  double xx = 1.0, xy = 0.0, yy = 1.0;
  [[nodiscard]] double Determinant() const { return xx * yy - xy * xy; }
};

inline Distorted Distort(const LensDistortion& d, const Vec2& u) {
  const double r2 = u.x * u.x + u.y * u.y;
  const double radial = 1.0 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  const double slope = d.k1 + r2 * (2.0 * d.k2 + 3.0 * r2 * d.k3);  // d radial / d r2
  const double xy = u.x * u.y;
  Distorted out;
  out.value = {u.x * radial + 2.0 * d.p1 * xy + d.p2 * (r2 + 2.0 * u.x * u.x),
               u.y * radial + d.p1 * (r2 + 2.0 * u.y * u.y) + 2.0 * d.p2 * xy};
  out.xx = radial + 2.0 * slope * u.x * u.x + 2.0 * d.p1 * u.y + 6.0 * d.p2 * u.x;
  out.xy = 2.0 * slope * xy + 2.0 * d.p1 * u.x + 2.0 * d.p2 * u.y;
  out.yy = radial + 2.0 * slope * u.y * u.y + 6.0 * d.p1 * u.y + 2.0 * d.p2 * u.x;
  return out;
}

/// What undoes a lens nearly: x_d (1 + b1 r2 + ... + b4 r2^4) of what is left without the
/// tangential part. The b are those of the inverse power series of the radial part [Drap2016]; all
/// zero: x_d.
struct NearInverse {
  LensDistortion lens;
  std::array<double, 4> b{};

  static NearInverse Of(const LensDistortion& d) {
    const double k1 = d.k1, k2 = d.k2, k3 = d.k3;
    return {d,
            {-k1,
             3.0 * k1 * k1 - k2,
             -12.0 * k1 * k1 * k1 + 8.0 * k1 * k2 - k3,
             k1 * k1 * (55.0 * k1 * k1 - 55.0 * k2) + 5.0 * k2 * k2 + 10.0 * k1 * k3}};
  }
  [[nodiscard]] Vec2 Undo(const Vec2& x) const {
    const double r2 = x.x * x.x + x.y * x.y;
    const double radial = 1.0 + r2 * (b[0] + r2 * (b[1] + r2 * (b[2] + r2 * b[3])));
    const double xy = x.x * x.y;
    return {x.x * radial - 2.0 * lens.p1 * xy - lens.p2 * (r2 + 2.0 * x.x * x.x),
            x.y * radial - lens.p1 * (r2 + 2.0 * x.y * x.y) - 2.0 * lens.p2 * xy};
  }
};

}  // namespace pathfit::renderer
