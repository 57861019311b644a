#include "renderer/math/transform.h"

#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pathfit::renderer {
namespace {

constexpr double kRounding = 1e-14;

void ExpectNear(const Vec3& a, const Vec3& b) { EXPECT_LT(Norm(a - b), kRounding); }

TEST(RotationAboutAxis, IsRightHanded) {
  const Mat3 r = RotationAboutAxis({0, 0, 1}, 0.5 * std::numbers::pi);
  ExpectNear(r * Vec3{1, 0, 0}, {0, 1, 0});
  ExpectNear(r * Vec3{0, 1, 0}, {-1, 0, 0});
  EXPECT_NEAR(Determinant(RotationAboutAxis(Normalized(Vec3{1, 2, 3}), 0.7)), 1.0, kRounding);
}

TEST(LookAt, LooksAlongMinusZWithYUp) {
  const Transform world_from_camera = LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
  EXPECT_EQ(world_from_camera, (Transform{{}, {0, 0, 4}}));
  const Transform side = LookAt({3, 1, 0}, {0, 1, 0}, {0, 1, 0});
  ExpectNear(side.Direction({0, 0, -1}), {-1, 0, 0});
  ExpectNear(side.Direction({0, 1, 0}), {0, 1, 0});
  ExpectNear(side.Direction({1, 0, 0}), {0, 0, -1});
}

TEST(LookAt, RefusesDirectionsThatSpanNoFrame) {
  EXPECT_THROW(LookAt({1, 2, 3}, {1, 2, 3}, {0, 1, 0}), std::invalid_argument);
  EXPECT_THROW(LookAt({0, 2, 0}, {0, 0, 0}, {0, 1, 0}), std::invalid_argument);
}

TEST(Transform, ComposesFromRightToLeftAndInverts) {
  const Transform b_from_a{RotationAboutAxis({0, 1, 0}, 0.4), {1, 2, 3}};
  const Transform c_from_b{RotationAboutAxis(Normalized(Vec3{1, 1, 0}), -1.1), {-2, 0, 1}};
  const Vec3 x_in_a{0.3, -0.6, 0.9};
  const Vec3 x_in_c = (c_from_b * b_from_a).Point(x_in_a);
  ExpectNear(x_in_c, c_from_b.Point(b_from_a.Point(x_in_a)));
  ExpectNear(RigidInverse(c_from_b * b_from_a).Point(x_in_c), x_in_a);
}

}  // namespace
}  // namespace pathfit::renderer
