#include "renderer/path/mirror_normal.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/derivative/color_gradient.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::mirror_normal_test {
namespace {

const Vec3 kFacet = Normalized(Vec3{0.1, -0.2, 1.0});

Vec3 Reflected(const Vec3& n, const Vec3& wo) { return n * (2.0 * Dot(n, wo)) - wo; }

TEST(MirrorNormal, IsTheInterpolatedOneWhereItsReflectionClearsTheFacet) {
  const Vec3 n = Normalized(Vec3{0.2, 0.1, 1.0});
  const MirrorNormal mirror(n, kFacet, Normalized(Vec3{-0.3, 0.5, 1.0}));
  EXPECT_FALSE(mirror.IsBent());
  EXPECT_EQ(mirror.Value(), n);
}

TEST(MirrorNormal, RaisesTheReflectionElsewhereAndIsContinuous) {
  Vec3 last;
  bool bent = false;
  for (int i = 0; i <= 2500; ++i) {  // until wo is far below the horizon of n
    const double angle = 0.5e-3 * i;
    const Vec3 wo = Normalized(Vec3{0.0, 1.0, 0.5});
    const Vec3 n = Normalized(Vec3{0.0, -std::sin(angle), std::cos(angle)} + wo * 0.3);
    const MirrorNormal mirror(n, kFacet, wo);
    const Vec3 r = Reflected(mirror.Value(), wo);
    EXPECT_NEAR(Norm(mirror.Value()), 1.0, 1e-12);
    EXPECT_GT(Dot(mirror.Value(), wo), 0.0);
    EXPECT_GT(Dot(r, kFacet), 0.9 * MirrorNormal::kLift / 2.0);
    if (i > 0) {
      EXPECT_LT(Norm(mirror.Value() - last), 5e-3) << angle;
    }
    last = mirror.Value();
    bent = bent || mirror.IsBent();
  }
  EXPECT_TRUE(bent);
}

TEST(MirrorNormal, PullsAdjointsAsDifferencesDo) {
  const Vec3 wo = Normalized(Vec3{0.2, 1.0, 0.4});
  const Vec3 n = Normalized(Vec3{0.1, -0.5, 0.8});
  const Vec3 weight{0.7, -0.4, 0.9};
  ASSERT_TRUE(MirrorNormal(n, kFacet, wo).IsBent());
  Vec3 d_n = weight;
  Vec3 d_ng;
  Vec3 d_wo;
  MirrorNormal(n, kFacet, wo).Pull(d_n, d_ng, d_wo);
  for (int i = 0; i < 3; ++i) {
    const auto value = [&](int which, double step) {
      Vec3 at[3] = {n, kFacet, wo};
      at[which][i] += step;
      return Dot(weight, MirrorNormal(at[0], at[1], at[2]).Value());
    };
    const Vec3 pulled[3] = {d_n, d_ng, d_wo};
    for (int which = 0; which < 3; ++which) {
      const double exact =
          tests::RiddersDerivative([&](double h) { return value(which, h); }, 0.0, 1e-3);
      EXPECT_LT(tests::RelativeError(pulled[which][i], exact), 1e-8) << which << " " << i;
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::mirror_normal_test
