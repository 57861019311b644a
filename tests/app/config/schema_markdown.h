#pragma once

#include <string>

namespace pathfit::app {

/// configs/README.md: every key with its type, default, unit and meaning.
std::string SchemaMarkdown();

}  // namespace pathfit::app
