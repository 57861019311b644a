#include "optim/observation/mirror_ball.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/optim/observation/lit_ball.h"

namespace pathfit::optim::mirror_ball_test {
namespace {

using renderer::Image;
using renderer::Vec3;

TEST(MirrorBall, TheHighlightTellsTheLamp) {
  const BallOutline ball = FindBall(tests::BallMask());
  EXPECT_NEAR(ball.centre.x, 0.5 * tests::kBallSize, 0.02);
  EXPECT_NEAR(ball.centre.y, 0.5 * tests::kBallSize, 0.02);
  EXPECT_NEAR(ball.radius, tests::kBallRadius, 0.1);
  for (const Vec3& lamp : tests::BallLamps()) {
    const Vec3 found = LampOfHighlight(tests::ShinyBall(lamp, 1.0, 0.2), ball);
    EXPECT_NEAR(renderer::Norm(found), 1.0, 1e-12);
    EXPECT_GT(renderer::Dot(found, lamp), std::cos(0.03));  // a third of a pixel
  }
}

TEST(MirrorBall, RefusesWhatIsNone) {
  Image square(40, 40, 1);
  for (int y = 5; y < 35; ++y) {
    for (int x = 15; x < 25; ++x) square.At(x, y, 0) = 1.0F;
  }
  EXPECT_THROW(FindBall(square), renderer::SceneError);
  EXPECT_THROW(FindBall(Image(40, 40, 1)), renderer::SceneError);
  const BallOutline ball = FindBall(tests::BallMask());
  EXPECT_THROW(LampOfHighlight(tests::LitBall({0, 0, 1}, 1.0, 0.5), ball), renderer::SceneError);
  EXPECT_THROW(LampOfHighlight(Image(tests::kBallSize, tests::kBallSize, 3), ball),
               renderer::SceneError);
}

}  // namespace
}  // namespace pathfit::optim::mirror_ball_test
