#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

using FlatTriangle = std::array<Vec2, 3>;

/// Twice the area, positive if counter-clockwise.
inline double TwiceArea(const FlatTriangle& t) {
  return (t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[1].y - t[0].y) * (t[2].x - t[0].x);
}

/// Triangles of a plane, to be asked whether another one lies over one of them.
class FlatTriangles {
 public:
  /// `low`, `high`: around all that will be added; `count`: about how many.
  FlatTriangles(const Vec2& low, const Vec2& high, std::size_t count);

  /// All triangles are counter-clockwise.
  void Add(const FlatTriangle& triangle);
  /// Whether the interiors of the triangle and of one that was added have points in common: by more
  /// than rounding, so that triangles that touch along sides or in corners do not.
  [[nodiscard]] bool Meets(const FlatTriangle& triangle) const;
  /// Area that the triangle has in common with those that were added, each by itself.
  [[nodiscard]] double SharedArea(const FlatTriangle& triangle) const;

 private:
  struct Cells {
    std::size_t x0, y0, x1, y1;
  };
  [[nodiscard]] Cells CellsOf(const FlatTriangle& triangle) const;
  /// Calls visit(index) for those added whose interiors have points in common with the triangle's,
  /// some more than once, until it returns true; whether it did.
  template <class Visit>
  bool VisitMet(const FlatTriangle& triangle, Visit visit) const;

  Vec2 low_;
  std::size_t width_ = 1, height_ = 1;
  double per_x_ = 0.0, per_y_ = 0.0;  ///< cells per unit
  double tolerance_ = 0.0;
  std::vector<FlatTriangle> triangles_;
  std::vector<std::vector<std::int32_t>> cells_;
};

/// Whether all meshes have UVs, all in the unit square.
bool HaveUvsInPicture(std::span<const Mesh* const> meshes);
/// Whether each point of a picture belongs to one point of the surfaces at most: UVs are in the
/// picture, of triangles that do not lie over each other by more than slips of whoever laid them
/// out (a hundredth of what they cover).
bool HaveSeparateUvs(std::span<const Mesh* const> meshes);

}  // namespace pathfit::renderer
