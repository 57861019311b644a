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
// Pixels around one of the object's edge whose mean is its background.
constexpr int kBackgroundReach = 3;

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

/// Mean colour of the pixels around (x, y) that the mask leaves out; black where there is none.
renderer::Rgb BackgroundAround(const Image& photo, const Image& mask, int x, int y) {
  renderer::Rgb sum;
  int bare = 0;
  for (int v = std::max(0, y - kBackgroundReach);
       v <= std::min(photo.height - 1, y + kBackgroundReach);
       ++v) {
    for (int u = std::max(0, x - kBackgroundReach);
         u <= std::min(photo.width - 1, x + kBackgroundReach);
         ++u) {
      if (mask.At(u, v, 0) > 0.0F) continue;
      sum += photo.ColorAt(u, v);
      ++bare;
    }
  }
  return bare > 0 ? sum / bare : sum;
}

/// The photo as it would be before black: of each pixel the share that its mask leaves to the
/// background is taken off. Where pixels are averaged, an edge then holds of the object's colour
/// what the rendering does, whatever was behind it.
Image BeforeBlack(const View& view) {
  const Image whole = view.photo.Unpack();
  const Image mask = view.mask.Unpack();
  Image photo = whole;
  for (int y = 0; y < photo.height; ++y) {
    for (int x = 0; x < photo.width; ++x) {
      const float inside = mask.At(x, y, 0);
      if (inside >= 1.0F) continue;
      const renderer::Rgb behind = inside <= 0.0F || view.straight_alpha
                                       ? whole.ColorAt(x, y)
                                       : BackgroundAround(whole, mask, x, y);
      for (int c = 0; c < 3; ++c) {
        float& value = photo.At(x, y, c);
        value = std::max(0.0F, value - (1.0F - inside) * static_cast<float>(behind[c]));
      }
    }
  }
  return photo;
}

/// Means over the pixels that are data; over all where none is.
Image MeanOfData(const View& view, int width, int height) {
  const Image mask = view.mask.Unpack();
  Image weighted = view.photo.Unpack();
  Image mean = Resized(weighted, width, height);
  for (std::size_t i = 0; i < weighted.data.size(); ++i) weighted.data[i] *= mask.data[i / 3];
  weighted = Resized(std::move(weighted), width, height);
  const Image share = Resized(mask, width, height);
  for (std::size_t i = 0; i < mean.data.size(); ++i) {
    if (share.data[i / 3] > 0.0F) mean.data[i] = weighted.data[i] / share.data[i / 3];
  }
  return mean;
}

/// `meaning`: kNone leaves the photo's background in it.
Image PhotoAt(const View& view, MaskMeaning meaning, int width, int height) {
  const bool is_full = view.photo.width() == width && view.photo.height() == height;
  if (meaning == MaskMeaning::kSilhouette && !view.mask.Empty()) {
    return Resized(BeforeBlack(view), width, height);
  }
  return meaning == MaskMeaning::kIgnore && !view.mask.Empty() && !is_full
             ? MeanOfData(view, width, height)
             : Resized(view.photo.Unpack(), width, height);
}

renderer::Camera CameraAt(const View& view, double scale) {
  PATHFIT_CHECK(std::isfinite(scale) && scale > 0.0 && !view.photo.Empty());
  const int width = std::max(1, static_cast<int>(std::lround(view.photo.width() * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(view.photo.height() * scale)));
  return renderer::ScaledCamera(view.camera, width, height);
}

}  // namespace

PackedLevel::PackedLevel(const View& view, const ObservationSet& observations, double scale)
    : camera_(CameraAt(view, scale)), view_(&view), masks_(observations.mask_meaning) {
  const int width = camera_.width;
  const int height = camera_.height;
  const bool later = !view.photo.IsRead();
  const auto made = [&](int channels, const auto& make) {
    return later ? PackedImage::Later(width, height, channels, make) : make();
  };
  if (masks_ == MaskMeaning::kSilhouette && !observations.black_background) {
    masks_ = MaskMeaning::kNone;
  }
  const auto resized = [&](const PackedImage& image) {
    const bool stays = image.Empty() || (image.width() == width && image.height() == height);
    return stays ? image
                 : made(1, [&image, width, height] { return Resized(image, width, height); });
  };
  mask_ = resized(view.mask);
  clipped_ = resized(view.clipped);
  color_weight_ = made(1, [&view, &observations, width, height] {
    return Resized(FullColorWeight(view, observations), width, height);
  });
  const double full = static_cast<double>(view.photo.width()) * view.photo.height();
  if (static_cast<double>(width) * height <= kKeptShare * full) {
    photo_ = made(3, [&view, masks = masks_, width, height] {
      return PackedImage(PhotoAt(view, masks, width, height));
    });
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
          photo_.Empty() ? PhotoAt(*view_, masks_, camera_.width, camera_.height) : photo_.Unpack(),
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
