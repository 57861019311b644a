#include "renderer/io/vertex_colors.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

namespace pathfit::renderer {

void WeldColors(Mesh& mesh) {
  // A position and the colour a triangle sees there.
  using Corner = std::tuple<std::int32_t, double, double, double>;
  const auto corner = [&mesh](std::size_t f, std::size_t k) {
    const Rgb& color = mesh.colors[static_cast<std::size_t>(mesh.color_triangles[f][k])];
    return Corner(mesh.triangles[f][k], color.r, color.g, color.b);
  };
  std::vector<Corner> distinct;
  distinct.reserve(mesh.color_triangles.size() * 3);
  for (std::size_t f = 0; f < mesh.color_triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) distinct.push_back(corner(f, k));
  }
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  for (std::size_t f = 0; f < mesh.color_triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto place = std::lower_bound(distinct.begin(), distinct.end(), corner(f, k));
      mesh.color_triangles[f][k] = static_cast<std::int32_t>(place - distinct.begin());
    }
  }
  // The old colours were needed until here by corner().
  std::vector<Rgb> colors;
  colors.reserve(distinct.size());
  for (const auto& [position, r, g, b] : distinct) colors.push_back({r, g, b});
  mesh.colors = std::move(colors);
}

}  // namespace pathfit::renderer
