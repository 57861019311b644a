#include "optim/observation/lamp_list.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;
using renderer::Rgb;
using renderer::Vec3;

constexpr std::size_t kMaxLamps = 100'000;
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{64} << 20U;
constexpr double kMostStrength = 1e12;
constexpr double kUnit = 0.05;  // by which lengths of unit vectors of few digits may differ from 1

/// A line: its last numbers, and what stands before them.
struct Row {
  std::string text;                 ///< from its first word to its last
  std::vector<std::size_t> begins;  ///< of the numbers, in `text`
  std::vector<double> numbers;
  std::int64_t line = 0;

  /// What stands before the numbers.
  [[nodiscard]] std::string Name() const {
    const std::string before = text.substr(0, begins.empty() ? text.size() : begins.front());
    return before.substr(0, before.find_last_not_of(" \t") + 1);
  }
};

std::string Place(const fs::path& path, const Row& row) {
  return path.string() + ":" + std::to_string(row.line);
}

/// Lines that hold something.
std::vector<Row> ReadRows(const fs::path& path) {
  renderer::CheckRegularFile(path);
  std::error_code error;
  if (fs::file_size(path, error) > kMaxFileBytes) {
    throw IoError(path.string() + ": is too large for a list of lamps");
  }
  std::string text = renderer::ReadWholeFile(path);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  std::ranges::replace_if(
      text, [](char c) { return c == ',' || c == ';'; }, ' ');
  std::vector<Row> rows;
  renderer::LineReader lines(text);
  for (std::string_view line; lines.Next(line);) {
    line = line.substr(0, line.find('#'));
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    line.remove_prefix(first);
    Row& row = rows.emplace_back();
    row.line = lines.LineNumber();
    row.text = line.substr(0, line.find_last_not_of(" \t") + 1);
    std::string_view rest = line;
    for (std::string_view token; !(token = renderer::NextToken(rest)).empty();) {
      if (const auto number = renderer::ParseReal(token)) {
        row.begins.push_back(static_cast<std::size_t>(token.data() - line.data()));
        row.numbers.push_back(*number);
      } else {
        row.begins.clear();
        row.numbers.clear();
      }
    }
    if (rows.size() > kMaxLamps) throw IoError(path.string() + ": has too many lamps");
  }
  if (rows.empty()) throw IoError(path.string() + ": holds no lamp");
  return rows;
}

bool HasName(const Row& row) { return row.begins.empty() || row.begins.front() > 0; }

bool AreUnit(const std::vector<Vec3>& vectors) {
  return std::ranges::all_of(
      vectors, [](const Vec3& v) { return std::abs(renderer::Norm(v) - 1.0) < kUnit; });
}

/// Columns of three rows without names as rows, if that is how the file is written.
std::vector<Row> AsRows(std::vector<Row> rows) {
  if (rows.size() != 3) return rows;
  const std::size_t count = rows[0].numbers.size();
  for (const Row& row : rows) {
    if (HasName(row) || row.numbers.size() != count) return rows;
  }
  std::vector<Vec3> columns, lines;
  std::vector<Row> turned;
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<double> column = {rows[0].numbers[i], rows[1].numbers[i], rows[2].numbers[i]};
    columns.push_back({column[0], column[1], column[2]});
    turned.push_back({"", {}, column, rows[0].line});
  }
  for (const Row& row : rows) {
    if (count >= 3) lines.push_back({row.numbers[0], row.numbers[1], row.numbers[2]});
  }
  const bool is_turned = count > 6 || (count > 2 && AreUnit(columns) && !AreUnit(lines));
  return is_turned ? turned : rows;
}

/// Takes off a first column that counts the rows, perhaps with gaps.
void TakeNumbers(std::vector<Row>& rows) {
  double last = -1.0;
  for (const Row& row : rows) {
    const bool counts = !HasName(row) && row.numbers.size() > 3 && row.numbers.front() > last &&
                        row.numbers.front() == std::floor(row.numbers.front());
    if (!counts || rows.size() < 2) return;
    last = row.numbers.front();
  }
  for (Row& row : rows) row.numbers.erase(row.numbers.begin());
}

bool IsStrength(const Rgb& rgb) {
  const double most = std::max({rgb.r, rgb.g, rgb.b});
  return std::min({rgb.r, rgb.g, rgb.b}) >= 0.0 && most > 0.0 && most <= kMostStrength;
}

/// One number or three, from `first` on.
Rgb Strength(const fs::path& path, const Row& row, std::size_t first, bool colored) {
  const double* n = row.numbers.data() + first;
  const Rgb strength = colored ? Rgb{n[0], n[1], n[2]} : Rgb{n[0], n[0], n[0]};
  if (!IsStrength(strength)) {
    throw IoError(Place(path, row) + ": the strength of a lamp must be above 0, at most 1e12");
  }
  return strength;
}

}  // namespace

LampList ReadLampList(const fs::path& path) {
  std::vector<Row> rows = ReadRows(path);
  const bool has_count = rows.size() > 1 && !HasName(rows[0]) && rows[0].numbers.size() == 1;
  if (has_count) {
    const double count = rows[0].numbers[0];
    const std::string rows_said = rows[0].text;
    rows.erase(rows.begin());
    if (count != static_cast<double>(rows.size())) {
      throw IoError(path.string() + ": says that it has " + rows_said + " lamps, has " +
                    std::to_string(rows.size()));
    }
    // The last three are the direction, whatever numbers a name ends with.
    for (Row& row : rows) {
      if (row.numbers.size() <= 3) continue;
      const auto more = static_cast<std::ptrdiff_t>(row.numbers.size()) - 3;
      row.numbers.erase(row.numbers.begin(), row.numbers.begin() + more);
      row.begins.erase(row.begins.begin(), row.begins.begin() + more);
    }
  } else {
    rows = AsRows(std::move(rows));
    TakeNumbers(rows);
  }
  LampList list;
  const std::size_t columns = rows.front().numbers.size();
  bool all_away = true;
  for (const Row& row : rows) {
    if (row.numbers.size() != columns || columns < 3 || columns > 6) {
      throw IoError(Place(path, row) + ": has " + std::to_string(row.numbers.size()) +
                    " numbers; a lamp is \"x y z\", \"x y z strength\" or \"x y z red green "
                    "blue\", the same for all, perhaps after its photo's name");
    }
    PhotoLamp& lamp = list.lamps.emplace_back();
    if (HasName(row)) lamp.photo = row.Name();
    const Vec3 towards{row.numbers[0], row.numbers[1], row.numbers[2]};
    const double length = renderer::Norm(towards);
    if (!(length > 0.0) || !std::isfinite(length)) {
      throw IoError(Place(path, row) + ": the direction of a lamp must not be 0 0 0");
    }
    lamp.towards = towards / length;
    all_away = all_away && lamp.towards.z < 0.0;
    if (columns > 3) lamp.strength = Strength(path, row, 3, columns == 6);
  }
  if (columns == 5) list.num_unused = 1;
  list.reversed = all_away;
  if (all_away) {
    for (PhotoLamp& lamp : list.lamps) lamp.towards = -lamp.towards;
  }
  return list;
}

void ReadLampStrengths(const fs::path& path, LampList& list) {
  const std::vector<Row> rows = ReadRows(path);
  if (rows.size() != list.lamps.size()) {
    throw IoError(path.string() + ": has " + std::to_string(rows.size()) + " strengths for " +
                  std::to_string(list.lamps.size()) + " lamps");
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t columns = rows[i].numbers.size();
    if (columns != 1 && columns != 3) {
      throw IoError(Place(path, rows[i]) + ": a strength is one number or \"red green blue\"");
    }
    list.lamps[i].strength = Strength(path, rows[i], 0, columns == 3);
  }
}

}  // namespace pathfit::optim
