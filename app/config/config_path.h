#pragma once

#include <filesystem>
#include <string>

#include "app/config/scalar.h"

namespace pathfit::app {

/// A path as written in a file: a leading `~/` and every `${VAR}` are replaced, what is relative is
/// taken from `folder`, and the result is absolute and normal.
Parsed<std::filesystem::path> ResolvePath(const std::string& text,
                                          const std::filesystem::path& folder);

}  // namespace pathfit::app
