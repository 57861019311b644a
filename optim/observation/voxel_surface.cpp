#include "optim/observation/voxel_surface.h"

#include <openvdb/Grid.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <openvdb/tree/Tree.h>

#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

using renderer::Mesh;
using renderer::Triangle;
using renderer::Vec3;
using FloatTree = openvdb::tree::Tree4<float, 5, 4, 3>::Type;
using FloatGrid = openvdb::Grid<FloatTree>;

constexpr float kOutside = 4.0F;  // of the level set: negative inside

/// Leaves of 8^3 nodes are filled in parallel and then hung into the tree.
FloatGrid::Ptr MakeLevelSet(const VoxelGrid& grid) {
  using Leaf = FloatTree::LeafNodeType;
  constexpr int kDim = static_cast<int>(Leaf::DIM);
  std::array<int, 3> leaves{};
  for (std::size_t a = 0; a < 3; ++a) leaves[a] = (grid.size[a] + kDim - 1) / kDim;
  std::vector<std::unique_ptr<Leaf>> filled(static_cast<std::size_t>(leaves[0]) *
                                            static_cast<std::size_t>(leaves[1]) *
                                            static_cast<std::size_t>(leaves[2]));
  renderer::ParallelFor(static_cast<std::int64_t>(filled.size()), [&](std::int64_t i) {
    const openvdb::Coord first(static_cast<int>(i % leaves[0]) * kDim,
                               static_cast<int>(i / leaves[0] % leaves[1]) * kDim,
                               static_cast<int>(i / leaves[0] / leaves[1]) * kDim);
    auto leaf = std::make_unique<Leaf>(first, kOutside, false);
    for (int x = first.x(); x < std::min(first.x() + kDim, grid.size[0]); ++x) {
      for (int y = first.y(); y < std::min(first.y() + kDim, grid.size[1]); ++y) {
        for (int z = first.z(); z < std::min(first.z() + kDim, grid.size[2]); ++z) {
          leaf->setValueOn(openvdb::Coord(x, y, z), -grid.values[grid.Offset(x, y, z)]);
        }
      }
    }
    filled[static_cast<std::size_t>(i)] = std::move(leaf);
  });
  auto tree = std::make_shared<FloatTree>(kOutside);
  for (std::unique_ptr<Leaf>& leaf : filled) {
    tree->addLeaf(leaf.release());  // the tree owns its leaves
  }
  return FloatGrid::create(tree);
}

void AddQuad(const openvdb::Vec4I& quad, Mesh& mesh) {
  std::array<std::int32_t, 4> v{};
  for (int k = 0; k < 4; ++k) v[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(quad[k]);
  const auto squared_length = [&](std::int32_t a, std::int32_t b) {
    return SquaredNorm(mesh.positions[static_cast<std::size_t>(a)] -
                       mesh.positions[static_cast<std::size_t>(b)]);
  };
  if (squared_length(v[0], v[2]) <= squared_length(v[1], v[3])) {
    mesh.triangles.push_back({v[0], v[1], v[2]});
    mesh.triangles.push_back({v[0], v[2], v[3]});
  } else {
    mesh.triangles.push_back({v[0], v[1], v[3]});
    mesh.triangles.push_back({v[1], v[2], v[3]});
  }
}

}  // namespace

Mesh ExtractSurface(const VoxelGrid& grid) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*MakeLevelSet(grid), points, triangles, quads, 0.0, 0.0);
  Mesh mesh;
  mesh.positions.reserve(points.size());
  for (const openvdb::Vec3s& p : points) {
    const Vec3 in_nodes{
        static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z())};
    mesh.positions.push_back(grid.origin + in_nodes * grid.spacing);
  }
  mesh.triangles.reserve(triangles.size() + 2 * quads.size());
  for (const openvdb::Vec3I& t : triangles) {
    mesh.triangles.push_back({static_cast<std::int32_t>(t[0]),
                              static_cast<std::int32_t>(t[1]),
                              static_cast<std::int32_t>(t[2])});
  }
  for (const openvdb::Vec4I& quad : quads) AddQuad(quad, mesh);
  if (SignedVolume(mesh) < 0.0) {
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

}  // namespace pathfit::optim
