#include "optim/problem/view_quality.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "renderer/image/color.h"

namespace pathfit::optim {
namespace {

/// Sum of products of the errors of two halves.
class SquaredError {
 public:
  void Add(double weight, double a, double b) {
    const double product = weight * a * b;
    sum_ += product;
    squares_ += product * product;
    weight_ += weight;
  }
  [[nodiscard]] double Psnr() const {
    if (weight_ <= 0.0) return std::numeric_limits<double>::quiet_NaN();
    const double error = std::max(sum_, std::sqrt(squares_));
    if (error <= 0.0) return kMaxPsnr;
    return std::min(kMaxPsnr, -10.0 * std::log10(error / weight_));
  }

 private:
  double sum_ = 0.0, squares_ = 0.0, weight_ = 0.0;
};

}  // namespace

ViewQuality MeasureView(const ViewLevel& level,
                        const renderer::Film& a,
                        const renderer::Film& b,
                        bool silhouettes) {
  SquaredError linear, encoded;
  const bool has_silhouette = silhouettes && !level.mask.Empty();
  std::size_t both = 0, either = 0;
  for (std::size_t p = 0; p < a.pixels.size(); ++p) {
    const auto w = static_cast<double>(level.color_weight.data[p]);
    for (int c = 0; w > 0.0 && c < 3; ++c) {
      const double of_a = a.pixels[p][c], of_b = b.pixels[p][c];
      const auto photo = static_cast<double>(level.photo.data[3 * p + static_cast<std::size_t>(c)]);
      const double shown = renderer::ClampedSrgb(photo);
      linear.Add(w, of_a - photo, of_b - photo);
      encoded.Add(w, renderer::ClampedSrgb(of_a) - shown, renderer::ClampedSrgb(of_b) - shown);
    }
    if (has_silhouette) {
      const bool rendered = a.pixels[p].a + b.pixels[p].a > 1.0;
      const bool masked = level.mask.data[p] > 0.5F;
      both += static_cast<std::size_t>(rendered && masked);
      either += static_cast<std::size_t>(rendered || masked);
    }
  }
  ViewQuality quality;
  quality.psnr_linear = linear.Psnr();
  quality.psnr_srgb = encoded.Psnr();
  if (!has_silhouette) {
    quality.iou = std::numeric_limits<double>::quiet_NaN();
  } else {
    quality.iou = either == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(either);
  }
  return quality;
}

ViewQuality MeasureView(const ViewLevel& level, const renderer::Film& film, bool silhouettes) {
  return MeasureView(level, film, film, silhouettes);
}

}  // namespace pathfit::optim
