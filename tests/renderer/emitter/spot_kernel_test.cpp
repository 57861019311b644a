#include "renderer/emitter/spot_kernel.h"

#include <array>
#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::renderer::spot_kernel_test {
namespace {

constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;
// An angle beside a cone by this much changes the falloff by its square: the slope is zero there.
constexpr double kBeside = 1e-5;

struct Cone {
  double inner, outer;
};
constexpr std::array<Cone, 4> kCones = {{{0.2, 0.4}, {0.0, 1.5}, {0.3, 0.31}, {0.01, 0.7}}};

TEST(SpotKernel, IsOneInsideZeroOutsideAndSmoothBetween) {
  for (const Cone& cone : kCones) {
    const auto at = [&](double angle) {
      return SpotFalloff(std::cos(angle), cone.inner, cone.outer);
    };
    EXPECT_EQ(at(0.5 * cone.inner), 1.0);
    EXPECT_EQ(at(cone.outer + 0.01), 0.0);
    EXPECT_EQ(at(3.0), 0.0);
    const double half_cosine = 0.5 * (std::cos(cone.inner) + std::cos(cone.outer));
    EXPECT_NEAR(SpotFalloff(half_cosine, cone.inner, cone.outer), 0.5, 1e-12);
    double before = 1.0;
    for (int i = 1; i < 100; ++i) {
      const double here = at(cone.inner + (cone.outer - cone.inner) * i / 100.0);
      EXPECT_LT(here, before);
      before = here;
    }
  }
}

/// Value and slope go on without a jump at both cones.
TEST(SpotKernel, BothConesAreContinuousWithTheirSlopes) {
  for (const Cone& cone : kCones) {
    const double width = std::cos(cone.inner) - std::cos(cone.outer);
    for (const auto& [edge, value] :
         {std::pair{std::cos(cone.inner), 1.0}, std::pair{std::cos(cone.outer), 0.0}}) {
      for (const double side : {-1.0, 1.0}) {
        const SpotFalloffPartials p =
            SpotFalloffDerivative(edge + side * kBeside * width, cone.inner, cone.outer);
        EXPECT_NEAR(p.value, value, 4.0 * kBeside * kBeside);
        EXPECT_NEAR(p.d_cos * width, 0.0, 7.0 * kBeside);
        EXPECT_NEAR(p.d_inner * width, 0.0, 7.0 * kBeside);
        EXPECT_NEAR(p.d_outer * width, 0.0, 7.0 * kBeside);
      }
    }
  }
}

TEST(SpotKernel, HandJetAndDifferencesAgree) {
  using J = ceres::Jet<double, 3>;
  for (const Cone& cone : kCones) {
    const double width = std::cos(cone.inner) - std::cos(cone.outer);
    for (const double t : {-0.3, 0.1, 0.35, 0.6, 0.9, 1.2}) {
      const std::array<double, 3> at = {std::cos(cone.outer) + t * width, cone.inner, cone.outer};
      const SpotFalloffPartials p = SpotFalloffDerivative(at[0], at[1], at[2]);
      const J jet = SpotFalloff(J(at[0], 0), J(at[1], 1), J(at[2], 2));
      EXPECT_EQ(p.value, SpotFalloff(at[0], at[1], at[2]));
      EXPECT_NEAR(p.value, jet.a, kSameFormula);
      const std::array<double, 3> hand = {p.d_cos, p.d_inner, p.d_outer};
      for (std::size_t i = 0; i < 3; ++i) {
        const auto along = [&](double x) {
          std::array<double, 3> q = at;
          q[i] = x;
          return SpotFalloff(q[0], q[1], q[2]);
        };
        const double difference = tests::RiddersDerivative(along, at[i], 0.05 * width);
        EXPECT_LT(std::abs(hand[i] - jet.v[static_cast<int>(i)]) * width, kSameFormula);
        EXPECT_LT(std::abs(hand[i] - difference) * width, kDifference)
            << "argument " << i << " at t " << t << " of the cone " << cone.inner;
      }
    }
  }
}

TEST(SpotKernel, ConesCloserThanRoundingAreAHardEdge) {
  EXPECT_EQ(SpotFalloff(1.0, 0.0, 1e-12), 1.0);
  EXPECT_EQ(SpotFalloff(0.999, 0.0, 1e-12), 0.0);
  const SpotFalloffPartials p = SpotFalloffDerivative(std::cos(0.3), 0.3, 0.3);
  EXPECT_TRUE(std::isfinite(p.value) && p.d_cos == 0.0 && p.d_inner == 0.0 && p.d_outer == 0.0);
}

}  // namespace
}  // namespace pathfit::renderer::spot_kernel_test
