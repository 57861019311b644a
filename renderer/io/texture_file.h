#pragma once

#include <filesystem>

#include "renderer/texture/texture.h"

namespace pathfit::renderer {

/// What the numbers of a picture mean.
enum class TextureRole {
  kColor,   ///< 8- and 16-bit files are sRGB encoded and become linear; float files are linear
  kNormal,  ///< three numbers per texel as they are
  kData     ///< one number per texel: the first channel as it is, 0..1 in 8- and 16-bit files
};

/// Texture from a JPEG, PNG, TIFF, HDR or EXR file, repeating, named as the file; alpha and the
/// EXIF orientation are ignored. kData sets `scalar`. Fails: IoError naming the file, also for
/// negative values.
Texture ReadTexture(const std::filesystem::path& path, TextureRole role);

}  // namespace pathfit::renderer
