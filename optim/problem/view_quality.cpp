#include "optim/problem/view_quality.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "renderer/image/color.h"

namespace pathfit::optim {
namespace {

double Psnr(double squared_error, double weight) {
  if (weight <= 0.0) return std::numeric_limits<double>::quiet_NaN();
  if (squared_error <= 0.0) return kMaxPsnr;
  return std::min(kMaxPsnr, -10.0 * std::log10(squared_error / weight));
}

double Encoded(double linear) { return renderer::SrgbFromLinear(std::clamp(linear, 0.0, 1.0)); }

}  // namespace

ViewQuality MeasureView(const ViewLevel& level, const renderer::Film& film, bool silhouettes) {
  double linear = 0.0, encoded = 0.0, weight = 0.0;
  const bool has_silhouette = silhouettes && !level.mask.Empty();
  std::size_t both = 0, either = 0;
  for (std::size_t p = 0; p < film.pixels.size(); ++p) {
    const auto w = static_cast<double>(level.color_weight.data[p]);
    for (std::size_t c = 0; w > 0.0 && c < 3; ++c) {
      const double rendered = film.pixels[p][static_cast<int>(c)];
      const auto photo = static_cast<double>(level.photo.data[3 * p + c]);
      const double difference = Encoded(rendered) - Encoded(photo);
      linear += w * (rendered - photo) * (rendered - photo);
      encoded += w * difference * difference;
      weight += w;
    }
    if (has_silhouette) {
      const bool rendered = film.pixels[p].a > 0.5;
      const bool masked = level.mask.data[p] > 0.5F;
      both += static_cast<std::size_t>(rendered && masked);
      either += static_cast<std::size_t>(rendered || masked);
    }
  }
  ViewQuality quality;
  quality.psnr_linear = Psnr(linear, weight);
  quality.psnr_srgb = Psnr(encoded, weight);
  if (!has_silhouette) {
    quality.iou = std::numeric_limits<double>::quiet_NaN();
  } else {
    quality.iou = either == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(either);
  }
  return quality;
}

}  // namespace pathfit::optim
