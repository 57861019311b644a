#include "optim/problem/view_quality.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "renderer/core/parallel.h"
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
  void Add(const SquaredError& other) {
    sum_ += other.sum_;
    squares_ += other.squares_;
    weight_ += other.weight_;
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

/// Of some pixels.
struct Errors {
  SquaredError linear, encoded;
  std::size_t both = 0, either = 0;  ///< in the rendering and in the mask, or in one of them
};

}  // namespace

ViewQuality MeasureView(const ViewLevel& level,
                        const renderer::Film& a,
                        const renderer::Film& b,
                        bool silhouettes) {
  const bool has_silhouette = silhouettes && !level.mask.Empty();
  const auto width = static_cast<std::size_t>(a.width);
  const auto add_line = [&](std::int64_t y, Errors& errors) {
    const std::size_t first = static_cast<std::size_t>(y) * width;
    for (std::size_t p = first; p < first + width; ++p) {
      const auto w = static_cast<double>(level.color_weight.data[p]);
      for (int c = 0; w > 0.0 && c < 3; ++c) {
        const double of_a = a.pixels[p][c], of_b = b.pixels[p][c];
        const auto photo =
            static_cast<double>(level.photo.data[3 * p + static_cast<std::size_t>(c)]);
        const double shown = renderer::ClampedSrgb(photo);
        errors.linear.Add(w, of_a - photo, of_b - photo);
        errors.encoded.Add(
            w, renderer::ClampedSrgb(of_a) - shown, renderer::ClampedSrgb(of_b) - shown);
      }
      if (has_silhouette) {
        const bool rendered = a.pixels[p].a + b.pixels[p].a > 1.0;
        const bool masked = level.mask.data[p] > 0.5F;
        errors.both += static_cast<std::size_t>(rendered && masked);
        errors.either += static_cast<std::size_t>(rendered || masked);
      }
    }
  };
  Errors all;
  for (const Errors& line : renderer::ParallelParts<Errors>(a.height, add_line)) {
    all.linear.Add(line.linear);
    all.encoded.Add(line.encoded);
    all.both += line.both;
    all.either += line.either;
  }
  ViewQuality quality;
  quality.psnr_linear = all.linear.Psnr();
  quality.psnr_srgb = all.encoded.Psnr();
  if (!has_silhouette) {
    quality.iou = std::numeric_limits<double>::quiet_NaN();
  } else {
    quality.iou =
        all.either == 0 ? 1.0 : static_cast<double>(all.both) / static_cast<double>(all.either);
  }
  return quality;
}

ViewQuality MeasureView(const ViewLevel& level, const renderer::Film& film, bool silhouettes) {
  return MeasureView(level, film, film, silhouettes);
}

}  // namespace pathfit::optim
