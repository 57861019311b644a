#include "renderer/scene/texture_surface.h"

#include <algorithm>
#include <cstddef>

#include "renderer/geometry/uv_overlap.h"

namespace pathfit::renderer {
namespace {

template <class Predicate>
std::vector<int> MeshesWhere(const Scene& scene, const Predicate& fits) {
  std::vector<int> meshes;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    if (fits(scene.meshes[i].material)) meshes.push_back(static_cast<int>(i));
  }
  return meshes;
}

}  // namespace

std::vector<int> MeshesOfMaterial(const Scene& scene, int material) {
  return MeshesWhere(scene, [material](int own) { return own == material; });
}

std::vector<int> MeshesOfTexture(const Scene& scene, int texture) {
  return MeshesWhere(scene, [&](int own) {
    const auto used = scene.materials[static_cast<std::size_t>(own)].Textures();
    return std::ranges::find(used, texture) != used.end();
  });
}

bool IsTextureOfLight(const Scene& scene, int texture) {
  return std::ranges::any_of(scene.emitters, [texture](const Emitter& emitter) {
    return texture >= 0 && LightTexture(emitter) == texture;
  });
}

bool IsAtlas(const Scene& scene, int texture) {
  if (IsTextureOfLight(scene, texture)) return false;
  std::vector<const Mesh*> meshes;
  for (const int i : MeshesOfTexture(scene, texture)) {
    meshes.push_back(&scene.meshes[static_cast<std::size_t>(i)].mesh);
  }
  return !meshes.empty() && HaveSeparateUvs(meshes);
}

}  // namespace pathfit::renderer
