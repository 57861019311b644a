#include "optim/observation/manifold_repair.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_topology.h"

namespace pathfit::optim {
namespace {

using renderer::Mesh;
using renderer::Triangle;
using renderer::Vec3;

std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }

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

}  // namespace

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

void KeepLargestPart(Mesh& mesh) {
  renderer::DisjointSets parts(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    parts.Unite(Index(t[0]), Index(t[1]));
    parts.Unite(Index(t[1]), Index(t[2]));
  }
  std::vector<double> volume(mesh.positions.size(), 0.0);
  const Vec3 origin = mesh.positions.empty() ? Vec3{} : mesh.positions.front();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.positions[Index(t[0])] - origin;
    const Vec3 b = mesh.positions[Index(t[1])] - origin;
    const Vec3 c = mesh.positions[Index(t[2])] - origin;
    volume[parts.Find(Index(t[0]))] += Dot(a, Cross(b, c)) / 6.0;
  }
  const auto largest = static_cast<std::size_t>(std::ranges::max_element(volume) - volume.begin());
  std::vector<bool> keep(mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    keep[f] = parts.Find(Index(mesh.triangles[f][0])) == largest;
  }
  KeepTriangles(keep, mesh);
}

}  // namespace pathfit::optim
