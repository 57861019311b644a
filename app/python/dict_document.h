#pragma once

#include <string>

#include <pybind11/pybind11.h>

#include "app/config/yaml_document.h"

namespace pathfit::app {

/// A config written in Python: dicts with text keys, lists, tuples, numbers, text, None, paths and
/// what has tolist(), as numpy's arrays. Text is never taken for a number. What is none of these
/// is in `problems`, named by its keys, as there are no lines; `name` is what messages call the
/// whole.
YamlDocument DocumentOf(const pybind11::dict& config, const std::string& name);

/// Text as it is; anything else as above, written as YAML in one line.
std::string OverrideText(const pybind11::handle& value);

}  // namespace pathfit::app
