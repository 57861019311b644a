// A matt ball under far lamps, as its shading says: no rendering.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/math/vector.h"

namespace pathfit::tests {

inline constexpr int kBallSize = 64;
inline constexpr double kBallRadius = 24.0;  // pixels

/// Unit normal of the ball in the middle of the picture; z = 0 beside it.
inline renderer::Vec3 BallNormal(int x, int y) {
  const double u = (x + 0.5 - 0.5 * kBallSize) / kBallRadius;
  const double v = (0.5 * kBallSize - y - 0.5) / kBallRadius;
  const double square = u * u + v * v;
  return square < 1.0 ? renderer::Vec3{u, v, std::sqrt(1.0 - square)} : renderer::Vec3{};
}

/// 1 where the ball is.
inline renderer::Image BallMask() {
  renderer::Image mask(kBallSize, kBallSize, 1);
  for (int y = 0; y < kBallSize; ++y) {
    for (int x = 0; x < kBallSize; ++x) mask.At(x, y, 0) = BallNormal(x, y).z > 0.0 ? 1.0F : 0.0F;
  }
  return mask;
}

/// Linear values; `albedo` times `strength` where the surface faces the lamp.
inline renderer::Image LitBall(const renderer::Vec3& towards, double strength, double albedo) {
  renderer::Image photo(kBallSize, kBallSize, 3);
  for (int y = 0; y < kBallSize; ++y) {
    for (int x = 0; x < kBallSize; ++x) {
      const double shade = std::max(0.0, renderer::Dot(BallNormal(x, y), towards));
      for (int c = 0; c < 3; ++c) {
        photo.At(x, y, c) = static_cast<float>(albedo * strength * shade);
      }
    }
  }
  return photo;
}

/// The same with a highlight about the mirror direction.
inline renderer::Image ShinyBall(const renderer::Vec3& towards, double strength, double albedo) {
  renderer::Image photo = LitBall(towards, strength, albedo);
  for (int y = 0; y < kBallSize; ++y) {
    for (int x = 0; x < kBallSize; ++x) {
      const renderer::Vec3 n = BallNormal(x, y);
      if (n.z <= 0.0) continue;
      const renderer::Vec3 mirrored = n * (2.0 * n.z) - renderer::Vec3{0.0, 0.0, 1.0};
      const double shine = std::pow(std::max(0.0, renderer::Dot(mirrored, towards)), 60.0);
      for (int c = 0; c < 3; ++c) photo.At(x, y, c) += static_cast<float>(0.5 * strength * shine);
    }
  }
  return photo;
}

inline const std::vector<renderer::Vec3>& BallLamps() {
  static const std::vector<renderer::Vec3> lamps = {{0.48, 0.0, 0.8772684879784524},
                                                    {-0.3, 0.4, 0.8660254037844386},
                                                    {0.0, -0.5, 0.8660254037844386},
                                                    {0.2, 0.3, 0.9327379053088815},
                                                    {-0.4, -0.2, 0.8944271909999159}};
  return lamps;
}
inline constexpr double kBallStrengths[] = {0.7, 1.3, 1.0, 1.2, 0.8};

}  // namespace pathfit::tests
