#include "renderer/geometry/uv_overlap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "renderer/geometry/mesh_checks.h"

namespace pathfit::renderer {
namespace {

constexpr double kTolerance = 1e-9;   // of the plane's size
constexpr double kMostShared = 0.01;  // of what separate UVs cover
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

/// Of the part of `a` inside `b`, both counter-clockwise: cut by one side of `b` after the other
/// [Sutherland and Hodgman 1974].
double CommonArea(const FlatTriangle& a, const FlatTriangle& b) {
  std::vector<Vec2> part(a.begin(), a.end());
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2& from = b[i];
    const Vec2& to = b[(i + 1) % 3];
    std::vector<Vec2> inside;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const Vec2& p = part[k];
      const Vec2& q = part[(k + 1) % part.size()];
      const double of_p = TwiceArea({from, to, p});
      const double of_q = TwiceArea({from, to, q});
      if (of_p >= 0.0) inside.push_back(p);
      if (of_p * of_q < 0.0) inside.push_back(p + (q - p) * (of_p / (of_p - of_q)));
    }
    part = std::move(inside);
  }
  double twice = 0.0;
  for (std::size_t k = 2; k < part.size(); ++k) twice += TwiceArea({part[0], part[k - 1], part[k]});
  return 0.5 * twice;
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

template <class Visit>
bool FlatTriangles::VisitMet(const FlatTriangle& triangle, Visit visit) const {
  const Cells cells = CellsOf(triangle);
  for (std::size_t y = cells.y0; y <= cells.y1; ++y) {
    for (std::size_t x = cells.x0; x <= cells.x1; ++x) {
      for (const std::int32_t i : cells_[y * width_ + x]) {
        const FlatTriangle& other = triangles_[Index(i)];
        if (!HasSeparatingSide(triangle, other, tolerance_) &&
            !HasSeparatingSide(other, triangle, tolerance_) && visit(i)) {
          return true;
        }
      }
    }
  }
  return false;
}

bool FlatTriangles::Meets(const FlatTriangle& triangle) const {
  return VisitMet(triangle, [](std::int32_t) { return true; });
}

double FlatTriangles::SharedArea(const FlatTriangle& triangle) const {
  std::vector<std::int32_t> met;
  VisitMet(triangle, [&](std::int32_t i) {
    met.push_back(i);
    return false;
  });
  std::ranges::sort(met);
  met.erase(std::unique(met.begin(), met.end()), met.end());
  double area = 0.0;
  for (const std::int32_t i : met) area += CommonArea(triangle, triangles_[Index(i)]);
  return area;
}

void FlatTriangles::Add(const FlatTriangle& triangle) {
  const auto index = static_cast<std::int32_t>(triangles_.size());
  triangles_.push_back(triangle);
  const Cells cells = CellsOf(triangle);
  for (std::size_t y = cells.y0; y <= cells.y1; ++y) {
    for (std::size_t x = cells.x0; x <= cells.x1; ++x) cells_[y * width_ + x].push_back(index);
  }
}

bool HaveUvsInPicture(std::span<const Mesh* const> meshes) {
  return std::ranges::all_of(meshes, [](const Mesh* mesh) {
    const auto is_inside = [&](std::int32_t corner) {
      const Vec2& uv = mesh->uvs[Index(corner)];
      return uv.x >= 0.0 && uv.x <= 1.0 && uv.y >= 0.0 && uv.y <= 1.0;
    };
    return !mesh->uv_triangles.empty() &&
           std::ranges::all_of(mesh->uv_triangles, [&](const Triangle& t) {
             return std::ranges::all_of(t, is_inside);
           });
  });
}

bool HaveSeparateUvs(std::span<const Mesh* const> meshes) {
  if (!HaveUvsInPicture(meshes)) return false;
  std::vector<FlatTriangle> triangles;
  double covered = 0.0;
  for (const Mesh* mesh : meshes) {
    for (const Triangle& t : mesh->uv_triangles) {
      FlatTriangle& flat = triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) flat[k] = mesh->uvs[Index(t[k])];
      if (TwiceArea(flat) < 0.0) std::swap(flat[1], flat[2]);  // mirrored halves are fine
      covered += 0.5 * TwiceArea(flat);
    }
  }
  FlatTriangles placed({0.0, 0.0}, {1.0, 1.0}, triangles.size());
  double shared = 0.0;
  for (const FlatTriangle& flat : triangles) {
    shared += placed.SharedArea(flat);
    if (shared > kMostShared * covered) return false;
    placed.Add(flat);
  }
  return covered > 0.0;
}

}  // namespace pathfit::renderer
