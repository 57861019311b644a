#include "renderer/emitter/projector_kernel.h"

#include <array>
#include <cmath>
#include <numbers>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::renderer::projector_kernel_test {
namespace {

constexpr double kRounding = 1e-13;
constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;
constexpr double kTanX = 0.4;
constexpr double kTanY = 0.25;

ProjectorPoint<double> Towards(const Vec3& w) { return ProjectorPointTowards(w, kTanX, kTanY); }

TEST(ProjectorKernel, PictureCoordinatesRunRightAndUp) {
  const auto expect = [](const Vec3& w, double u, double v) {
    const ProjectorPoint<double> point = Towards(Normalized(w));
    ASSERT_TRUE(point.inside);
    EXPECT_NEAR(point.u, u, kRounding);
    EXPECT_NEAR(point.v, v, kRounding);
  };
  expect({0, 0, -1}, 0.5, 0.5);
  expect({0.2, 0, -1}, 0.75, 0.5);
  expect({0, 0.125, -1}, 0.5, 0.75);
  expect({-0.6, -0.375, -2}, 0.125, 0.125);
}

TEST(ProjectorKernel, NothingIsCastBehindOrBesideThePicture) {
  EXPECT_TRUE(Towards({0.399, -0.249, -1}).inside);
  EXPECT_FALSE(Towards({0.401, 0, -1}).inside);
  EXPECT_FALSE(Towards({-0.401, 0, -1}).inside);
  EXPECT_FALSE(Towards({0, 0.251, -1}).inside);
  EXPECT_FALSE(Towards({0, -0.251, -1}).inside);
  EXPECT_FALSE(Towards({0, 0, 1}).inside);
  EXPECT_FALSE(Towards({0.1, 0.1, 1}).inside);
  EXPECT_FALSE(Towards({1, 0, 0}).inside);
  EXPECT_EQ(Towards({1, 0, 0}).scale, 0.0);
  EXPECT_EQ(ProjectorDerivative({0, 0, 1}, kTanX, kTanY).d_scale, (Vec3{0, 0, 0}));
}

TEST(ProjectorKernel, HandJetAndDifferencesAgree) {
  using J = ceres::Jet<double, 3>;
  constexpr double kStep = 0.01;
  for (const Vec3& direction :
       {Vec3{0, 0, -1}, Vec3{0.3, 0.1, -1}, Vec3{-0.35, 0.2, -1}, Vec3{0.05, -0.22, -1}}) {
    const Vec3 w = Normalized(direction);
    const ProjectorPartials hand = ProjectorDerivative(w, kTanX, kTanY);
    ASSERT_TRUE(hand.point.inside);
    const auto jet =
        ProjectorPointTowards(Vector3<J>{J(w.x, 0), J(w.y, 1), J(w.z, 2)}, J(kTanX), J(kTanY));
    for (const Vec3& gradient : {hand.d_u, hand.d_v, hand.d_scale}) {
      EXPECT_NEAR(Dot(gradient, w), 0.0, 1e-12) << "tangential";
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(hand.d_u[i], jet.u.v[i], kSameFormula);
      EXPECT_NEAR(hand.d_v[i], jet.v.v[i], kSameFormula);
      EXPECT_NEAR(hand.d_scale[i], jet.scale.v[i], kSameFormula);
      const auto moved = [&](double x) {
        Vec3 q = w;
        q[i] = x;
        return Towards(q);
      };
      const auto u = [&](double x) { return moved(x).u; };
      const auto v = [&](double x) { return moved(x).v; };
      const auto scale = [&](double x) { return moved(x).scale; };
      EXPECT_NEAR(hand.d_u[i], tests::RiddersDerivative(u, w[i], kStep), kDifference);
      EXPECT_NEAR(hand.d_v[i], tests::RiddersDerivative(v, w[i], kStep), kDifference);
      EXPECT_NEAR(hand.d_scale[i], tests::RiddersDerivative(scale, w[i], kStep), kDifference);
    }
  }
}

/// The flux through the picture, the scale's integral over its solid angle, is that of a plane
/// across the axis at depth 1 which receives pi everywhere.
TEST(ProjectorKernel, AFlatScreenReceivesPiTimesThePictureEverywhere) {
  for (const Vec3& on_screen : {Vec3{0, 0, -1}, Vec3{0.39, 0.24, -1}, Vec3{-0.3, 0.1, -1}}) {
    const double r = Norm(on_screen);
    const double cosine = 1.0 / r;
    const double irradiance = Towards(on_screen / r).scale * cosine / (r * r);
    EXPECT_NEAR(irradiance, std::numbers::pi, kRounding * 10.0);
  }
}

}  // namespace
}  // namespace pathfit::renderer::projector_kernel_test
