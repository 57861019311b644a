#include "renderer/math/frame.h"

#include <gtest/gtest.h>

#include "renderer/math/warp.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::renderer::frame_test {
namespace {

// A handful of products of numbers of size one.
constexpr double kRounding = 1e-13;

TEST(Frame, IsRightHandedAndOrthonormalForAnyNormal) {
  CounterRng rng(1);
  for (int i = 0; i < 1000; ++i) {
    Vec3 n = SampleUniformHemisphere(rng.Next(), rng.Next());
    if (i % 2 == 1) n = -n;
    const Frame f = Frame::FromNormal(n);
    EXPECT_NEAR(Norm(f.s), 1.0, kRounding);
    EXPECT_NEAR(Norm(f.t), 1.0, kRounding);
    EXPECT_NEAR(Dot(f.s, f.t), 0.0, kRounding);
    EXPECT_NEAR(Norm(Cross(f.s, f.t) - n), 0.0, kRounding);
  }
}

TEST(Frame, HoldsAtBothPolesAndWithNegativeZero) {
  for (const Vec3& n : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 0, 0.0}, Vec3{1, 0, -0.0}}) {
    const Frame f = Frame::FromNormal(n);
    EXPECT_NEAR(Norm(Cross(f.s, f.t) - n), 0.0, kRounding);
  }
}

TEST(Frame, ToLocalUndoesToWorld) {
  const Frame f = Frame::FromNormal(Normalized(Vec3{0.3, -0.8, 0.4}));
  const Vec3 v{0.2, 0.5, -0.7};
  EXPECT_NEAR(Norm(f.ToLocal(f.ToWorld(v)) - v), 0.0, kRounding);
  EXPECT_NEAR(Norm(f.ToWorld({0, 0, 1}) - f.n), 0.0, kRounding);
}

}  // namespace
}  // namespace pathfit::renderer::frame_test
