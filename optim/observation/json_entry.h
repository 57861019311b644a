#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace pathfit::optim {

/// A JSON object together with where it stands, for messages. Errors are IoErrors with the place.
struct JsonEntry {
  const nlohmann::json& value;
  std::string place;

  /// Empty when the key is absent or null.
  [[nodiscard]] std::optional<double> Number(const char* key) const;
  [[nodiscard]] std::optional<std::string> Text(const char* key) const;
  /// Lists and objects are only named: writing them out would recurse as deep as the file nests
  /// them.
  static std::string Shown(const nlohmann::json& value);
};

/// Throws IoError with file and line.
nlohmann::json ParseJsonFile(const std::filesystem::path& path);

}  // namespace pathfit::optim
