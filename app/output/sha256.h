#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace pathfit::app {

/// SHA-256 (FIPS 180-4) of data given in pieces.
class Sha256 {
 public:
  void Update(std::string_view data);
  /// The digest of everything so far; the object must not be used afterwards.
  [[nodiscard]] std::array<std::uint8_t, 32> Finish();

 private:
  void Compress(const std::uint8_t* block);

  std::array<std::uint32_t, 8> state_{0x6a09e667U,
                                      0xbb67ae85U,
                                      0x3c6ef372U,
                                      0xa54ff53aU,
                                      0x510e527fU,
                                      0x9b05688cU,
                                      0x1f83d9abU,
                                      0x5be0cd19U};
  std::array<std::uint8_t, 64> buffer_{};
  std::size_t buffered_ = 0;
  std::uint64_t num_bytes_ = 0;
};

/// Lower-case hexadecimal digest.
std::string Sha256Hex(std::string_view data);
/// The same of a file, read in pieces. Throws IoError when it cannot be read.
std::string Sha256OfFile(const std::filesystem::path& path);

/// Standard alphabet with padding.
std::string Base64(std::string_view data);
/// Content-security-policy source of an inline script or style: sha256-<base64>.
std::string CspHash(std::string_view text);

}  // namespace pathfit::app
