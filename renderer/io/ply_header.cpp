#include "renderer/io/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "renderer/core/error.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::renderer {
namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames = {{
    {"char", PlyType::kInt8},
    {"int8", PlyType::kInt8},
    {"uchar", PlyType::kUint8},
    {"uint8", PlyType::kUint8},
    {"short", PlyType::kInt16},
    {"int16", PlyType::kInt16},
    {"ushort", PlyType::kUint16},
    {"uint16", PlyType::kUint16},
    {"int", PlyType::kInt32},
    {"int32", PlyType::kInt32},
    {"uint", PlyType::kUint32},
    {"uint32", PlyType::kUint32},
    {"float", PlyType::kFloat32},
    {"float32", PlyType::kFloat32},
    {"double", PlyType::kFloat64},
    {"float64", PlyType::kFloat64},
}};

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
    const bool is_repeated =
        std::any_of(header_.elements.begin(), header_.elements.end(), [&](const PlyElement& e) {
          return e.name == element.name;
        });
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
      property.is_list = true;
      property.count_type = ParseType(NextToken(line));
      if (IsFloatType(property.count_type)) Fail("the length of a list must be of an integer type");
      type = NextToken(line);
    }
    property.type = ParseType(type);
    property.name = NextToken(line);
    if (property.name.empty()) Fail("a property needs a name");
    std::vector<PlyProperty>& known = header_.elements.back().properties;
    const bool is_repeated = std::any_of(
        known.begin(), known.end(), [&](const PlyProperty& p) { return p.name == property.name; });
    if (is_repeated) Fail("property '" + Quoted(property.name) + "' is declared twice");
    if (known.size() >= kMaxDeclarations) Fail("too many properties");
    known.push_back(std::move(property));
  }

  PlyType ParseType(std::string_view name) const {
    for (const auto& [known, type] : kTypeNames) {
      if (name == known) return type;
    }
    Fail("type '" + Quoted(name) +
         "' is unknown, allowed are char uchar short ushort int uint float double");
  }

  const std::filesystem::path& path_;
  std::string_view bytes_;
  LineReader reader_;
  PlyHeader header_;
};

}  // namespace

std::size_t SizeOf(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      return 8;
  }
  return 0;
}

PlyHeader ParsePlyHeader(const std::filesystem::path& path, std::string_view bytes) {
  return HeaderParser(path, bytes).Parse();
}

}  // namespace pathfit::renderer
