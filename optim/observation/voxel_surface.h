#pragma once

#include <array>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::optim {

/// Field samples at the nodes of a regular grid, x fastest; distances in units of the spacing.
struct VoxelGrid {
  renderer::Vec3 origin;  ///< of node (0, 0, 0), world
  double spacing = 1.0;   ///< world
  std::array<int, 3> size{};
  std::vector<float> values;  ///< positive inside

  [[nodiscard]] std::size_t Offset(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
  }
  [[nodiscard]] renderer::Vec3 Node(int x, int y, int z) const {
    return origin + renderer::Vec3{x * spacing, y * spacing, z * spacing};
  }
};

/// Triangles of the zero surface, wound outward, by dual contouring. Closed if the outermost nodes
/// are negative; edges may still have four triangles where the surface touches itself (see
/// SeparateTouchingParts).
renderer::Mesh ExtractSurface(const VoxelGrid& grid);

/// Cuts a closed surface where it touches itself, at edges with more than two triangles and at
/// vertices with several fans, such that each piece of the body keeps its own edge and vertex; the
/// copies are moved `inset` (world units) into the body. Afterwards each edge has two triangles of
/// opposite direction. Throws SceneError if the surface is not closed or not consistently wound.
/// Positions and triangles only.
void SeparateTouchingParts(double inset, renderer::Mesh& mesh);

/// A mesh in parts that share no vertex, those of larger enclosed volume first.
struct MeshParts {
  std::vector<std::size_t> of_triangle;
  std::vector<double> volumes;
};
MeshParts PartsByVolume(const renderer::Mesh& mesh);

/// Keeps these triangles, and their positions only.
void KeepTriangles(const std::vector<bool>& keep, renderer::Mesh& mesh);

/// Keeps the part of largest enclosed volume.
void KeepLargestPart(renderer::Mesh& mesh);

}  // namespace pathfit::optim
