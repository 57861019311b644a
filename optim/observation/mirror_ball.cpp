#include "optim/observation/mirror_ball.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/io/color_segmentation.h"
#include "renderer/io/image_filter.h"
#include "renderer/math/median.h"

namespace pathfit::optim {
namespace {

using renderer::Image;
using renderer::Vec2;
using renderer::Vec3;

constexpr double kRound = 0.1;      // by which a disc's box and area may be off
constexpr double kSmallest = 5.0;   // pixels
constexpr double kInside = 0.97;    // of the radius: where highlights are looked for
constexpr double kHighlight = 0.9;  // of the brightest value, from the ball's median on
constexpr double kStandsOut = 1.5;  // brightest value over the median
constexpr double kLargest = 0.2;    // share of the disc that is no highlight any more

/// The pixels of a mask.
struct Spot {
  double area = 0.0;
  Vec2 centre;
};

Spot SpotOf(const Image& mask) {
  Spot spot;
  Vec2 sum;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (mask.At(x, y, 0) < 0.5F) continue;
      spot.area += 1.0;
      sum = sum + Vec2{x + 0.5, y + 0.5};
    }
  }
  if (spot.area > 0.0) spot.centre = sum * (1.0 / spot.area);
  return spot;
}

}  // namespace

BallOutline FindBall(const Image& mask) {
  const Image part = renderer::LargestPart(mask, 1.0);
  const renderer::PixelBox box = renderer::BoxAbove(part, 0.5F);
  const Spot spot = SpotOf(part);
  const double radius = std::sqrt(spot.area / std::numbers::pi);
  const auto fits = [radius](int first, int last) {
    return std::abs(last + 1 - first - 2.0 * radius) < 2.0 * kRound * radius;
  };
  if (!(radius > kSmallest && fits(box.x0, box.x1) && fits(box.y0, box.y1))) {
    throw renderer::SceneError("the mask of the ball is not a disc");
  }
  return {spot.centre, radius};
}

Vec3 LampOfHighlight(const Image& photo, const BallOutline& ball) {
  std::vector<double> values;
  const auto inside = [&](int x, int y) {
    return std::hypot(x + 0.5 - ball.centre.x, y + 0.5 - ball.centre.y) < kInside * ball.radius;
  };
  for (int y = 0; y < photo.height; ++y) {
    for (int x = 0; x < photo.width; ++x) {
      if (inside(x, y)) values.push_back(renderer::MeanOfChannels(photo, x, y));
    }
  }
  if (values.empty()) throw renderer::SceneError("the ball is outside the picture");
  const double brightest = *std::ranges::max_element(values);
  const double middle = renderer::Median(values);
  const double least = middle + kHighlight * (brightest - middle);
  Image bright(photo.width, photo.height, 1);
  for (int y = 0; y < photo.height; ++y) {
    for (int x = 0; x < photo.width; ++x) {
      const bool is_bright = inside(x, y) && renderer::MeanOfChannels(photo, x, y) >= least;
      bright.At(x, y, 0) = is_bright ? 1.0F : 0.0F;
    }
  }
  const Spot spot = SpotOf(renderer::LargestPart(bright, 1.0));
  if (!(brightest > kStandsOut * middle) ||
      spot.area > kLargest * static_cast<double>(values.size())) {
    throw renderer::SceneError("the ball has no highlight");
  }
  const Vec2 place = spot.centre - ball.centre;
  const double x = place.x / ball.radius, y = -place.y / ball.radius;
  const Vec3 normal{x, y, std::sqrt(std::max(0.0, 1.0 - x * x - y * y))};
  return normal * (2.0 * normal.z) - Vec3{0.0, 0.0, 1.0};
}

}  // namespace pathfit::optim
