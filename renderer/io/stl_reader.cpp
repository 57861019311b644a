#include "renderer/io/stl_reader.h"

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "renderer/core/error.h"
#include "renderer/geometry/ray.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/mesh_assembly.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::renderer {
namespace {

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFirstTriangle = kHeaderBytes + sizeof(std::uint32_t);
constexpr std::size_t kTriangleBytes = 50;  // normal and corners as float, attributes
constexpr std::size_t kNormalBytes = 12;

void AddTriangle(const Vec3 (&corners)[3], Mesh& mesh) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (const Vec3& corner : corners) mesh.positions.push_back(corner);
  mesh.triangles.push_back({first, first + 1, first + 2});
}

Mesh ParseBinary(const std::filesystem::path& path, std::string_view bytes, std::uint32_t count) {
  Mesh mesh;
  for (std::uint32_t t = 0; t < count; ++t) {
    float numbers[9];
    std::memcpy(numbers,
                bytes.data() + kFirstTriangle + kTriangleBytes * t + kNormalBytes,
                sizeof(numbers));
    Vec3 corners[3];
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = {numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]};
      if (!IsWithinBounds(corners[k])) {
        throw IoError(path.string() + ": triangle " + std::to_string(t + 1) +
                      ": a coordinate is not finite or beyond 1e12");
      }
    }
    AddTriangle(corners, mesh);
  }
  return mesh;
}

/// Statements in their order, one on each line: what may stand where is what the state says.
class TextParser {
 public:
  TextParser(const std::filesystem::path& path, std::string_view text)
      : path_(path), reader_(text) {}

  Mesh Parse() {
    while (NextStatement()) {
      Expect("solid");
      while (NextStatement() && keyword_ == "facet") ParseFacet();
      Expect("endsolid");
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw IoError(path_.string() + ":" + std::to_string(reader_.LineNumber()) + ": " + what);
  }

  /// Of the next line that is not blank; false, with an empty keyword, at the end.
  bool NextStatement() {
    keyword_ = {};
    while (keyword_.empty() && reader_.Next(rest_)) keyword_ = NextToken(rest_);
    return !keyword_.empty();
  }
  void Expect(std::string_view keyword) const {
    if (keyword_ == keyword) return;
    const std::string found =
        keyword_.empty() ? "the file ends" : "'" + std::string(keyword_.substr(0, 32)) + "' stands";
    Fail(found + " where '" + std::string(keyword) + "' is expected");
  }
  void Take(std::string_view keyword, std::string_view second = {}) {
    NextStatement();
    Expect(keyword);
    if (!second.empty() && NextToken(rest_) != second) {
      Fail("'" + std::string(keyword) + "' needs '" + std::string(second) + "' behind it");
    }
  }

  void ParseFacet() {
    Take("outer", "loop");
    Vec3 corners[3];
    for (Vec3& corner : corners) {
      Take("vertex");
      corner = ParsePoint();
    }
    Take("endloop");
    Take("endfacet");
    AddTriangle(corners, mesh_);
  }

  Vec3 ParsePoint() {
    double numbers[3];
    for (double& number : numbers) {
      const std::string_view token = NextToken(rest_);
      const std::optional<double> value = ParseReal(token);
      if (!value) {
        Fail(token.empty() ? "a vertex has three numbers"
                           : "'" + std::string(token.substr(0, 32)) + "' is not a finite number");
      }
      number = *value;
    }
    if (!NextToken(rest_).empty()) Fail("a vertex has three numbers");
    const Vec3 point{numbers[0], numbers[1], numbers[2]};
    if (!IsWithinBounds(point)) Fail("a coordinate is beyond 1e12");
    return point;
  }

  const std::filesystem::path& path_;
  LineReader reader_;
  std::string_view keyword_, rest_;  ///< of the current statement
  Mesh mesh_;
};

}  // namespace

Mesh ReadStl(const std::filesystem::path& path) {
  const std::string bytes = ReadWholeFile(path);
  Mesh mesh;
  std::uint32_t count = 0;
  const bool has_count = bytes.size() >= kFirstTriangle;
  if (has_count) std::memcpy(&count, bytes.data() + kHeaderBytes, sizeof(count));
  const std::size_t wanted = kFirstTriangle + kTriangleBytes * std::size_t{count};
  std::string_view begin = bytes;
  if (has_count && bytes.size() == wanted) {
    mesh = ParseBinary(path, bytes, count);
  } else if (NextToken(begin) == "solid" && bytes.find('\0') == std::string::npos) {
    mesh = TextParser(path, bytes).Parse();
  } else {
    throw IoError(path.string() + ": no text that begins with 'solid', and " +
                  (has_count ? std::to_string(count) + " triangles take " + std::to_string(wanted) +
                                   " bytes; the file has " + std::to_string(bytes.size())
                             : "too short for a binary STL"));
  }
  if (mesh.triangles.empty()) throw IoError(path.string() + ": no triangles");
  FinishMesh(mesh);
  return mesh;
}

}  // namespace pathfit::renderer
