#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "renderer/bsdf/bsdf.h"
#include "renderer/geometry/mesh.h"
#include "renderer/image/image.h"

namespace pathfit::app {

struct ObjMaterial {
  std::string name = "material";
  renderer::Rgb base_color{0.5, 0.5, 0.5};  ///< linear; without a texture and colours
  renderer::MetallicRoughnessBsdf bsdf = {.roughness = 1.0};
  // By the mesh's UVs.
  std::optional<renderer::Image> texture = std::nullopt;  ///< linear base colour
  std::optional<renderer::Image> roughness_texture = std::nullopt, metallic_texture = std::nullopt;
  std::optional<renderer::Image> normal_texture = std::nullopt;  ///< directions as (1 + n) / 2
  double normal_scale = 1.0;
};

/// stem.obj with the mesh's normals and UVs, stem.mtl, and stem.png (sRGB, clamped to 0..1) with
/// the texture, and stem_roughness.png, _metallic.png and _normal.png as they are (map_Pr, map_Pm,
/// norm). Colours of vertices, which OBJ has no agreed place for, become a texture with a
/// patch for every triangle, which bilinear sampling turns into the same colours; it replaces UVs,
/// and leaves no place for these. Positions read back to the same bits. Returns the files. Throws
/// IoError (not writable).
std::vector<std::filesystem::path> WriteObj(const std::filesystem::path& stem,
                                            const renderer::Mesh& mesh,
                                            const ObjMaterial& material);

}  // namespace pathfit::app
