#include "optim/observation/json_entry.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::optim {

using nlohmann::json;
using renderer::IoError;

std::optional<double> JsonEntry::Number(const char* key) const {
  const auto found = value.find(key);
  if (found == value.end() || found->is_null()) return std::nullopt;
  if (!found->is_number() || !std::isfinite(found->get<double>())) {
    throw IoError(place + "." + key + ": " + Shown(*found) + " is not a finite number");
  }
  return found->get<double>();
}

std::optional<std::string> JsonEntry::Text(const char* key) const {
  const auto found = value.find(key);
  if (found == value.end() || found->is_null()) return std::nullopt;
  if (!found->is_string() || found->get_ref<const std::string&>().empty()) {
    throw IoError(place + "." + key + ": " + Shown(*found) + " is not a text that names something");
  }
  return found->get<std::string>();
}

std::string JsonEntry::Shown(const json& value) {
  if (value.is_structured()) return value.is_array() ? "a list" : "an object";
  const std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  return text.size() <= 40 ? text : text.substr(0, 37) + "...";
}

json ParseJsonFile(const std::filesystem::path& path) {
  const std::string text = renderer::ReadWholeFile(path);
  try {
    return json::parse(text);
  } catch (const json::parse_error& error) {
    const std::size_t byte = std::min(error.byte, text.size());
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n');
    throw IoError(path.string() + ":" + std::to_string(line) + ": not valid JSON (byte " +
                  std::to_string(byte) + ")");
  } catch (const json::exception&) {
    throw IoError(path.string() + ": holds a number that is out of range");
  }
}

}  // namespace pathfit::optim
