#include "optim/checkpoint/npy.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

static_assert(std::endian::native == std::endian::little,
              "arrays are written as they are in memory");

constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);
constexpr std::size_t kAlignment = 64;

[[noreturn]] void Fail(const std::filesystem::path& path, const std::string& what) {
  throw renderer::IoError(path.string() + ": " + what);
}

}  // namespace

void WriteNpy(const std::filesystem::path& path, const std::vector<double>& values) {
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
                       std::to_string(values.size()) + ",), }";
  const std::size_t unpadded = kMagic.size() + 2 + header.size() + 1;
  header.append((kAlignment - unpadded % kAlignment) % kAlignment, ' ');
  header.push_back('\n');
  std::ofstream file(path, std::ios::binary);
  file.write(kMagic.data(), static_cast<std::streamsize>(kMagic.size()));
  file.put(static_cast<char>(header.size() & 0xFFU));
  file.put(static_cast<char>(header.size() >> 8U));
  file.write(header.data(), static_cast<std::streamsize>(header.size()));
  // NOLINTNEXTLINE(bugprone-casting-through-void): bytes of doubles.
  file.write(static_cast<const char*>(static_cast<const void*>(values.data())),
             static_cast<std::streamsize>(values.size() * sizeof(double)));
  file.close();
  if (!file) {
    Fail(path, "cannot be written (disk full, or no permission)");
  }
}

std::vector<double> ReadNpy(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic(kMagic.size() + 2, '\0');
  if (!file.read(magic.data(), static_cast<std::streamsize>(magic.size())) ||
      magic.compare(0, kMagic.size(), kMagic) != 0) {
    Fail(path, "not a NumPy array of version 1.0");
  }
  const std::size_t length = static_cast<std::uint8_t>(magic[8]) +
                             (static_cast<std::size_t>(static_cast<std::uint8_t>(magic[9])) << 8U);
  std::string header(length, '\0');
  file.read(header.data(), static_cast<std::streamsize>(length));
  if (!file || header.find("'<f8'") == std::string::npos ||
      header.find("'fortran_order': False") == std::string::npos) {
    Fail(path, "expected a vector of little-endian float64");
  }
  const auto start = file.tellg();
  file.seekg(0, std::ios::end);
  const auto bytes = static_cast<std::size_t>(file.tellg() - start);
  file.seekg(start);
  const std::string shape = "'shape': (" + std::to_string(bytes / sizeof(double)) + ",)";
  if (bytes % sizeof(double) != 0 || header.find(shape) == std::string::npos) {
    Fail(path, "truncated, or its header states another length");
  }
  std::vector<double> values(bytes / sizeof(double));
  file.read(static_cast<char*>(static_cast<void*>(values.data())),
            static_cast<std::streamsize>(bytes));
  if (!file) {
    Fail(path, "cannot be read");
  }
  return values;
}

}  // namespace pathfit::optim
