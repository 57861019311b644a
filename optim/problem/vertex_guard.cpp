#include "optim/problem/vertex_guard.h"

#include <algorithm>
#include <cmath>

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
    surface.triangles = scene.meshes[static_cast<std::size_t>(group.object)].mesh.triangles;
    for (const renderer::Triangle& triangle : surface.triangles) {
      surface.area_vectors.push_back(AreaVector(values, surface.offset, triangle));
    }
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
    std::size_t bad = 0;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const renderer::Vec3 before = surface.area_vectors[t];
      const renderer::Vec3 after = AreaVector(values, surface.offset, surface.triangles[t]);
      if (!(Norm(after) > kNoArea * mean)) {
        return false;
      }
      bad += static_cast<std::size_t>(Dot(before, after) <= 0.0 ||
                                      Norm(after) < kCollapsed * Norm(before));
    }
    if (static_cast<double>(bad) > kAllowedShare * static_cast<double>(surface.triangles.size())) {
      return false;
    }
  }
  return true;
}

}  // namespace pathfit::optim
