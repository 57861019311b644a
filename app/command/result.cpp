#include "app/command/result.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

namespace pathfit::app {
namespace {

bool HasType(const Json& value, std::string_view type) {
  if (value.is_null()) return type.ends_with(" or null");
  const std::string_view first = type.substr(0, type.find(' '));
  return (first == "text" && value.is_string()) || (first == "number" && value.is_number()) ||
         (first == "whole" && value.is_number_integer()) ||
         (first == "boolean" && value.is_boolean()) || (first == "list" && value.is_array()) ||
         (first == "map" && value.is_object());
}

}  // namespace

void RequireDeclared(const Command& command, const Json& result) {
  const auto fail = [&](const std::string& key, const char* what) {
    throw std::logic_error(fmt::format("result of {}: {} {}", command.name, key, what));
  };
  for (const ResultKey& declared : command.result) {
    const auto found = result.find(declared.key);
    if (found == result.end()) {
      if (!std::string_view(declared.type).ends_with(" or absent"))
        fail(declared.key, "is missing");
    } else if (!HasType(*found, declared.type)) {
      fail(declared.key, "has another type");
    }
  }
  for (const auto& [key, value] : result.items()) {
    const bool known =
        key == "schema" ||
        std::ranges::any_of(command.result, [&](const ResultKey& r) { return key == r.key; });
    if (!known) fail(key, "is not declared");
  }
}

void PrintResult(const CommandContext& context, const Json& result) {
  const Command& command = *context.line.command;
  RequireDeclared(command, result);
  Json object = {{"schema", fmt::format("pathfit-{}-1", command.name)}};
  object.update(result);
  fmt::print("{}\n", JsonText(object));
}

}  // namespace pathfit::app
