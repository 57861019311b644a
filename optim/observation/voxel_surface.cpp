#include "optim/observation/voxel_surface.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include <openvdb/Grid.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <openvdb/tree/Tree.h>

#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_topology.h"

namespace pathfit::optim {
namespace {

using renderer::Index;
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
  std::vector<std::unique_ptr<Leaf>> filled(Index(leaves[0]) * Index(leaves[1]) * Index(leaves[2]));
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
    return SquaredNorm(mesh.positions[Index(a)] - mesh.positions[Index(b)]);
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

/// Vertices and triangles of the parts listed by `keep` (one entry per triangle).
void KeepTriangles(const std::vector<bool>& keep, Mesh& mesh) {
  std::vector<std::int32_t> new_index(mesh.positions.size(), -1);
  Mesh out;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    if (!keep[f]) continue;
    Triangle triangle = mesh.triangles[f];
    for (std::int32_t& v : triangle) {
      std::int32_t& target = new_index[Index(v)];
      if (target < 0) {
        target = static_cast<std::int32_t>(out.positions.size());
        out.positions.push_back(mesh.positions[Index(v)]);
      }
      v = target;
    }
    out.triangles.push_back(triangle);
  }
  mesh = std::move(out);
}

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

void SeparateTouchingParts(double inset, Mesh& mesh) {
  const renderer::CornerFans fans = renderer::CornerFans::Build(mesh);
  if (fans.num_unpaired > 0 || fans.num_irregular > 0) {
    throw renderer::SceneError(
        "visual hull: the carved surface is not closed; try another resolution");
  }
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> first_fan(mesh.positions.size(), kNone);
  std::vector<std::int32_t> vertex_of_fan(3 * mesh.triangles.size(), -1);
  std::vector<bool> is_split(mesh.positions.size(), false);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t& vertex = mesh.triangles[f][k];
      const std::size_t fan = fans.fan[3 * f + k];
      std::int32_t& target = vertex_of_fan[fan];
      if (target < 0) {
        target = vertex;
        if (first_fan[Index(vertex)] == kNone) {
          first_fan[Index(vertex)] = fan;
        } else {
          target = static_cast<std::int32_t>(mesh.positions.size());
          const Vec3 copy = mesh.positions[Index(vertex)];
          mesh.positions.push_back(copy);
          is_split[Index(vertex)] = true;
          is_split.push_back(true);
        }
      }
      vertex = target;
    }
  }
  std::vector<Vec3> normals(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    const Vec3 n = Cross(mesh.positions[Index(t[1])] - mesh.positions[Index(t[0])],
                         mesh.positions[Index(t[2])] - mesh.positions[Index(t[0])]);
    for (const std::int32_t v : t) normals[Index(v)] += n;
  }
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (const double length = Norm(normals[v]); is_split[v] && length > 0.0) {
      mesh.positions[v] -= normals[v] * (inset / length);
    }
  }
}

MeshParts PartsByVolume(const Mesh& mesh) {
  renderer::DisjointSets sets(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    sets.Unite(Index(t[0]), Index(t[1]));
    sets.Unite(Index(t[1]), Index(t[2]));
  }
  std::vector<double> volume(mesh.positions.size(), 0.0);
  std::vector<bool> is_used(mesh.positions.size(), false);
  const Vec3 origin = mesh.positions.empty() ? Vec3{} : mesh.positions.front();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.positions[Index(t[0])] - origin;
    const Vec3 b = mesh.positions[Index(t[1])] - origin;
    const Vec3 c = mesh.positions[Index(t[2])] - origin;
    const std::size_t root = sets.Find(Index(t[0]));
    volume[root] += Dot(a, Cross(b, c)) / 6.0;
    is_used[root] = true;
  }
  std::vector<std::size_t> roots;
  for (std::size_t v = 0; v < is_used.size(); ++v) {
    if (is_used[v]) roots.push_back(v);
  }
  std::ranges::stable_sort(roots, std::greater(), [&](std::size_t root) { return volume[root]; });
  MeshParts parts;
  std::vector<std::size_t> part_of(mesh.positions.size());
  for (const std::size_t root : roots) {
    part_of[root] = parts.volumes.size();
    parts.volumes.push_back(volume[root]);
  }
  for (const Triangle& t : mesh.triangles) {
    parts.of_triangle.push_back(part_of[sets.Find(Index(t[0]))]);
  }
  return parts;
}

void KeepLargestPart(Mesh& mesh) {
  const MeshParts parts = PartsByVolume(mesh);
  std::vector<bool> keep;
  for (const std::size_t part : parts.of_triangle) keep.push_back(part == 0);
  KeepTriangles(keep, mesh);
}

}  // namespace pathfit::optim
