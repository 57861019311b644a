#include "optim/observation/observation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "renderer/core/check.h"
#include "renderer/io/image_filter.h"

namespace pathfit::optim {
namespace {

using renderer::Image;

// A photo of at most this share of the full one's pixels is kept beside it.
constexpr double kKeptShare = 1.0 / 16.0;

Image Resized(Image image, int width, int height) {
  if (image.Empty() || (image.width == width && image.height == height)) return image;
  return renderer::ResizeArea(image, width, height);
}

PackedImage Resized(const PackedImage& image, int width, int height) {
  if (image.Empty() || (image.width() == width && image.height() == height)) return image;
  return renderer::ResizeArea(image.Unpack(), width, height);
}

/// Full size: 1 where the colour of a pixel is evidence.
PackedImage FullColorWeight(const View& view, const ObservationSet& observations) {
  if (observations.mask_meaning == MaskMeaning::kNone || view.mask.Empty()) {
    Image ones(view.photo.width(), view.photo.height(), 1);
    std::ranges::fill(ones.data, 1.0F);
    return ones;
  }
  return observations.mask_erode_px > 0
             ? renderer::Erode(view.mask.Unpack(), observations.mask_erode_px)
             : view.mask;
}

renderer::Camera CameraAt(const View& view, double scale) {
  PATHFIT_CHECK(std::isfinite(scale) && scale > 0.0 && !view.photo.Empty());
  const int width = std::max(1, static_cast<int>(std::lround(view.photo.width() * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(view.photo.height() * scale)));
  return renderer::ScaledCamera(view.camera, width, height);
}

}  // namespace

PackedLevel::PackedLevel(const View& view, const ObservationSet& observations, double scale)
    : camera_(CameraAt(view, scale)), view_(&view) {
  const auto resized = [&](const PackedImage& image) {
    return Resized(image, camera_.width, camera_.height);
  };
  mask_ = resized(view.mask);
  clipped_ = resized(view.clipped);
  color_weight_ = resized(FullColorWeight(view, observations));
  const double full = static_cast<double>(view.photo.width()) * view.photo.height();
  if (static_cast<double>(camera_.width) * camera_.height <= kKeptShare * full) {
    photo_ = resized(view.photo);
    bytes_ += photo_.MemoryBytes();
  }
  for (const PackedImage* image : {&mask_, &clipped_, &color_weight_}) {
    const bool is_of_view = image->SharesPixels(view.mask) || image->SharesPixels(view.clipped);
    bytes_ += is_of_view ? 0 : image->MemoryBytes();
  }
}

PackedLevel::PackedLevel(const ViewLevel& level)
    : camera_(level.camera),
      photo_(level.photo),
      mask_(level.mask),
      clipped_(level.clipped),
      color_weight_(level.color_weight),
      bytes_(photo_.MemoryBytes() + mask_.MemoryBytes() + clipped_.MemoryBytes() +
             color_weight_.MemoryBytes()) {}

ViewLevel PackedLevel::Unpack() const {
  return {camera_,
          photo_.Empty() ? Resized(view_->photo.Unpack(), camera_.width, camera_.height)
                         : photo_.Unpack(),
          mask_.Unpack(),
          clipped_.Unpack(),
          color_weight_.Unpack()};
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
