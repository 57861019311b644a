#include "renderer/sensor/pixel_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/math/inverse_erf.h"

namespace pathfit::renderer {
namespace {

// The cut and shifted Gaussian in b = |d| / (sigma sqrt 2), with a = radius / (sigma sqrt 2):
//   g(b) = exp(-b^2) - exp(-a^2),   G(b) = int_0^b g = sqrt(pi)/2 erf(b) - b exp(-a^2).
// A filter much narrower than its Gaussian has a ~ 0, where both differences cancel; they are
// written as sums of positive terms there.
class CutGaussian {
 public:
  explicit CutGaussian(const PixelFilter& filter)
      : scale_(filter.sigma * std::numbers::sqrt2),
        a_(filter.radius / scale_),
        floor_(std::exp(-a_ * a_)),
        half_mass_(Integral(a_)) {}

  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double half_width() const { return a_; }
  /// Density of b among 0 <= b <= a.
  [[nodiscard]] double Density(double b) const { return Value(b) / half_mass_; }
  /// Share of the mass at or below b.
  [[nodiscard]] double Share(double b) const { return Integral(b) / half_mass_; }
  /// Derivative of Density by b.
  [[nodiscard]] double Slope(double b) const { return -2.0 * b * std::exp(-b * b) / half_mass_; }

 private:
  static constexpr double kSeriesBelow = 1.0;

  [[nodiscard]] double Value(double b) const {
    return -std::exp(-b * b) * std::expm1((b - a_) * (b + a_));
  }
  [[nodiscard]] double Integral(double b) const {
    if (b >= kSeriesBelow) return 0.5 * std::sqrt(std::numbers::pi) * std::erf(b) - b * floor_;
    // erf without its first term: sqrt(pi)/2 erf(b) = exp(-b^2) sum_k 2^k b^(2k+1) / (2k+1)!!.
    const double b2 = 2.0 * b * b;
    double term = b;
    double sum = 0.0;
    for (double k = 3.0; term > 1e-17 * sum; k += 2.0) {
      term *= b2 / k;
      sum += term;
    }
    return std::exp(-b * b) * sum + b * Value(b);
  }

  double scale_, a_, floor_, half_mass_;
};

/// b with 1 - Share(b) = tail, by Newton's method on sqrt(1 - Share), which is nearly straight up
/// to the end of the support where the density vanishes; bisection keeps it inside its bracket.
double OffsetOfTail(const CutGaussian& gaussian, double tail) {
  constexpr int kMaxSteps = 60;
  constexpr double kTolerance = 1e-15;  // of the mass: what rounding leaves of 1 - Share
  const double end = gaussian.half_width();
  if (tail <= 0.0) return end;
  const double root = std::sqrt(tail);
  double low = 0.0;
  double high = end;
  double b = std::min(RoughInverseErf(tail), end * (1.0 - root));
  for (int i = 0; i < kMaxSteps; ++i) {
    const double mass = std::max(0.0, 1.0 - gaussian.Share(b));
    if (std::abs(mass - tail) <= kTolerance) break;
    const double rest = std::sqrt(mass);
    (rest > root ? low : high) = b;
    double next = b + 2.0 * rest * (rest - root) / gaussian.Density(b);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    b = next;
  }
  return b;
}

}  // namespace

double FilterProfile(const PixelFilter& filter, double d) {
  const double distance = std::abs(d);
  const double r = filter.radius;
  if (!(distance <= r)) return 0.0;
  if (filter.shape == PixelFilter::Shape::kBox) return 0.5 / r;
  if (filter.shape == PixelFilter::Shape::kTent) return (1.0 - distance / r) / r;
  const CutGaussian gaussian(filter);
  return 0.5 * gaussian.Density(distance / gaussian.scale()) / gaussian.scale();
}

double FilterSlope(const PixelFilter& filter, double d) {
  const double distance = std::abs(d);
  const double r = filter.radius;
  if (filter.shape == PixelFilter::Shape::kBox || !(distance < r) || d == 0.0) return 0.0;
  if (filter.shape == PixelFilter::Shape::kTent) return std::copysign(1.0 / (r * r), -d);
  const CutGaussian gaussian(filter);
  const double scale = gaussian.scale();
  return std::copysign(0.5 * gaussian.Slope(distance / scale) / (scale * scale), -d);
}

double SampleFilter(const PixelFilter& filter, double u) {
  const double r = filter.radius;
  if (filter.shape == PixelFilter::Shape::kBox) return r * (2.0 * u - 1.0);
  // Twice the mass beyond the offset, on the offset's own side: exact at both ends.
  const double tail = 2.0 * (u < 0.5 ? u : 1.0 - u);
  double distance = 0.0;
  if (filter.shape == PixelFilter::Shape::kTent) {
    distance = r * (1.0 - std::sqrt(tail));
  } else {
    const CutGaussian gaussian(filter);
    distance = std::min(r, gaussian.scale() * OffsetOfTail(gaussian, tail));
  }
  return u < 0.5 ? -distance : distance;
}

CoveringRange CoveringPixels(const PixelFilter& filter, double at, int size) {
  // Pixel i covers [i + 1/2 - r, i + 1/2 + r). Clamped before the conversion: a coordinate far off
  // the film does not fit an int; one that is not a number covers nothing.
  const double first = std::floor(at - 0.5 - filter.radius) + 1.0;
  const double end = std::floor(at - 0.5 + filter.radius) + 1.0;
  const double limit = size;
  return {first > 0.0 ? static_cast<int>(first < limit ? first : limit) : 0,
          end > 0.0 ? static_cast<int>(end < limit ? end : limit) : 0};
}

}  // namespace pathfit::renderer
