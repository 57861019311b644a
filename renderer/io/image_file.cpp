#include "renderer/io/image_file.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_check.h"
#include "renderer/io/image_container.h"

namespace pathfit::renderer {
namespace {

cv::Mat DecodeWithOpenCv(std::string& bytes, const std::filesystem::path& path) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw IoError(path.string() + ": the file is too large");
  }
  const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U, bytes.data());
  cv::Mat pixels;
  try {
    pixels = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  } catch (const std::exception& error) {
    throw IoError(path.string() + ": cannot be decoded: " + error.what());
  }
  if (pixels.empty()) throw IoError(path.string() + ": the image is malformed or cut off");
  return pixels;
}

/// Channel c of the pixels as 0..1 (integers) or as it is (floats). T is the stored number.
template <class T>
void CopyChannel(const cv::Mat& pixels, int from, int to, Image& image) {
  const double scale =
      std::numeric_limits<T>::is_integer ? static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
  for (int y = 0; y < image.height; ++y) {
    const T* row = pixels.ptr<T>(y);
    for (int x = 0; x < image.width; ++x) {
      const T value = row[x * pixels.channels() + from];
      image.At(x, y, to) = static_cast<float>(static_cast<double>(value) / scale);
    }
  }
}

void CopyChannel(const cv::Mat& pixels, int from, int to, Image& image) {
  switch (pixels.depth()) {
    case CV_8U:
      return CopyChannel<std::uint8_t>(pixels, from, to, image);
    case CV_16U:
      return CopyChannel<std::uint16_t>(pixels, from, to, image);
    case CV_32F:
      return CopyChannel<float>(pixels, from, to, image);
    default:
      return CopyChannel<double>(pixels, from, to, image);
  }
}

DecodedImage DecodeInteger(std::string& bytes, ImageKind kind, const std::filesystem::path& path) {
  CheckContainer(bytes, kind, path);
  const cv::Mat pixels = DecodeWithOpenCv(bytes, path);
  const int channels = pixels.channels();
  const int depth = pixels.depth();
  if (channels > 4) throw IoError(path.string() + ": has more than 4 channels");
  if (depth != CV_8U && depth != CV_16U && depth != CV_32F && depth != CV_64F) {
    throw IoError(path.string() + ": allowed are 8 and 16 bits without sign, and floats");
  }
  DecodedImage decoded;
  decoded.linear = depth == CV_32F || depth == CV_64F;
  decoded.bits = depth == CV_8U ? 8 : (depth == CV_16U ? 16 : 32);
  decoded.image = Image(pixels.cols, pixels.rows, 3);
  for (int c = 0; c < 3; ++c) {
    // The library stores blue first, and alpha last.
    CopyChannel(pixels, channels >= 3 ? 2 - c : 0, c, decoded.image);
  }
  if (channels == 2 || channels == 4) {
    decoded.alpha = Image(pixels.cols, pixels.rows, 1);
    CopyChannel(pixels, channels - 1, 0, decoded.alpha);
  }
  return decoded;
}

}  // namespace

DecodedImage ReadImageFile(const std::filesystem::path& path, bool apply_exif_orientation) {
  std::string bytes = ReadWholeFile(path);
  const ImageKind kind = KindOfImage(bytes);
  DecodedImage decoded;
  switch (kind) {
    case ImageKind::kUnknown:
      throw IoError(path.string() + ": not an image; allowed are JPEG, PNG, TIFF, HDR and EXR");
    case ImageKind::kExr:
      decoded.image = ReadExr(path, &decoded.alpha);
      decoded.linear = true;
      decoded.bits = 32;
      break;
    case ImageKind::kHdr:
      decoded.image = DecodeHdr(bytes, path);
      decoded.linear = true;
      decoded.bits = 32;
      break;
    case ImageKind::kJpeg:
    case ImageKind::kPng:
    case ImageKind::kTiff:
      decoded = DecodeInteger(bytes, kind, path);
      break;
  }
  for (const Image* image : {&decoded.image, &decoded.alpha}) {
    const std::string place = FirstNonFinite(*image);
    if (!place.empty()) throw IoError(path.string() + ": " + place + " is not finite");
  }
  decoded.exif_orientation = ReadJpegOrientation(bytes);
  if (apply_exif_orientation && decoded.exif_orientation != 1) {
    decoded.image = ApplyOrientation(decoded.image, decoded.exif_orientation);
    if (!decoded.alpha.Empty()) {
      decoded.alpha = ApplyOrientation(decoded.alpha, decoded.exif_orientation);
    }
  }
  return decoded;
}

Image ApplyOrientation(const Image& image, int exif_orientation) {
  // Where the stored rows and columns begin and whether they change roles, for 1 to 8 as the
  // standard lists them.
  const bool is_transposed = exif_orientation >= 5 && exif_orientation <= 8;
  const bool flip_x = exif_orientation == 2 || exif_orientation == 3 || exif_orientation == 7 ||
                      exif_orientation == 8;
  const bool flip_y = exif_orientation == 3 || exif_orientation == 4 || exif_orientation == 6 ||
                      exif_orientation == 7;
  Image upright(is_transposed ? image.height : image.width,
                is_transposed ? image.width : image.height,
                image.channels);
  for (int y = 0; y < upright.height; ++y) {
    for (int x = 0; x < upright.width; ++x) {
      int stored_x = is_transposed ? y : x;
      int stored_y = is_transposed ? x : y;
      if (flip_x) stored_x = image.width - 1 - stored_x;
      if (flip_y) stored_y = image.height - 1 - stored_y;
      for (int c = 0; c < image.channels; ++c) {
        upright.At(x, y, c) = image.At(stored_x, stored_y, c);
      }
    }
  }
  return upright;
}

}  // namespace pathfit::renderer
