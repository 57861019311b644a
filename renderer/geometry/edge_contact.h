#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/ray_caster.h"

namespace pathfit::renderer {

/// Surfaces nearer to an edge than so many offsets of rays touch it.
inline constexpr double kTouch = 2.0;

/// Which edges other surfaces may touch, by bounding boxes of the parts of meshes that edges join.
class ContactBounds {
 public:
  /// `topologies`: of the caster's meshes. The caster must outlive it.
  ContactBounds(const RayCaster& caster, const std::vector<MeshTopology>& topologies);
  /// Between the points a and b of an edge. Borders may meet their own part, too.
  [[nodiscard]] bool MayTouch(int mesh, const MeshEdge& edge, const Vec3& a, const Vec3& b) const;

  /// A mesh of more parts counts as one for others, and all its edges may touch.
  static constexpr std::int32_t kMostParts = 16;

 private:
  struct Part {
    int mesh;
    std::int32_t part;  // -1: all of the mesh
    RayCaster::Box box;
  };
  /// How far apart things may be that touch in the box, metres.
  [[nodiscard]] double Slack(const RayCaster::Box& box) const;
  [[nodiscard]] static bool Overlap(const RayCaster::Box& box,
                                    const RayCaster::Box& other,
                                    double slack);

  const RayCaster& caster_;
  const std::vector<MeshTopology>& topologies_;
  std::vector<std::vector<Part>> near_;  // by mesh: its own parts, unless it is one, and others'
  std::vector<bool> crowded_;            // by mesh: more than kMostParts
};

/// Triangles that touch a point of an edge, without those of its own part that share a corner with
/// it.
class TouchingFaces {
 public:
  TouchingFaces() = default;
  TouchingFaces(const RayCaster& caster,
                const Mesh& mesh,
                const MeshTopology& topology,
                int index,
                const MeshEdge& edge,
                const Vec3& x);

  [[nodiscard]] std::span<const TriangleId> faces() const { return {faces_.data(), count_}; }

  static constexpr std::size_t kMost = 32;

 private:
  std::array<TriangleId, kMost> faces_;
  std::size_t count_ = 0;
};

/// Triangles that a line past an edge does not meet: the edge's own faces, and what touches it.
class PassedFaces {
 public:
  PassedFaces(int mesh, const MeshEdge& edge, const TouchingFaces& touching) {
    for (const std::int32_t face : edge.faces) {
      Add({mesh, face});
    }
    for (const TriangleId id : touching.faces()) {
      Add(id);
    }
  }
  void Add(TriangleId id) { faces_[count_++] = id; }
  [[nodiscard]] bool IsFull() const { return count_ == faces_.size(); }
  [[nodiscard]] std::span<const TriangleId> All() const { return {faces_.data(), count_}; }

 private:
  // Where a mesh touches itself, triangles are added one by one.
  static constexpr std::size_t kMore = 6;
  std::array<TriangleId, 2 + TouchingFaces::kMost + kMore> faces_;
  std::size_t count_ = 0;
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
