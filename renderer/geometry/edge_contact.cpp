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

ContactBounds::ContactBounds(const RayCaster& caster, const std::vector<MeshTopology>& topologies)
    : caster_(caster), topologies_(topologies), near_(topologies.size()) {
  std::vector<Part> all;
  for (std::size_t m = 0; m < topologies.size(); ++m) {
    const int mesh = static_cast<int>(m);
    const std::vector<std::int32_t>& parts = topologies[m].parts;
    const std::int32_t count =
        parts.empty() ? 0 : *std::max_element(parts.begin(), parts.end()) + 1;
    crowded_.push_back(count > kMostParts);
    if (count <= 1 || crowded_.back()) {
      all.push_back({mesh, -1, caster.Bounds(mesh)});
      continue;
    }
    const std::size_t first = all.size();
    all.resize(first + static_cast<std::size_t>(count), {mesh, -1, {}});
    for (std::size_t f = 0; f < parts.size(); ++f) {
      Part& part = all[first + static_cast<std::size_t>(parts[f])];
      for (const Vec3& p : CornersOf(caster.Geometry({mesh, static_cast<std::int32_t>(f)}))) {
        if (part.part < 0) {
          part = {mesh, parts[f], {p, p}};
        }
        for (int i = 0; i < 3; ++i) {
          part.box.low[i] = std::min(part.box.low[i], p[i]);
          part.box.high[i] = std::max(part.box.high[i], p[i]);
        }
      }
    }
  }
  for (std::size_t m = 0; m < topologies.size(); ++m) {
    const int mesh = static_cast<int>(m);
    const RayCaster::Box& bounds = caster.Bounds(mesh);
    for (const Part& part : all) {
      const bool itself = part.mesh == mesh && part.part < 0;
      if (!itself && Overlap(bounds, part.box, Slack(bounds))) {
        near_[m].push_back(part);
      }
    }
  }
}

bool ContactBounds::MayTouch(int mesh, const MeshEdge& edge, const Vec3& a, const Vec3& b) const {
  const auto m = static_cast<std::size_t>(mesh);
  if (edge.faces[1] < 0 || crowded_[m] || near_[m].empty()) {
    return edge.faces[1] < 0 || crowded_[m];
  }
  RayCaster::Box box{a, a};
  for (int i = 0; i < 3; ++i) {
    box.low[i] = std::min(a[i], b[i]);
    box.high[i] = std::max(a[i], b[i]);
  }
  const double slack = Slack(box);
  const std::int32_t own = topologies_[m].parts[static_cast<std::size_t>(edge.faces[0])];
  return std::any_of(near_[m].begin(), near_[m].end(), [&](const Part& part) {
    return !(part.mesh == mesh && part.part == own) && Overlap(box, part.box, slack);
  });
}

double ContactBounds::Slack(const RayCaster::Box& box) const {
  return kTouch * std::max(caster_.Offset(box.low), caster_.Offset(box.high));
}

bool ContactBounds::Overlap(const RayCaster::Box& box, const RayCaster::Box& other, double slack) {
  for (int i = 0; i < 3; ++i) {
    if (box.high[i] + slack < other.low[i] || other.high[i] + slack < box.low[i]) {
      return false;
    }
  }
  return true;
}

TouchingFaces::TouchingFaces(const RayCaster& caster,
                             const Mesh& mesh,
                             const MeshTopology& topology,
                             int index,
                             const MeshEdge& edge,
                             const Vec3& x) {
  const auto part = [&](std::int32_t face) {
    return topology.parts[static_cast<std::size_t>(face)];
  };
  count_ = caster.TrianglesNear(x, kTouch * caster.Offset(x), faces_);
  const auto joined = [&](TriangleId id) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(id.triangle)];
    return part(id.triangle) == part(edge.faces[0]) &&
           std::find_first_of(t.begin(), t.end(), edge.vertices.begin(), edge.vertices.end()) !=
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
