#include "renderer/geometry/texel_places.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/uv_overlap.h"

namespace pathfit::renderer {
namespace {

/// Where a point of a plane is nearest to a triangle.
struct FlatPoint {
  std::array<double, 3> weights{};
  double distance = 0.0;
};

FlatPoint NearestOn(const FlatTriangle& t, const Vec2& x) {
  const double area = TwiceArea(t);
  if (area != 0.0) {
    const double w1 = TwiceArea({t[0], x, t[2]}) / area;
    const double w2 = TwiceArea({t[0], t[1], x}) / area;
    if (w1 >= 0.0 && w2 >= 0.0 && w1 + w2 <= 1.0) return {{1.0 - w1 - w2, w1, w2}, 0.0};
  }
  FlatPoint best{{}, 1e300};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2& a = t[k];
    const Vec2 along = t[(k + 1) % 3] - a;
    const double square = along.x * along.x + along.y * along.y;
    const double at =
        square > 0.0
            ? std::clamp(((x.x - a.x) * along.x + (x.y - a.y) * along.y) / square, 0.0, 1.0)
            : 0.0;
    const Vec2 away = x - a - along * at;
    const double distance = std::hypot(away.x, away.y);
    if (distance >= best.distance) continue;
    best = {{}, distance};
    best.weights[k] = 1.0 - at;
    best.weights[(k + 1) % 3] = at;
  }
  return best;
}

/// In texels: x to the right, y downwards, centres at halves.
Vec2 TexelOf(const Vec2& uv, int width, int height) {
  return {uv.x * width, (1.0 - uv.y) * height};
}

}  // namespace

std::vector<TexelPlace> PlaceTexels(std::span<const Mesh* const> meshes,
                                    int width,
                                    int height,
                                    double reach) {
  std::vector<TexelPlace> places(static_cast<std::size_t>(width) *
                                 static_cast<std::size_t>(height));
  std::int32_t first_chart = 0;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const Mesh& mesh = *meshes[m];
    DisjointSets charts(mesh.uvs.size());
    for (const Triangle& t : mesh.uv_triangles) {
      charts.Unite(Index(t[0]), Index(t[1]));
      charts.Unite(Index(t[0]), Index(t[2]));
    }
    for (std::size_t f = 0; f < mesh.uv_triangles.size(); ++f) {
      const Triangle& t = mesh.uv_triangles[f];
      FlatTriangle flat;
      for (std::size_t k = 0; k < 3; ++k) flat[k] = TexelOf(mesh.uvs[Index(t[k])], width, height);
      const auto chart = first_chart + static_cast<std::int32_t>(charts.Find(Index(t[0])));
      const auto [x0, x1] = std::minmax({flat[0].x, flat[1].x, flat[2].x});
      const auto [y0, y1] = std::minmax({flat[0].y, flat[1].y, flat[2].y});
      const auto first = [reach](double at) {
        return std::max(0, static_cast<int>(std::ceil(at - reach - 0.5)));
      };
      const auto last = [reach](double at, int count) {
        return std::min(count - 1, static_cast<int>(std::floor(at + reach - 0.5)));
      };
      for (int y = first(y0); y <= last(y1, height); ++y) {
        for (int x = first(x0); x <= last(x1, width); ++x) {
          TexelPlace& place = places[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                     static_cast<std::size_t>(x)];
          const FlatPoint near = NearestOn(flat, {x + 0.5, y + 0.5});
          if (near.distance > reach || (place.mesh >= 0 && place.distance <= near.distance)) {
            continue;
          }
          place = {static_cast<std::int32_t>(m),
                   static_cast<std::int32_t>(f),
                   chart,
                   near.weights,
                   near.distance};
        }
      }
    }
    first_chart += static_cast<std::int32_t>(mesh.uvs.size());
  }
  return places;
}

std::vector<SeamPoint> SampleSeams(std::span<const Mesh* const> meshes, int width, int height) {
  std::vector<SeamPoint> points;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const Mesh& mesh = *meshes[m];
    ForEachEdge(SortedSides(mesh), [&](auto first, auto last) {
      if (last - first != 2) return;
      // UV of the end of a side that is at a position.
      const auto uv_at = [&](const MeshSide& side, std::int32_t position) {
        const std::size_t f = side.Face();
        const std::size_t corner =
            mesh.triangles[f][side.side % 3] == position ? side.side % 3 : (side.side + 1) % 3;
        return mesh.uv_triangles[f][corner];
      };
      const MeshSide& one = *first;
      const MeshSide& two = *(first + 1);
      const std::int32_t from = one.From(mesh);
      const std::int32_t to = one.To(mesh);
      const std::array<Vec2, 2> a = {mesh.uvs[Index(uv_at(one, from))],
                                     mesh.uvs[Index(uv_at(two, from))]};
      const std::array<Vec2, 2> b = {mesh.uvs[Index(uv_at(one, to))],
                                     mesh.uvs[Index(uv_at(two, to))]};
      if (a[0] == a[1] && b[0] == b[1]) return;
      double texels = 1.0;
      for (std::size_t side = 0; side < 2; ++side) {
        const Vec2 along = TexelOf(b[side], width, height) - TexelOf(a[side], width, height);
        texels = std::max(texels, std::hypot(along.x, along.y));
      }
      const int count = static_cast<int>(std::ceil(texels));
      const double length = Norm(mesh.positions[Index(to)] - mesh.positions[Index(from)]);
      for (int i = 0; i < count; ++i) {
        const double at = (i + 0.5) / count;
        SeamPoint& point = points.emplace_back();
        point.mesh = static_cast<std::int32_t>(m);
        point.length = length / count;
        for (std::size_t side = 0; side < 2; ++side) {
          point.uv[side] = a[side] * (1.0 - at) + b[side] * at;
        }
      }
    });
  }
  return points;
}

}  // namespace pathfit::renderer
