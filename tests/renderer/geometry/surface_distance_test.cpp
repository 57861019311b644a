#include "renderer/geometry/surface_distance.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"

namespace pathfit::renderer::surface_distance_test {
namespace {

SurfaceGap GapOf(const Mesh& from, const Mesh& to) {
  return GapBetween(from, UniformPoints(from, 20000), to);
}

Mesh Moved(Mesh mesh, const Mat3& turn, const Vec3& by) {
  for (Vec3& p : mesh.positions.Edit()) p = turn * p + by;
  return mesh;
}

TEST(SurfaceDistance, ParallelSheetsAreTheirDistanceApart) {
  const Mesh sheet = MakeRectangle();
  const Mesh above = Moved(MakeRectangle(), {}, {0, 0, 0.25});
  const SurfaceGap gap = GapOf(sheet, above);
  EXPECT_NEAR(gap.mean, 0.25, 1e-12);
  EXPECT_NEAR(gap.rms, 0.25, 1e-12);
  EXPECT_NEAR(gap.most, 0.25, 1e-12);
  EXPECT_NEAR(gap.mean_angle, 0.0, 1e-7);
}

/// Of the part that is not opposite, the nearest points lie on the border.
TEST(SurfaceDistance, WhatIsMissingIsFoundOneWayOnly) {
  const Mesh sheet = MakeRectangle();  // [-1, 1]^2
  Mesh half = MakeRectangle();
  for (Vec3& p : half.positions.Edit()) p.x = std::min(p.x, 0.0);
  EXPECT_NEAR(GapOf(half, sheet).most, 0.0, 1e-12);
  const SurfaceGap back = GapOf(sheet, half);
  EXPECT_NEAR(back.mean, 0.25, 2e-3);  // half of it is 1/2 away in the mean
  EXPECT_NEAR(back.rms, std::sqrt(1.0 / 6.0), 2e-3);
}

TEST(SurfaceDistance, NormalsAreComparedWhereItIsNearest) {
  const Mat3 turn = RotationAboutAxis({1, 0, 0}, 0.3);
  const SurfaceGap tilted = GapOf(MakeRectangle(), Moved(MakeRectangle(), turn, {}));
  EXPECT_NEAR(tilted.mean_angle, 0.3, 1e-9);
  const Mat3 over = RotationAboutAxis({1, 0, 0}, std::numbers::pi);
  EXPECT_NEAR(
      GapOf(MakeRectangle(), Moved(MakeRectangle(), over, {})).mean_angle, std::numbers::pi, 1e-6);
}

TEST(SurfaceDistance, SpheresInEachOther) {
  const Mesh small = MakeIcosphere(4, 1.0), large = MakeIcosphere(4, 1.2);
  for (const SurfaceGap& gap : {GapOf(small, large), GapOf(large, small)}) {
    EXPECT_NEAR(gap.mean, 0.2, 2e-3);
    EXPECT_LT(gap.mean_angle, 0.05);
  }
}

TEST(SurfaceDistance, NearestPointsLieOnTheirTriangles) {
  const Mesh ball = MakeIcosphere(2, 1.0);
  const NearestSurface surface(ball);
  for (const MeshPoint& from : UniformPoints(MakeIcosphere(1, 1.7), 500)) {
    const MeshPoint point = surface.Nearest(from.x);
    const Triangle& t = ball.triangles[static_cast<std::size_t>(point.triangle)];
    const auto corner = [&](std::size_t i) {
      return ball.positions[static_cast<std::size_t>(t[i])];
    };
    const Vec3 x =
        corner(0) * (1.0 - point.b1 - point.b2) + corner(1) * point.b1 + corner(2) * point.b2;
    EXPECT_LT(Norm(x - point.x), 1e-9);
    EXPECT_GE(std::min({point.b1, point.b2, 1.0 - point.b1 - point.b2}), -1e-12);
    for (const Vec3& p : ball.positions) EXPECT_LE(Norm(x - from.x), Norm(p - from.x) + 1e-9);
  }
}

}  // namespace
}  // namespace pathfit::renderer::surface_distance_test
