#include "renderer/emitter/area_sampler.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/triangle_kernel.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/closed_forms.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer {
namespace {

constexpr double kRounding = 1e-12;
constexpr int kDraws = 100000;
constexpr int kSuite = 2;
constexpr double kFloorShare = 0.1;

TriangleGeometry GeometryOf(const Mesh& mesh, std::size_t triangle) {
  const Triangle& t = mesh.triangles[triangle];
  return TriangleGeometry::Make(mesh.positions[static_cast<std::size_t>(t[0])],
                                mesh.positions[static_cast<std::size_t>(t[1])],
                                mesh.positions[static_cast<std::size_t>(t[2])]);
}
double AreaOf(const Mesh& mesh, std::size_t triangle) {
  return 0.5 * GeometryOf(mesh, triangle).double_area;
}

/// Mesh 1: a stretched cube with triangles of three sizes and brightnesses from dark to bright;
/// mesh 3: a rectangle. Meshes 0 and 2 do not shine.
struct TwoLights {
  Mesh cube = MakeCube();
  Mesh rectangle = MakeRectangle();
  std::vector<double> cube_brightness, rectangle_brightness;
  AreaSampler sampler;

  TwoLights() {
    ApplyTransform({{{0.5, 0, 0}, {0, 1.5, 0}, {0.1, 0, 0.8}}, {1, 2, 3}}, cube);
    for (std::size_t i = 0; i < cube.triangles.size(); ++i) {
      cube_brightness.push_back(0.3 * static_cast<double>(i % 4));
    }
    rectangle_brightness = {2.0, 0.5};
    sampler.AddMesh(3, rectangle, rectangle_brightness);
    sampler.AddMesh(1, cube, cube_brightness);
    sampler.Finish();
  }
};

TEST(AreaSampler, ChoosesTrianglesByAreaTimesBrightnessWithAFloor) {
  const TwoLights lights;
  double area = 0.0;
  double power = 0.0;
  const auto sum = [&](const Mesh& mesh, const std::vector<double>& brightness) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      area += AreaOf(mesh, i);
      power += AreaOf(mesh, i) * brightness[i];
    }
  };
  sum(lights.cube, lights.cube_brightness);
  sum(lights.rectangle, lights.rectangle_brightness);
  double total = 0.0;
  const auto check = [&](int index, const Mesh& mesh, const std::vector<double>& brightness) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const double pdf = lights.sampler.Pdf({index, static_cast<std::int32_t>(i)});
      const double expected = (1.0 - kFloorShare) * brightness[i] / power + kFloorShare / area;
      EXPECT_NEAR(pdf, expected, kRounding);
      total += pdf * AreaOf(mesh, i);
    }
  };
  check(1, lights.cube, lights.cube_brightness);
  check(3, lights.rectangle, lights.rectangle_brightness);
  EXPECT_NEAR(total, 1.0, kRounding) << "the density integrates to one over the lights";
  for (const int mesh : {-1, 0, 2, 4}) {
    EXPECT_EQ(lights.sampler.Pdf({mesh, 0}), 0.0);
  }
}

TEST(AreaSampler, SamplesFollowTheDensityAcrossAndInsideTriangles) {
  const TwoLights lights;
  constexpr int kParts = 4;  // each triangle is cut into 16 equal ones
  const std::size_t triangles = lights.cube.triangles.size() + lights.rectangle.triangles.size();
  std::vector<double> by_triangle(triangles), expected(triangles);
  std::vector<double> by_part(kParts * kParts), expected_part(kParts * kParts);
  CounterRng rng(31);
  const auto slot = [&](TriangleId id) {
    const auto i = static_cast<std::size_t>(id.triangle);
    return id.mesh == 1 ? i : lights.cube.triangles.size() + i;
  };
  for (int i = 0; i < kDraws; ++i) {
    const double u0 = rng.Next();
    const AreaSample sample = lights.sampler.Sample(u0, rng.Next());
    ASSERT_EQ(sample.pdf, lights.sampler.Pdf(sample.id));
    ASSERT_GE(std::min({sample.b1, sample.b2, 1.0 - sample.b1 - sample.b2}), -1e-15);
    by_triangle[slot(sample.id)] += 1.0;
    const int x = std::clamp(static_cast<int>(sample.b1 * kParts), 0, kParts - 1);
    const int y = std::clamp(static_cast<int>(sample.b2 * kParts), 0, kParts - 1);
    const bool flipped = (sample.b1 * kParts - x) + (sample.b2 * kParts - y) > 1.0;
    // Rows of 2 (kParts - y) - 1 parts.
    const int part = y * (2 * kParts - y) + 2 * x + (flipped ? 1 : 0);
    by_part[static_cast<std::size_t>(std::min(part, kParts * kParts - 1))] += 1.0;
  }
  for (int mesh : {1, 3}) {
    const Mesh& world = mesh == 1 ? lights.cube : lights.rectangle;
    for (std::size_t i = 0; i < world.triangles.size(); ++i) {
      const TriangleId id{mesh, static_cast<std::int32_t>(i)};
      expected[slot(id)] = kDraws * lights.sampler.Pdf(id) * AreaOf(world, i);
    }
  }
  expected_part.assign(kParts * kParts, static_cast<double>(kDraws) / (kParts * kParts));
  EXPECT_TRUE(tests::ChiSquareAccepts(by_triangle, expected, kSuite));
  EXPECT_TRUE(tests::ChiSquareAccepts(by_part, expected_part, kSuite));
}

/// Inside one triangle, near numbers give near points: strata of the square stay compact.
TEST(AreaSampler, NearNumbersGiveNearPoints) {
  Mesh one = MakeRectangle();
  one.triangles.resize(1);
  AreaSampler sampler;
  sampler.AddMesh(0, one, {1.0});
  sampler.Finish();
  CounterRng rng(32);
  for (int i = 0; i < 2000; ++i) {
    const double a0 = rng.Next();
    const double a1 = rng.Next();
    const double b0 = rng.Next();
    const double b1 = rng.Next();
    const AreaSample a = sampler.Sample(a0, a1);
    const AreaSample b = sampler.Sample(b0, b1);
    EXPECT_LE(std::hypot(a.b1 - b.b1, a.b2 - b.b2), 1.2 * std::hypot(a0 - b0, a1 - b1));
  }
}

TEST(AreaSampler, DarkLightsAreSampledByAreaAndNoLightLeavesItEmpty) {
  AreaSampler none;
  none.Finish();
  EXPECT_TRUE(none.Empty());
  AreaSampler dark;
  dark.AddMesh(0, MakeRectangle(), {0.0, 0.0});
  dark.Finish();
  ASSERT_FALSE(dark.Empty());
  EXPECT_NEAR(dark.Pdf({0, 0}), 0.25, kRounding);
  EXPECT_NEAR(dark.Sample(0.7, 0.3).pdf, 0.25, kRounding);
}

TEST(AreaSampler, TrianglesWithoutAreaAreNeverChosen) {
  Mesh mesh = MakeRectangle();
  mesh.triangles.push_back({0, 1, 1});
  AreaSampler sampler;
  sampler.AddMesh(0, mesh, {1.0, 1.0, 1.0});
  sampler.Finish();
  EXPECT_EQ(sampler.Pdf({0, 2}), 0.0);
  for (const double u : {0.0, 0.5, 1.0 - 1e-16}) {
    EXPECT_LT(sampler.Sample(u, 0.5).id.triangle, 2);
  }
}

/// Irradiance of a bright sphere (closed form C7) from samples on a mesh of it. The mesh lies
/// between the sphere and the one that touches its planes from inside, and irradiance of nested
/// convex bodies is ordered: that bounds the mesh's own error.
TEST(AreaSampler, SphereLightGivesTheKnownIrradiance) {
  constexpr double kRadius = 0.3;
  const Vec3 centre{0.4, -0.3, 1.5};
  Mesh sphere = MakeIcosphere(4, kRadius);
  double inner = kRadius;
  for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
    const TriangleGeometry t = GeometryOf(sphere, i);
    inner = std::min(inner, Dot(t.n, t.p0));
  }
  const double mesh_error = 1.0 - inner * inner / (kRadius * kRadius);
  ASSERT_LT(mesh_error, 5e-3);
  ApplyTransform({{}, centre}, sphere);
  AreaSampler sampler;
  sampler.AddMesh(0, sphere, std::vector<double>(sphere.triangles.size(), 1.0));
  sampler.Finish();
  CounterRng rng(33);
  tests::MeanAndError estimate;
  std::vector<double> samples;
  for (int i = 0; i < kDraws; ++i) {
    const double u0 = rng.Next();
    const AreaSample sample = sampler.Sample(u0, rng.Next());
    const TriangleGeometry t = GeometryOf(sphere, static_cast<std::size_t>(sample.id.triangle));
    const Vec3 x = t.Point(sample.b1, sample.b2);
    const double r = Norm(x);
    const double cosine = std::max(0.0, -Dot(t.n, x) / r);
    samples.push_back(cosine * (x.z / r) / (r * r) / sample.pdf);
  }
  estimate = tests::EstimateMean(samples);
  const double exact = tests::C7Sphere(kRadius, centre).value;
  EXPECT_LT(estimate.error, 0.01 * exact);
  EXPECT_LT(estimate.mean, exact + 4.0 * estimate.error);
  EXPECT_GT(estimate.mean, exact * (1.0 - mesh_error) - 4.0 * estimate.error);
  RecordProperty("z", std::to_string((estimate.mean - exact) / estimate.error));
}

}  // namespace
}  // namespace pathfit::renderer
