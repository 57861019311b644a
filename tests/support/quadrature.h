#pragma once

#include <array>
#include <cstddef>

namespace pathfit::tests {

/// Integral of f over [a, b]: `panels` equal panels of 10-point Gauss-Legendre. Put kinks of f on
/// a panel border (or split the interval): then 1e-13 is usual for smooth integrands.
template <class F>
double Integrate(const F& f, double a, double b, int panels = 8) {
  constexpr std::array<double, 5> kNodes{0.1488743389816312,
                                         0.4333953941292472,
                                         0.6794095682990244,
                                         0.8650633666889845,
                                         0.9739065285171717};
  constexpr std::array<double, 5> kWeights{0.2955242247147529,
                                           0.2692667193099963,
                                           0.2190863625159820,
                                           0.1494513491505806,
                                           0.0666713443086881};
  const double half = 0.5 * (b - a) / panels;
  double sum = 0.0;
  for (int p = 0; p < panels; ++p) {
    const double centre = a + (2 * p + 1) * half;
    for (std::size_t i = 0; i < kNodes.size(); ++i) {
      sum += kWeights[i] * (f(centre - half * kNodes[i]) + f(centre + half * kNodes[i]));
    }
  }
  return sum * half;
}

/// Integral of f(x, y) over [x0, x1] x [y0, y1], by Integrate in each variable.
template <class F>
double Integrate2D(
    const F& f, double x0, double x1, double y0, double y1, int panels_x = 8, int panels_y = 8) {
  const auto row = [&](double x) {
    return Integrate([&](double y) { return f(x, y); }, y0, y1, panels_y);
  };
  return Integrate(row, x0, x1, panels_x);
}

}  // namespace pathfit::tests
