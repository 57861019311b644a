#include "app/config/config_error.h"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "app/config/utf8.h"

namespace pathfit::app {
namespace {

constexpr std::size_t kMaxPrinted = 20;
constexpr std::size_t kMaxLineShown = 120;  // bytes of a source line

// The source line with a caret below the place; long lines are shown around it.
std::string SourceExcerpt(const std::string& line, int line_number, int column) {
  const std::size_t at = std::min(static_cast<std::size_t>(std::max(column - 1, 0)), line.size());
  std::size_t first = at > kMaxLineShown - 40 ? at - (kMaxLineShown - 40) : 0;
  while (first > 0 && IsContinuationByte(line[first])) --first;
  std::size_t last = std::min(line.size(), first + kMaxLineShown);
  while (last < line.size() && IsContinuationByte(line[last])) ++last;
  std::string shown = (first > 0 ? "…" : "") + line.substr(first, last - first);
  std::replace(shown.begin(), shown.end(), '\t', ' ');
  if (last < line.size()) shown += "…";
  const std::size_t indent =
      (first > 0 ? 1 : 0) + NumCharacters(std::string_view(line).substr(first, at - first));
  return fmt::format("{:>5} | {}\n      | {:{}}^\n", line_number, shown, "", indent);
}

// Names and values come from files and must not steer a terminal.
std::string WithoutControls(std::string text) {
  constexpr unsigned char kDelete = 0x7F;
  std::ranges::replace_if(
      text,
      [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte < ' ' || byte == kDelete;
      },
      '?');
  return text;
}

std::string FormatProblem(const ConfigSource& source, const Problem& problem) {
  std::string out = FormatPlace(source, problem.place) + ": error: ";
  if (!problem.path.empty()) out += WithoutControls(problem.path) + ": ";
  out += WithoutControls(problem.text) + "\n";
  const Place& place = problem.place;
  if (place.source == Place::Source::kOverride) {
    const auto index = static_cast<std::size_t>(place.override_index);
    out += "      " + WithoutControls(source.overrides[index].assignment) + "\n";
  } else if (place.line >= 1 && place.line <= static_cast<int>(source.lines.size())) {
    out += SourceExcerpt(
        source.lines[static_cast<std::size_t>(place.line - 1)], place.line, place.column);
  }
  return out;
}

auto SortKey(const Problem& problem) {
  const Place& place = problem.place;
  return std::tuple(
      place.source == Place::Source::kOverride, place.override_index, place.line, place.column);
}

void SortAndUnique(std::vector<Problem>& problems) {
  std::ranges::stable_sort(
      problems, [](const Problem& a, const Problem& b) { return SortKey(a) < SortKey(b); });
  // An alias brings the same problem once per use.
  const auto last =
      std::unique(problems.begin(), problems.end(), [](const Problem& a, const Problem& b) {
        return a.place == b.place && a.path == b.path && a.text == b.text;
      });
  problems.erase(last, problems.end());
}

int CountProblems(std::vector<Problem> problems) {
  SortAndUnique(problems);
  return static_cast<int>(problems.size());
}

std::string ClosingLine(int count) {
  return "pathfit: config has " + std::to_string(count) + (count == 1 ? " error" : " errors") +
         "; nothing was run (status 3)";
}

}  // namespace

std::string FormatPlace(const ConfigSource& source, const Place& place) {
  switch (place.source) {
    case Place::Source::kOverride:
      return source.overrides[static_cast<std::size_t>(place.override_index)].label;
    case Place::Source::kFile:
      if (place.line > 0) {
        return source.file + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
      }
      break;
    case Place::Source::kDefault:
      break;
  }
  return source.file;
}

std::string FormatProblems(const ConfigSource& source, std::vector<Problem> problems) {
  SortAndUnique(problems);
  std::string out;
  for (std::size_t i = 0; i < std::min(problems.size(), kMaxPrinted); ++i) {
    out += FormatProblem(source, problems[i]);
  }
  if (problems.size() > kMaxPrinted) {
    out += "... and " + std::to_string(problems.size() - kMaxPrinted) + " more\n";
  }
  return out;
}

ConfigError::ConfigError(const ConfigSource& source, const std::vector<Problem>& problems)
    : std::runtime_error(FormatProblems(source, problems) + ClosingLine(CountProblems(problems))) {}

}  // namespace pathfit::app
