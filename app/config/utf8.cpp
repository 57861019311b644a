#include "app/config/utf8.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace pathfit::app {
namespace {

bool IsControl(unsigned byte) {
  constexpr unsigned kDelete = 0x7F;
  return (byte < ' ' && byte != '\t' && byte != '\n' && byte != '\r') || byte == kDelete;
}

// Length of the sequence that a lead byte starts, 0 if it starts none.
std::size_t SequenceLength(unsigned lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  if (lead >= 0xF0 && lead < 0xF5) return 4;
  return 0;
}

}  // namespace

std::size_t NumCharacters(std::string_view text) {
  return text.size() - static_cast<std::size_t>(std::ranges::count_if(text, IsContinuationByte));
}

std::string FirstBytes(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  while (most > 0 && IsContinuationByte(text[most])) --most;
  return text.substr(0, most);
}

std::string LastBytes(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t begin = text.size() - most;
  while (begin < text.size() && IsContinuationByte(text[begin])) ++begin;
  return text.substr(begin);
}

std::optional<std::size_t> FirstBadByte(const std::string& text) {
  const auto byte = [&text](std::size_t i) {
    return static_cast<unsigned>(static_cast<unsigned char>(text[i]));
  };
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = SequenceLength(byte(i));
    if (length == 0 || i + length > text.size() || IsControl(byte(i))) return i;
    std::uint32_t code = length == 1 ? byte(i) : byte(i) & (0x7FU >> length);
    for (std::size_t k = 1; k < length; ++k) {
      if (!IsContinuationByte(text[i + k])) return i;
      code = (code << 6U) | (byte(i + k) & 0x3FU);
    }
    // Overlong forms, surrogates and numbers beyond Unicode.
    constexpr std::array<std::uint32_t, 5> kSmallest = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
    if (code < kSmallest[length] || surrogate || code > 0x10FFFF) return i;
    i += length;
  }
  return std::nullopt;
}

}  // namespace pathfit::app
