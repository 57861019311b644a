#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// What of a surface a texel of a picture shows: the point whose UV is nearest to the texel's
/// centre.
struct TexelPlace {
  std::int32_t mesh = -1;  ///< -1: none is near enough
  std::int32_t triangle = -1;
  std::int32_t chart = -1;          ///< triangles of one chart hang together by their UVs
  std::array<double, 3> weights{};  ///< of the triangle's corners, >= 0, adding up to one
  double distance = 0.0;            ///< of the centre from the point, texels; 0: on the surface
};

/// Texels that bilinear lookups on the surface use have their centres within this distance of it.
inline constexpr double kTexelReach = 1.4143;

/// By texel of a picture of this size on the meshes (which have UVs), row by row from the top.
/// Texels farther than `reach` texels from all triangles have no place.
std::vector<TexelPlace> PlaceTexels(std::span<const Mesh* const> meshes,
                                    int width,
                                    int height,
                                    double reach = kTexelReach);

/// A point of an edge whose triangles have different UVs there.
struct SeamPoint {
  std::int32_t mesh = -1;
  std::array<Vec2, 2> uv;  ///< on both sides
  double length = 0.0;     ///< of the piece of the edge that it stands for, metres
};

/// Points of all seams between triangles that share an edge of a surface, about a texel apart.
std::vector<SeamPoint> SampleSeams(std::span<const Mesh* const> meshes, int width, int height);

}  // namespace pathfit::renderer
