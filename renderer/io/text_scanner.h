#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace pathfit::renderer {

/// A whole token as a number in the C locale. Empty for anything else; "nan", "inf" and overflow
/// are refused too.
std::optional<double> ParseReal(std::string_view token);
std::optional<std::int64_t> ParseInteger(std::string_view token);

inline constexpr std::string_view kBlanks = " \t\v\f\r\n";

/// Cuts the next run of non-blank characters off the front of `text`; empty at its end.
std::string_view NextToken(std::string_view& text);

/// Lines of a text, counted from 1; ends at LF, CR LF or CR. The text must outlive the reader.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}

  /// False at the end. The line excludes its end.
  bool Next(std::string_view& line);
  [[nodiscard]] std::int64_t LineNumber() const { return line_number_; }
  /// What follows the last line read.
  [[nodiscard]] std::string_view Rest() const { return rest_; }

 private:
  std::string_view rest_;
  std::int64_t line_number_ = 0;
};

}  // namespace pathfit::renderer
