#include "app/output/report_images.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderer/core/check.h"
#include "renderer/image/color.h"
#include "renderer/io/image_filter.h"

namespace pathfit::app {
namespace {

using renderer::Image;
using renderer::Rgb;

constexpr Rgb kMagenta{1.0, 0.0, 1.0};
constexpr Rgb kNotCompared{0.82, 0.82, 0.82};
constexpr Rgb kWhite{1.0, 1.0, 1.0};
constexpr Rgb kBoth{0.72, 0.72, 0.72};
constexpr Rgb kOnlyRendered{0.86, 0.15, 0.13};
constexpr Rgb kOnlyMask{0.13, 0.35, 0.85};

void SetColor(int x, int y, const Rgb& color, Image& image) {
  for (int c = 0; c < 3; ++c) image.At(x, y, c) = static_cast<float>(color[c]);
}

Rgb Mixed(const Rgb& a, const Rgb& b, double t) { return a * (1.0 - t) + b * t; }

Rgb Encoded(const Rgb& linear) {
  Rgb encoded;
  for (int c = 0; c < 3; ++c) {
    if (!std::isfinite(linear[c])) return kMagenta;
    encoded[c] = renderer::ClampedSrgb(linear[c]);
  }
  return encoded;
}

/// Into 0..1; NaN counts as 0.
double Share(float value) { return value > 0.0F ? std::min(static_cast<double>(value), 1.0) : 0.0; }

}  // namespace

Image ReducedImage(const Image& image, int max_px) {
  const int longest = std::max(image.width, image.height);
  if (longest <= max_px) return image;
  const double scale = static_cast<double>(max_px) / longest;
  return renderer::ResizeArea(image,
                              std::max(1, static_cast<int>(std::lround(scale * image.width))),
                              std::max(1, static_cast<int>(std::lround(scale * image.height))));
}

Image EncodedImage(const Image& linear) {
  PATHFIT_CHECK(linear.channels >= 3);
  Image encoded(linear.width, linear.height, 3);
  for (int y = 0; y < linear.height; ++y) {
    for (int x = 0; x < linear.width; ++x) SetColor(x, y, Encoded(linear.ColorAt(x, y)), encoded);
  }
  return encoded;
}

Image DifferenceImage(const Image& fit, const Image& photo, const Image& mask) {
  PATHFIT_CHECK(fit.width == photo.width && fit.height == photo.height);
  PATHFIT_CHECK(mask.Empty() || (mask.width == fit.width && mask.height == fit.height));
  Image picture(fit.width, fit.height, 3);
  for (int y = 0; y < fit.height; ++y) {
    for (int x = 0; x < fit.width; ++x) {
      if (!mask.Empty() && !(mask.At(x, y, 0) > 0.5F)) {
        SetColor(x, y, kNotCompared, picture);
        continue;
      }
      const Rgb difference = Encoded(fit.ColorAt(x, y)) - Encoded(photo.ColorAt(x, y));
      const double value = std::clamp(
          (difference.r + difference.g + difference.b) / 3.0 / kDifferenceScale, -1.0, 1.0);
      SetColor(
          x, y, Mixed(kWhite, value < 0.0 ? kOnlyMask : kOnlyRendered, std::abs(value)), picture);
    }
  }
  return picture;
}

Image SilhouetteImage(const Image& coverage, const Image& mask) {
  PATHFIT_CHECK(coverage.width == mask.width && coverage.height == mask.height);
  Image picture(mask.width, mask.height, 3);
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const double rendered = Share(coverage.At(x, y, 0));
      const double seen = Share(mask.At(x, y, 0));
      const double both = std::min(rendered, seen);
      const Rgb color = kBoth * both + kOnlyRendered * (rendered - both) +
                        kOnlyMask * (seen - both) + kWhite * (1.0 - std::max(rendered, seen));
      SetColor(x, y, color, picture);
    }
  }
  return picture;
}

double EnvironmentExposure(const renderer::EnvironmentEmitter& environment) {
  std::vector<double> luminances;
  for (const Rgb& texel : environment.texels) {
    const double luminance = Luminance(environment.intensity * texel);
    if (std::isfinite(luminance)) luminances.push_back(luminance);
  }
  if (luminances.empty()) return 1.0;
  const auto bright = luminances.begin() + static_cast<std::ptrdiff_t>(
                                               0.95 * static_cast<double>(luminances.size() - 1));
  std::nth_element(luminances.begin(), bright, luminances.end());
  constexpr double kJustBelowWhite = 0.8;
  return *bright > 1e-12 ? kJustBelowWhite / *bright : 1.0;
}

Image EnvironmentPicture(const renderer::EnvironmentEmitter& environment, double exposure) {
  constexpr int kLeastWidth = 256;
  PATHFIT_CHECK(environment.texels.size() == static_cast<std::size_t>(environment.width) *
                                                 static_cast<std::size_t>(environment.height));
  Image linear(environment.width, environment.height, 3);
  for (int y = 0; y < environment.height; ++y) {
    for (int x = 0; x < environment.width; ++x) {
      const std::size_t texel = linear.Offset(x, y) / 3;
      SetColor(x, y, environment.intensity * environment.texels[texel] * exposure, linear);
    }
  }
  // The map covers 2 pi by pi, whatever its number of texels.
  const int width = (kLeastWidth + environment.width - 1) / environment.width * environment.width;
  return ReducedImage(EncodedImage(renderer::ResizeArea(linear, width, std::max(1, width / 2))),
                      kThumbnailPx);
}

}  // namespace pathfit::app
