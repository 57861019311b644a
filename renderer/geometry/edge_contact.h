#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/ray_caster.h"

namespace pathfit::renderer {

/// Surfaces nearer to an edge than so many offsets of rays touch it.
inline constexpr double kTouch = 2.0;

/// The triangles at a point of an edge, which a line past it does not meet: the edge's own faces,
/// and what touches it. Valid as long as the contacts it is from.
class FacesAtEdge {
 public:
  FacesAtEdge() = default;
  /// `all`: own faces and what touches; empty if nothing does.
  FacesAtEdge(const std::array<TriangleId, 2>& own, std::span<const TriangleId> all)
      : own_(own), all_(all) {}

  [[nodiscard]] std::span<const TriangleId> All() const { return all_.empty() ? own_ : all_; }
  [[nodiscard]] std::span<const TriangleId> Touching() const {
    return all_.subspan(std::min(own_.size(), all_.size()));
  }

 private:
  std::array<TriangleId, 2> own_;
  std::span<const TriangleId> all_;
};

/// What runs along the edges of a scene: for each stretch of an edge the triangles that touch it,
/// of other meshes, of other parts of its own mesh (which edges join), and at a border of its own
/// part. What an edge meets in a point only is none of them. There may be any number.
class EdgeContacts {
 public:
  /// Of the caster's meshes. The topologies must outlive it.
  EdgeContacts(const RayCaster& caster,
               const std::vector<Mesh>& meshes,
               const std::vector<MeshTopology>& topologies);

  /// At the share t of the way along an edge of a mesh; touching triangles in ascending order.
  [[nodiscard]] FacesAtEdge At(int mesh, std::int32_t edge, double t) const;

 private:
  /// From the end of the one before.
  struct Stretch {
    double end;
    std::size_t first, count;  // into faces_
  };
  struct Range {
    std::size_t first = 0, count = 0;  // into stretches_
  };
  struct Touch;
  /// Of one edge.
  void AddStretches(std::span<const Touch> touches);

  const std::vector<MeshTopology>& topologies_;
  std::vector<std::vector<Range>> edges_;  // by mesh and edge; empty: nothing touches the mesh
  std::vector<Stretch> stretches_;
  std::vector<TriangleId> faces_;
};

/// How fast a triangle falls away in `direction` with the distance from the plane with this normal,
/// which holds `direction`, on the side to which the normal points; on the other side as fast the
/// other way. Empty: seen edge-on.
std::optional<double> SlopeBeside(const TriangleGeometry& triangle,
                                  const Vec3& direction,
                                  const Vec3& normal);

/// The side of a triangle, named by the corner from which it starts, along which the triangle ends
/// at the point x of an edge with unit direction `along`; -1 if it goes on beyond the edge: x lies
/// inside, or its side runs across the edge, where neighbours go on.
int BorderAlong(const TriangleGeometry& triangle,
                const Vec3& x,
                const Vec3& along,
                const RayCaster& caster);
/// The corner across from that side.
Vec3 ApexOf(const TriangleGeometry& triangle, int border);

/// A hit with the barycentrics of a point that lies on the triangle but for rounding.
Hit HitInside(TriangleId id, const PlaneHit& hit);

}  // namespace pathfit::renderer
