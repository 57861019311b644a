#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace pathfit::app {

/// Offset of the first byte that is not printable UTF-8 text (tab and line ends are), or empty.
std::optional<std::size_t> FirstBadByte(const std::string& text);

}  // namespace pathfit::app
