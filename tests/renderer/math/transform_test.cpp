#include "renderer/math/transform.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::renderer::transform_test {
namespace {

constexpr double kRounding = 1e-14;

void ExpectNear(const Vec3& a, const Vec3& b) { EXPECT_LT(Norm(a - b), kRounding); }

TEST(RotationAboutAxis, IsRightHanded) {
  const Mat3 r = RotationAboutAxis({0, 0, 1}, 0.5 * std::numbers::pi);
  ExpectNear(r * Vec3{1, 0, 0}, {0, 1, 0});
  ExpectNear(r * Vec3{0, 1, 0}, {-1, 0, 0});
  EXPECT_NEAR(Determinant(RotationAboutAxis(Normalized(Vec3{1, 2, 3}), 0.7)), 1.0, kRounding);
}

double Difference(const Mat3& a, const Mat3& b) {
  return std::max({Norm(a.x - b.x), Norm(a.y - b.y), Norm(a.z - b.z)});
}

/// Lengths from nothing to beyond a full turn, with both sides of the series' limit.
constexpr std::array<double, 12> kAngles = {
    0.0, 1e-200, 1e-120, 1e-12, 1e-7, 1e-3, 0.3, 0.9999999, 1.0000001, 2.5, std::numbers::pi, 7.0};

TEST(RotationFromVector, IsTheRotationAboutItsAxis) {
  const Vec3 axis = Normalized(Vec3{0.5, -1.0, 0.7});
  for (const double angle : kAngles) {
    const Mat3 r = RotationFromVector(axis * angle);
    EXPECT_LT(Difference(r, RotationAboutAxis(axis, angle)), kRounding) << angle;
    EXPECT_LT(Difference(Transposed(r) * r, Mat3{}), kRounding);
  }
  EXPECT_EQ(RotationFromVector({}), Mat3{});
  // A tiny rotation keeps its digits: the off-diagonal is the vector itself.
  EXPECT_EQ(RotationFromVector({0, 0, 1e-12}).x.y, 1e-12);
}

/// The derivative of the rotation along its own vector is the vector, J(r) r = r; J(-r) = J(r)^T
/// and R = J(r) J(-r)^-1. Near zero nothing may cancel, nor become 0 / 0.
TEST(RotationLeftJacobian, KeepsItsIdentitiesAtAllAngles) {
  const Vec3 axis = Normalized(Vec3{0.5, -1.0, 0.7});
  for (const double angle : kAngles) {
    const Vec3 r = axis * angle;
    const Mat3 j = RotationLeftJacobian(r);
    EXPECT_LT(Norm(j * r - r), kRounding * std::max(1.0, angle) * angle + 1e-300) << angle;
    EXPECT_LT(Difference(Transposed(j), RotationLeftJacobian(-r)), kRounding);
    EXPECT_LT(Difference(RotationFromVector(r) * RotationLeftJacobian(-r), j), kRounding) << angle;
  }
  EXPECT_EQ(RotationLeftJacobian({}), Mat3{});
}

/// R(r + dr) = (I + [J dr]x) R(r): the columns of R turn with J dr.
TEST(RotationLeftJacobian, AgreesWithDifferences) {
  const Vec3 axis = Normalized(Vec3{0.5, -1.0, 0.7});
  for (const double angle : kAngles) {
    const Vec3 r = axis * angle;
    const Mat3 rotation = RotationFromVector(r);
    const Mat3 jacobian = RotationLeftJacobian(r);
    for (int i = 0; i < 3; ++i) {
      Vec3 unit;
      unit[i] = 1.0;
      const Vec3 turn = jacobian * unit;
      for (const Vec3& e : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        const Vec3 expected = Cross(turn, rotation * e);
        for (int k = 0; k < 3; ++k) {
          const auto along = [&](double t) { return (RotationFromVector(r + unit * t) * e)[k]; };
          EXPECT_NEAR(tests::RiddersDerivative(along, 0.0, 0.1), expected[k], 1e-10) << angle;
        }
      }
    }
  }
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
}  // namespace pathfit::renderer::transform_test
