#include "optim/problem/split_half_cost.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

/// Of pixel p; adds it to `costs`.
float AddPixel(const ViewLevel& level,
               const RowScales& scales,
               const renderer::Film& a,
               const renderer::Film& b,
               std::size_t p,
               ImageCosts& costs) {
  const auto r_a = PixelResidual(level, scales[p], a.pixels[p], p);
  const auto r_b = PixelResidual(level, scales[p], b.pixels[p], p);
  std::array<double, 4> product{};
  double noise = 0.0;
  for (std::size_t c = 0; c < 4; ++c) {
    const double u = 0.5 * (r_a[c] + r_b[c]);
    const double v = 0.5 * (r_a[c] - r_b[c]);
    product[c] = r_a[c] * r_b[c];
    costs.signal_squared += u * u;
    costs.noise_squared += v * v;
    noise += u * v;
    costs.num_colors += c < 3 && u != 0.0 ? 1.0 : 0.0;
  }
  const double colors = 0.5 * (product[0] + product[1] + product[2]);
  const double coverage = 0.5 * product[3];
  costs.colors += colors;
  costs.coverage += coverage;
  costs.variance += noise * noise;
  return static_cast<float>(colors + coverage);
}

}  // namespace

double UnexplainedResidual(const ImageCosts& costs, bool with_noise) {
  const double sum = 2.0 * std::max(0.0, costs.colors) + (with_noise ? costs.noise_squared : 0.0);
  return std::sqrt(sum / std::max(1.0, costs.num_colors));
}

std::vector<float> AddSplitHalfCosts(const ViewLevel& level,
                                     const RowScales& scales,
                                     const renderer::Film& a,
                                     const renderer::Film& b,
                                     ImageCosts& costs) {
  std::vector<float> pixel_costs(scales.size());
  const auto width = static_cast<std::size_t>(a.width);
  const std::vector<ImageCosts> lines =
      renderer::ParallelParts<ImageCosts>(a.height, [&](std::int64_t y, ImageCosts& line) {
        const std::size_t first = static_cast<std::size_t>(y) * width;
        for (std::size_t p = first; p < first + width; ++p) {
          pixel_costs[p] = AddPixel(level, scales, a, b, p, line);
        }
      });
  for (const ImageCosts& line : lines) costs.Add(line);
  return pixel_costs;
}

}  // namespace pathfit::optim
