#include "optim/observation/mirror_ball.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/io/color_segmentation.h"
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

double BrightnessAt(const Image& photo, int x, int y) {
  double sum = 0.0;
  for (int c = 0; c < photo.channels; ++c) sum += static_cast<double>(photo.At(x, y, c));
  return sum / photo.channels;
}

}  // namespace

BallOutline FindBall(const Image& mask) {
  const Image part = renderer::LargestPart(mask, 1.0);
  double area = 0.0, left = part.width, right = 0.0, top = part.height, bottom = 0.0;
  Vec2 centre;
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      if (part.At(x, y, 0) < 0.5F) continue;
      area += 1.0;
      centre = centre + Vec2{x + 0.5, y + 0.5};
      left = std::min<double>(left, x);
      right = std::max(right, x + 1.0);
      top = std::min<double>(top, y);
      bottom = std::max(bottom, y + 1.0);
    }
  }
  const double radius = std::sqrt(area / std::numbers::pi);
  const bool is_disc = radius > kSmallest &&
                       std::abs(right - left - 2.0 * radius) < 2.0 * kRound * radius &&
                       std::abs(bottom - top - 2.0 * radius) < 2.0 * kRound * radius;
  if (!is_disc) throw renderer::SceneError("the mask of the ball is not a disc");
  return {centre * (1.0 / area), radius};
}

Vec3 LampOfHighlight(const Image& photo, const BallOutline& ball) {
  std::vector<double> values;
  const auto inside = [&](int x, int y) {
    return std::hypot(x + 0.5 - ball.centre.x, y + 0.5 - ball.centre.y) < kInside * ball.radius;
  };
  for (int y = 0; y < photo.height; ++y) {
    for (int x = 0; x < photo.width; ++x) {
      if (inside(x, y)) values.push_back(BrightnessAt(photo, x, y));
    }
  }
  if (values.empty()) throw renderer::SceneError("the ball is outside the picture");
  const double brightest = *std::ranges::max_element(values);
  const double middle = renderer::Median(values);
  const double least = middle + kHighlight * (brightest - middle);
  Image bright(photo.width, photo.height, 1);
  for (int y = 0; y < photo.height; ++y) {
    for (int x = 0; x < photo.width; ++x) {
      const bool is_bright = inside(x, y) && BrightnessAt(photo, x, y) >= least;
      bright.At(x, y, 0) = is_bright ? 1.0F : 0.0F;
    }
  }
  const Image spot = renderer::LargestPart(bright, 1.0);
  Vec2 sum;
  double count = 0.0;
  for (int y = 0; y < spot.height; ++y) {
    for (int x = 0; x < spot.width; ++x) {
      if (spot.At(x, y, 0) < 0.5F) continue;
      sum = sum + Vec2{x + 0.5, y + 0.5};
      count += 1.0;
    }
  }
  if (!(brightest > kStandsOut * middle) || count > kLargest * static_cast<double>(values.size())) {
    throw renderer::SceneError("the ball has no highlight");
  }
  const Vec2 place = sum * (1.0 / count) - ball.centre;
  const double x = place.x / ball.radius, y = -place.y / ball.radius;
  const Vec3 normal{x, y, std::sqrt(std::max(0.0, 1.0 - x * x - y * y))};
  return normal * (2.0 * normal.z) - Vec3{0.0, 0.0, 1.0};
}

}  // namespace pathfit::optim
