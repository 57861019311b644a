#include <algorithm>
#include <cmath>
#include <string_view>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_check.h"
#include "renderer/io/image_file.h"

namespace pathfit::renderer {
namespace {

std::vector<unsigned char> Encode(const Image& image,
                                  const char* extension,
                                  const std::vector<int>& options,
                                  const std::filesystem::path& name) {
  CheckWritable(image, {1, 3}, name);
  cv::Mat pixels(image.height, image.width, image.channels == 1 ? CV_8UC1 : CV_8UC3);
  for (int y = 0; y < image.height; ++y) {
    unsigned char* row = pixels.ptr<unsigned char>(y);
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channels; ++c) {
        // The library stores blue first.
        const float value = std::clamp(image.At(x, y, image.channels - 1 - c), 0.0F, 1.0F);
        *row++ = static_cast<unsigned char>(std::lround(value * 255.0F));
      }
    }
  }
  std::vector<unsigned char> bytes;
  try {
    if (cv::imencode(extension, pixels, bytes, options)) return bytes;
  } catch (const cv::Exception& error) {
    throw IoError(name.string() + ": cannot be encoded: " + error.what());
  }
  throw IoError(name.string() + ": cannot be encoded");
}

}  // namespace

std::vector<unsigned char> EncodePng(const Image& image) {
  return Encode(image, ".png", {cv::IMWRITE_PNG_COMPRESSION, 6}, "PNG image");
}

std::vector<unsigned char> EncodeJpeg(const Image& image, int quality) {
  return Encode(
      image, ".jpg", {cv::IMWRITE_JPEG_QUALITY, std::clamp(quality, 1, 100)}, "JPEG image");
}

void WritePng8(const std::filesystem::path& path, const Image& image) {
  const std::vector<unsigned char> bytes =
      Encode(image, ".png", {cv::IMWRITE_PNG_COMPRESSION, 6}, path);
  WriteFileAtomically(path,
                      std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace pathfit::renderer
