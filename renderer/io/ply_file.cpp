#include "renderer/io/ply_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/ray.h"
#include "renderer/image/color.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/mesh_assembly.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::renderer {
namespace {

enum class PlyFormat { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

template <class T>
double ReadBinary(const char* bytes, bool is_swapped) {
  std::array<char, sizeof(T)> ordered;
  std::memcpy(ordered.data(), bytes, sizeof(T));
  if (is_swapped) std::reverse(ordered.begin(), ordered.end());
  return static_cast<double>(std::bit_cast<T>(ordered));
}

/// How a number is stored.
struct PlyType {
  std::string_view name, other_name;
  std::size_t size;
  bool is_float;
  double (*read)(const char* bytes, bool is_swapped);
};

template <class T>
constexpr PlyType TypeOf(std::string_view name, std::string_view other_name) {
  return {name, other_name, sizeof(T), std::is_floating_point_v<T>, ReadBinary<T>};
}

constexpr std::array<PlyType, 8> kTypes = {TypeOf<std::int8_t>("char", "int8"),
                                           TypeOf<std::uint8_t>("uchar", "uint8"),
                                           TypeOf<std::int16_t>("short", "int16"),
                                           TypeOf<std::uint16_t>("ushort", "uint16"),
                                           TypeOf<std::int32_t>("int", "int32"),
                                           TypeOf<std::uint32_t>("uint", "uint32"),
                                           TypeOf<float>("float", "float32"),
                                           TypeOf<double>("double", "float64")};

struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;        ///< of the value, or of a list's entries
  const PlyType* count_type = nullptr;  ///< of a list's length; null for one value

  [[nodiscard]] bool IsList() const { return count_type != nullptr; }
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::size_t num_bytes = 0;  ///< the body follows
  std::int64_t num_lines = 0;
};

/// Elements of a file and properties of an element; bounds the time of hostile headers.
constexpr std::size_t kMaxDeclarations = 1000;

class HeaderParser {
 public:
  HeaderParser(const std::filesystem::path& path, std::string_view bytes)
      : path_(path), bytes_(bytes), reader_(bytes) {}

  PlyHeader Parse() {
    std::string_view line;
    if (!reader_.Next(line) || line != "ply") Fail("a PLY file begins with the line 'ply'");
    bool has_format = false;
    while (reader_.Next(line)) {
      const std::string_view keyword = NextToken(line);
      if (keyword == "end_header") {
        if (!has_format) Fail("the header has no 'format'");
        header_.num_bytes = bytes_.size() - reader_.Rest().size();
        header_.num_lines = reader_.LineNumber();
        return std::move(header_);
      }
      if (keyword == "format") {
        ParseFormat(line);
        has_format = true;
      } else if (keyword == "element") {
        ParseElement(line);
      } else if (keyword == "property") {
        ParseProperty(line);
      } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
        Fail("unknown header statement '" + Quoted(keyword) +
             "', allowed are format comment obj_info element property end_header");
      }
    }
    Fail("the header ends without 'end_header'");
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw IoError(path_.string() + ":" +
                  std::to_string(std::max<std::int64_t>(1, reader_.LineNumber())) + ": " + what);
  }

  static std::string Quoted(std::string_view token) { return std::string(token.substr(0, 32)); }

  void ParseFormat(std::string_view line) {
    const std::string_view name = NextToken(line);
    if (name == "ascii") {
      header_.format = PlyFormat::kAscii;
    } else if (name == "binary_little_endian") {
      header_.format = PlyFormat::kBinaryLittleEndian;
    } else if (name == "binary_big_endian") {
      header_.format = PlyFormat::kBinaryBigEndian;
    } else {
      Fail("format '" + Quoted(name) +
           "' is unknown, allowed are ascii binary_little_endian binary_big_endian");
    }
    if (NextToken(line) != "1.0") Fail("only version 1.0 is known");
  }

  void ParseElement(std::string_view line) {
    PlyElement element;
    element.name = NextToken(line);
    const std::optional<std::int64_t> count = ParseInteger(NextToken(line));
    if (element.name.empty() || !count || *count < 0) {
      Fail("an element needs a name and a count of 0 or more");
    }
    const bool is_repeated = std::ranges::any_of(
        header_.elements, [&](const PlyElement& e) { return e.name == element.name; });
    if (is_repeated) Fail("element '" + Quoted(element.name) + "' is declared twice");
    element.count = static_cast<std::uint64_t>(*count);
    if (header_.elements.size() >= kMaxDeclarations) Fail("too many elements");
    header_.elements.push_back(std::move(element));
  }

  void ParseProperty(std::string_view line) {
    if (header_.elements.empty()) Fail("a property needs an element before it");
    PlyProperty property;
    std::string_view type = NextToken(line);
    if (type == "list") {
      property.count_type = ParseType(NextToken(line));
      if (property.count_type->is_float) Fail("the length of a list must be of an integer type");
      type = NextToken(line);
    }
    property.type = ParseType(type);
    property.name = NextToken(line);
    if (property.name.empty()) Fail("a property needs a name");
    std::vector<PlyProperty>& known = header_.elements.back().properties;
    const bool is_repeated =
        std::ranges::any_of(known, [&](const PlyProperty& p) { return p.name == property.name; });
    if (is_repeated) Fail("property '" + Quoted(property.name) + "' is declared twice");
    if (known.size() >= kMaxDeclarations) Fail("too many properties");
    known.push_back(std::move(property));
  }

  const PlyType* ParseType(std::string_view name) const {
    for (const PlyType& type : kTypes) {
      if (name == type.name || name == type.other_name) return &type;
    }
    Fail("type '" + Quoted(name) +
         "' is unknown, allowed are char uchar short ushort int uint float double");
  }

  const std::filesystem::path& path_;
  std::string_view bytes_;
  LineReader reader_;
  PlyHeader header_;
};

/// The numbers of a body one after another, with the place of the current row for messages.
class PlyBody {
 public:
  PlyBody(const std::filesystem::path& path, const PlyHeader& header, std::string_view bytes)
      : path_(path),
        format_(header.format),
        header_lines_(header.num_lines),
        rest_(bytes.substr(header.num_bytes)),
        lines_(rest_) {}

  [[noreturn]] void Fail(const std::string& what) const {
    std::string place = path_.string();
    if (format_ == PlyFormat::kAscii && lines_.LineNumber() > 0) {
      place += ":" + std::to_string(header_lines_ + lines_.LineNumber());
    }
    throw IoError(place + ": " + element_ + " " + std::to_string(row_) + ": " + what);
  }

  /// Refuses a count that the rest of the file cannot hold, so that rows may be reserved.
  void BeginElement(const PlyElement& element) {
    element_ = element.name;
    row_ = 0;
    std::uint64_t row_bytes = 0;
    for (const PlyProperty& property : element.properties) {
      const PlyType& first = property.IsList() ? *property.count_type : *property.type;
      row_bytes += format_ == PlyFormat::kAscii ? 2 : first.size;
    }
    // The last number of an ascii file needs no blank after it.
    const std::uint64_t available =
        format_ == PlyFormat::kAscii ? lines_.Rest().size() + 1 : rest_.size();
    if (row_bytes > 0 && element.count > available / row_bytes) {
      throw IoError(path_.string() + ": the header declares " + std::to_string(element.count) +
                    " of element '" + element.name + "', more than the file holds");
    }
  }

  void BeginRow(std::uint64_t row) { row_ = row; }

  void EndRow() {
    if (format_ == PlyFormat::kAscii && !NextToken(line_).empty()) Fail("too many numbers");
  }

  double NextNumber(const PlyType& type) {
    if (format_ == PlyFormat::kAscii) return NextAscii(type);
    if (rest_.size() < type.size) Fail("the file ends too early");
    const bool is_big = format_ == PlyFormat::kBinaryBigEndian;
    const double number =
        type.read(rest_.data(), is_big != (std::endian::native == std::endian::big));
    rest_.remove_prefix(type.size);
    if (!std::isfinite(number)) Fail("a number is not finite");
    return number;
  }

  std::uint64_t NextListLength(const PlyProperty& property) {
    const double length = NextNumber(*property.count_type);
    if (length < 0.0) Fail("list '" + property.name + "' has a negative length");
    return static_cast<std::uint64_t>(length);
  }

  void Skip(const PlyProperty& property) {
    const std::uint64_t count = property.IsList() ? NextListLength(property) : 1;
    if (format_ == PlyFormat::kAscii) {
      for (std::uint64_t i = 0; i < count; ++i) NextAsciiToken();
      return;
    }
    const std::uint64_t num_bytes = count * property.type->size;
    if (num_bytes > rest_.size()) Fail("the file ends too early");
    rest_.remove_prefix(num_bytes);
  }

 private:
  std::string_view NextAsciiToken() {
    std::string_view token = NextToken(line_);
    while (token.empty()) {
      if (!lines_.Next(line_)) Fail("the file ends too early");
      token = NextToken(line_);
    }
    return token;
  }

  double NextAscii(const PlyType& type) {
    const std::string_view token = NextAsciiToken();
    const std::optional<double> number = ParseReal(token);
    if (!number || (!type.is_float && *number != std::floor(*number))) {
      Fail("'" + std::string(token.substr(0, 32)) + "' is not " +
           (type.is_float ? "a finite number" : "an integer"));
    }
    return *number;
  }

  const std::filesystem::path& path_;
  PlyFormat format_;
  std::int64_t header_lines_;
  std::string_view rest_;  ///< of a binary body
  LineReader lines_;       ///< of an ascii body
  std::string_view line_;  ///< rest of the current line
  std::string element_ = "vertex";
  std::uint64_t row_ = 0;
};

/// Numbers of a vertex that are kept; two names may mean one slot.
enum Slot { kX, kY, kZ, kNx, kNy, kNz, kRed, kGreen, kBlue, kU, kV, kNumSlots };
constexpr Slot kSkipped = kNumSlots;

/// kSkipped for names that mean nothing here.
Slot SlotOf(const std::string& name) {
  constexpr std::array<std::string_view, kNumSlots> kNames = {
      "x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "s", "t"};
  const std::string_view known = name == "u" ? "s" : name == "v" ? "t" : std::string_view(name);
  return static_cast<Slot>(std::ranges::find(kNames, known) - kNames.begin());
}

class PlyParser {
 public:
  PlyParser(const std::filesystem::path& path, std::string_view bytes)
      : path_(path), header_(HeaderParser(path, bytes).Parse()), body_(path, header_, bytes) {}

  Mesh Parse() {
    for (const PlyElement& element : header_.elements) {
      body_.BeginElement(element);
      if (element.name == "vertex") {
        ReadVertices(element);
      } else if (element.name == "face") {
        ReadFaces(element);
      } else if (!element.properties.empty()) {
        for (std::uint64_t i = 0; i < element.count; ++i) {
          body_.BeginRow(i);
          for (const PlyProperty& property : element.properties) body_.Skip(property);
          body_.EndRow();
        }
      }
    }
    if (face_begins_.empty()) Fail("has no face");
    Triangulate();
    FinishMesh(mesh_);
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw IoError(path_.string() + ": " + what);
  }

  /// Slot of each property; refuses wrong types and missing coordinates.
  std::vector<Slot> MatchSlots(const PlyElement& element) {
    std::vector<Slot> slots;
    std::array<bool, kNumSlots> found = {};
    for (const PlyProperty& property : element.properties) {
      Slot slot = property.IsList() ? kSkipped : SlotOf(property.name);
      const bool is_color = slot >= kRed && slot <= kBlue;
      if (slot != kSkipped && !property.type->is_float &&
          !(is_color && property.type->name == "uchar")) {
        Fail("vertex property '" + property.name + "' has a wrong type, allowed are float, double" +
             (is_color ? " and uchar" : ""));
      }
      if (slot != kSkipped && found[slot]) slot = kSkipped;
      if (slot != kSkipped) found[slot] = true;
      if (is_color && property.type->name == "uchar") is_encoded_[slot - kRed] = true;
      slots.push_back(slot);
    }
    const auto all = [&found](std::size_t first, std::size_t last) {
      return std::all_of(found.begin() + static_cast<std::ptrdiff_t>(first),
                         found.begin() + static_cast<std::ptrdiff_t>(last) + 1,
                         [](bool is_found) { return is_found; });
    };
    if (!all(kX, kZ)) Fail("element 'vertex' needs the properties x, y and z");
    has_normals_ = all(kNx, kNz);
    has_colors_ = all(kRed, kBlue);
    has_uvs_ = all(kU, kV);
    return slots;
  }

  void ReadVertices(const PlyElement& element) {
    const std::vector<Slot> slots = MatchSlots(element);
    if (element.count > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())) {
      Fail("has too many vertices");
    }
    mesh_.positions.reserve(element.count);
    std::array<double, kNumSlots> row = {};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      body_.BeginRow(i);
      for (std::size_t p = 0; p < slots.size(); ++p) {
        if (slots[p] == kSkipped) {
          body_.Skip(element.properties[p]);
        } else {
          row[slots[p]] = body_.NextNumber(*element.properties[p].type);
        }
      }
      body_.EndRow();
      AppendVertex(row);
    }
  }

  void AppendVertex(const std::array<double, kNumSlots>& row) {
    mesh_.positions.push_back({row[kX], row[kY], row[kZ]});
    if (!IsWithinBounds(mesh_.positions.back())) body_.Fail("a coordinate is beyond 1e12");
    if (has_normals_) mesh_.normals.push_back({row[kNx], row[kNy], row[kNz]});
    if (has_uvs_) mesh_.uvs.push_back({row[kU], row[kV]});
    if (!has_colors_) return;
    Rgb color;
    for (int c = 0; c < 3; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      const double value = row[kRed + channel];
      if (is_encoded_[channel] && !(value >= 0.0 && value <= 255.0)) {
        body_.Fail("a colour of type uchar must be 0 to 255");
      }
      color[c] = is_encoded_[channel] ? LinearFromSrgb(value / 255.0) : value;
    }
    mesh_.colors.push_back(color);
  }

  void ReadFaces(const PlyElement& element) {
    const auto is_indices = [](const PlyProperty& p) {
      return p.IsList() && (p.name == "vertex_indices" || p.name == "vertex_index");
    };
    const auto place = std::ranges::find_if(element.properties, is_indices);
    if (place == element.properties.end()) Fail("element 'face' needs a list 'vertex_indices'");
    if (place->type->is_float) Fail("list '" + place->name + "' must be of an integer type");
    const auto indices = static_cast<std::size_t>(place - element.properties.begin());
    face_begins_.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      body_.BeginRow(i);
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        if (p == indices) {
          ReadFace(element.properties[p]);
        } else {
          body_.Skip(element.properties[p]);
        }
      }
      body_.EndRow();
    }
  }

  void ReadFace(const PlyProperty& property) {
    const std::uint64_t num_corners = body_.NextListLength(property);
    if (num_corners < 3) body_.Fail("a face needs at least 3 corners");
    face_begins_.push_back(corners_.size());
    for (std::uint64_t k = 0; k < num_corners; ++k) {
      const double index = body_.NextNumber(*property.type);
      if (index < 0.0 || index >= static_cast<double>(NumVertices())) {
        body_.Fail("vertex index is out of range, allowed are 0 to below " +
                   std::to_string(NumVertices()));
      }
      corners_.push_back(static_cast<std::int32_t>(index));
    }
  }

  /// As declared, since faces may stand before the vertices; bounded by what an index can hold.
  [[nodiscard]] std::uint64_t NumVertices() const {
    for (const PlyElement& element : header_.elements) {
      if (element.name != "vertex") continue;
      return std::min<std::uint64_t>(element.count, std::numeric_limits<std::int32_t>::max());
    }
    return 0;
  }

  void Triangulate() {
    std::vector<Vec3> polygon;
    for (std::size_t i = 0; i < face_begins_.size(); ++i) {
      const std::size_t begin = face_begins_[i];
      const std::size_t end = i + 1 < face_begins_.size() ? face_begins_[i + 1] : corners_.size();
      polygon.clear();
      for (std::size_t c = begin; c < end; ++c) {
        polygon.push_back(mesh_.positions[static_cast<std::size_t>(corners_[c])]);
      }
      const std::optional<FanTriangles> fan = TriangulatePolygon(polygon);
      if (!fan) Fail("face " + std::to_string(i) + " is not convex enough; triangulate it first");
      for (const auto& [a, b, c] : *fan) {
        mesh_.triangles.push_back({corners_[begin + a], corners_[begin + b], corners_[begin + c]});
      }
    }
    if (has_normals_) mesh_.normal_triangles = mesh_.triangles;
    if (has_uvs_) mesh_.uv_triangles = mesh_.triangles;
    if (has_colors_) mesh_.color_triangles = mesh_.triangles;
  }

  const std::filesystem::path& path_;
  PlyHeader header_;
  PlyBody body_;
  Mesh mesh_;
  bool has_normals_ = false;
  bool has_colors_ = false;
  bool has_uvs_ = false;
  std::array<bool, 3> is_encoded_ = {};  ///< per colour channel: sRGB bytes
  std::vector<std::int32_t> corners_;
  std::vector<std::size_t> face_begins_;
};

void AppendUint32(std::uint32_t value, std::string& bytes) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes.push_back(static_cast<char>((value >> shift) & 0xffU));
  }
}

void AppendFloat(double value, const std::filesystem::path& path, std::string& bytes) {
  AppendUint32(std::bit_cast<std::uint32_t>(StoredFloat(value, path)), bytes);
}

char EncodedByte(double linear) {
  const double encoded = ClampedSrgb(linear);
  return static_cast<char>(static_cast<unsigned char>(std::lround(encoded * 255.0)));
}

}  // namespace

Mesh ReadPly(const std::filesystem::path& path) {
  const std::string bytes = ReadWholeFile(path);
  return PlyParser(path, bytes).Parse();
}

void WritePly(const std::filesystem::path& path,
              const Mesh& mesh,
              const std::string& texture_file) {
  const SplitMesh split = SplitVertices(mesh);
  const bool has_normals = !mesh.normal_triangles.empty();
  const bool has_uvs = !mesh.uv_triangles.empty();
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment linear colours are sRGB encoded\n";
  if (!texture_file.empty()) bytes += "comment TextureFile " + texture_file + "\n";
  bytes += "element vertex " + std::to_string(split.vertices.size()) + "\n";
  bytes += "property float x\nproperty float y\nproperty float z\n";
  if (has_normals) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
  if (has_uvs) bytes += "property float s\nproperty float t\n";
  if (mesh.HasColors()) bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  bytes += "element face " + std::to_string(split.triangles.size()) + "\n";
  bytes += "property list uchar int vertex_indices\nend_header\n";
  for (const SplitVertex& vertex : split.vertices) {
    const Vec3& position = mesh.positions[Index(vertex.position)];
    for (int c = 0; c < 3; ++c) AppendFloat(position[c], path, bytes);
    if (has_normals) {
      const Vec3& normal = mesh.normals[Index(vertex.normal)];
      for (int c = 0; c < 3; ++c) AppendFloat(normal[c], path, bytes);
    }
    if (has_uvs) {
      AppendFloat(mesh.uvs[Index(vertex.uv)].x, path, bytes);
      AppendFloat(mesh.uvs[Index(vertex.uv)].y, path, bytes);
    }
    if (mesh.HasColors()) {
      const Rgb& color = mesh.colors[Index(vertex.color)];
      for (int c = 0; c < 3; ++c) {
        // Checked like the others: a colour that is not a number must not become a byte.
        StoredFloat(color[c], path);
        bytes.push_back(EncodedByte(color[c]));
      }
    }
  }
  for (const Triangle& triangle : split.triangles) {
    bytes.push_back(3);
    for (const std::int32_t i : triangle) AppendUint32(static_cast<std::uint32_t>(i), bytes);
  }
  WriteFileAtomically(path, bytes);
}

}  // namespace pathfit::renderer
