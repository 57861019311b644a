#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "renderer/bsdf/bsdf.h"
#include "renderer/geometry/mesh.h"
#include "renderer/texture/texture.h"

namespace pathfit::renderer {

/// In the extras of a node: what its scale is.
inline constexpr const char* kMetresPerUnit = "metres_per_unit";

/// glTF 2.0 metallic-roughness material. Factors are linear and clamped to 0..1, as the format
/// demands.
struct GlbMaterial {
  std::string name = "material";
  Rgb base_color = {1.0, 1.0, 1.0};  ///< multiplies the vertex colours
  MetallicRoughnessBsdf bsdf = {.roughness = 1.0};
  bool double_sided = false;
  // Textures are embedded as 8-bit PNG, clamped to 0..1, and need UVs.
  std::optional<Texture> base_color_texture = std::nullopt;  ///< as sRGB; multiplies the factor
  std::optional<Texture> roughness_texture = std::nullopt;   ///< replaces that of `bsdf`
  std::optional<Texture> metallic_texture = std::nullopt;    ///< likewise, in the same picture
  /// Directions in the mesh's tangent frame (MakeTangents) as (1 + n) / 2; needs normals, too.
  std::optional<Texture> normal_texture = std::nullopt;
  double normal_scale = 1.0;
  Rgb emission = {0.0, 0.0, 0.0};  ///< radiance; above 1 by KHR_materials_emissive_strength
  /// As sRGB; multiplies `emission`, which takes over what is above 1.
  std::optional<Texture> emission_texture = std::nullopt;
};

/// A node of a file.
struct GlbMesh {
  std::string name;
  Mesh mesh;
  std::size_t material = 0;  ///< of those that are written with it
};

/// Meshes as binary glTF (y up, metres), a node each. `metres_per_unit` of the meshes'
/// coordinates, unless it is 0 (unknown, taken for 1), is the scale of the nodes, which say so in
/// their extras: ReadGltf leaves such a scale out, and gives the coordinates back. Textures that
/// share their texels are one picture. Float POSITION, unit NORMAL when the mesh has normals (else
/// viewers shade it flat), TEXCOORD_0 (v down, as the format demands) when the mesh has UVs,
/// TANGENT with a normal texture, linear float COLOR_0 (clamped to 0..1) when it has colours,
/// uint32 indices. A position with several normals, UVs or colours is repeated. Written through a
/// temporary file. Fails: IoError (not writable, a number beyond float), SceneError (wrong indices,
/// no triangle, a texture without UVs or whose texels do not match its size).
void WriteGlb(const std::filesystem::path& path,
              const std::vector<GlbMesh>& meshes,
              const std::vector<GlbMaterial>& materials,
              double metres_per_unit = 0.0);
/// One mesh, called as the file.
void WriteGlb(const std::filesystem::path& path,
              const Mesh& mesh,
              const GlbMaterial& material,
              double metres_per_unit = 0.0);

}  // namespace pathfit::renderer
