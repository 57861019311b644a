#include "renderer/emitter/area_sampler.h"

#include <algorithm>

#include "renderer/core/check.h"

namespace pathfit::renderer {
namespace {

// Share of the samples that goes to the triangles by area alone, whatever their brightness.
constexpr double kAreaFloor = 0.1;

double AreaOf(const Mesh& mesh, const Triangle& t) {
  const auto corner = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(t[i])]; };
  const double area = 0.5 * Norm(Cross(corner(1) - corner(0), corner(2) - corner(0)));
  return area > 0.0 ? area : 0.0;
}

}  // namespace

void AreaSampler::AddMesh(int mesh, const Mesh& world, const std::vector<double>& brightness) {
  PATHFIT_CHECK(mesh >= 0 && brightness.size() == world.triangles.size());
  const auto index = static_cast<std::size_t>(mesh);
  if (first_of_mesh_.size() <= index) first_of_mesh_.resize(index + 1, -1);
  PATHFIT_CHECK(first_of_mesh_[index] < 0);
  first_of_mesh_[index] = static_cast<std::int64_t>(triangles_.size());
  for (std::size_t i = 0; i < world.triangles.size(); ++i) {
    triangles_.push_back({mesh, static_cast<std::int32_t>(i)});
    areas_.push_back(AreaOf(world, world.triangles[i]));
    weights_.push_back(areas_.back() * std::max(brightness[i], 0.0));
  }
}

void AreaSampler::Finish() {
  double total_area = 0.0;
  double total_weight = 0.0;
  for (std::size_t i = 0; i < areas_.size(); ++i) {
    total_area += areas_[i];
    total_weight += weights_[i];
  }
  const double floor =
      total_weight > 0.0 ? kAreaFloor / (1.0 - kAreaFloor) * total_weight / total_area : 1.0;
  for (std::size_t i = 0; i < areas_.size(); ++i) weights_[i] += floor * areas_[i];
  distribution_ = Distribution1D(weights_);
  pdf_.assign(areas_.size(), 0.0);
  for (std::size_t i = 0; i < areas_.size(); ++i) {
    if (areas_[i] > 0.0) pdf_[i] = distribution_.Probability(static_cast<int>(i)) / areas_[i];
  }
}

AreaSample AreaSampler::Sample(double u0, double u1) const {
  double remainder = 0.0;
  const int index = distribution_.Sample(u0, remainder);
  // The square is folded along its diagonal onto the triangle: uniform and continuous, so strata
  // of the square stay compact on the triangle.
  double b1 = remainder;
  double b2 = u1;
  if (b1 > b2) {
    b2 *= 0.5;
    b1 -= b2;
  } else {
    b1 *= 0.5;
    b2 -= b1;
  }
  const auto i = static_cast<std::size_t>(index);
  return {triangles_[i], b1, b2, pdf_[i]};
}

double AreaSampler::Pdf(TriangleId id) const {
  const auto mesh = static_cast<std::size_t>(id.mesh);
  if (id.mesh < 0 || mesh >= first_of_mesh_.size() || first_of_mesh_[mesh] < 0) return 0.0;
  return pdf_[static_cast<std::size_t>(first_of_mesh_[mesh] + id.triangle)];
}

}  // namespace pathfit::renderer
