#include "renderer/io/obj_reader.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/ray.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/mesh_assembly.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::renderer {
namespace {

constexpr std::int32_t kAbsent = -1;

/// A list as text: an array of these would take a line each.
constexpr std::string_view kIgnoredStatements =
    " o g s usemtl mtllib usemap maplib l p mg bevel c_interp d_interp shadow_obj trace_obj lod "
    "call ";

/// Position, uv and normal of a face corner, from 0 or kAbsent.
using Corner = std::array<std::int32_t, 3>;

/// Text without the blanks around it.
std::string Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(kBlanks) - first + 1));
}

/// Copies the values that the triangles use, in their old order, and renumbers the triangles.
template <class T>
std::vector<T> TakeUsed(const SharedVector<T>& values, SharedVector<Triangle>& triangles) {
  std::vector<std::int32_t> used;
  used.reserve(triangles.size() * 3);
  for (const Triangle& t : triangles.Items()) used.insert(used.end(), t.begin(), t.end());
  std::ranges::sort(used);
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (Triangle& t : triangles) {
    for (std::int32_t& i : t) {
      i = static_cast<std::int32_t>(std::ranges::lower_bound(used, i) - used.begin());
    }
  }
  std::vector<T> taken;
  taken.reserve(used.size());
  for (const std::int32_t i : used) taken.push_back(values[static_cast<std::size_t>(i)]);
  return taken;
}

class ObjParser {
 public:
  ObjParser(const std::filesystem::path& path, std::string_view text, bool by_material)
      : path_(path), reader_(text), by_material_(by_material) {}

  std::vector<MeshGroup> Parse() {
    std::string_view line;
    while (reader_.Next(line)) {
      line_ = reader_.LineNumber();
      // A backslash at the end continues the statement on the next line; a comment may end so, too.
      if (line.ends_with('\\') && line.find('#') == std::string_view::npos) {
        std::string joined;
        while (line.ends_with('\\')) {
          joined.append(line.substr(0, line.size() - 1)).append(" ");
          if (!reader_.Next(line)) line = {};
        }
        joined.append(line);
        ParseStatement(joined);
      } else {
        ParseStatement(line);
      }
    }
    return Finish();
  }

 private:
  [[noreturn]] void Fail(const std::string& what, std::int64_t line) const {
    throw IoError(path_.string() + ":" + std::to_string(line) + ": " + what);
  }

  void ParseStatement(std::string_view statement) {
    statement = statement.substr(0, statement.find('#'));
    const std::string_view keyword = NextToken(statement);
    if (keyword.empty()) return;
    if (by_material_ && keyword == "usemtl") {
      BeginGroup(statement);
    } else if (keyword == "v") {
      ParseVertex(statement);
    } else if (keyword == "vt") {
      const std::vector<double> numbers = ParseNumbers(statement, keyword, 1, 3);
      mesh_.uvs.push_back({numbers[0], numbers.size() > 1 ? numbers[1] : 0.0});
    } else if (keyword == "vn") {
      const std::vector<double> numbers = ParseNumbers(statement, keyword, 3, 3);
      mesh_.normals.push_back({numbers[0], numbers[1], numbers[2]});
    } else if (keyword == "f") {
      ParseFace(statement);
    } else if (kIgnoredStatements.find(" " + std::string(keyword) + " ") ==
               std::string_view::npos) {
      Fail("unknown statement '" + std::string(keyword.substr(0, 32)) +
               "'; read are v vt vn f, ignored are o g s usemtl mtllib l p",
           line_);
    }
  }

  void BeginGroup(std::string_view statement) {
    const auto [entry, is_new] = group_of_name_.try_emplace(Trimmed(statement), groups_.size());
    if (is_new) groups_.push_back({entry->first, {}});
    group_ = entry->second;
  }

  std::vector<double> ParseNumbers(std::string_view text,
                                   std::string_view keyword,
                                   std::size_t min_count,
                                   std::size_t max_count) const {
    std::vector<double> numbers;
    for (std::string_view token = NextToken(text); !token.empty(); token = NextToken(text)) {
      const std::optional<double> number = ParseReal(token);
      if (!number) Fail("'" + std::string(token.substr(0, 32)) + "' is not a finite number", line_);
      numbers.push_back(*number);
      if (numbers.size() > max_count) break;
    }
    if (numbers.size() < min_count || numbers.size() > max_count) {
      Fail("'" + std::string(keyword) + "' takes " + std::to_string(min_count) + " to " +
               std::to_string(max_count) + " numbers",
           line_);
    }
    return numbers;
  }

  void ParseVertex(std::string_view text) {
    const std::vector<double> numbers = ParseNumbers(text, "v", 3, 7);
    if (numbers.size() == 5) Fail("'v' takes 3, 4, 6 or 7 numbers", line_);
    if (mesh_.positions.size() >= kMaxCount) Fail("too many vertices", line_);
    const bool has_color = numbers.size() >= 6;
    if (!mesh_.positions.empty() && has_color == mesh_.colors.empty()) {
      Fail("either all vertices have a colour or none", line_);
    }
    mesh_.positions.push_back({numbers[0], numbers[1], numbers[2]});
    if (!IsWithinBounds(mesh_.positions.back())) Fail("a coordinate is beyond 1e12", line_);
    if (has_color) mesh_.colors.push_back({numbers[3], numbers[4], numbers[5]});
  }

  void ParseFace(std::string_view text) {
    const std::size_t begin = corners_.size();
    for (std::string_view token = NextToken(text); !token.empty(); token = NextToken(text)) {
      const Corner corner = ParseCorner(token);
      if (corners_.size() > begin && ((corner[1] == kAbsent) != (corners_[begin][1] == kAbsent) ||
                                      (corner[2] == kAbsent) != (corners_[begin][2] == kAbsent))) {
        Fail("the corners of a face must all have the same form, such as 1/2/3", line_);
      }
      corners_.push_back(corner);
    }
    if (corners_.size() < begin + 3) Fail("a face needs at least 3 corners", line_);
    if (corners_.size() > kMaxCount) Fail("too many face corners", line_);
    groups_[group_].faces.push_back(faces_.size());
    faces_.push_back({begin, line_});
  }

  /// v, v/vt, v//vn or v/vt/vn.
  [[nodiscard]] Corner ParseCorner(std::string_view token) const {
    const std::array<std::size_t, 3> counts = {
        mesh_.positions.size(), mesh_.uvs.size(), mesh_.normals.size()};
    Corner corner = {kAbsent, kAbsent, kAbsent};
    std::string_view rest = token;
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const std::size_t slash = rest.find('/');
      const std::string_view field = rest.substr(0, slash);
      if (!field.empty()) {
        corner[kind] = ParseIndex(field, counts[kind]);
      } else if (kind != 1 || slash == std::string_view::npos) {
        break;  // Only the middle field may be empty, as in v//vn.
      }
      if (slash == std::string_view::npos) return corner;
      rest.remove_prefix(slash + 1);
    }
    Fail("'" + std::string(token.substr(0, 32)) +
             "' is not a face corner; allowed are v, v/vt, v//vn and v/vt/vn",
         line_);
  }

  /// From 1, or from the end when negative. Later definitions may be meant, so Finish checks the
  /// upper bound.
  [[nodiscard]] std::int32_t ParseIndex(std::string_view field, std::size_t count) const {
    const std::optional<std::int64_t> index = ParseInteger(field);
    const auto num_defined = static_cast<std::int64_t>(count);
    if (!index || *index == 0 || *index < -num_defined ||
        *index > static_cast<std::int64_t>(kMaxCount)) {
      Fail("'" + std::string(field.substr(0, 32)) +
               "' is not an index; allowed are 1 and more, or -1 to -" + std::to_string(count),
           line_);
    }
    return static_cast<std::int32_t>(*index > 0 ? *index - 1 : num_defined + *index);
  }

  std::vector<MeshGroup> Finish() {
    if (faces_.empty()) throw IoError(path_.string() + ": has no face");
    // Groups in the order of their first faces.
    std::ranges::sort(groups_, [](const Part& a, const Part& b) {
      return !a.faces.empty() && (b.faces.empty() || a.faces.front() < b.faces.front());
    });
    std::vector<MeshGroup> result;
    for (Part& part : groups_) {
      if (!part.faces.empty()) result.push_back({std::move(part.name), BuildMesh(part.faces)});
    }
    return result;
  }

  [[nodiscard]] Mesh BuildMesh(const std::vector<std::size_t>& faces) const {
    const bool all_uvs = AllHave(faces, 1);
    const bool all_normals = AllHave(faces, 2);
    Mesh mesh;
    std::vector<Vec3> polygon;
    for (const std::size_t i : faces) {
      const auto [begin, line] = faces_[i];
      const std::size_t end = i + 1 < faces_.size() ? faces_[i + 1].first : corners_.size();
      polygon.clear();
      for (std::size_t c = begin; c < end; ++c) {
        CheckRange(corners_[c], line);
        polygon.push_back(mesh_.positions[static_cast<std::size_t>(corners_[c][0])]);
      }
      const std::optional<FanTriangles> fan = TriangulatePolygon(polygon);
      if (!fan) Fail("this polygon is not convex enough for a fan; triangulate it first", line);
      for (const auto& [a, b, c] : *fan) {
        const std::array<Corner, 3> t = {
            corners_[begin + a], corners_[begin + b], corners_[begin + c]};
        mesh.triangles.push_back({t[0][0], t[1][0], t[2][0]});
        if (all_uvs) mesh.uv_triangles.push_back({t[0][1], t[1][1], t[2][1]});
        if (all_normals) mesh.normal_triangles.push_back({t[0][2], t[1][2], t[2][2]});
      }
    }
    if (!mesh_.colors.empty()) {
      mesh.color_triangles = mesh.triangles;
      mesh.colors = TakeUsed(mesh_.colors, mesh.color_triangles);
    }
    mesh.positions = TakeUsed(mesh_.positions, mesh.triangles);
    mesh.uvs = TakeUsed(mesh_.uvs, mesh.uv_triangles);
    mesh.normals = TakeUsed(mesh_.normals, mesh.normal_triangles);
    FinishMesh(mesh);
    return mesh;
  }

  [[nodiscard]] bool AllHave(const std::vector<std::size_t>& faces, std::size_t kind) const {
    return std::ranges::all_of(
        faces, [&](std::size_t face) { return corners_[faces_[face].first][kind] != kAbsent; });
  }

  void CheckRange(const Corner& corner, std::int64_t line) const {
    const std::array<std::pair<std::size_t, const char*>, 3> counts = {
        {{mesh_.positions.size(), "vertex"},
         {mesh_.uvs.size(), "texture vertex"},
         {mesh_.normals.size(), "normal"}}};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      if (corner[kind] >= static_cast<std::int64_t>(counts[kind].first)) {
        Fail(std::string(counts[kind].second) + " index " + std::to_string(corner[kind] + 1) +
                 " is out of range, the file has " + std::to_string(counts[kind].first),
             line);
      }
    }
  }

  static constexpr std::size_t kMaxCount = std::numeric_limits<std::int32_t>::max();

  struct Part {
    std::string name;
    std::vector<std::size_t> faces;
  };

  const std::filesystem::path& path_;
  LineReader reader_;
  bool by_material_;
  std::int64_t line_ = 0;  ///< where the current statement begins
  Mesh mesh_;              ///< values only
  std::vector<Corner> corners_;
  std::vector<std::pair<std::size_t, std::int64_t>> faces_;  ///< first corner and line
  std::vector<Part> groups_ = {Part{}};                      ///< the first has no name
  std::unordered_map<std::string, std::size_t> group_of_name_ = {{"", 0}};
  std::size_t group_ = 0;  ///< of the next face
};

}  // namespace

Mesh ReadObj(const std::filesystem::path& path) {
  const std::string text = ReadWholeFile(path);
  return std::move(ObjParser(path, text, false).Parse().front().mesh);
}

std::vector<MeshGroup> ReadObjGroups(const std::filesystem::path& path) {
  const std::string text = ReadWholeFile(path);
  return ObjParser(path, text, true).Parse();
}

}  // namespace pathfit::renderer
