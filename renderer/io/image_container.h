#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

namespace pathfit::renderer {

enum class ImageKind { kUnknown, kJpeg, kPng, kTiff, kHdr, kExr };

/// By the first bytes; the extension is not trusted.
ImageKind KindOfImage(std::string_view bytes);

/// EXIF orientation (tag 0x0112) of a JPEG file, 1 to 8; 1 when absent or malformed.
int ReadJpegOrientation(std::string_view bytes);

/// Checks what the decoders leave open, before they allocate: the declared size, and for JPEG that
/// the file is not cut off. Fails: IoError naming `name`.
void CheckContainer(std::string_view bytes, ImageKind kind, const std::filesystem::path& name);

/// Value of a SHORT or LONG tag with one entry in the first directory of a TIFF structure. Empty
/// when absent or malformed.
std::optional<std::uint32_t> FindTiffTag(std::string_view bytes, std::uint16_t tag);

}  // namespace pathfit::renderer
