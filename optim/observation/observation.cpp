#include "optim/observation/observation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "renderer/core/check.h"
#include "renderer/io/image_filter.h"

namespace pathfit::optim {
namespace {

using renderer::Image;

Image Resized(const Image& image, int width, int height) {
  if (image.Empty() || (image.width == width && image.height == height)) return image;
  return renderer::ResizeArea(image, width, height);
}

/// Full size: 1 where the colour of a pixel is evidence.
Image ColorWeight(const View& view, const ObservationSet& observations) {
  if (observations.mask_meaning == MaskMeaning::kNone || view.mask.Empty()) {
    Image ones(view.photo.width, view.photo.height, 1);
    std::ranges::fill(ones.data, 1.0F);
    return ones;
  }
  return observations.mask_erode_px > 0 ? renderer::Erode(view.mask, observations.mask_erode_px)
                                        : view.mask;
}

}  // namespace

ViewLevel MakeViewLevel(const View& view, const ObservationSet& observations, double scale) {
  PATHFIT_CHECK(std::isfinite(scale) && scale > 0.0 && !view.photo.Empty());
  const int width = std::max(1, static_cast<int>(std::lround(view.photo.width * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(view.photo.height * scale)));
  ViewLevel level;
  level.camera = renderer::ScaledCamera(view.camera, width, height);
  level.photo = Resized(view.photo, width, height);
  level.mask = Resized(view.mask, width, height);
  level.clipped = Resized(view.clipped, width, height);
  level.color_weight = Resized(ColorWeight(view, observations), width, height);
  return level;
}

double MaskIou(const Image& coverage, const Image& mask) {
  PATHFIT_CHECK(coverage.width == mask.width && coverage.height == mask.height);
  PATHFIT_CHECK(coverage.channels == 1 && mask.channels == 1);
  std::int64_t both = 0;
  std::int64_t either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const bool rendered = coverage.data[i] > 0.5F;
    const bool masked = mask.data[i] > 0.5F;
    both += rendered && masked ? 1 : 0;
    either += rendered || masked ? 1 : 0;
  }
  return either == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(either);
}

}  // namespace pathfit::optim
