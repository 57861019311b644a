#include "renderer/geometry/edge_contact.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {
namespace {

// A triangle seen under a smaller cosine covers nothing.
constexpr double kEdgeOn = 1e-12;
// A triangle whose border is no farther inside, in offsets of rays, ends there.
constexpr double kOnBorder = 0.25;
// Sine between lines that run along each other.
constexpr double kParallel = 0.1;

std::array<Vec3, 3> CornersOf(const TriangleGeometry& t) {
  return {t.p0, t.p0 + t.e1, t.p0 + t.e2};
}

}  // namespace

MeshContactBounds::MeshContactBounds(const RayCaster& caster, int mesh, int num_meshes)
    : caster_(caster) {
  for (int other = 0; other < num_meshes; ++other) {
    const RayCaster::Box& bounds = caster.Bounds(mesh);
    if (other != mesh && Overlap(bounds, caster.Bounds(other), Slack(bounds))) {
      others_.push_back(caster.Bounds(other));
    }
  }
}

bool MeshContactBounds::MayTouch(const MeshEdge& edge, const Vec3& a, const Vec3& b) const {
  if (edge.faces[1] < 0 || others_.empty()) {
    return edge.faces[1] < 0;
  }
  RayCaster::Box box{a, a};
  for (int i = 0; i < 3; ++i) {
    box.low[i] = std::min(a[i], b[i]);
    box.high[i] = std::max(a[i], b[i]);
  }
  const double slack = Slack(box);
  return std::any_of(others_.begin(), others_.end(), [&](const RayCaster::Box& other) {
    return Overlap(box, other, slack);
  });
}

double MeshContactBounds::Slack(const RayCaster::Box& box) const {
  return kTouch * std::max(caster_.Offset(box.low), caster_.Offset(box.high));
}

bool MeshContactBounds::Overlap(const RayCaster::Box& box,
                                const RayCaster::Box& other,
                                double slack) {
  for (int i = 0; i < 3; ++i) {
    if (box.high[i] + slack < other.low[i] || other.high[i] + slack < box.low[i]) {
      return false;
    }
  }
  return true;
}

TouchingFaces::TouchingFaces(
    const RayCaster& caster, const Mesh& mesh, int index, const MeshEdge& edge, const Vec3& x) {
  count_ = caster.TrianglesNear(x, kTouch * caster.Offset(x), faces_);
  const auto joined = [&](TriangleId id) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(id.triangle)];
    return std::find_first_of(t.begin(), t.end(), edge.vertices.begin(), edge.vertices.end()) !=
           t.end();
  };
  const auto end = std::remove_if(faces_.begin(),
                                  faces_.begin() + static_cast<std::ptrdiff_t>(count_),
                                  [&](TriangleId id) { return id.mesh == index && joined(id); });
  count_ = static_cast<std::size_t>(end - faces_.begin());
}

std::optional<double> SlopeBeside(const TriangleGeometry& triangle,
                                  const Vec3& direction,
                                  const Vec3& normal) {
  const double cosine = Dot(triangle.n, direction);
  if (std::abs(cosine) < kEdgeOn) {
    return std::nullopt;
  }
  return -Dot(triangle.n, normal) / cosine;
}

int BorderAlong(const TriangleGeometry& triangle,
                const Vec3& x,
                const Vec3& along,
                const RayCaster& caster) {
  const std::array<Vec3, 3> corners = CornersOf(triangle);
  double nearest = kOnBorder * caster.Offset(x);
  int border = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 side = Normalized(corners[(i + 1) % 3] - corners[i]);
    const double inside = Dot(Cross(triangle.n, side), x - corners[i]);
    if (inside <= nearest) {
      nearest = inside;
      border = Norm(Cross(side, along)) < kParallel ? static_cast<int>(i) : -1;
    }
  }
  return border;
}

Vec3 ApexOf(const TriangleGeometry& triangle, int border) {
  return CornersOf(triangle)[static_cast<std::size_t>(border + 2) % 3];
}

Hit HitInside(TriangleId id, const PlaneHit& hit) {
  const double b1 = std::max(0.0, hit.b1);
  const double b2 = std::max(0.0, hit.b2);
  const double sum = std::max(1.0, b1 + b2);
  return {id, b1 / sum, b2 / sum, hit.distance};
}

}  // namespace pathfit::renderer
