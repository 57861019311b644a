#include "renderer/io/ply_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include "renderer/image/color.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/split_vertices.h"

namespace pathfit::renderer {
namespace {

std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }

void AppendUint32(std::uint32_t value, std::string& bytes) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes.push_back(static_cast<char>((value >> shift) & 0xffU));
  }
}

void AppendFloat(double value, const std::filesystem::path& path, std::string& bytes) {
  AppendUint32(std::bit_cast<std::uint32_t>(StoredFloat(value, path)), bytes);
}

char EncodedByte(double linear) {
  const double encoded = SrgbFromLinear(std::clamp(linear, 0.0, 1.0));
  return static_cast<char>(static_cast<unsigned char>(std::lround(encoded * 255.0)));
}

}  // namespace

void WritePly(const std::filesystem::path& path,
              const Mesh& mesh,
              const std::string& texture_file) {
  const SplitMesh split = SplitVertices(mesh, {.normals = true, .uvs = true, .colors = true});
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
