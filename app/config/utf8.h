#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace pathfit::app {

/// Whether a byte goes on with a character that an earlier one has begun.
constexpr bool IsContinuationByte(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

/// Number of characters of UTF-8 text, each of which takes one column of a terminal.
std::size_t NumCharacters(std::string_view text);

/// Up to so many bytes of UTF-8 text from its begin or to its end, of whole characters.
std::string FirstBytes(const std::string& text, std::size_t most);
std::string LastBytes(const std::string& text, std::size_t most);

/// Offset of the first byte that is not printable UTF-8 text (tab and line ends are), or empty.
std::optional<std::size_t> FirstBadByte(const std::string& text);

}  // namespace pathfit::app
