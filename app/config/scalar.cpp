#include "app/config/scalar.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace pathfit::app {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

std::string Lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

std::string_view WithoutSign(const std::string& text) {
  std::string_view rest = text;
  if (!rest.empty() && (rest[0] == '+' || rest[0] == '-')) rest.remove_prefix(1);
  return rest;
}

std::size_t CountDigits(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::find_if_not(text, IsDigit) - text.begin());
}

// [-+]? (digits (. digits?)? | . digits) ([eE] [-+]? digits)?
bool HasNumberForm(const std::string& text) {
  std::string_view rest = WithoutSign(text);
  const std::size_t whole = CountDigits(rest);
  rest.remove_prefix(whole);
  std::size_t fraction = 0;
  if (!rest.empty() && rest[0] == '.') {
    rest.remove_prefix(1);
    fraction = CountDigits(rest);
    rest.remove_prefix(fraction);
  }
  if (whole + fraction == 0) return false;
  if (rest.empty()) return true;
  if (rest[0] != 'e' && rest[0] != 'E') return false;
  rest.remove_prefix(1);
  if (!rest.empty() && (rest[0] == '+' || rest[0] == '-')) rest.remove_prefix(1);
  return !rest.empty() && CountDigits(rest) == rest.size();
}

// 012, 007.5: other readers take them for octal.
bool HasLeadingZero(const std::string& text) {
  const std::string_view rest = WithoutSign(text);
  return rest.size() > 1 && rest[0] == '0' && IsDigit(rest[1]);
}

std::string WithoutLeadingZeros(const std::string& text) {
  const std::string_view rest = WithoutSign(text);
  std::size_t zeros = std::min(rest.find_first_not_of('0'), rest.size());
  if (zeros == rest.size() || !IsDigit(rest[zeros])) --zeros;
  return (text[0] == '-' ? "-" : "") + std::string(rest.substr(zeros));
}

double FromDigits(const std::string& text) {
  const char* first = text.data() + (text[0] == '+' ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range || end != text.data() + text.size()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return value;
}

// Why text that should be a number is none.
std::string NumberProblem(const YamlNode& node, const std::string& noun) {
  const std::string& text = node.text;
  if (node.quoted) {
    const bool number = HasNumberForm(text) && !HasLeadingZero(text);
    return DescribeNode(node) + " is text, because it is in quotes" +
           (number ? "; write " + text : "; " + noun + " is needed");
  }
  const std::string lower = Lower(text);
  if (lower == ".nan" || lower == "nan") return "NaN is not allowed";
  if (HasNumberForm(text) && HasLeadingZero(text)) {
    return fmt::format(
        "{} has a leading zero; write {}", DescribeNode(node), WithoutLeadingZeros(text));
  }
  std::string with_point = text;
  if (std::ranges::count(text, ',') == 1) {
    with_point[text.find(',')] = '.';
    if (HasNumberForm(with_point)) {
      return fmt::format("{} is not a number; write {}", DescribeNode(node), with_point);
    }
  }
  return DescribeNode(node) + " is not " + noun;
}

std::optional<double> Infinity(const std::string& text) {
  const std::string lower = Lower(text);
  if (lower == ".inf" || lower == "+.inf") return std::numeric_limits<double>::infinity();
  if (lower == "-.inf") return -std::numeric_limits<double>::infinity();
  return std::nullopt;
}

bool IsInfinityWord(const std::string& text) {
  const std::string rest = Lower(std::string(WithoutSign(text)));
  return rest == "inf" || rest == "infinity";
}

Parsed<std::string> ExpandVariables(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t open = text.find("${", i);
    out += text.substr(i, open - i);
    if (open == std::string::npos) break;
    const std::size_t close = text.find('}', open);
    if (close == std::string::npos) return {{}, "'${' is never closed by '}'"};
    const std::string name = text.substr(open + 2, close - open - 2);
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing sets variables.
    const char* value = name.empty() ? nullptr : std::getenv(name.c_str());
    if (value == nullptr) return {{}, "environment variable '" + name + "' is not set"};
    out += value;
    i = close + 1;
  }
  return {out, {}};
}

}  // namespace

Parsed<double> ParseNumber(const YamlNode& node, bool allow_infinite) {
  if (!node.IsScalar()) return {{}, "a number is needed, not " + DescribeNode(node)};
  if (!node.quoted) {
    if (const std::optional<double> infinite = Infinity(node.text)) {
      if (allow_infinite) return {infinite, {}};
      return {{}, DescribeNode(node) + " is not allowed here; a finite number is needed"};
    }
    if (IsInfinityWord(node.text)) {
      const std::string sign = node.text[0] == '-' ? "-" : "";
      return {{},
              allow_infinite
                  ? DescribeNode(node) + " is not a number; write " + sign + ".inf"
                  : DescribeNode(node) + " is not allowed here; a finite number is needed"};
    }
    if (HasNumberForm(node.text) && !HasLeadingZero(node.text)) {
      const double value = FromDigits(node.text);
      if (std::isfinite(value)) return {value, {}};
      return {{}, DescribeNode(node) + " does not fit a double-precision number"};
    }
  }
  return {{}, NumberProblem(node, "a number")};
}

Parsed<std::int64_t> ParseInteger(const YamlNode& node) {
  if (!node.IsScalar()) return {{}, "a whole number is needed, not " + DescribeNode(node)};
  const std::string& text = node.text;
  const std::string_view digits = WithoutSign(text);
  if (node.quoted || digits.empty() || HasLeadingZero(text) ||
      CountDigits(digits) != digits.size()) {
    return {{}, NumberProblem(node, "a whole number")};
  }
  std::int64_t value = 0;
  const char* first = text.data() + (text[0] == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
  if (error != std::errc()) return {{}, DescribeNode(node) + " has too many digits"};
  return {value, {}};
}

Parsed<bool> ParseBool(const YamlNode& node) {
  if (!node.IsScalar()) return {{}, "true or false is needed, not " + DescribeNode(node)};
  const std::string lower = Lower(node.text);
  if (!node.quoted && (node.text == "true" || node.text == "false")) {
    return {node.text == "true", {}};
  }
  constexpr std::array<std::pair<const char*, const char*>, 10> kSpellings = {{{"yes", "true"},
                                                                               {"y", "true"},
                                                                               {"on", "true"},
                                                                               {"1", "true"},
                                                                               {"true", "true"},
                                                                               {"no", "false"},
                                                                               {"n", "false"},
                                                                               {"off", "false"},
                                                                               {"0", "false"},
                                                                               {"false", "false"}}};
  for (const auto& [spelling, meaning] : kSpellings) {
    if (lower == spelling) {
      return {{}, DescribeNode(node) + " is not a boolean here; write " + std::string(meaning)};
    }
  }
  return {{}, DescribeNode(node) + " is not a boolean; write true or false"};
}

Parsed<double> ParseBytes(const YamlNode& node) {
  if (!node.IsScalar()) return {{}, "a size such as 16 GiB is needed, not " + DescribeNode(node)};
  const std::string& text = node.text;
  const std::size_t unit_start = std::min(text.find_first_not_of("0123456789."), text.size());
  const std::string number = text.substr(0, unit_start);
  const std::size_t letters = std::min(text.find_first_not_of(' ', unit_start), text.size());
  const std::string unit = text.substr(letters);
  constexpr std::array<std::pair<const char*, double>, 9> kUnits = {{{"B", 1.0},
                                                                     {"KB", 1e3},
                                                                     {"MB", 1e6},
                                                                     {"GB", 1e9},
                                                                     {"TB", 1e12},
                                                                     {"KiB", 1024.0},
                                                                     {"MiB", 1048576.0},
                                                                     {"GiB", 1073741824.0},
                                                                     {"TiB", 1099511627776.0}}};
  for (const auto& [name, bytes] : kUnits) {
    if (unit == name && HasNumberForm(number) && !HasLeadingZero(number)) {
      const double value = FromDigits(number) * bytes;
      if (value >= 1.0 && std::isfinite(value)) return {value, {}};
    }
  }
  return {{},
          DescribeNode(node) + " is not a size; write a number and a unit, as 16 GiB or 500 MiB"};
}

Parsed<std::filesystem::path> ResolvePath(const std::string& text,
                                          const std::filesystem::path& folder) {
  Parsed<std::string> expanded = ExpandVariables(text);
  if (!expanded.value) return {{}, expanded.problem};
  std::string& path = *expanded.value;
  if (path == "~" || path.rfind("~/", 0) == 0) {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing sets variables.
    const char* home = std::getenv("HOME");
    if (home == nullptr) return {{}, "'~' cannot be replaced, HOME is not set"};
    path.replace(0, 1, home);
  }
  if (path.empty()) return {{}, "a path is needed, not empty text"};
  std::filesystem::path result = (folder / path).lexically_normal();
  if (!result.has_filename() && result.has_relative_path()) result = result.parent_path();
  if (result.string().find("${") != std::string::npos) {
    return {{}, "the folder '" + result.string() + "' holds '${' in its name"};
  }
  return {result, {}};
}

std::optional<double> ParseDuration(const std::string& text) {
  std::string_view rest = text;
  double seconds = 0.0;
  double last_unit = std::numeric_limits<double>::infinity();
  while (!rest.empty()) {
    const std::size_t length = std::min(rest.find_first_not_of("0123456789."), rest.size());
    const std::string number(rest.substr(0, length));
    if (!HasNumberForm(number) || length == rest.size()) return std::nullopt;
    const char letter = rest[length];
    const double unit = letter == 'h' ? 3600.0 : letter == 'm' ? 60.0 : letter == 's' ? 1.0 : 0.0;
    if (unit == 0.0 || unit >= last_unit) return std::nullopt;
    last_unit = unit;
    seconds += FromDigits(number) * unit;
    rest.remove_prefix(length + 1);
  }
  if (!std::isfinite(seconds) || seconds <= 0.0) return std::nullopt;
  return seconds;
}

}  // namespace pathfit::app
