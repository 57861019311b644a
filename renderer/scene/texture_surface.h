#pragma once

#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// Meshes whose material uses the texture, ascending.
std::vector<int> MeshesOfMaterial(const Scene& scene, int material);
std::vector<int> MeshesOfTexture(const Scene& scene, int texture);

bool IsTextureOfLight(const Scene& scene, int texture);

/// Whether the texture is a picture of surfaces of which each texel shows one place at most: it is
/// used by materials alone, and the UVs of their meshes do not overlap or leave the picture.
bool IsAtlas(const Scene& scene, int texture);

}  // namespace pathfit::renderer
