#include "optim/problem/vertex_guard.h"

#include <algorithm>
#include <cmath>

#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_folds.h"

namespace pathfit::optim {
namespace {

using renderer::Index;
using renderer::Mesh;
using renderer::Triangle;
using renderer::Vec3;

// Below this share of the mean a triangle has no usable normal.
constexpr double kNoArea = 1e-9;
constexpr int kMaxPasses = 12;
constexpr int kPassesPerRing = 3;  // after so many passes one more ring of neighbours is held back
// By the last passes, which stop what halving has not mended.
constexpr int kStoppingPasses = 3;

std::vector<Vec3> Positions(const std::vector<double>& values,
                            std::size_t offset,
                            std::size_t count) {
  std::vector<Vec3> positions;
  positions.reserve(count);
  for (std::size_t i = offset; i < offset + 3 * count; i += 3) {
    positions.push_back({values[i], values[i + 1], values[i + 2]});
  }
  return positions;
}

std::vector<Vec3> AreaVectors(const Mesh& mesh) {
  std::vector<Vec3> vectors;
  vectors.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles.Items()) {
    vectors.push_back(TwiceArea(mesh, triangle));
  }
  return vectors;
}

}  // namespace

VertexGuard::VertexGuard(const renderer::Scene& scene,
                         const ParameterSet& set,
                         const std::vector<double>& values) {
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (group.kind != renderer::ParameterKind::kVertexPositions) {
      continue;
    }
    Surface surface;
    surface.offset = static_cast<std::size_t>(group.first_scalar);
    surface.mesh.triangles = scene.meshes[static_cast<std::size_t>(group.object)].mesh.triangles;
    surface.mesh.positions =
        Positions(values, surface.offset, static_cast<std::size_t>(group.num_blocks));
    surface.topology = renderer::MeshTopology::Build(surface.mesh);
    surface.area_vectors = AreaVectors(surface.mesh);
    for (const Vec3& area : surface.area_vectors) {
      surface.mean_area += Norm(area) / static_cast<double>(surface.area_vectors.size());
    }
    for (const renderer::MeshEdge& edge : surface.topology.edges) {
      if (edge.faces[1] < 0) continue;
      const std::size_t a = Index(edge.faces[0]);
      const std::size_t b = Index(edge.faces[1]);
      if (!renderer::AreFolded(surface.area_vectors[a], surface.area_vectors[b])) {
        surface.neighbors.push_back({a, b});
      }
    }
    surface.crosses.resize(surface.area_vectors.size());
    for (const std::int32_t t : renderer::CrossingTriangles(surface.mesh, surface.topology.parts)) {
      surface.crosses[Index(t)] = 1;
    }
    surfaces_.push_back(std::move(surface));
  }
}

bool VertexGuard::Restrain(std::vector<double>& values) const {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }) &&
         std::all_of(surfaces_.begin(), surfaces_.end(), [&values](const Surface& surface) {
           return Restrain(surface, values);
         });
}

std::vector<char> VertexGuard::VerticesOfWrecks(const Surface& surface, const Mesh& moved) {
  const std::vector<Triangle>& triangles = moved.triangles.Items();
  std::vector<char> marks(moved.positions.size(), 0);
  const auto mark = [&](std::size_t t) {
    for (const std::int32_t v : triangles[t]) {
      marks[Index(v)] = 1;
    }
  };
  const std::vector<Vec3> area_vectors = AreaVectors(moved);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3& before = surface.area_vectors[t];
    const Vec3& after = area_vectors[t];
    if (Dot(before, after) <= 0.0 || !(Norm(after) >= kCollapsed * Norm(before)) ||
        !(Norm(after) > kNoArea * surface.mean_area)) {
      mark(t);
    }
  }
  for (const auto& [a, b] : surface.neighbors) {
    if (renderer::AreFolded(area_vectors[a], area_vectors[b])) {
      mark(a);
      mark(b);
    }
  }
  for (const std::int32_t t : renderer::CrossingTriangles(moved, surface.topology.parts)) {
    if (surface.crosses[Index(t)] == 0) {
      mark(Index(t));
    }
  }
  return marks;
}

bool VertexGuard::Restrain(const Surface& surface, std::vector<double>& values) {
  const std::vector<Vec3>& start = surface.mesh.positions.Items();
  const std::vector<Vec3> wanted = Positions(values, surface.offset, start.size());
  std::vector<double> share(start.size(), 1.0);
  Mesh moved = surface.mesh;
  for (int pass = 0;; ++pass) {
    std::vector<Vec3>& positions = moved.positions.Edit();
    for (std::size_t v = 0; v < start.size(); ++v) {
      positions[v] = share[v] == 1.0 ? wanted[v] : start[v] + (wanted[v] - start[v]) * share[v];
    }
    std::vector<char> marks = VerticesOfWrecks(surface, moved);
    if (std::find(marks.begin(), marks.end(), 1) == marks.end()) {
      for (std::size_t v = 0; v < start.size(); ++v) {
        for (int i = 0; i < 3; ++i) {
          values[surface.offset + 3 * v + static_cast<std::size_t>(i)] = positions[v][i];
        }
      }
      return true;
    }
    if (pass == kMaxPasses) {
      return false;
    }
    for (int ring = 0; ring < pass / kPassesPerRing; ++ring) {
      surface.topology.MarkRing(marks);
    }
    const bool stops = pass >= kMaxPasses - kStoppingPasses;
    for (std::size_t v = 0; v < share.size(); ++v) {
      if (marks[v] != 0) {
        share[v] = stops ? 0.0 : 0.5 * share[v];
      }
    }
  }
}

}  // namespace pathfit::optim
