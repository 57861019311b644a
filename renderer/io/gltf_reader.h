#pragma once

#include <filesystem>

#include "renderer/io/mesh_file.h"

namespace pathfit::renderer {

inline constexpr int kGltfCameraHeight = 1080;

/// Reads the file's default scene. Files beside it are read from its own folder and the folders in
/// that.
///
/// Meshes are in the frame of the file's scene (y up, metres; of our own files the unit that they
/// were written from, see WriteGlb), one for each material of each node and called by both where
/// that is needed to tell them apart. Materials: only those that are used. Factors are multiplied
/// into vertex colours and textures, a metallic-roughness texture becomes two, emission an area
/// light of each mesh that has it. Single-sided ones are black from behind, where viewers show
/// nothing. Roughness is at least kMinRoughness. Lights take candela for W/sr, and lux for W/m².
/// Sensors: the cameras, all kGltfCameraHeight pixels high, as wide as their aspect ratio says
/// (16 : 9 without one).
///
/// Fails: IoError naming the file and the
/// element: not readable, malformed, not finite, out of range, an extension that is needed and not
/// known, nothing to be seen.
/// Source: glTF 2.0 specification; KHR_texture_transform, KHR_lights_punctual,
/// KHR_materials_emissive_strength, KHR_materials_specular (its factor), KHR_mesh_quantization,
/// KHR_draco_mesh_compression, EXT_meshopt_compression.
SceneFile ReadGltf(const std::filesystem::path& path);

}  // namespace pathfit::renderer
