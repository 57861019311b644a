#pragma once

#include <filesystem>

#include "renderer/image/image.h"

namespace pathfit::renderer {

/// Pixels of the data window, linear, 3 channels: R G B, or Y repeated. Half or float, scan lines
/// or tiles, first part. `alpha`, if given, gets channel A (1 channel), or becomes empty without
/// one. Fails: IoError when missing, malformed, cut off, with other channels only, colours whose
/// chromaticities are not those of Rec.709, or a value that is not finite.
Image ReadExr(const std::filesystem::path& path, Image* alpha = nullptr);

/// float32, ZIP; 1 (Y), 3 (R G B) or 4 channels (R G B A). Written through a temporary file.
/// Fails: IoError (not writable), NumericalError naming the first pixel that is not finite.
void WriteExr(const std::filesystem::path& path, const Image& image);

}  // namespace pathfit::renderer
