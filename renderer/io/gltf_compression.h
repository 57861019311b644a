#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace pathfit::renderer {

inline constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";
inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// JSON of a glTF file as the parser takes it: buffers that stand for what is still compressed get
/// a byte of their own, indices that Draco holds any bufferView. The same text where nothing is
/// compressed, or where it is no JSON.
std::string ParsableGltf(std::string_view json);

/// What EXT_meshopt_compression says of a bufferView.
struct MeshoptView {
  std::string_view bytes;
  std::size_t count = 0, stride = 0;
  std::string mode, filter;
};

/// count * stride bytes, nothing allocated before the numbers are found to fit the compressed
/// bytes. Fails: IoError that says what is wrong, not where.
/// Source: EXT_meshopt_compression.
std::vector<unsigned char> DecodeMeshopt(const MeshoptView& view);

/// A mesh of KHR_draco_mesh_compression.
class DracoMesh {
 public:
  /// Of as many triangles as the file says elsewhere: Draco makes room for what its own header
  /// says. Fails as DecodeMeshopt does.
  DracoMesh(std::string_view bytes, std::size_t num_triangles);

  [[nodiscard]] std::size_t NumPoints() const;
  /// Corners by point number, 32 bit each.
  [[nodiscard]] std::vector<unsigned char> Corners() const;
  /// Values of the attribute of this unique id side by side, as glTF's componentType; empty if
  /// there is no such attribute, or if its values are not of so many components or not to be had
  /// so.
  [[nodiscard]] std::vector<unsigned char> Attribute(std::uint32_t id,
                                                     int component_type,
                                                     std::size_t components) const;

 private:
  struct Decoded;
  std::shared_ptr<const Decoded> decoded_;
};

}  // namespace pathfit::renderer
