#pragma once

#include <string>
#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::app {

/// Meshes of few triangles for other programs, with what they lost as pictures on UVs of their own.
struct CoarseAsset {
  /// With meshes in the world frame; each that became coarse has a material and textures of its
  /// own: what its colours, roughness and metallic were on vertices or as textures, and the normals
  /// of the fine surface as its normal texture.
  renderer::Scene scene;
  std::vector<std::string> messages;  ///< a sentence for each mesh
};

/// Meshes with more than `num_triangles` > 0 triangles get so many (optim::Decimate), smooth
/// normals and an atlas with texels as large as those of the fine mesh's textures, or half of its
/// edges, what is smaller. Those that shine stay. Throws SceneError naming the mesh.
CoarseAsset MakeCoarseAsset(const renderer::Scene& scene, int num_triangles);

}  // namespace pathfit::app
