#include "app/output/sha256.h"

#include <fstream>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "renderer/core/check.h"
#include "renderer/core/error.h"

namespace pathfit::app {
namespace {

/// SHA-256 of data given in pieces.
class Sha256 {
 public:
  Sha256() { PATHFIT_CHECK(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1); }
  void Update(std::string_view data) {
    PATHFIT_CHECK(EVP_DigestUpdate(context_.get(), data.data(), data.size()) == 1);
  }
  /// The bytes of the digest; nothing may follow.
  std::string Finish() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    PATHFIT_CHECK(EVP_DigestFinal_ex(context_.get(), digest, &size) == 1);
    return {digest, digest + size};
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_{EVP_MD_CTX_new(),
                                                                   EVP_MD_CTX_free};
};

std::string DigestOf(std::string_view data) {
  Sha256 hash;
  hash.Update(data);
  return hash.Finish();
}

std::string Hex(const std::string& bytes) {
  std::string text;
  for (const char byte : bytes) text += fmt::format("{:02x}", static_cast<unsigned char>(byte));
  return text;
}

}  // namespace

std::string Sha256Hex(std::string_view data) { return Hex(DigestOf(data)); }

std::string Sha256OfFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw renderer::IoError(path.string() + ": cannot be opened for reading");
  Sha256 hash;
  std::vector<char> piece(1U << 16U);
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0) {
    hash.Update({piece.data(), static_cast<std::size_t>(file.gcount())});
  }
  if (file.bad()) throw renderer::IoError(path.string() + ": reading failed");
  return Hex(hash.Finish());
}

std::string Base64(std::string_view data) {
  std::string text((data.size() + 2) / 3 * 4 + 1, '\0');  // the library ends it with a zero
  const auto* bytes = reinterpret_cast<const unsigned char*>(data.data());
  text.resize(static_cast<std::size_t>(EVP_EncodeBlock(
      reinterpret_cast<unsigned char*>(text.data()), bytes, static_cast<int>(data.size()))));
  return text;
}

std::string DataUri(std::string_view bytes, std::string_view mime) {
  return "data:" + std::string(mime) + ";base64," + Base64(bytes);
}

std::string CspHash(std::string_view text) { return "sha256-" + Base64(DigestOf(text)); }

}  // namespace pathfit::app
