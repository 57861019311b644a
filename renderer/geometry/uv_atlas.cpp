#include "renderer/geometry/uv_atlas.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#define STBRP_STATIC
#define STB_RECT_PACK_IMPLEMENTATION
#include <stb/stb_rect_pack.h>

#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/uv_charts.h"

namespace pathfit::renderer {
namespace {

constexpr double kGrowth = 1.04;  // of the picture's side, until all fits
constexpr int kStep = 4;          // sizes are multiples of it

struct PlacedChart {
  std::size_t mesh = 0;
  UvChart chart;
  double density = 0.0;  ///< texels per metre
  int x = 0, y = 0;      ///< of the rectangle's corner
};

int RoundUp(double size) { return kStep * static_cast<int>(std::ceil(size / kStep)); }

/// Places the charts in a square of this side; its used height, or nothing if they do not fit.
std::optional<int> Pack(int side, double scale, std::vector<PlacedChart>& charts) {
  std::vector<stbrp_rect> rects;
  for (std::size_t i = 0; i < charts.size(); ++i) {
    // One texel more than the chart is long: its ends are at centres of texels.
    const auto length = [&](double metres) {
      return static_cast<int>(std::ceil(metres * charts[i].density * scale)) + 1 + 2 * kAtlasGutter;
    };
    stbrp_rect& rect = rects.emplace_back();
    rect.id = static_cast<int>(i);
    rect.w = length(charts[i].chart.size.x);
    rect.h = length(charts[i].chart.size.y);
    if (rect.w > side || rect.h > side) return std::nullopt;
  }
  std::vector<stbrp_node> nodes(static_cast<std::size_t>(side));
  stbrp_context context;
  stbrp_init_target(&context, side, side, nodes.data(), side);
  if (stbrp_pack_rects(&context, rects.data(), static_cast<int>(rects.size())) == 0) {
    return std::nullopt;
  }
  int height = 0;
  for (const stbrp_rect& rect : rects) {
    PlacedChart& placed = charts[static_cast<std::size_t>(rect.id)];
    placed.x = rect.x;
    placed.y = rect.y;
    height = std::max(height, rect.y + rect.h);
  }
  return height;
}

double DensityOf(const UvChart& chart, const Mesh& mesh, const std::vector<double>& of_triangle) {
  double sum = 0.0;
  double area = 0.0;
  for (const std::int32_t f : chart.triangles) {
    const double own = Norm(TwiceArea(mesh, mesh.triangles[Index(f)]));
    sum += own * of_triangle[Index(f)] * of_triangle[Index(f)];
    area += own;
  }
  return std::sqrt(sum / area);
}

void WriteUvs(const std::vector<PlacedChart>& charts,
              const UvAtlas& atlas,
              std::span<Mesh* const> meshes) {
  std::vector<std::vector<Vec2>> uvs(meshes.size());
  std::vector<std::vector<Triangle>> triangles;
  for (const Mesh* mesh : meshes) triangles.emplace_back(mesh->triangles.size());
  for (const PlacedChart& placed : charts) {
    const Mesh& mesh = *meshes[placed.mesh];
    std::map<std::int32_t, std::int32_t> uv_of_position;
    for (std::size_t i = 0; i < placed.chart.triangles.size(); ++i) {
      const std::size_t f = Index(placed.chart.triangles[i]);
      for (std::size_t k = 0; k < 3; ++k) {
        std::vector<Vec2>& list = uvs[placed.mesh];
        const auto [at, is_new] = uv_of_position.emplace(std::as_const(mesh).triangles[f][k],
                                                         static_cast<std::int32_t>(list.size()));
        triangles[placed.mesh][f][k] = at->second;
        if (!is_new) continue;
        // Rows are counted from the top, the chart's y from the bottom.
        const Vec2 corner = placed.chart.corners[i][k];
        const Vec2 texel =
            Vec2{corner.x, placed.chart.size.y - corner.y} * (placed.density * atlas.scale) +
            Vec2{placed.x + kAtlasGutter + 0.5, placed.y + kAtlasGutter + 0.5};
        list.push_back({texel.x / atlas.width, 1.0 - texel.y / atlas.height});
      }
    }
  }
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    meshes[m]->uvs = std::move(uvs[m]);
    meshes[m]->uv_triangles = std::move(triangles[m]);
  }
}

}  // namespace

UvAtlas MakeUvAtlas(std::span<Mesh* const> meshes,
                    std::span<const std::vector<double>> texels_per_metre,
                    const UvAtlasOptions& options) {
  PATHFIT_CHECK_EQ(meshes.size(), texels_per_metre.size());
  std::vector<PlacedChart> charts;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    PATHFIT_CHECK_EQ(meshes[m]->triangles.size(), texels_per_metre[m].size());
    for (UvChart& chart : MakeUvCharts(*meshes[m])) {
      PlacedChart& placed = charts.emplace_back();
      placed.mesh = m;
      placed.density = DensityOf(chart, *meshes[m], texels_per_metre[m]);
      placed.chart = std::move(chart);
    }
  }
  UvAtlas atlas;
  atlas.charts = static_cast<int>(charts.size());
  for (;;) {
    double area = 0.0;
    for (const PlacedChart& placed : charts) {
      const double frame = 1.0 + 2.0 * kAtlasGutter;
      const double scale = placed.density * atlas.scale;
      area += (placed.chart.size.x * scale + frame) * (placed.chart.size.y * scale + frame);
    }
    std::optional<int> height;
    int side = std::min(options.max_side, RoundUp(std::sqrt(area)));
    for (;; side = std::min(options.max_side, RoundUp(kGrowth * side))) {
      height = Pack(side, atlas.scale, charts);
      if (height || side == options.max_side) break;
    }
    if (height) {
      atlas.width = side;
      atlas.height = RoundUp(*height);
      break;
    }
    atlas.scale *= 0.9;
    if (atlas.scale < 1e-6) {
      throw SceneError(std::to_string(charts.size()) + " pieces of surface do not fit into " +
                       std::to_string(options.max_side) + " x " + std::to_string(options.max_side) +
                       " texels");
    }
  }
  WriteUvs(charts, atlas, meshes);
  return atlas;
}

}  // namespace pathfit::renderer
