#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/io/image_filter.h"

namespace pathfit::renderer {

/// An image file as stored: nothing is linearised.
struct DecodedImage {
  Image image;  ///< 3 channels (gray is repeated); 0..1 encoded, or linear radiance
  Image alpha;  ///< 1 channel, 0..1; empty without an alpha channel
  bool linear =
      false;     ///< HDR, EXR and float TIFF; otherwise encoded (nearly always by the sRGB curve)
  int bits = 8;  ///< per channel in the file: 8, 16 or 32
  bool grey = false;         ///< one channel, but for alpha
  int exif_orientation = 1;  ///< of JPEG, 1 to 8; 1 when unknown
  std::string exif;          ///< of JPEG: the TIFF structure as stored; empty without one
  std::string icc;           ///< the colour profile as stored, unchecked; empty without one
};

/// JPEG, PNG, TIFF (8 and 16 bit, float), HDR, EXR, told apart by their first bytes. Rows stay as
/// the sensor stored them unless `apply_exif_orientation`. Fails: IoError naming the file; RAW
/// photos have a reader of their own (raw_file.h).
DecodedImage ReadImageFile(const std::filesystem::path& path, bool apply_exif_orientation);

/// The same for the bytes of a JPEG or PNG file that lies inside another; `name` is for messages.
DecodedImage DecodeImage(std::string bytes, const std::string& name);

/// Turns an image stored with the EXIF orientation 1 to 8 upright.
Image ApplyOrientation(const Image& image, int exif_orientation);

/// 8-bit encodings of 1 or 3 channels that are encoded already; values are clamped to 0..1 and
/// rounded. `quality` is 1 to 100. Fails: IoError (empty, other channels), NumericalError (not
/// finite).
std::vector<unsigned char> EncodePng(const Image& image);
std::vector<unsigned char> EncodeJpeg(const Image& image, int quality);

/// Radiance HDR: 3 channels, not negative; shared 8-bit exponent, so to about 1 % of the largest
/// channel. Written through a temporary file. Fails: IoError (not writable, negative or too large
/// values), NumericalError (not finite).
void WriteHdr(const std::filesystem::path& path, const Image& image);

/// EncodePng into a file, through a temporary one.
void WritePng8(const std::filesystem::path& path, const Image& image);

}  // namespace pathfit::renderer
