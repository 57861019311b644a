#include "renderer/io/text_scanner.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace pathfit::renderer {
namespace {

/// std::from_chars knows no plus sign.
std::string_view WithoutPlus(std::string_view token) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-' && token[1] != '+') {
    token.remove_prefix(1);
  }
  return token;
}

template <class T>
std::from_chars_result ParseWhole(std::string_view token, T& value) {
  const char* end = token.data() + token.size();
  std::from_chars_result result = std::from_chars(token.data(), end, value);
  if (result.ec == std::errc() && result.ptr != end) result.ec = std::errc::invalid_argument;
  return result;
}

}  // namespace

std::optional<double> ParseReal(std::string_view token) {
  token = WithoutPlus(token);
  double value = 0.0;
  const std::from_chars_result result = ParseWhole(token, value);
  if (result.ec == std::errc::result_out_of_range) {
    // Too small is zero, too large is refused; the wider exponent range tells which.
    long double wide = 0.0L;
    if (ParseWhole(token, wide).ec != std::errc()) return std::nullopt;
    value = static_cast<double>(wide);
  } else if (result.ec != std::errc()) {
    return std::nullopt;
  }
  if (!std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::int64_t> ParseInteger(std::string_view token) {
  std::int64_t value = 0;
  if (ParseWhole(WithoutPlus(token), value).ec != std::errc()) return std::nullopt;
  return value;
}

std::string_view NextToken(std::string_view& text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    text = {};
    return {};
  }
  const std::size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
  const std::string_view token = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return token;
}

bool LineReader::Next(std::string_view& line) {
  if (rest_.empty()) return false;
  const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  line = rest_.substr(0, end);
  std::size_t skipped = end;
  if (skipped < rest_.size()) {
    const bool is_pair = rest_[end] == '\r' && end + 1 < rest_.size() && rest_[end + 1] == '\n';
    skipped += is_pair ? 2 : 1;
  }
  rest_.remove_prefix(skipped);
  ++line_number_;
  return true;
}

}  // namespace pathfit::renderer
