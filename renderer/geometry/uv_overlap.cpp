#include "renderer/geometry/uv_overlap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "renderer/geometry/mesh_checks.h"

namespace pathfit::renderer {
namespace {

constexpr double kTolerance = 1e-9;  // of the plane's size
constexpr double kMostCells = 4e6;

/// Whether a side of `a` (counter-clockwise) has all of `b` beyond it, but for `tolerance`.
bool HasSeparatingSide(const FlatTriangle& a, const FlatTriangle& b, double tolerance) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 along = a[(i + 1) % 3] - a[i];
    const double length = std::hypot(along.x, along.y);
    if (length == 0.0) continue;
    double deepest = -1.0;
    for (const Vec2& p : b) {
      const Vec2 to = p - a[i];
      deepest = std::max(deepest, (along.x * to.y - along.y * to.x) / length);
    }
    if (deepest <= tolerance) return true;
  }
  return false;
}

}  // namespace

FlatTriangles::FlatTriangles(const Vec2& low, const Vec2& high, std::size_t count) : low_(low) {
  const Vec2 size = high - low;
  const double larger = std::max(size.x, size.y);
  tolerance_ = kTolerance * larger;
  if (larger <= 0.0) {
    cells_.resize(1);
    return;
  }
  // About one cell per triangle.
  const double cell =
      std::max(larger / std::sqrt(kMostCells),
               std::sqrt(std::max(size.x, 1e-3 * larger) * std::max(size.y, 1e-3 * larger) /
                         static_cast<double>(std::max<std::size_t>(1, count))));
  width_ = 1 + static_cast<std::size_t>(size.x / cell);
  height_ = 1 + static_cast<std::size_t>(size.y / cell);
  per_x_ = per_y_ = 1.0 / cell;
  cells_.resize(width_ * height_);
}

FlatTriangles::Cells FlatTriangles::CellsOf(const FlatTriangle& t) const {
  const auto index = [](double at, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count - 1)));
  };
  const auto [x0, x1] = std::minmax({t[0].x, t[1].x, t[2].x});
  const auto [y0, y1] = std::minmax({t[0].y, t[1].y, t[2].y});
  return {index((x0 - low_.x) * per_x_, width_),
          index((y0 - low_.y) * per_y_, height_),
          index((x1 - low_.x) * per_x_, width_),
          index((y1 - low_.y) * per_y_, height_)};
}

bool FlatTriangles::Meets(const FlatTriangle& triangle) const {
  const Cells cells = CellsOf(triangle);
  for (std::size_t y = cells.y0; y <= cells.y1; ++y) {
    for (std::size_t x = cells.x0; x <= cells.x1; ++x) {
      for (const std::int32_t i : cells_[y * width_ + x]) {
        const FlatTriangle& other = triangles_[Index(i)];
        if (!HasSeparatingSide(triangle, other, tolerance_) &&
            !HasSeparatingSide(other, triangle, tolerance_)) {
          return true;
        }
      }
    }
  }
  return false;
}

void FlatTriangles::Add(const FlatTriangle& triangle) {
  const auto index = static_cast<std::int32_t>(triangles_.size());
  triangles_.push_back(triangle);
  const Cells cells = CellsOf(triangle);
  for (std::size_t y = cells.y0; y <= cells.y1; ++y) {
    for (std::size_t x = cells.x0; x <= cells.x1; ++x) cells_[y * width_ + x].push_back(index);
  }
}

bool HaveSeparateUvs(std::span<const Mesh* const> meshes) {
  std::size_t count = 0;
  for (const Mesh* mesh : meshes) {
    if (mesh->uv_triangles.empty()) return false;
    count += mesh->uv_triangles.size();
  }
  FlatTriangles placed({0.0, 0.0}, {1.0, 1.0}, count);
  for (const Mesh* mesh : meshes) {
    for (const Triangle& t : mesh->uv_triangles) {
      FlatTriangle flat;
      for (std::size_t k = 0; k < 3; ++k) {
        flat[k] = mesh->uvs[Index(t[k])];
        const bool inside =
            flat[k].x >= 0.0 && flat[k].x <= 1.0 && flat[k].y >= 0.0 && flat[k].y <= 1.0;
        if (!inside) return false;
      }
      const double area = TwiceArea(flat);
      if (area == 0.0) return false;
      if (area < 0.0) std::swap(flat[1], flat[2]);  // mirrored halves are fine
      if (placed.Meets(flat)) return false;
      placed.Add(flat);
    }
  }
  return true;
}

}  // namespace pathfit::renderer
