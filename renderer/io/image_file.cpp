#include "renderer/io/image_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/hdr_file.h"
#include "renderer/io/image_check.h"
#include "renderer/io/raw_file.h"

namespace pathfit::renderer {
namespace {

cv::Mat DecodeWithOpenCv(std::string& bytes, const std::filesystem::path& path) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw IoError(path.string() + ": the file is too large");
  }
  const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U, bytes.data());
  return cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
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

DecodedImage Decode(std::string& bytes, ImageKind kind, const std::filesystem::path& path) {
  CheckContainer(bytes, kind, path.string());
  cv::Mat pixels;
  try {
    pixels = DecodeWithOpenCv(bytes, path);
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(path.string() + ": cannot be decoded: " + error.what());
  }
  if (pixels.empty()) throw IoError(path.string() + ": the image is malformed or cut off");
  const int channels = pixels.channels();
  const int depth = pixels.depth();
  if (channels > 4) throw IoError(path.string() + ": has more than 4 channels");
  if (depth != CV_8U && depth != CV_16U && depth != CV_32F && depth != CV_64F) {
    throw IoError(path.string() + ": allowed are 8 and 16 bits without sign, and floats");
  }
  DecodedImage decoded;
  decoded.linear = depth == CV_32F || depth == CV_64F;
  decoded.bits = depth == CV_8U ? 8 : (depth == CV_16U ? 16 : 32);
  decoded.grey = channels < 3;
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

DecodedImage DecodeImage(std::string bytes, const std::string& name) {
  const ImageKind kind = KindOfImage(bytes);
  if (kind != ImageKind::kJpeg && kind != ImageKind::kPng) {
    throw IoError(name + ": not a JPEG or PNG image");
  }
  return Decode(bytes, kind, name);
}

DecodedImage ReadImageFile(const std::filesystem::path& path, bool apply_exif_orientation) {
  if (HasRawExtension(path)) {  // what is found in it as a TIFF is a small preview
    throw IoError(path.string() + ": RAW photos can be input photos, but no other images");
  }
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
      decoded.image = ReadHdr(bytes, path.string());
      decoded.linear = true;
      decoded.bits = 32;
      break;
    default:
      decoded = Decode(bytes, kind, path);
      break;
  }
  for (const Image* image : {&decoded.image, &decoded.alpha}) {
    const std::string place = FirstNonFinite(*image);
    if (!place.empty()) throw IoError(path.string() + ": " + place + " is not finite");
  }
  decoded.icc = IccProfileOf(bytes, kind);
  decoded.exif = ExifOfJpeg(bytes);
  decoded.exif_orientation = OrientationOfExif(decoded.exif);
  if (apply_exif_orientation && decoded.exif_orientation != 1) {
    decoded.image = ApplyOrientation(decoded.image, decoded.exif_orientation);
    if (!decoded.alpha.Empty()) {
      decoded.alpha = ApplyOrientation(decoded.alpha, decoded.exif_orientation);
    }
  }
  return decoded;
}

Image ApplyOrientation(const Image& image, int exif_orientation) {
  const auto is_one_of = [exif_orientation](std::string_view digits) {
    return digits.find(static_cast<char>('0' + exif_orientation)) != std::string_view::npos;
  };
  // As the standard lists them: stored rows and columns are reversed, then change roles.
  const int type = CV_32FC(image.channels);
  cv::Mat pixels(image.height, image.width, type);
  std::ranges::copy(image.data, pixels.ptr<float>());
  if (is_one_of("2378")) cv::flip(pixels, pixels, 1);
  if (is_one_of("3467")) cv::flip(pixels, pixels, 0);
  if (is_one_of("5678")) cv::transpose(pixels, pixels);
  Image upright(pixels.cols, pixels.rows, image.channels);
  std::copy_n(pixels.ptr<float>(), upright.data.size(), upright.data.begin());
  return upright;
}

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

void WriteHdr(const std::filesystem::path& path, const Image& image) {
  CheckWritable(image, {3}, path);
  cv::Mat pixels(image.height, image.width, CV_32FC3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Rgb color = image.ColorAt(x, y);
      if (std::min({color.r, color.g, color.b}) < 0.0) {
        throw IoError(path.string() + ": an HDR file cannot hold negative values");
      }
      // The encoder cuts to steps of 2^(exponent - 8): half a step more makes that rounding, which
      // could carry the largest channel to the next exponent.
      int exponent = 0;
      if (std::frexp(MaxChannel(color), &exponent) * 256.0 >= 255.5) ++exponent;
      if (exponent > 127) throw IoError(path.string() + ": a value is too large for an HDR file");
      const double half_step = IsBlack(color) ? 0.0 : std::ldexp(0.5, exponent - 8);
      for (int c = 0; c < 3; ++c) {
        pixels.at<cv::Vec3f>(y, x)[2 - c] = static_cast<float>(color[c] + half_step);
      }
    }
  }
  WriteThroughTemporary(path, [&](const std::filesystem::path& temporary) {
    try {
      if (cv::imwrite(temporary.string(), pixels)) return;
    } catch (const std::exception& error) {
      throw IoError(path.string() + ": cannot be encoded: " + error.what());
    }
    throw IoError(path.string() + ": cannot be written");
  });
}

}  // namespace pathfit::renderer
