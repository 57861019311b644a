#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pathfit::renderer {

enum class PlyFormat { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;  ///< of the value, or of a list's entries
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< of a list's length
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

inline bool IsFloatType(PlyType type) {
  return type == PlyType::kFloat32 || type == PlyType::kFloat64;
}
std::size_t SizeOf(PlyType type);

/// Parses the header at the front of a whole PLY file. Counts are as declared: check them against
/// the body's size. Fails: IoError with file:line.
PlyHeader ParsePlyHeader(const std::filesystem::path& path, std::string_view bytes);

}  // namespace pathfit::renderer
