#include "renderer/io/image_check.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

constexpr std::int64_t kMaxPixels = std::int64_t{1} << 28;

}  // namespace

void CheckImageSize(std::int64_t width, std::int64_t height, const std::string& name) {
  if (width <= 0 || height <= 0 || width > kMaxPixels || height > kMaxPixels / width) {
    throw IoError(name + ": image size " + std::to_string(width) + " x " + std::to_string(height) +
                  " is not allowed, at most " + std::to_string(kMaxPixels) + " pixels");
  }
}

std::string FirstNonFinite(const Image& image) {
  const auto place =
      std::find_if(image.data.begin(), image.data.end(), [](float v) { return !std::isfinite(v); });
  if (place == image.data.end()) return "";
  const std::ptrdiff_t pixel = (place - image.data.begin()) / image.channels;
  return "pixel (" + std::to_string(pixel % image.width) + ", " +
         std::to_string(pixel / image.width) + ")";
}

void CheckWritable(const Image& image,
                   std::initializer_list<int> allowed_channels,
                   const std::filesystem::path& path) {
  const bool is_allowed =
      std::find(allowed_channels.begin(), allowed_channels.end(), image.channels) !=
      allowed_channels.end();
  if (image.Empty() || !is_allowed) {
    throw IoError(path.string() + ": an image of " + std::to_string(image.width) + " x " +
                  std::to_string(image.height) + " with " + std::to_string(image.channels) +
                  " channels cannot be written in this format");
  }
  if (const std::string place = FirstNonFinite(image); !place.empty()) {
    throw NumericalError(path.string() + ": " + place + " is not finite");
  }
}

}  // namespace pathfit::renderer
