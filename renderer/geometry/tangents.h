#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Frame of a normal map at a corner: u runs along `along_u` (unit, at right angles to the normal),
/// v along sign * cross(normal, along_u).
struct Tangent {
  Vec3 along_u{1.0, 0.0, 0.0};
  double sign = 1.0;  ///< 1 or -1
};

/// By triangle and corner: the mean of the directions of u in the triangles that share position,
/// normal and UV, weighted by their angles there, as MikkTSpace has it. Precondition: the mesh has
/// normals and UVs.
class TangentField {
 public:
  TangentField() = default;
  explicit TangentField(const Mesh& mesh);

  /// Anew for a mesh of the same lists of triangles, whose positions, normals or UVs are others.
  void Update(const Mesh& mesh);

  [[nodiscard]] bool empty() const { return tangents_.empty(); }
  [[nodiscard]] const std::vector<std::array<Tangent, 3>>& Items() const { return tangents_; }
  [[nodiscard]] const std::array<Tangent, 3>& operator[](std::int32_t triangle) const {
    return tangents_[static_cast<std::size_t>(triangle)];
  }

  /// Moves the adjoint of a corner's along_u to what it is made of: calls add_position(index, d)
  /// and add_normal(index, d) with indices into the mesh's lists. G: Vec3 or ColorGradient.
  template <class G, class AddPosition, class AddNormal>
  void Pull(const Mesh& mesh,
            std::int32_t triangle,
            std::size_t corner,
            const G& d_along_u,
            const AddPosition& add_position,
            const AddNormal& add_normal) const;

 private:
  /// What a triangle adds at one of its corners.
  struct Part {
    std::array<double, 3> by_corner{};  ///< derivative of the direction of u by the positions
    Vec3 along_u;                       ///< of the triangle, not unit
    Vec3 n;                             ///< unit normal of the corner
    double normal_length = 0.0;
    Vec3 in_plane;  ///< of along_u, at right angles to n; unit
    double length = 0.0;
    Vec3 next, previous;  ///< edges from the corner
    double angle = 0.0;
    double sign = 0.0;
    [[nodiscard]] bool Counts() const { return length > 0.0; }
  };
  static Part PartOf(const Mesh& mesh, std::size_t triangle, std::size_t corner);

  std::vector<std::array<Tangent, 3>> tangents_;
  std::vector<std::array<std::int32_t, 3>> group_;  ///< of corners that share one tangent
  std::vector<std::size_t> first_;                  ///< of a group's corners in `corners_`
  std::vector<std::size_t> corners_;                ///< 3 * triangle + corner
  std::vector<double> length_;                      ///< of a group's sum; 0: none
};

/// TangentField's values.
std::vector<std::array<Tangent, 3>> MakeTangents(const Mesh& mesh);

/// Normal and tangent frame inside a triangle: rows u, v, normal, each unit.
struct ShadingFrame {
  Vec3 u, v, normal;
};
ShadingFrame InterpolateFrame(const Mesh& mesh,
                              std::int32_t triangle,
                              const std::array<Tangent, 3>& tangents,
                              const std::array<double, 3>& weights);

template <class G, class AddPosition, class AddNormal>
void TangentField::Pull(const Mesh& mesh,
                        std::int32_t triangle,
                        std::size_t corner,
                        const G& d_along_u,
                        const AddPosition& add_position,
                        const AddNormal& add_normal) const {
  const auto f = static_cast<std::size_t>(triangle);
  const auto group = static_cast<std::size_t>(group_[f][corner]);
  if (!(length_[group] > 0.0)) return;
  const auto across = [](const Vec3& unit, const G& d, double norm) {
    return (d - Outer(unit, Dot(unit, d))) * (1.0 / norm);
  };
  const G d_sum = across(tangents_[f][corner].along_u, d_along_u, length_[group]);
  for (std::size_t c = first_[group]; c < first_[group + 1]; ++c) {
    const std::size_t of = corners_[c] / 3, k = corners_[c] % 3;
    const Part part = PartOf(mesh, of, k);
    if (!part.Counts()) continue;
    const G d_in_plane = across(part.in_plane, d_sum, part.length) * part.angle;
    const auto along_n = Dot(part.n, d_in_plane);
    const G d_edge = d_in_plane - Outer(part.n, along_n);
    const G d_n = -(d_in_plane * Dot(part.n, part.along_u) + Outer(part.along_u, along_n));
    add_normal(mesh.normal_triangles[of][k], across(part.n, d_n, part.normal_length));
    // The angle, by the corners before and behind.
    const auto d_angle = Dot(part.in_plane, d_sum);
    const double next = Norm(part.next), previous = Norm(part.previous);
    const Vec3 to_next = part.next / next, to_previous = part.previous / previous;
    const double cosine = Dot(to_next, to_previous);
    const double sine = Norm(Cross(to_next, to_previous));
    const G by_next = Outer((to_next * cosine - to_previous) / (next * sine), d_angle);
    const G by_previous = Outer((to_previous * cosine - to_next) / (previous * sine), d_angle);
    std::array<G, 3> d_x{};
    d_x[(k + 1) % 3] = by_next;
    d_x[(k + 2) % 3] = by_previous;
    d_x[k] = -(by_next + by_previous);
    for (std::size_t i = 0; i < 3; ++i) {
      add_position(mesh.triangles[of][i], d_x[i] + d_edge * part.by_corner[i]);
    }
  }
}

}  // namespace pathfit::renderer
