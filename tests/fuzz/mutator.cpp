#include "tests/fuzz/mutator.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace pathfit::tests {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 18U;
constexpr std::size_t kMaxPiece = 64;
constexpr std::array<const char*, 22> kNumbers = {
    "0",    "-1",   "1",     "1e999", "-1e999",     "nan",         "inf",
    "1e30", "-0.0", "1e-99", "1e300", "2147483648", "-2147483649", "18446744073709551616",
    "",     "x",    "0x10",  "012",   "65536",      "1e12",        "99999999999999999999999999",
    ".5"};

bool IsDigit(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; }

}  // namespace

std::string Mutator::Mutate(std::string bytes,
                            const std::string& other,
                            const std::vector<std::string>& words) {
  const std::size_t edits = 1 + Below(Below(4) == 0 ? 16 : 3);
  for (std::size_t i = 0; i < edits; ++i) Edit(other, words, bytes);
  if (bytes.size() > kMaxBytes) bytes.resize(kMaxBytes);
  return bytes;
}

void Mutator::Edit(const std::string& other,
                   const std::vector<std::string>& words,
                   std::string& bytes) {
  const std::size_t at = Below(bytes.size() + 1);
  const std::size_t piece = 1 + Below(kMaxPiece);
  switch (Below(10)) {
    case 0:
      if (at < bytes.size()) bytes[at] = static_cast<char>(Below(256));
      return;
    case 1:
      if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << Below(8)));
      return;
    case 2:
      bytes.erase(at, piece);
      return;
    case 3:
      if (Below(4) == 0) bytes.resize(at);
      return;
    case 4:  // a piece again, somewhere else
      if (at < bytes.size()) bytes.insert(Below(bytes.size()), bytes.substr(at, piece));
      return;
    case 5:
      if (!other.empty()) {
        const std::size_t from = Below(other.size());
        bytes.replace(std::min(at, bytes.size()), Below(piece), other.substr(from, piece));
      }
      return;
    case 6:
      if (!words.empty()) bytes.insert(at, words[Below(words.size())]);
      return;
    case 7:
      if (!words.empty()) {
        const std::string& word = words[Below(words.size())];
        bytes.replace(at, std::min(word.size(), bytes.size() - at), word);
      }
      return;
    case 8:
      return PutNumber(bytes);
    default:
      return ReplaceDigits(bytes);
  }
}

/// A whole or real number of a size that is rarely thought of, in either byte order.
void Mutator::PutNumber(std::string& bytes) {
  constexpr std::array<std::uint64_t, 12> kWhole = {
      0, 1, 0x7f, 0x80, 0xff, 0x7fff, 0xffff, 0x10000, 0x7fffffff, 0x80000000, 0xffffffff, ~0ULL};
  std::uint64_t value = kWhole[Below(kWhole.size())];
  std::size_t size = std::size_t{1} << Below(4);
  if (Below(4) == 0) {
    constexpr std::array<double, 5> kReal = {std::numeric_limits<double>::quiet_NaN(),
                                             std::numeric_limits<double>::infinity(),
                                             1e300,
                                             -1.0,
                                             std::numeric_limits<double>::denorm_min()};
    const double real = kReal[Below(kReal.size())];
    size = 4 + 4 * Below(2);
    if (size == sizeof(double)) {
      std::memcpy(&value, &real, sizeof real);
    } else {
      const auto single = static_cast<float>(real);
      value = 0;
      std::memcpy(&value, &single, sizeof single);
    }
  }
  if (bytes.size() < size) return;
  std::array<char, 8> stored{};
  std::memcpy(stored.data(), &value, stored.size());
  if (Below(2) == 0) std::reverse(stored.begin(), stored.begin() + static_cast<int>(size));
  bytes.replace(Below(bytes.size() - size + 1), size, stored.data(), size);
}

void Mutator::ReplaceDigits(std::string& bytes) {
  std::size_t at = Below(bytes.size() + 1);
  while (at < bytes.size() && !IsDigit(bytes[at])) ++at;
  std::size_t end = at;
  while (end < bytes.size() && IsDigit(bytes[end])) ++end;
  bytes.replace(at, end - at, kNumbers[Below(kNumbers.size())]);
}

}  // namespace pathfit::tests
