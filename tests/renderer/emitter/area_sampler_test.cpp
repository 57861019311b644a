#include "renderer/emitter/area_sampler.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/triangle_kernel.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/closed_forms.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::area_sampler_test {
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
    sampler.AddMesh(3, rectangle, rectangle_brightness, false);
    sampler.AddMesh(1, cube, cube_brightness, false);
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
  sampler.AddMesh(0, one, {1.0}, false);
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
  dark.AddMesh(0, MakeRectangle(), {0.0, 0.0}, false);
  dark.Finish();
  ASSERT_FALSE(dark.Empty());
  EXPECT_NEAR(dark.Pdf({0, 0}), 0.25, kRounding);
  EXPECT_NEAR(dark.Sample(0.7, 0.3).pdf, 0.25, kRounding);
}

TEST(AreaSampler, TrianglesWithoutAreaAreNeverChosen) {
  Mesh mesh = MakeRectangle();
  mesh.triangles.push_back({0, 1, 1});
  AreaSampler sampler;
  sampler.AddMesh(0, mesh, {1.0, 1.0, 1.0}, false);
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
  sampler.AddMesh(0, sphere, std::vector<double>(sphere.triangles.size(), 1.0), false);
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

/// A point of a mesh that shines, and its density per square metre for a receiver, whichever way it
/// was drawn.
struct Drawn {
  TriangleId id;
  Vec3 x;
  double cosine = 0.0;  ///< of the angle at the light; negative behind it
  double pdf = 0.0;     ///< 0: the direction misses the mesh
};

/// Of what faces the receiver, the nearest triangle along the direction.
std::optional<Drawn> Meet(const Mesh& mesh, const Vec3& receiver, const Vec3& w) {
  std::optional<Drawn> met;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const TriangleGeometry t = GeometryOf(mesh, i);
    const double along = Dot(t.n, w);
    const double distance = Dot(t.n, t.p0 - receiver) / along;
    const Vec3 x = receiver + w * distance;
    const auto inside = [&](const Vec3& a, const Vec3& b) {
      return Dot(Cross(b - a, x - a), t.n) >= 0.0;
    };
    const Vec3 p1 = t.p0 + t.e1;
    const Vec3 p2 = t.p0 + t.e2;
    if (distance > 0.0 && distance < nearest && inside(t.p0, p1) && inside(p1, p2) &&
        inside(p2, t.p0)) {
      nearest = distance;
      met = Drawn{{0, static_cast<std::int32_t>(i)}, x, -along};
    }
  }
  return met;
}

Drawn DrawTowards(const AreaSampler& sampler,
                  const Mesh& mesh,
                  const Vec3& receiver,
                  CounterRng& rng) {
  const double u0 = rng.Next();
  const AreaChoice choice = sampler.SampleTowards(receiver, u0, rng.Next());
  if (choice.point.pdf > 0.0) {
    const TriangleGeometry t = GeometryOf(mesh, static_cast<std::size_t>(choice.point.id.triangle));
    const Vec3 x = t.Point(choice.point.b1, choice.point.b2);
    const double cosine = Dot(t.n, receiver - x) / Norm(receiver - x);
    return {choice.point.id, x, cosine, choice.point.pdf};
  }
  EXPECT_GT(choice.pdf, 0.0);
  Drawn drawn = Meet(mesh, receiver, choice.direction).value_or(Drawn{});
  drawn.pdf = choice.pdf * std::abs(drawn.cosine) / SquaredNorm(drawn.x - receiver);
  return drawn;
}

/// Lower half of a sphere around `centre`, open above.
Mesh MakeBowl(double radius, const Vec3& centre) {
  Mesh sphere = MakeIcosphere(3, radius);
  Mesh bowl = sphere;
  bowl.triangles.clear();
  for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
    if (GeometryOf(sphere, i).n.z < 0.0) {
      bowl.triangles.push_back(sphere.triangles[i]);
    }
  }
  ApplyTransform({{}, centre}, bowl);
  return bowl;
}

struct SeenShape {
  const char* name;
  Mesh mesh;
  Vec3 receiver;
  double largest_deviation;  ///< relative, of one sample, of the light that is received
};

class AreaSamplerTowards : public testing::TestWithParam<int> {
 protected:
  static SeenShape Shape(int index) {
    Mesh ball = MakeIcosphere(3, 0.25);
    ApplyTransform({{}, {0.5, -0.5, 2.0}}, ball);
    Mesh block = MakeCube();
    ApplyTransform({{{0.5, 0, 0}, {0, 0.4, 0}, {0, 0, 0.3}}, {0.3, 0.2, 3.0}}, block);
    switch (index) {
      case 0:
        return {"ball", ball, {}, 0.3};
      case 1:
        return {"ball from beside it", ball, {0.5, -0.5, 1.7}, 1.0};
      case 2:
        return {"block", block, {}, 0.5};
      case 3:
        return {"bowl", MakeBowl(0.25, {0.3, 0.8, 1.0}), {}, 0.35};
      default:
        return {"bowl from the side", MakeBowl(0.25, {2.0, 0.8, 0.1}), {}, 0.45};
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Shapes, AreaSamplerTowards, testing::Range(0, 5));

/// The light that reaches a receiver, against samples by area; less noise; densities that agree.
TEST_P(AreaSamplerTowards, GivesTheSameLightWithLittleNoise) {
  const SeenShape shape = Shape(GetParam());
  SCOPED_TRACE(shape.name);
  AreaSampler sampler;
  sampler.AddMesh(0, shape.mesh, std::vector<double>(shape.mesh.triangles.size(), 1.0), false);
  sampler.Finish();
  // Without visibility a bowl or a ball hides nothing that faces the receiver.
  const auto flux = [&](const Drawn& d) {
    return d.pdf > 0.0 ? std::max(d.cosine, 0.0) / SquaredNorm(d.x - shape.receiver) / d.pdf : 0.0;
  };
  CounterRng rng(34);
  std::vector<double> towards, by_area;
  for (int i = 0; i < kDraws / 10; ++i) {
    const Drawn drawn = DrawTowards(sampler, shape.mesh, shape.receiver, rng);
    towards.push_back(flux(drawn));
    if (drawn.pdf > 0.0) {
      const Vec3 way = drawn.x - shape.receiver;
      const double expected = sampler.PdfTowards(shape.receiver,
                                                 drawn.id,
                                                 way * (1.0 / Norm(way)),
                                                 std::abs(drawn.cosine) / SquaredNorm(way));
      EXPECT_NEAR(drawn.pdf / expected, 1.0, 1e-6);
    }
  }
  for (int i = 0; i < 4 * kDraws; ++i) {
    const double u0 = rng.Next();
    const AreaSample y = sampler.Sample(u0, rng.Next());
    const TriangleGeometry t = GeometryOf(shape.mesh, static_cast<std::size_t>(y.id.triangle));
    const Vec3 x = t.Point(y.b1, y.b2);
    by_area.push_back(
        flux({y.id, x, Dot(t.n, shape.receiver - x) / Norm(shape.receiver - x), y.pdf}));
  }
  const tests::MeanAndError a = tests::EstimateMean(towards);
  const tests::MeanAndError b = tests::EstimateMean(by_area);
  EXPECT_LT(std::abs(a.mean - b.mean), 4.0 * std::hypot(a.error, b.error));
  EXPECT_LT(a.error * std::sqrt(static_cast<double>(towards.size())),
            shape.largest_deviation * a.mean);
}

/// Of two lamps the near one is looked at, however they are listed; all that may shine is found.
TEST(AreaSampler, ReceiversLookAtWhatIsNear) {
  Mesh near = MakeRectangle();
  ApplyTransform({{}, {0.0, 0.0, -1.0}}, near);
  Mesh far = MakeRectangle();
  ApplyTransform({{}, {0.0, 0.0, -100.0}}, far);
  AreaSampler sampler;
  sampler.AddMesh(4, far, {1.0, 1.0}, false);
  sampler.AddMesh(2, near, {1.0, 1.0}, false);
  sampler.Finish();
  CounterRng rng(35);
  int at_near = 0;
  for (int i = 0; i < 1000; ++i) {
    const double u0 = rng.Next();
    const AreaChoice choice = sampler.SampleTowards({0.0, 0.0, 0.0}, u0, rng.Next());
    at_near += choice.mesh == 2 ? 1 : 0;
  }
  EXPECT_GT(at_near, 990);
  double total = 0.0;
  for (const int mesh : {2, 4}) {
    for (const int triangle : {0, 1}) {
      const double pdf =
          sampler.PdfTowards({0.0, 0.0, 0.0}, {mesh, triangle}, {0.0, 0.0, -1.0}, 1.0);
      EXPECT_GT(pdf, 0.0);
      total += pdf * AreaOf(near, static_cast<std::size_t>(triangle));
    }
  }
  EXPECT_NEAR(total, 1.0, kRounding);
}

}  // namespace
}  // namespace pathfit::renderer::area_sampler_test
