#include "renderer/geometry/edge_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "renderer/geometry/near_pairs.h"

namespace pathfit::renderer {
namespace {

// A triangle seen under a smaller cosine covers nothing.
constexpr double kEdgeOn = 1e-12;
// A triangle whose border is no farther inside, in offsets of rays, ends there.
constexpr double kOnBorder = 0.25;
// Sine between lines that run along each other.
constexpr double kParallel = 0.1;
// Reaches of a touch along a part of an edge that differ less count as one.
constexpr double kAlike = 2.0;

/// All triangles, such that those of one part which no border of it may touch have one label.
std::vector<NearItem> ItemsOf(const RayCaster& caster,
                              const std::vector<MeshTopology>& topologies,
                              std::vector<TriangleId>& ids) {
  std::vector<NearItem> items;
  std::int32_t first_label = 0;
  for (std::size_t m = 0; m < topologies.size(); ++m) {
    const MeshTopology& topology = topologies[m];
    const std::size_t first = items.size();
    items.reserve(first + topology.parts.size());
    ids.reserve(first + topology.parts.size());
    std::int32_t num_parts = 0;
    for (std::size_t f = 0; f < topology.parts.size(); ++f) {
      ids.push_back({static_cast<std::int32_t>(m), static_cast<std::int32_t>(f)});
      const TriangleGeometry& t = caster.Geometry(ids.back());
      const double size = std::sqrt(std::max(SquaredNorm(t.e1), SquaredNorm(t.e2)));
      const double offset = caster.Offset(t.p0) + RayCaster::kRayOffset * size;  // of any corner
      items.push_back({&t, kTouch * offset, first_label + topology.parts[f]});
      num_parts = std::max(num_parts, topology.parts[f] + 1);
    }
    for (const MeshEdge& edge : topology.edges) {
      if (edge.faces[1] < 0) {
        items[first + static_cast<std::size_t>(edge.faces[0])].label = -1;
      }
    }
    first_label += num_parts;
  }
  return items;
}

/// Whether a triangle is so narrow that all of it touches its side a..b.
bool IsSliver(const TriangleGeometry& t, const Vec3& a, const Vec3& b, double reach) {
  const std::array<Vec3, 3> corners = t.Corners();
  return std::ranges::all_of(corners, [&](const Vec3& corner) {
    return Norm(Cross(corner - a, b - a)) <= reach * Norm(b - a);
  });
}

/// The parts of the segment a..b that touch a triangle, in ascending order; none where they cross.
std::vector<SegmentPart> TouchedParts(const RayCaster& caster,
                                      const Vec3& a,
                                      const Vec3& b,
                                      const TriangleGeometry& triangle) {
  const Vec3 along = b - a;
  const double length = Norm(along);
  const auto reach = [&](double t) { return kTouch * caster.Offset(a + along * t); };
  std::vector<SegmentPart> parts;
  // How near is near depends on the place: parts are halved until it is alike all over each.
  std::vector<SegmentPart> open = {{0.0, 1.0}};
  while (!open.empty()) {
    SegmentPart part = open.back();
    open.pop_back();
    part.KeepNear(triangle, a, b, std::max(reach(part.begin), reach(part.end)));
    if (part.IsEmpty()) {
      continue;
    }
    const double middle = 0.5 * (part.begin + part.end);
    const double nearest =
        std::clamp(Dot(caster.Center() - a, along) / (length * length), part.begin, part.end);
    if (std::max(reach(part.begin), reach(part.end)) > kAlike * reach(nearest)) {
      open.push_back({middle, part.end});
      open.push_back({part.begin, middle});
      continue;
    }
    part.KeepNear(triangle, a, b, reach(middle));
    if (part.IsEmpty()) {
      continue;
    }
    if (!parts.empty() && part.begin <= parts.back().end) {
      parts.back().end = part.end;
    } else {
      parts.push_back(part);
    }
  }
  // Lines that cross are near each other along their common width over the sine between them.
  std::erase_if(parts, [&](const SegmentPart& part) {
    const double crossing = 2.0 / kParallel * reach(0.5 * (part.begin + part.end));
    return length * (part.end - part.begin) < std::min(crossing, 0.5 * length);
  });
  return parts;
}

}  // namespace

/// A triangle touches a part of an edge.
struct EdgeContacts::Touch {
  int mesh;
  std::int32_t edge;
  TriangleId other;
  SegmentPart part;
};

EdgeContacts::EdgeContacts(const RayCaster& caster,
                           const std::vector<Mesh>& meshes,
                           const std::vector<MeshTopology>& topologies)
    : topologies_(topologies), edges_(topologies.size()) {
  std::vector<std::vector<std::array<std::int32_t, 3>>> edges_of(topologies.size());
  std::vector<Touch> touches;
  const auto add = [&](TriangleId id, TriangleId other) {
    const auto m = static_cast<std::size_t>(id.mesh);
    const MeshTopology& topology = topologies[m];
    const auto part = [&](TriangleId of) {
      return topology.parts[static_cast<std::size_t>(of.triangle)];
    };
    if (edges_of[m].empty()) {
      edges_of[m] = topology.EdgesOfTriangles();
    }
    const bool joined = other.mesh == id.mesh && part(other) == part(id);
    const auto& own_edges = edges_of[m][static_cast<std::size_t>(id.triangle)];
    // What slivers join to the triangle seems to touch its other sides.
    const auto is_joined_by_slivers = [&](const Vec3& a, const Vec3& b) {
      const double reach = kTouch * std::max(caster.Offset(a), caster.Offset(b));
      std::vector<std::int32_t> seen = {id.triangle};
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const std::int32_t face = seen[i];
        if (face == other.triangle) return true;
        if (!IsSliver(caster.Geometry({id.mesh, face}), a, b, reach)) continue;
        for (const std::int32_t e : edges_of[m][static_cast<std::size_t>(face)]) {
          for (const std::int32_t next : topology.edges[static_cast<std::size_t>(e)].faces) {
            if (next >= 0 && std::ranges::find(seen, next) == seen.end()) seen.push_back(next);
          }
        }
      }
      return false;
    };
    for (const std::int32_t e : own_edges) {
      const MeshEdge& edge = topology.edges[static_cast<std::size_t>(e)];
      if (edge.faces[0] != id.triangle || (joined && edge.faces[1] >= 0)) {
        continue;
      }
      const Vec3& a = meshes[m].positions[static_cast<std::size_t>(edge.vertices[0])];
      const Vec3& b = meshes[m].positions[static_cast<std::size_t>(edge.vertices[1])];
      if (joined && is_joined_by_slivers(a, b)) {
        continue;
      }
      for (const SegmentPart& touched : TouchedParts(caster, a, b, caster.Geometry(other))) {
        touches.push_back({id.mesh, e, other, touched});
      }
    }
  };
  std::vector<TriangleId> ids;
  const std::vector<NearItem> items = ItemsOf(caster, topologies, ids);
  ForEachNearPair(items, [&](std::size_t i, std::size_t k) {
    add(ids[i], ids[k]);
    add(ids[k], ids[i]);
  });
  std::sort(touches.begin(), touches.end(), [](const Touch& x, const Touch& y) {
    return std::tie(x.mesh, x.edge, x.other, x.part.begin) <
           std::tie(y.mesh, y.edge, y.other, y.part.begin);
  });
  for (auto first = touches.begin(); first != touches.end();) {
    const auto last = std::find_if(first, touches.end(), [&](const Touch& t) {
      return t.mesh != first->mesh || t.edge != first->edge;
    });
    AddStretches({first, last});
    first = last;
  }
}

void EdgeContacts::AddStretches(std::span<const Touch> touches) {
  const auto m = static_cast<std::size_t>(touches.front().mesh);
  const auto e = static_cast<std::size_t>(touches.front().edge);
  std::vector<std::pair<double, TriangleId>> changes;  // twice each: it begins, and it ends
  for (const Touch& touch : touches) {
    changes.emplace_back(touch.part.begin, touch.other);
    changes.emplace_back(touch.part.end, touch.other);
  }
  std::sort(changes.begin(), changes.end());
  edges_[m].resize(topologies_[m].edges.size());
  Range& range = edges_[m][e];
  range.first = stretches_.size();
  std::vector<TriangleId> present;
  const auto add = [&](double end) {
    stretches_.push_back({end, faces_.size(), 0});
    if (!present.empty()) {
      for (const std::int32_t face : topologies_[m].edges[e].faces) {
        faces_.push_back({static_cast<std::int32_t>(m), face});
      }
      faces_.insert(faces_.end(), present.begin(), present.end());
      stretches_.back().count = faces_.size() - stretches_.back().first;
    }
    ++range.count;
  };
  double begin = 0.0;
  for (const auto& [t, id] : changes) {
    if (t > begin) {
      add(t);
      begin = t;
    }
    const auto at = std::lower_bound(present.begin(), present.end(), id);
    if (at != present.end() && *at == id) {
      present.erase(at);
    } else {
      present.insert(at, id);
    }
  }
  add(std::numeric_limits<double>::infinity());
}

FacesAtEdge EdgeContacts::At(int mesh, std::int32_t edge, double t) const {
  const auto m = static_cast<std::size_t>(mesh);
  const auto e = static_cast<std::size_t>(edge);
  const std::array<std::int32_t, 2>& faces = topologies_[m].edges[e].faces;
  const std::array<TriangleId, 2> own = {TriangleId{mesh, faces[0]}, TriangleId{mesh, faces[1]}};
  if (edges_[m].empty() || edges_[m][e].count == 0) {
    return {own, {}};
  }
  const Range& range = edges_[m][e];
  const auto first = stretches_.begin() + static_cast<std::ptrdiff_t>(range.first);
  const auto stretch = std::upper_bound(first,
                                        first + static_cast<std::ptrdiff_t>(range.count - 1),
                                        t,
                                        [](double at, const Stretch& s) { return at < s.end; });
  return {own, {faces_.data() + stretch->first, stretch->count}};
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
  const std::array<Vec3, 3> corners = triangle.Corners();
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
  return triangle.Corners()[static_cast<std::size_t>(border + 2) % 3];
}

Hit HitInside(TriangleId id, const PlaneHit& hit) {
  const double b1 = std::max(0.0, hit.b1);
  const double b2 = std::max(0.0, hit.b2);
  const double sum = std::max(1.0, b1 + b2);
  return {id, b1 / sum, b2 / sum, hit.distance};
}

}  // namespace pathfit::renderer
