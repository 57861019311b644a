#pragma once

#include <span>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Texels around each chart: twice as many between two.
inline constexpr int kAtlasGutter = 3;

struct UvAtlasOptions {
  int max_side = 4096;  ///< what would be larger is packed with fewer texels per metre
};

/// The picture that UVs of several meshes share.
struct UvAtlas {
  int width = 0, height = 0;  ///< texels
  int charts = 0;
  double scale = 1.0;  ///< of the texels per metre that were asked for; below 1 at the largest size
};

/// Gives the meshes UVs in one picture, in which no two triangles lie over each other, without
/// touching anything but their UVs. `texels_per_metre`: by mesh and triangle, > 0, in the mesh's
/// own frame; a chart has one density, the root of the mean square of those of its triangles.
/// Charts: MakeUvCharts; packed by their rectangles. Same arguments, same UVs. Preconditions:
/// ValidateMesh passed for each; at least one mesh. Fails: SceneError if not even the largest
/// picture has room for the charts' gutters.
UvAtlas MakeUvAtlas(std::span<Mesh* const> meshes,
                    std::span<const std::vector<double>> texels_per_metre,
                    const UvAtlasOptions& options = {});

}  // namespace pathfit::renderer
