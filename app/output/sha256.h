#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace pathfit::app {

/// Lower-case hexadecimal SHA-256.
std::string Sha256Hex(std::string_view data);
/// The same of a file, read in pieces. Throws IoError when it cannot be read.
std::string Sha256OfFile(const std::filesystem::path& path);

/// Standard alphabet with padding.
std::string Base64(std::string_view data);
/// A picture inside a page: its bytes as the text of a URI.
std::string DataUri(std::string_view bytes, std::string_view mime = "image/jpeg");
/// Content-security-policy source of an inline script or style: sha256-<base64>.
std::string CspHash(std::string_view text);

}  // namespace pathfit::app
