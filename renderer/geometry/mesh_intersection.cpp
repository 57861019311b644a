#include "renderer/geometry/mesh_intersection.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/near_pairs.h"
#include "renderer/geometry/ray_caster.h"
#include "renderer/math/box.h"

namespace pathfit::renderer {
namespace {

// A mesh touches itself along at least so many times the depth: less is a point.
constexpr double kAlong = 20.0;

/// A mesh with what contacts depend on.
struct Surface {
  explicit Surface(const Mesh& of)
      : mesh(of), topology(MeshTopology::Build(of)), triangles(GeometryOf(of)) {
    const Box box = BoxAround(mesh.positions);
    middle = box.Middle();
    extent = box.HalfDiagonal();
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      volumes.resize(std::max(volumes.size(), PartOf(f) + 1), 0.0);
      const TriangleGeometry& t = triangles[f];
      volumes[PartOf(f)] += Dot(t.p0 - box.low, Cross(t.e1, t.e2));
    }
    holds_eye.resize(volumes.size());
    borders.resize(triangles.size());
    for (const MeshEdge& edge : topology.edges) {
      if (edge.faces[1] < 0) {
        const auto f = static_cast<std::size_t>(edge.faces[0]);
        const Triangle& t = mesh.triangles[f];
        borders[f] |= static_cast<std::uint8_t>(
            1U << (std::find(t.begin(), t.end(), edge.vertices[0]) - t.begin()));
        volumes[PartOf(f)] = 0.0;
      }
    }
  }

  [[nodiscard]] std::size_t PartOf(std::size_t triangle) const {
    return static_cast<std::size_t>(topology.parts[triangle]);
  }
  /// Solid angle of a part from x, with the sign of its winding: 4 pi or 0 if it is closed.
  [[nodiscard]] double AngleSeen(std::size_t part, const Vec3& x) const {
    double sum = 0.0;
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      if (PartOf(f) == part) {
        const Vec3 a = triangles[f].p0 - x, b = a + triangles[f].e1, c = a + triangles[f].e2;
        const double la = Norm(a), lb = Norm(b), lc = Norm(c);
        sum += 2.0 * std::atan2(Dot(a, Cross(b, c)),
                                la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb);
      }
    }
    return sum;
  }

  const Mesh& mesh;
  MeshTopology topology;
  std::vector<TriangleGeometry> triangles;
  std::vector<std::uint8_t> borders;           // by triangle: bits of its sides
  std::vector<double> volumes;                 // by part, six times; 0: it is open
  std::vector<std::optional<bool>> holds_eye;  // by part, where somebody asked
  Vec3 middle;
  double extent = 0.0;  // half the diagonal
};

/// Of the corners of a triangle over the plane of another one.
Vec3 HeightsOver(const TriangleGeometry& plane, const TriangleGeometry& t) {
  const double at = Dot(plane.n, t.p0 - plane.p0);
  return {at, at + Dot(plane.n, t.e1), at + Dot(plane.n, t.e2)};
}

/// Whether the boxes around a segment and a triangle are farther apart than `slack`.
bool AreApart(const Vec3& a, const Vec3& b, const TriangleGeometry& t, double slack) {
  const Vec3 around{slack, slack, slack};
  Box segment = BoxAround(std::array{a, b});
  segment.Include({segment.low - around, segment.high + around});
  return !segment.Meets(BoxAround(t.Corners()));
}

/// Whether the segment a..b passes through the inside of a triangle.
bool Pierces(const Vec3& a, const Vec3& b, double depth, const TriangleGeometry& t) {
  const double at_a = Dot(t.n, a - t.p0);
  const double at_b = Dot(t.n, b - t.p0);
  if (!(at_a * at_b < 0.0) || !(std::min(std::abs(at_a), std::abs(at_b)) > depth)) {
    return false;
  }
  const PlaneHit hit = IntersectPlane(t, a, b - a);
  const double longest = std::max({Norm(t.e1), Norm(t.e2), Norm(t.e2 - t.e1)});
  // Edges of a solid that stands on another lie in the border of its faces.
  return std::min({hit.b1, hit.b2, 1.0 - hit.b1 - hit.b2}) * t.double_area > depth * longest;
}

/// Whether triangles that lie in each other's plane cover each other.
bool Cover(const TriangleGeometry& a, const TriangleGeometry& b, double depth) {
  for (const auto& [t, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    const std::array<Vec3, 3> corners = t->Corners();
    const std::array<Vec3, 3> others = other->Corners();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 side = corners[(i + 1) % 3] - corners[i];
      const Vec3 inward = Cross(t->n, side) * (1.0 / Norm(side));
      const auto within = [&](const Vec3& x) { return Dot(inward, x - corners[i]) > depth; };
      if (std::none_of(others.begin(), others.end(), within)) {
        return false;
      }
    }
  }
  return true;
}

class ContactSearch {
 public:
  ContactSearch(const std::vector<const Mesh*>& meshes, const std::vector<Eye>& eyes)
      : eyes_(eyes) {
    surfaces_.reserve(meshes.size());
    for (const Mesh* mesh : meshes) {
      surfaces_.emplace_back(*mesh);
    }
  }

  std::vector<MeshContact> Run() {
    std::vector<NearItem> items;
    std::vector<TriangleId> ids;
    for (std::size_t m = 0; m < surfaces_.size(); ++m) {
      items.reserve(items.size() + surfaces_[m].triangles.size());
      ids.reserve(items.capacity());
      for (const TriangleGeometry& t : surfaces_[m].triangles) {
        ids.push_back(
            {static_cast<int>(m), static_cast<std::int32_t>(&t - surfaces_[m].triangles.data())});
        items.push_back({&t, kTouchDepth * surfaces_[m].extent, -1});
      }
    }
    ForEachNearPair(items, [&](std::size_t i, std::size_t k) {
      const auto [first, second] = std::minmax(i, k);  // in the order of the meshes
      LookAt(ids[first], *items[first].triangle, ids[second], *items[second].triangle);
    });
    std::vector<MeshContact> contacts;
    for (const auto& [pair, contact] : contacts_) {
      contacts.push_back(contact);
    }
    return contacts;
  }

 private:
  [[nodiscard]] const Surface& Of(TriangleId id) const {
    return surfaces_[static_cast<std::size_t>(id.mesh)];
  }
  [[nodiscard]] const TriangleGeometry& Geometry(TriangleId id) const {
    return Of(id).triangles[static_cast<std::size_t>(id.triangle)];
  }
  [[nodiscard]] std::size_t PartOf(TriangleId id) const {
    return Of(id).PartOf(static_cast<std::size_t>(id.triangle));
  }

  /// Most pairs are neighbours, and need no more than this.
  void LookAt(TriangleId a,
              const TriangleGeometry& of_a,
              TriangleId b,
              const TriangleGeometry& of_b) {
    const double slack = kTouchDepth * std::max(Of(a).extent, Of(b).extent);
    const double depth = kTouchDepth * std::min(Of(a).extent, Of(b).extent);
    const auto [open_a, in_plane_of_b] = OpenSides(HeightsOver(of_b, of_a), slack, depth);
    if (open_a == 0) {
      return;
    }
    const auto [open_b, in_plane_of_a] = OpenSides(HeightsOver(of_a, of_b), slack, depth);
    if (open_b == 0) {
      return;
    }
    const bool in_plane = in_plane_of_a && in_plane_of_b;
    const std::array<unsigned, 2> joints = CommonSides(a, b);
    const std::array<unsigned, 2> open = {open_a & ~joints[0], open_b & ~joints[1]};
    if (in_plane || (open[0] | open[1]) != 0) {
      LookCloser({a, b}, open, in_plane, slack, depth);
    }
  }

  /// The sides of a triangle, as bits, that come near a plane over which its corners have these
  /// heights, and whether all of it lies in that plane.
  static std::pair<unsigned, bool> OpenSides(const Vec3& heights, double slack, double depth) {
    const auto bits = [](bool x, bool y, bool z) {
      return static_cast<unsigned>(x) | static_cast<unsigned>(y) << 1U |
             static_cast<unsigned>(z) << 2U;
    };
    const auto ends = [](unsigned corners) {  // of sides that both end at such corners
      return corners & (corners >> 1U | corners << 2U);
    };
    const Vec3& h = heights;
    const unsigned above = bits(h.x > slack, h.y > slack, h.z > slack);
    const unsigned below = bits(h.x < -slack, h.y < -slack, h.z < -slack);
    const double farthest = std::max({std::abs(h.x), std::abs(h.y), std::abs(h.z)});
    return {0b111U & ~(ends(above) | ends(below)), farthest < depth};
  }

  /// At the open sides of either of two triangles.
  void LookCloser(const std::array<TriangleId, 2>& ids,
                  const std::array<unsigned, 2>& open,
                  bool in_plane,
                  double slack,
                  double depth) {
    const auto [a, b] = ids;
    const std::array<const TriangleGeometry*, 2> triangles = {&Geometry(a), &Geometry(b)};
    MeshContact found{a.mesh, b.mesh};
    bool touch = false;
    for (std::size_t k = 0; k < 2; ++k) {
      const TriangleGeometry& other = *triangles[1 - k];
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = (i + 1) % 3;
        if ((open[k] >> i & 1U) == 0) {
          continue;
        }
        const std::array<Vec3, 3> corners = triangles[k]->Corners();
        SegmentPart near;
        if (AreApart(corners[i], corners[next], other, 3.0 * slack)) {
          continue;  // KeepNear, which costs more, goes a little farther at corners
        }
        near.KeepNear(other, corners[i], corners[next], slack);
        if (near.IsEmpty()) {
          continue;
        }
        const bool joined = a.mesh == b.mesh && PartOf(a) == PartOf(b);
        const double length = TouchedLength(corners[i], corners[next], near, ids[k], ids[1 - k]);
        found.cut = found.cut || Pierces(corners[i], corners[next], depth, other);
        touch = touch || (!joined && length >= 0.0);
        found.folded = found.folded || (joined && length > kAlong * depth && !IsBorder(ids[k], i));
      }
    }
    found.overlap = in_plane && Cover(*triangles[0], *triangles[1], depth) && AreSeen(a, b);
    if (touch || found.cut || found.overlap || found.folded) {
      MeshContact& all = contacts_.try_emplace({a.mesh, b.mesh}, found).first->second;
      all.cut = all.cut || found.cut;
      all.overlap = all.overlap || found.overlap;
      all.folded = all.folded || found.folded;
    }
  }

  /// Whether an eye is before one of the two sides of triangles in one plane that no body hides.
  [[nodiscard]] bool AreSeen(TriangleId a, TriangleId b) {
    const Vec3& n = Geometry(a).n;
    std::array<bool, 2> is_hidden{};  // where n comes from, and where it points
    for (const TriangleId id : {a, b}) {
      const double volume = Of(id).volumes[PartOf(id)];
      if (volume != 0.0 && !HoldsEye(id)) {
        is_hidden[volume * Dot(n, Geometry(id).n) < 0.0 ? 1 : 0] = true;
      }
    }
    return std::any_of(eyes_.begin(), eyes_.end(), [&](const Eye& eye) {
      return !is_hidden[Dot(n, eye.at - Geometry(a).p0 * eye.w) > 0.0 ? 1 : 0];
    });
  }

  /// Whether one is inside the triangle's part, which is closed.
  [[nodiscard]] bool HoldsEye(TriangleId id) {
    Surface& surface = surfaces_[static_cast<std::size_t>(id.mesh)];
    std::optional<bool>& known = surface.holds_eye[PartOf(id)];
    if (!known.has_value()) {
      known = std::any_of(eyes_.begin(), eyes_.end(), [&](const Eye& eye) {
        return eye.w != 0.0 && Norm(eye.at - surface.middle) < surface.extent &&
               std::abs(surface.AngleSeen(PartOf(id), eye.at)) > 2.0 * std::numbers::pi;
      });
    }
    return *known;
  }

  /// Of each of two triangles, as bits: the sides that end at a corner of the other one.
  [[nodiscard]] std::array<unsigned, 2> CommonSides(TriangleId a, TriangleId b) const {
    std::array<unsigned, 2> sides{};
    if (a.mesh == b.mesh) {
      const Triangle& t = Of(a).mesh.triangles[static_cast<std::size_t>(a.triangle)];
      const Triangle& u = Of(b).mesh.triangles[static_cast<std::size_t>(b.triangle)];
      constexpr std::array<unsigned, 3> kAtCorner = {5, 3, 6};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          const unsigned common = t[i] == u[k] ? ~0U : 0U;
          sides[0] |= common & kAtCorner[i];
          sides[1] |= common & kAtCorner[k];
        }
      }
    }
    return sides;
  }

  /// Whether no other triangle shares a triangle's side from its corner `corner` on.
  [[nodiscard]] bool IsBorder(TriangleId id, std::size_t corner) const {
    return (Of(id).borders[static_cast<std::size_t>(id.triangle)] >> corner & 1U) != 0;
  }

  /// Of what touches a triangle in the part of an edge that is near it; -1: nothing does.
  [[nodiscard]] double TouchedLength(
      const Vec3& p, const Vec3& q, SegmentPart near, TriangleId of_edge, TriangleId id) const {
    const Surface& a = Of(of_edge);
    const Surface& b = Of(id);
    // As near as rays can tell from there.
    const Vec3 x = p + (q - p) * (0.5 * (near.begin + near.end));
    const double offset = RayCaster::kRayOffset * std::max(Norm(x - a.middle), Norm(x - b.middle));
    near.KeepNear(Geometry(id), p, q, std::max(kTouchDepth * std::min(a.extent, b.extent), offset));
    return near.IsEmpty() ? -1.0 : Norm(q - p) * (near.end - near.begin);
  }

  const std::vector<Eye>& eyes_;
  std::vector<Surface> surfaces_;
  std::map<std::pair<int, int>, MeshContact> contacts_;
};

}  // namespace

std::vector<MeshContact> MeshContacts(const std::vector<const Mesh*>& meshes,
                                      const std::vector<Eye>& eyes) {
  return ContactSearch(meshes, eyes).Run();
}

}  // namespace pathfit::renderer
