#pragma once

#include <filesystem>
#include <string_view>

#include "renderer/image/image.h"

namespace pathfit::renderer {

/// Pixels of a Radiance HDR file (RGBE, run-length coded by component or flat, any of the eight
/// axis orders; EXPOSURE is divided out), 3 channels. `name` is for messages.   Fails: IoError when
/// malformed or cut off.
Image DecodeHdr(std::string_view bytes, const std::filesystem::path& name);

/// 3 channels, not negative; shared 8-bit exponent, so about 1 % of the largest channel. Written
/// through a temporary file. Fails: IoError (not writable, negative or too large values),
/// NumericalError (not finite).
void WriteHdr(const std::filesystem::path& path, const Image& image);

}  // namespace pathfit::renderer
