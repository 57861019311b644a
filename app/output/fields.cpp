#include "app/output/fields.h"

#include <fmt/format.h>

namespace pathfit::app {

std::string JsonText(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string CsvCell(std::string text) {
  for (char& c : text) c = c == '\n' || c == '\r' ? ' ' : c;
  if (text.find_first_of(",\"") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

std::string CsvCell(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}

}  // namespace pathfit::app
