#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "renderer/core/error.h"
#include "renderer/math/rgb.h"

namespace pathfit::app {

using Json = nlohmann::ordered_json;

/// One figure of a report: its name in files, and how progress lines, tables and charts show it.
struct Figure {
  const char* key;         ///< in metrics.csv, history.json, run.json and JSON progress lines
  const char* unit = "";   ///< s, MB, dB, IoU; empty for pure numbers and names
  const char* label = "";  ///< for people, without its unit
  const char* doc = "";
  const char* chart = "";     ///< title of the report's chart it is drawn in; empty: in none
  const char* by_stage = "";  ///< sum, max or last over a stage's rounds, in the table of times
  const char* plain = "";     ///< fmt pattern of its part of a plain progress line; empty: none
  const char* status = "";    ///< the same for the status line
  double scale = 1.0;         ///< multiplies the number in both patterns
};

/// The fields of a struct, listed once for all that writes or reads it: specialisations have
/// `Visit(value, visit)`, which calls visit(key, member) for each field. A key is a string, which a
/// file must have, or a Figure, which files of older versions may lack.
template <class T>
struct Fields;

inline const char* KeyOf(const char* key) { return key; }
inline const char* KeyOf(const Figure& figure) { return figure.key; }

template <class T>
concept HasFields = requires {
  sizeof(Fields<T>);
};
template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

/// JSON has no infinities: they become the names "inf" and "-inf"; NaN becomes null.
template <class T>
Json ToJson(const T& value) {
  if constexpr (std::is_same_v<T, double>) {
    if (std::isnan(value)) return nullptr;
    if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
    return value;
  } else if constexpr (std::is_same_v<T, renderer::Rgb>) {
    return {ToJson(value.r), ToJson(value.g), ToJson(value.b)};
  } else if constexpr (HasFields<T>) {
    Json json = Json::object();
    Fields<T>::Visit(
        value, [&json](const auto& key, const auto& member) { json[KeyOf(key)] = ToJson(member); });
    return json;
  } else if constexpr (IsVector<T>::value) {
    Json json = Json::array();
    for (const auto& element : value) json.push_back(ToJson(element));
    return json;
  } else if constexpr (IsOptional<T>::value) {
    return value ? ToJson(*value) : Json(nullptr);
  } else {
    return value;
  }
}

/// Throws Json::exception when a field is missing, of another type or beyond what its member holds.
template <class T>
void FromJson(const Json& json, T& value) {
  if constexpr (std::is_same_v<T, double>) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    value = json.is_number() ? json.get<double>()
            : json == "inf"  ? kInfinity
            : json == "-inf" ? -kInfinity
                             : std::numeric_limits<double>::quiet_NaN();
  } else if constexpr (std::is_same_v<T, renderer::Rgb>) {
    for (int c = 0; c < 3; ++c) FromJson(json.at(static_cast<std::size_t>(c)), value[c]);
  } else if constexpr (HasFields<T>) {
    Fields<T>::Visit(value, [&json]<class Key>(const Key& key, auto& member) {
      if constexpr (std::is_same_v<Key, Figure>) {
        if (json.is_object() && !json.contains(key.key)) return;
      }
      FromJson(json.at(KeyOf(key)), member);
    });
  } else if constexpr (IsVector<T>::value) {
    value.clear();
    for (const Json& element : json.get_ref<const Json::array_t&>()) {
      FromJson(element, value.emplace_back());
    }
  } else if constexpr (IsOptional<T>::value) {
    value.reset();
    if (!json.is_null()) FromJson(json, value.emplace());
  } else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
    const bool fits = json.is_number_unsigned()
                          ? std::in_range<T>(json.get<std::uint64_t>())
                          : json.is_number_integer() && std::in_range<T>(json.get<std::int64_t>());
    if (!fits) throw Json::out_of_range::create(406, "no whole number that fits", &json);
    json.get_to(value);
  } else {
    json.get_to(value);
  }
}

/// Bytes that are not UTF-8 become U+FFFD. `indent` < 0: one line.
std::string JsonText(const Json& json, int indent = 2);

/// Quoted when it holds a comma or quote; line breaks become spaces, so that a row is a line.
std::string CsvCell(std::string text);
/// Shortest decimal form that reads back to the same double; empty when not finite.
std::string CsvCell(double value);
inline std::string CsvCell(bool value) { return value ? "1" : "0"; }
template <class T>
requires std::is_integral_v<T> std::string CsvCell(T value) { return std::to_string(value); }

/// A header of keys and one line for each row.
template <class Row>
std::string CsvTable(const std::vector<Row>& rows) {
  std::string header;
  const Row none;
  Fields<Row>::Visit(none, [&header](const auto& key, const auto&) {
    header += (header.empty() ? "" : ",") + std::string(KeyOf(key));
  });
  std::string csv = header + "\n";
  for (const Row& row : rows) {
    std::string line;
    Fields<Row>::Visit(row,
                       [&](const auto&, const auto& member) { line += CsvCell(member) + ","; });
    line.back() = '\n';
    csv += line;
  }
  return csv;
}

}  // namespace pathfit::app
