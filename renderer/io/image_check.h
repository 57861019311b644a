#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include "renderer/image/image.h"

namespace pathfit::renderer {

enum class ImageKind { kUnknown, kJpeg, kPng, kTiff, kHdr, kExr };

/// By the first bytes; the extension is not trusted.
ImageKind KindOfImage(std::string_view bytes);

// What is checked before a decoder allocates or an encoder writes.

/// Fails: IoError naming `name` when a side is not positive or there are more than 2^28 pixels.
void CheckImageSize(std::int64_t width, std::int64_t height, const std::string& name);

/// The same for what the header of a file claims, before a decoder takes memory for it: fails too
/// when a file of this kind and size cannot hold so many pixels.
void CheckClaimedSize(std::int64_t width,
                      std::int64_t height,
                      ImageKind kind,
                      std::uintmax_t file_bytes,
                      const std::string& name);

/// "pixel (x, y)" of the first value that is not finite; empty if there is none.
std::string FirstNonFinite(const Image& image);

/// Fails: IoError naming `path` when the image is empty or its channel count is not in
/// `allowed_channels`, NumericalError when a value is not finite.
void CheckWritable(const Image& image,
                   std::initializer_list<int> allowed_channels,
                   const std::filesystem::path& path);

/// What cameras note in a JPEG file (a TIFF structure, unchecked), within `bytes`; empty without.
std::string_view ExifOfJpeg(std::string_view bytes);

/// Orientation (tag 0x0112) in what ExifOfJpeg found, 1 to 8; 1 when absent or malformed.
int OrientationOfExif(std::string_view exif);

/// The ICC profile in a JPEG, PNG or TIFF file, unchecked; empty without one.
std::string IccProfileOf(std::string_view bytes, ImageKind kind);

/// What OpenCV's decoders leave open: the declared size before they allocate, and for JPEG that the
/// file is not cut off (they fill up with grey). Fails: IoError naming `name`.
void CheckContainer(std::string_view bytes, ImageKind kind, const std::string& name);

}  // namespace pathfit::renderer
