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

  /// Whether the interiors of the triangle and of one that was added have points in common: by more
  /// than rounding, so that triangles that touch along sides or in corners do not.
  [[nodiscard]] bool Meets(const FlatTriangle& triangle) const;
  void Add(const FlatTriangle& triangle);

 private:
  struct Cells {
    std::size_t x0, y0, x1, y1;
  };
  [[nodiscard]] Cells CellsOf(const FlatTriangle& triangle) const;

  Vec2 low_;
  std::size_t width_ = 1, height_ = 1;
  double per_x_ = 0.0, per_y_ = 0.0;  ///< cells per unit
  double tolerance_ = 0.0;
  std::vector<FlatTriangle> triangles_;
  std::vector<std::vector<std::int32_t>> cells_;
};

/// Whether each point of a picture belongs to one point of the surfaces at most: all meshes have
/// UVs, all in the unit square, of triangles with an area that do not lie over each other.
bool HaveSeparateUvs(std::span<const Mesh* const> meshes);

}  // namespace pathfit::renderer
