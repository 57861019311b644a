#include "optim/problem/vertex_guard.h"

#include <algorithm>
#include <cmath>

#include "renderer/geometry/mesh_folds.h"
#include "renderer/geometry/mesh_topology.h"

namespace pathfit::optim {
namespace {

// Below this share of the mean a triangle has no usable normal.
constexpr double kNoArea = 1e-9;

renderer::Vec3 AreaVector(const std::vector<double>& values,
                          std::size_t offset,
                          const renderer::Triangle& triangle) {
  const auto vertex = [&](std::size_t k) {
    const double* p = values.data() + offset + 3 * static_cast<std::size_t>(triangle[k]);
    return renderer::Vec3{p[0], p[1], p[2]};
  };
  const renderer::Vec3 a = vertex(0);
  return Cross(vertex(1) - a, vertex(2) - a);
}

std::vector<renderer::Vec3> Positions(const std::vector<double>& values,
                                      std::size_t offset,
                                      std::size_t count) {
  std::vector<renderer::Vec3> positions;
  positions.reserve(count);
  for (std::size_t i = offset; i < offset + 3 * count; i += 3) {
    positions.push_back({values[i], values[i + 1], values[i + 2]});
  }
  return positions;
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
    for (const renderer::Triangle& triangle : surface.mesh.triangles.Items()) {
      surface.area_vectors.push_back(AreaVector(values, surface.offset, triangle));
    }
    for (const renderer::MeshEdge& edge : renderer::MeshTopology::Build(surface.mesh).edges) {
      if (edge.faces[1] < 0) continue;
      const auto a = static_cast<std::size_t>(edge.faces[0]);
      const auto b = static_cast<std::size_t>(edge.faces[1]);
      if (!renderer::AreFolded(surface.area_vectors[a], surface.area_vectors[b])) {
        surface.neighbors.push_back({a, b});
      }
    }
    surface.crossing = renderer::CrossingTriangles(surface.mesh).size();
    surfaces_.push_back(std::move(surface));
  }
}

bool VertexGuard::Admits(const std::vector<double>& values) const {
  if (!std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); })) {
    return false;
  }
  for (const Surface& surface : surfaces_) {
    double mean = 0.0;
    for (const renderer::Vec3& area : surface.area_vectors) {
      mean += Norm(area) / static_cast<double>(surface.area_vectors.size());
    }
    const std::vector<renderer::Triangle>& triangles = surface.mesh.triangles.Items();
    std::vector<renderer::Vec3> area_vectors;
    area_vectors.reserve(triangles.size());
    std::size_t bad = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const renderer::Vec3 before = surface.area_vectors[t];
      const renderer::Vec3 after = AreaVector(values, surface.offset, triangles[t]);
      area_vectors.push_back(after);
      if (!(Norm(after) > kNoArea * mean)) {
        return false;
      }
      bad += static_cast<std::size_t>(Dot(before, after) <= 0.0 ||
                                      Norm(after) < kCollapsed * Norm(before));
    }
    const double allowed = kAllowedShare * static_cast<double>(triangles.size());
    const auto folded = std::count_if(
        surface.neighbors.begin(), surface.neighbors.end(), [&area_vectors](const auto& pair) {
          return renderer::AreFolded(area_vectors[pair[0]], area_vectors[pair[1]]);
        });
    if (static_cast<double>(bad) > allowed || static_cast<double>(folded) > allowed) {
      return false;
    }
    renderer::Mesh moved = surface.mesh;
    moved.positions = Positions(values, surface.offset, surface.mesh.positions.size());
    const std::size_t crossing = renderer::CrossingTriangles(moved).size();
    if (static_cast<double>(crossing) > static_cast<double>(surface.crossing) + allowed) {
      return false;
    }
  }
  return true;
}

}  // namespace pathfit::optim
