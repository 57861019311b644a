#pragma once

#include <filesystem>
#include <string>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// glTF 2.0 metallic-roughness material. Factors are linear and clamped to 0..1, as the format
/// demands.
struct GlbMaterial {
  std::string name = "material";
  Rgb base_color = {1.0, 1.0, 1.0};  ///< multiplies the vertex colours
  double roughness = 1.0;
  double metallic = 0.0;
  bool double_sided = false;
};

/// One mesh with one material as binary glTF (y up, metres): float POSITION, area-weighted smooth
/// NORMAL, linear float COLOR_0 (clamped to 0..1) when the mesh has colours, uint32 indices. A
/// position with several colours is repeated. Written through a temporary file. Fails: IoError (not
/// writable, a number beyond float), SceneError (wrong indices, no triangle).
void WriteGlb(const std::filesystem::path& path, const Mesh& mesh, const GlbMaterial& material);

}  // namespace pathfit::renderer
