#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// What a glTF 2.0 file shows, as far as the renderer has it.
struct GltfFile {
  /// Meshes are in the frame of the file's scene (y up, metres; of our own files the unit that they
  /// were written from, see WriteGlb), one for each material of each node
  /// and called by both where that is needed to tell them apart. Names are the file's own, those of
  /// objects of one list are all different.
  ///
  /// Materials: only those that are used. Factors are multiplied into vertex colours and textures,
  /// a metallic-roughness texture becomes two, emission an area light of each mesh that has it.
  /// Single-sided ones are black from behind, where viewers show nothing. Roughness is at least
  /// kMinRoughness.
  /// Lights take candela for W/sr, and lux for W/m².
  ///
  /// Sensors: the cameras, all kGltfCameraHeight pixels high, as wide as their aspect ratio says
  /// (16 : 9 without one).
  Scene scene;
  std::vector<std::string> warnings;  ///< what is in the file but not, or changed, in `scene`
  std::vector<std::filesystem::path> files;  ///< all that were read, the file itself first
};

inline constexpr int kGltfCameraHeight = 1080;

/// By the extension, in either case: .gltf or .glb.
bool IsGltfPath(const std::filesystem::path& path);

/// Reads the file's default scene. Meshes may still be ones that ValidateMesh refuses. Files beside
/// it are read from its own folder and the folders in that. Fails: IoError naming the file and the
/// element: not readable, malformed, not finite, out of range, an extension that is needed and not
/// known, nothing to be seen.
/// Source: glTF 2.0 specification; KHR_texture_transform, KHR_lights_punctual,
/// KHR_materials_emissive_strength, KHR_materials_specular (its factor), KHR_mesh_quantization.
GltfFile ReadGltf(const std::filesystem::path& path);

}  // namespace pathfit::renderer
