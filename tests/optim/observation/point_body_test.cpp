#include "optim/observation/point_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_topology.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/optim/observation/ball_views.h"

namespace pathfit::optim::point_body_test {
namespace {

using renderer::Mesh;
using renderer::Vec3;

constexpr double kFills = 0.9;  // radius of the ball that is looked into

std::vector<renderer::Camera> Cameras() {
  std::vector<renderer::Camera> cameras;
  for (const View& view : BallFromAllSides().views) cameras.push_back(view.camera);
  return cameras;
}

/// Spread over a sphere, without those that a slice leaves out.
std::vector<Vec3> OnSphere(double radius, int count) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count;
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    points.push_back(kCenter + Vec3{r * std::cos(angle), r * std::sin(angle), z} * radius);
  }
  return points;
}

double VolumeOf(const Mesh& mesh) {
  double six = 0.0;
  for (const renderer::Triangle& t : mesh.triangles) {
    const auto at = [&](int k) {
      return mesh.positions[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])] - kCenter;
    };
    six += Dot(at(0), Cross(at(1), at(2)));
  }
  return six / 6.0;
}

TEST(PointBody, IsTheBallThatThePointsLieOnWhateverLiesAround) {
  std::vector<Vec3> points = OnSphere(kRadius, 4000);
  renderer::CounterRng rng(1, renderer::RandomDomain{9}, 0, 0, 0);
  for (int i = 0; i < 40; ++i) {  // mismatches, and a wall far behind
    const Vec3 random{rng.Next() - 0.5, rng.Next() - 0.5, rng.Next() - 0.5};
    points.push_back(kCenter + random * 1.5);
    points.push_back(kCenter + random * 5.0 + Vec3{20.0, 0.0, 0.0});
  }
  const auto body = BodyOfPoints(points, Cameras(), kCenter + Vec3{0.03, 0.0, 0.0}, kFills);
  ASSERT_TRUE(body);
  EXPECT_NO_THROW(ValidateMesh(*body, "body"));
  EXPECT_EQ(renderer::CornerFans::Build(*body).num_unpaired, 0U) << "closed";
  double farthest = 0.0, nearest = 1.0;
  for (const Vec3& p : body->positions) {
    farthest = std::max(farthest, Norm(p - kCenter));
    nearest = std::min(nearest, Norm(p - kCenter));
  }
  EXPECT_GT(nearest, 0.9 * kRadius);
  EXPECT_LT(farthest, 1.4 * kRadius) << "at mismatches";
  const double ball = 4.0 / 3.0 * std::numbers::pi * std::pow(kRadius, 3);
  EXPECT_NEAR(VolumeOf(*body) / ball, 1.25, 0.2);
}

// Where the surface shows nothing that can be matched, points are missing.
TEST(PointBody, ClosesGapsBetweenPoints) {
  std::vector<Vec3> points = OnSphere(kRadius, 1500);
  std::erase_if(points, [](const Vec3& p) {
    return Norm(p - kCenter - Vec3{kRadius, 0, 0}) < 0.12;
  });
  const auto body = BodyOfPoints(points, Cameras(), kCenter, kFills);
  ASSERT_TRUE(body);
  EXPECT_GT(std::ranges::max(body->positions, {}, &Vec3::x).x, kCenter.x + 0.8 * kRadius);
}

TEST(PointBody, PointsThatEncloseNoBodyTellNone) {
  const std::vector<Vec3> ball = OnSphere(kRadius, 1500);
  std::vector<renderer::Camera> few = Cameras();
  few.resize(5);
  EXPECT_FALSE(BodyOfPoints(ball, few, kCenter, kFills));
  EXPECT_FALSE(BodyOfPoints(OnSphere(kRadius, 150), Cameras(), kCenter, kFills));
  EXPECT_FALSE(BodyOfPoints(ball, Cameras(), kCenter, 0.0));
  EXPECT_FALSE(BodyOfPoints(ball, Cameras(), kCenter + Vec3{0.0, 3.0, 0.0}, kFills));
  EXPECT_FALSE(BodyOfPoints(OnSphere(0.98 * kFills, 4000), Cameras(), kCenter, kFills)) << "a room";
  const std::vector<Vec3> one_place(1000, kCenter);
  EXPECT_FALSE(BodyOfPoints(one_place, Cameras(), kCenter, kFills));
}

}  // namespace
}  // namespace pathfit::optim::point_body_test
