#include "optim/observation/cushion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "optim/observation/voxel_surface.h"
#include "renderer/core/error.h"
#include "renderer/io/color_segmentation.h"
#include "renderer/io/image_filter.h"

namespace pathfit::optim {
namespace {

using renderer::Image;

constexpr int kNodes = 64;       // along the longer side of the mask's box
constexpr int kMargin = 3;       // nodes around it
constexpr int kSweeps = 600;     // of successive over-relaxation
constexpr double kInset = 0.25;  // of the spacing: where parts that touch are cut

/// Distances at the nodes of a plane, in nodes: of the mask's border, positive inside.
struct Plane {
  int width = 0, height = 0;
  std::vector<double> values;

  [[nodiscard]] std::size_t Offset(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// Between the centres of an image's pixels.
double Interpolate(const Image& image, double x, double y) {
  x = std::clamp(x, 0.0, image.width - 1.0);
  y = std::clamp(y, 0.0, image.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), std::max(0, image.width - 2));
  const int y0 = std::min(static_cast<int>(y), std::max(0, image.height - 2));
  const int x1 = std::min(x0 + 1, image.width - 1);
  const int y1 = std::min(y0 + 1, image.height - 1);
  const auto at = [&](int i, int j) { return static_cast<double>(image.At(i, j, 0)); };
  const double u = x - x0, v = y - y0;
  return (1.0 - v) * ((1.0 - u) * at(x0, y0) + u * at(x1, y0)) +
         v * ((1.0 - u) * at(x0, y1) + u * at(x1, y1));
}

/// What solves Laplace(h) = -4 inside, 0 at the border: of a disc R^2 - r^2, whose root is a half
/// ball's height. Outside minus the square of the distance.
std::vector<double> SquaredHeights(const Plane& distance) {
  std::vector<double> h(distance.values.size());
  for (std::size_t i = 0; i < h.size(); ++i) {
    const double d = distance.values[i];
    h[i] = d > 0.0 ? 2.0 * d : -d * d;
  }
  const double over =
      2.0 / (1.0 + std::sin(std::numbers::pi / std::max(distance.width, distance.height)));
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int y = 1; y + 1 < distance.height; ++y) {
      for (int x = 1; x + 1 < distance.width; ++x) {
        const std::size_t i = distance.Offset(x, y);
        const double d = distance.values[i];
        if (d <= 0.0) continue;
        // A neighbour outside counts at the border, as far as that is.
        double sum = 0.0, weights = 0.0;
        for (const std::size_t other : {distance.Offset(x - 1, y),
                                        distance.Offset(x + 1, y),
                                        distance.Offset(x, y - 1),
                                        distance.Offset(x, y + 1)}) {
          const double e = distance.values[other];
          const double part = e > 0.0 ? 1.0 : std::max(0.1, d / (d - e));
          sum += e > 0.0 ? h[other] : 0.0;
          weights += 1.0 / part;
        }
        const double solved = (sum + 4.0) / weights;
        h[i] = std::max(0.0, h[i] + over * (solved - h[i]));
      }
    }
  }
  return h;
}

}  // namespace

renderer::Mesh MakeCushion(const Image& whole_mask, double pixel, double depth) {
  const Image mask = renderer::LargestPart(whole_mask, 0.0);
  const renderer::PixelBox box = renderer::BoxAbove(mask, 0.5F);
  if (box.x1 < box.x0) throw renderer::SceneError("the mask is empty");
  const int longer = std::max(box.x1 - box.x0, box.y1 - box.y0) + 1;
  const double step = std::max(1.0, static_cast<double>(longer) / kNodes);  // pixels
  // Rows of zeros around the mask, where it touches the picture's border.
  const int frame = static_cast<int>(std::ceil((kMargin + 1) * step));
  Image framed(mask.width + 2 * frame, mask.height + 2 * frame, 1);
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) framed.At(x + frame, y + frame, 0) = mask.At(x, y, 0);
  }
  const Image signed_distance = renderer::SignedDistanceToMask(framed);
  Plane distance;
  distance.width = static_cast<int>(std::ceil((box.x1 - box.x0 + 1) / step)) + 2 * kMargin;
  distance.height = static_cast<int>(std::ceil((box.y1 - box.y0 + 1) / step)) + 2 * kMargin;
  const double left = box.x0 + frame - kMargin * step;
  const double top = box.y0 + frame - kMargin * step;
  for (int y = 0; y < distance.height; ++y) {
    for (int x = 0; x < distance.width; ++x) {
      distance.values.push_back(Interpolate(signed_distance, left + x * step, top + y * step) /
                                step);
    }
  }
  const std::vector<double> squared = SquaredHeights(distance);
  const double highest = depth * std::sqrt(std::max(0.0, *std::ranges::max_element(squared)));
  const int half = static_cast<int>(std::ceil(highest)) + kMargin;

  VoxelGrid grid;
  grid.spacing = step * pixel;
  grid.size = {distance.width, distance.height, 2 * half + 1};
  // Rows of the grid go up, those of the plane down.
  grid.origin = {(left - frame + 0.5 - 0.5 * mask.width) * pixel,
                 (0.5 * mask.height - 0.5 - (top - frame) - (distance.height - 1) * step) * pixel,
                 -half * grid.spacing};
  for (int z = -half; z <= half; ++z) {
    for (int y = distance.height - 1; y >= 0; --y) {
      for (int x = 0; x < distance.width; ++x) {
        // Over its slope this is about the distance from the surface.
        const double h = depth * depth * squared[distance.Offset(x, y)];
        const double value = h - z * z;
        const double slope = 2.0 * std::sqrt(std::max(0.25, std::abs(h)) + z * z);
        grid.values.push_back(static_cast<float>(std::clamp(value / slope, -3.0, 3.0)));
      }
    }
  }
  renderer::Mesh mesh = ExtractSurface(grid);
  SeparateTouchingParts(kInset * grid.spacing, mesh);
  KeepLargestPart(mesh);
  WeldPositions(mesh);
  ValidateMesh(mesh, "cushion");
  return mesh;
}

}  // namespace pathfit::optim
