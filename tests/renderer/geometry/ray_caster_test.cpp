#include "renderer/geometry/ray_caster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/near_corner.h"
#include "renderer/geometry/own_corners.h"
#include "renderer/math/warp.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::ray_caster_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

RayCaster CasterOf(const std::vector<const Mesh*>& meshes) {
  RayCaster caster;
  caster.Build(meshes);
  return caster;
}

TEST(RayCaster, RefinesHitsInDoublePrecision) {
  const Mesh ball = MakeIcosphere(3, 1.0);
  const RayCaster caster = CasterOf({&ball});
  CounterRng rng(4);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 origin{4.0 * rng.Next() - 2.0, 4.0 * rng.Next() - 2.0, 3.0};
    const Vec3 target{rng.Next() - 0.5, rng.Next() - 0.5, 0.0};
    const Ray ray{origin, Normalized(target - origin)};
    const auto hit = caster.Intersect(ray);
    ASSERT_TRUE(hit.has_value());
    ++hits;
    const TriangleGeometry& t = caster.Geometry(hit->id);
    const Vec3 x = ray.origin + ray.direction * hit->distance;
    // Float hits would be off by 1e-7; a ray on an edge may be given to either face by Embree's
    // float geometry.
    EXPECT_LT(Norm(x - t.Point(hit->b1, hit->b2)), 1e-13);
    EXPECT_LT(std::abs(Dot(t.n, x - t.p0)), 1e-13);
    EXPECT_GT(std::min({hit->b1, hit->b2, 1.0 - hit->b1 - hit->b2}), -1e-5);
  }
  EXPECT_EQ(hits, 2000);
}

TEST(RayCaster, MissesAndMeshIndices) {
  Mesh near_plate = tests::Rectangle();
  Mesh far_plate = tests::Rectangle();
  ApplyTransform({{}, {0, 0, -2}}, far_plate);
  const RayCaster caster = CasterOf({&far_plate, &near_plate});
  const auto hit = caster.Intersect({{0.2, 0.1, 3}, {0, 0, -1}});
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->id.mesh, 1);
  EXPECT_DOUBLE_EQ(hit->distance, 3.0);
  EXPECT_FALSE(caster.Intersect({{3, 0, 3}, {0, 0, -1}}).has_value());
  EXPECT_FALSE(caster.Intersect({{0, 0, 3}, {0, 0, 1}}).has_value());
}

TEST(RayCaster, IgnoresNamedTrianglesOnly) {
  Mesh near_plate = tests::Rectangle();
  Mesh far_plate = tests::Rectangle();
  ApplyTransform({{}, {0, 0, -2}}, far_plate);
  const RayCaster caster = CasterOf({&far_plate, &near_plate});
  const Ray ray{{0.3, 0.1, 3}, {0, 0, -1}};
  const auto first = caster.Intersect(ray);
  ASSERT_TRUE(first.has_value());
  const std::array<TriangleId, 1> ignored = {first->id};
  const auto second = caster.IntersectIgnoring(ray, 0.0, ignored);
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(second->id.mesh, 0);
  EXPECT_DOUBLE_EQ(second->distance, 5.0);
  const auto beyond = caster.IntersectIgnoring(ray, 4.0, {});
  ASSERT_TRUE(beyond.has_value());
  EXPECT_EQ(beyond->id.mesh, 0) << "the first hit is nearer than min_distance";
}

TEST(RayCaster, OcclusionRespectsTheDistance) {
  const Mesh plate = tests::Rectangle();
  const RayCaster caster = CasterOf({&plate});
  const Ray ray{{0, 0, 2}, {0, 0, -1}};
  EXPECT_TRUE(caster.Occluded(ray, kInfinity));
  EXPECT_TRUE(caster.Occluded(ray, 2.1));
  EXPECT_FALSE(caster.Occluded(ray, 1.9));
  EXPECT_FALSE(caster.Occluded({{0, 0, 2}, {0, 0, 1}}, kInfinity));
}

/// Rays leaving a convex body never meet it again, at any size and distance from the origin.
TEST(RayCaster, OffsetPointsClearTheSurface) {
  for (const double scale : {1e-4, 1.0, 1e4}) {
    Mesh ball = MakeIcosphere(2, 1.0);
    ApplyTransform({{{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}},
                    {30.0 * scale, -20.0 * scale, 10.0 * scale}},
                   ball);
    const RayCaster caster = CasterOf({&ball});
    CounterRng rng(5);
    int occluded = 0;
    for (int i = 0; i < 20000; ++i) {
      const TriangleId id{0, i % static_cast<int>(ball.triangles.size())};
      const TriangleGeometry& t = caster.Geometry(id);
      const double a = rng.Next();
      const double b = rng.Next() * (1.0 - a);
      Vec3 d = SampleUniformHemisphere(rng.Next(), rng.Next());
      if (Dot(d, t.n) < 0.0) d = -d;
      occluded +=
          caster.Occluded({t.Point(a, b) + t.n * caster.Offset(t.Point(a, b)), d}, kInfinity) ? 1
                                                                                              : 0;
    }
    EXPECT_EQ(occluded, 0) << "scale " << scale;
  }
}

TEST(RayCaster, NearnessSeesCornersAndNotWhatLiesBehind) {
  const Mesh floor = tests::Rectangle();  // [-1, 1]^2, z = 0
  Mesh wall = floor;                      // upright at x = 0.5, from z = 0 to 2
  for (Vec3& p : wall.positions) p = {0.5, p.y, p.x + 1.0};
  Mesh sheet = floor;  // just below the floor
  for (Vec3& p : sheet.positions) p.z -= 1e-4;
  const RayCaster caster = CasterOf({&floor, &wall, &sheet});
  const std::vector<double> all(3, 0.5);
  const std::vector<double> others = {0.5, 0.0, 0.5};
  const Vec3 up{0, 0, 1};
  const double d = 0.01;
  // From beside the wall its corners rise almost straight up.
  EXPECT_NEAR(caster.Nearness({0.5 - d, 0.0, 0.0}, up, {all, 0.5}), 2.0 * d, 0.4 * d);
  EXPECT_EQ(caster.Nearness({0.5 - d, 0.0, 0.0}, up, {others, 0.5}), 1.0);
  EXPECT_EQ(caster.Nearness({0.5 - d, 0.0, 0.0}, up, {all, 0.5, 1}), 1.0);
  EXPECT_EQ(caster.Nearness({-0.8, 0.0, 0.0}, up, {all, 0.5}), 1.0);
  EXPECT_LT(caster.Nearness({-0.8, 0.0, 0.0}, -up, {all, 0.5}), 4e-4);
  // What stands on a surface meets it; what hovers, however low, does not.
  NearFacts facts;
  EXPECT_GT(caster.Nearness({0.5 - d, 0.0, 0.0}, up, {all, 0.5}, 1.0, &facts), 0.0);
  EXPECT_TRUE(facts.meets);
  EXPECT_EQ(facts.reach, 0.5);
  EXPECT_LT(caster.Nearness({-0.8, 0.0, 0.0}, -up, {all, 0.5}, 1.0, &facts), 1.0);
  EXPECT_FALSE(facts.meets);
  // Its own triangle does not count, however rounding has moved a point.
  Mesh ball = MakeIcosphere(2, 1.0);
  const RayCaster of_ball = CasterOf({&ball});
  const std::vector<double> alone = {0.5};
  CounterRng rng(6);
  for (int i = 0; i < 2000; ++i) {
    const TriangleGeometry& t = of_ball.Geometry({0, i % static_cast<int>(ball.triangles.size())});
    const double a = rng.Next();
    const Vec3 x = t.Point(a, rng.Next() * (1.0 - a));
    EXPECT_EQ(of_ball.Nearness(x, t.n, {alone, 0.5}), 1.0);
  }
}

/// Of what RayCaster::Nearness is the least.
double NearnessOf(const TriangleGeometry& t, const Vec3& x, const Vec3& n, double reach) {
  constexpr double kFlat = 1e-3;
  const Vec3 to_nearest = ClosestPointOfTriangle(x, t) - x;
  double rise = 0.0;
  for (const Vec3& to : {to_nearest, t.p0 - x, t.p0 + t.e1 - x, t.p0 + t.e2 - x}) {
    rise = std::max(rise, Dot(n, to) / Norm(to));
  }
  return reach > 0.0 && rise > kFlat ? Norm(to_nearest) / (rise * reach) : kInfinity;
}

/// Bounds leave out what does not count, and nothing else.
TEST(RayCaster, NearnessIsTheLeastOfAllTriangles) {
  Mesh ball = MakeIcosphere(3, 1.0);
  Mesh pebble = MakeIcosphere(2, 0.3);
  for (Vec3& p : pebble.positions) p = p + Vec3{1.1, 0.2, 0.0};
  Mesh floor = tests::Rectangle();
  for (Vec3& p : floor.positions) p = {2.0 * p.x, 2.0 * p.y, p.z - 0.9};
  const std::array<const Mesh*, 3> meshes = {&ball, &pebble, &floor};
  const RayCaster caster = CasterOf({meshes.begin(), meshes.end()});
  CounterRng rng(12);
  int near = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> of_mesh = {0.4, i % 3 == 0 ? 0.0 : 0.2, 0.3};
    const RayCaster::Reach reach{of_mesh, 0.35, i % 5 == 0 ? 0 : -1};
    const Vec3 x{4.0 * rng.Next() - 2.0, 4.0 * rng.Next() - 2.0, 3.0 * rng.Next() - 1.5};
    const Vec3 n = SampleUniformSphere(rng.Next(), rng.Next());
    double least = 1.0;
    for (int m = 0; m < 3; ++m) {
      const auto count = static_cast<int>(meshes[static_cast<std::size_t>(m)]->triangles.size());
      for (int k = 0; k < count; ++k) {
        least = std::min(least, NearnessOf(caster.Geometry({m, k}), x, n, reach.Of(m)));
      }
    }
    EXPECT_NEAR(caster.Nearness(x, n, reach), least, 1e-6) << "point " << i;
    near += least < 1.0 ? 1 : 0;
  }
  EXPECT_GT(near, 100);
}

/// On a ball with dents, seen from all over each triangle.
TEST(RayCaster, OwnCornersAreThoseOfTheMeshAlone) {
  Mesh ball = MakeIcosphere(4, 1.0);
  for (Vec3& p : ball.positions) {
    p = p * (1.0 + 0.05 * std::sin(9.0 * p.x) * std::sin(8.0 * p.y) * std::sin(7.0 * p.z));
  }
  const RayCaster caster = CasterOf({&ball});
  const OwnCorners corners(caster.TrianglesOf(0));
  constexpr double kReach = 0.4;
  const std::vector<double> of_mesh = {kReach};
  const RayCaster::Reach reach{of_mesh, kReach};
  CounterRng rng(4);
  int none = 0;
  int near = 0;
  for (const TriangleGeometry& t : caster.TrianglesOf(0)) {
    for (const double side : {1.0, -1.0}) {
      const Vec3 n = t.n * side;
      const double u = std::sqrt(rng.Next());
      const Vec3 x = t.Point(1.0 - u, u * rng.Next());
      const CornerView view{x, n, caster.Offset(x)};
      const double nearness = caster.Nearness(x, n, reach);
      EXPECT_NEAR(corners.Nearness(view, kReach), nearness, 1e-9);
      EXPECT_NEAR(corners.Nearness(view, kReach, 0.3), std::min(nearness, 0.3), 1e-9);
      none += nearness < 1.0 ? 0 : 1;
      near += nearness < 0.3 ? 1 : 0;
    }
  }
  EXPECT_GT(none, 500);
  EXPECT_GT(near, 500);
}

/// Embree's distances to thin triangles are inexact: what a large triangle is cut into must not be
/// thin, or rays that start on one of its pieces meet it again.
TEST(RayCaster, RaysDoNotMeetTheTriangleThatTheyStartOn) {
  CounterRng rng(6);
  const auto in_cube = [&] {
    return Vec3{2.0 * rng.Next() - 1.0, 2.0 * rng.Next() - 1.0, 2.0 * rng.Next() - 1.0};
  };
  for (int trial = 0; trial < 60; ++trial) {
    Mesh fold;
    fold.positions = {{-1, 0, 1}, {1, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {1, 1, -0.2}, {-1, 1, -0.2}};
    fold.triangles = {{0, 1, 2}, {0, 2, 3}, {3, 2, 4}, {3, 4, 5}};
    for (Vec3& p : fold.positions) p += in_cube() * 2.5e-3;
    RayCaster caster;
    caster.Build({&fold}, {}, RayFrame{{0.3634, 0.3634, 0.3634}, 0.25});
    int met = 0;
    constexpr double kShare = 0.25;  // of the offset
    for (int i = 0; i < 40000; ++i) {
      const TriangleGeometry& t = caster.Geometry({0, i % 4});
      const double u = std::sqrt(rng.Next());
      const Vec3 x = t.Point(u * rng.Next(), 1.0 - u);
      const Vec3 side = in_cube();
      const Vec3 direction = Normalized(Dot(side, t.n) > 0.0 ? side : -side);
      const auto hit = caster.Intersect({x + t.n * (kShare * caster.Offset(x)), direction});
      met += hit.has_value() && hit->distance <= 0.0 ? 1 : 0;
    }
    EXPECT_EQ(met, 0) << trial;
  }
}

/// However large the floor is, on which things stand beside or around its middle, and whichever
/// comes first: rays tell apart what is there.
TEST(RayCaster, AHugeFloorIsNotTheCenter) {
  const auto scaled = [](Mesh mesh, double size, double x) {
    ApplyTransform({{{size, 0, 0}, {0, size, 0}, {0, 0, size}}, {x, 0, 0}}, mesh);
    return mesh;
  };
  const Mesh ball = MakeIcosphere(2, 1.0);
  const Mesh left = scaled(ball, 1.0, -5.0);
  const Mesh right = scaled(ball, 1.0, 5.0);
  for (const double size : {1e2, 1e4, 1e6}) {
    const Mesh floor = scaled(tests::Rectangle(), size, 0.0);
    const auto offset = [](const std::vector<const Mesh*>& meshes, const Vec3& x) {
      return CasterOf(meshes).Offset(x) / RayCaster::kRayOffset;
    };
    EXPECT_LT(offset({&floor, &ball}, {0, 0, 0}), 2.0) << size;
    EXPECT_LT(offset({&ball, &floor}, {0, 0, 0}), 2.0) << size;
    EXPECT_LT(offset({&floor, &left, &right}, {5, 0, 0}), 12.0) << size;
    EXPECT_LT(offset({&right, &left, &floor}, {-5, 0, 0}), 12.0) << size;
    const RayCaster caster = CasterOf({&left, &floor, &right});
    const Ray up{{5.0, 0.0, caster.Offset({5, 0, 0})}, {0, 0, 1}};
    const auto hit = caster.Intersect(up);
    ASSERT_TRUE(hit.has_value()) << size;
    EXPECT_EQ(hit->id.mesh, 2);
  }
}
TEST(RayCaster, ExtentIsHalfTheDiagonalAndEmptyScenesWork) {
  const Mesh plate = tests::Rectangle();
  EXPECT_DOUBLE_EQ(CasterOf({&plate}).Extent(), std::sqrt(2.0));
  const RayCaster empty = CasterOf({});
  EXPECT_FALSE(empty.Intersect({{0, 0, 0}, {0, 0, 1}}).has_value());
  EXPECT_FALSE(empty.Occluded({{0, 0, 0}, {0, 0, 1}}, kInfinity));
}

}  // namespace
}  // namespace pathfit::renderer::ray_caster_test
