#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>

#include "renderer/image/image.h"

namespace pathfit::renderer {

/// Fails: IoError naming `name` when a side is not positive or there are more than 2^28 pixels.
void CheckImageSize(std::int64_t width, std::int64_t height, const std::string& name);

/// "pixel (x, y)" of the first value that is not finite; empty if there is none.
std::string FirstNonFinite(const Image& image);

/// Fails: IoError naming `path` when the image is empty or its channel count is not in
/// `allowed_channels`, NumericalError when a value is not finite.
void CheckWritable(const Image& image,
                   std::initializer_list<int> allowed_channels,
                   const std::filesystem::path& path);

}  // namespace pathfit::renderer
