#include "renderer/sensor/camera.h"

#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/renderer/sensor/projection_formula.h"
#include "tests/renderer/sensor/test_cameras.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::camera_test {
namespace {

constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;
constexpr double kPixelRounding = 1e-9;

using tests::AllCameras;
using tests::AxeCamera;
using tests::BarrelCamera;
using tests::ParallelCamera;
using tests::PinholeCamera;

TEST(Camera, PixelCentresAndAxes) {
  Camera camera;
  camera.width = 4;
  camera.height = 2;
  camera.fx = camera.fy = 2.0;
  camera.cx = 2.0;
  camera.cy = 1.0;
  const CameraModel model(camera);
  EXPECT_EQ(model.RayThrough(2.0, 1.0).direction, (Vec3{0, 0, -1}));
  // Centre of the top-left pixel: half a pixel inside the corner, up and to the left.
  const Vec3 d = model.RayThrough(0.5, 0.5).direction;
  EXPECT_NEAR(d.x / -d.z, -0.75, 1e-15);
  EXPECT_NEAR(d.y / -d.z, 0.25, 1e-15);
  const auto right_up = model.Project({0.2, 0.1, -1.0});
  ASSERT_TRUE(right_up.has_value());
  EXPECT_NEAR(right_up->u, 2.4, 1e-15);
  EXPECT_NEAR(right_up->v, 0.8, 1e-15);
  EXPECT_EQ(right_up->depth, 1.0);
  EXPECT_FALSE(model.Project({0, 0, 1}).has_value()) << "behind the camera";
  EXPECT_FALSE(model.Project({0, 0, 0}).has_value());
}

TEST(Camera, ProjectUndoesRayThroughAlsoWithStrongDistortion) {
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    CounterRng rng(3);
    for (int i = 0; i < 3000; ++i) {
      // Borders and corners included.
      const double u = camera.width * std::min(1.0, std::max(0.0, 1.2 * rng.Next() - 0.1));
      const double v = camera.height * std::min(1.0, std::max(0.0, 1.2 * rng.Next() - 0.1));
      const Ray ray = model.RayThrough(u, v);
      EXPECT_NEAR(Norm(ray.direction), 1.0, 1e-14);
      const auto projection = model.Project(ray.origin + ray.direction * (0.5 + 5.0 * rng.Next()));
      ASSERT_TRUE(projection.has_value()) << camera.name << " " << u << " " << v;
      EXPECT_NEAR(projection->u, u, kPixelRounding);
      EXPECT_NEAR(projection->v, v, kPixelRounding);
    }
  }
}

TEST(Camera, ProjectionDerivativesThreeWays) {
  using J = ceres::Jet<double, 3>;
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    for (const auto& [u, v, depth] :
         {std::array{0.1, 0.2, 1.0}, std::array{0.9, 0.7, 2.5}, std::array{0.5, 0.95, 0.7}}) {
      const Ray ray = model.RayThrough(u * camera.width, v * camera.height);
      const Vec3 x = ray.origin + ray.direction * depth;
      const auto hand = model.Project(x);
      ASSERT_TRUE(hand.has_value());
      const auto jet = tests::ProjectByFormula<J>(camera,
                                                  tests::Constants<J>(tests::IntrinsicsOf(camera)),
                                                  {J(x.x, 0), J(x.y, 1), J(x.z, 2)});
      const std::array<Vec3, 2> rows = {hand->du, hand->dv};
      EXPECT_NEAR(hand->u, jet[0].a, kPixelRounding);
      EXPECT_NEAR(hand->v, jet[1].a, kPixelRounding);
      for (std::size_t k = 0; k < 2; ++k) {
        for (int i = 0; i < 3; ++i) {
          const auto along = [&](double value) {
            Vec3 moved = x;
            moved[i] = value;
            const auto p = model.Project(moved);
            return k == 0 ? p->u : p->v;
          };
          const double scale = camera.fx / depth;
          EXPECT_LT(tests::RelativeError(rows[k][i], jet[k].v[i], scale), kSameFormula);
          EXPECT_LT(tests::RelativeError(
                        rows[k][i], tests::RiddersDerivative(along, x[i], 1e-3 * depth), scale),
                    kDifference);
        }
      }
    }
  }
}

TEST(Camera, RefusesDistortionThatFoldsInsideTheImage) {
  Camera camera = BarrelCamera();
  camera.distortion = {-0.9, 0.0, 0.0, 0.0, 0.0};
  EXPECT_THROW(CameraModel{camera}, SceneError);
  camera.distortion = {0.0, 0.0, -1.5, 0.0, 0.0};
  EXPECT_THROW(CameraModel{camera}, SceneError);
  try {
    const CameraModel model(camera);
    FAIL();
  } catch (const SceneError& e) {
    EXPECT_NE(std::string(e.what()).find("wide"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("folds"), std::string::npos) << e.what();
  }
}

/// A polynomial that folds far outside the image must not bring points from there back into it.
TEST(Camera, PointsBeyondTheFieldOfViewDoNotProject) {
  const CameraModel model(AxeCamera());
  int inside = 0;
  for (int i = 0; i < 400; ++i) {
    const double slope =
        0.01 * i;  // up to 76 degrees off axis, where k3 has long turned the image over
    const auto projection = model.Project({slope, 0.0, 1.0});
    if (projection) {
      EXPECT_LT(slope, 0.3);
      ++inside;
    }
  }
  EXPECT_GT(inside, 20);
}

TEST(Camera, RefusesBadNumbersNamingTheCamera) {
  const auto refuse = [](auto change) {
    Camera camera = BarrelCamera();
    change(camera);
    EXPECT_THROW(CameraModel{camera}, SceneError);
  };
  refuse([](Camera& c) { c.width = 0; });
  refuse([](Camera& c) { c.fx = 0.0; });
  refuse([](Camera& c) { c.fy = -1.0; });
  refuse([](Camera& c) { c.cx = std::nan(""); });
  refuse([](Camera& c) { c.distortion.k2 = INFINITY; });
  refuse([](Camera& c) { c.gain = 0.0; });
  refuse([](Camera& c) { c.rotation.y = std::nan(""); });
  refuse([](Camera& c) { c.rotation.y = 1e200; });
  refuse([](Camera& c) { c.filter.radius = 0.0; });
  refuse([](Camera& c) { c.filter.radius = 8.1; });
  refuse([](Camera& c) { c.filter.radius = std::nan(""); });
  refuse([](Camera& c) { c.filter = {PixelFilter::Shape::kGaussian, 2.0, 0.0}; });
  refuse([](Camera& c) { c.filter = {PixelFilter::Shape::kGaussian, 2.0, INFINITY}; });
  refuse([](Camera& c) { c.projection = ProjectionKind::kOrthographic; });
  refuse([](Camera& c) { c.world_from_camera.translation.x = std::nan(""); });
  refuse([](Camera& c) { c.world_from_camera.linear.x = c.world_from_camera.linear.x * 1.01; });
  refuse([](Camera& c) { c.world_from_camera.linear.x = -c.world_from_camera.linear.x; });
}

TEST(Camera, ScaledAndCroppedCamerasSeeTheSameRays) {
  Camera camera = tests::PincushionCamera();
  camera.filter = {PixelFilter::Shape::kGaussian, 2.0, 0.7};
  camera.gain = 1.5;
  const CameraModel full(camera);
  const CameraModel half(ScaledCamera(camera, 100, 30));
  const CameraModel crop(CroppedCamera(camera, 20, 10, 50, 40));
  for (const Vec2& at : {Vec2{30.0, 20.0}, Vec2{55.5, 41.25}}) {
    const Vec3 d = full.RayThrough(at.x, at.y).direction;
    EXPECT_NEAR(Norm(half.RayThrough(0.5 * at.x, 0.25 * at.y).direction - d), 0.0, 1e-13);
    EXPECT_NEAR(Norm(crop.RayThrough(at.x - 20.0, at.y - 10.0).direction - d), 0.0, 1e-13);
  }
  EXPECT_EQ(crop.camera().width, 50);
  EXPECT_EQ(half.camera().height, 30);
  for (const CameraModel& part : {half, crop}) {
    EXPECT_EQ(part.camera().filter, camera.filter) << "in pixels of the image at hand";
    EXPECT_EQ(part.camera().rotation, camera.rotation);
    EXPECT_EQ(part.camera().gain, camera.gain);
  }
}

TEST(Camera, RotationTurnsTheViewAboutTheCentreInTheWorldFrame) {
  Camera camera = BarrelCamera();
  const CameraModel straight(camera);
  camera.rotation = Vec3{0.0, 0.5, 0.0};
  const CameraModel turned(camera);
  EXPECT_EQ(straight.Pose(), camera.world_from_camera);
  EXPECT_EQ(turned.Pose(), CameraPose(camera));
  EXPECT_EQ(turned.Origin(), straight.Origin());
  const Vec3 expected =
      RotationAboutAxis({0, 1, 0}, 0.5) * straight.RayThrough(30.0, 90.0).direction;
  EXPECT_LT(Norm(turned.RayThrough(30.0, 90.0).direction - expected), 1e-14);
}

TEST(Camera, ParallelRaysStartInThePlaneOfTheCentre) {
  const Camera camera = ParallelCamera();
  const CameraModel model(camera);
  const Vec3 axis = -model.Pose().linear.z;
  const Ray middle = model.RayThrough(camera.cx, camera.cy);
  EXPECT_LT(Norm(middle.origin - model.Origin()), 1e-14);
  const Ray ray = model.RayThrough(camera.cx + 2.0 * camera.fx, camera.cy + 3.0 * camera.fy);
  EXPECT_EQ(ray.direction, axis);
  EXPECT_NEAR(Dot(ray.origin - model.Origin(), axis), 0.0, 1e-14);
  EXPECT_NEAR(Norm(ray.origin - model.Origin()), std::sqrt(13.0), 1e-12) << "pixels per metre";
  EXPECT_FALSE(model.Project(middle.origin - axis * 0.1).has_value()) << "behind the plane";
  EXPECT_FALSE(model.Project(middle.origin).has_value());
  EXPECT_NEAR(model.Project(middle.origin + axis * 0.1)->depth, 0.1, 1e-14);
  const double border = std::hypot(105.0 / 55.0, 64.0 / 52.0);
  EXPECT_GE(model.MaxTangent(), border) << "metres from the axis to the farthest corner";
  EXPECT_LT(model.MaxTangent(), 1.1 * border);
}

TEST(Camera, RayToGoesBackWhereRayThroughCameFrom) {
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    const Ray seen = model.RayThrough(0.3 * camera.width, 0.8 * camera.height);
    const Vec3 x = seen.origin + seen.direction * 1.7;
    double distance = 0.0;
    const Ray back = model.RayTo(x, distance);
    EXPECT_EQ(back.origin, x);
    EXPECT_NEAR(distance, 1.7, 1e-14);
    EXPECT_LT(Norm(back.direction + seen.direction), 1e-14);
    EXPECT_LT(Norm(back.origin + back.direction * distance - seen.origin), 1e-14);
  }
  double distance = 0.0;
  const CameraModel parallel(ParallelCamera());
  (void)parallel.RayTo(parallel.Origin() + parallel.Pose().linear.z, distance);
  EXPECT_NEAR(distance, -1.0, 1e-14) << "behind the plane";
  const CameraModel pinhole(PinholeCamera());
  EXPECT_TRUE(IsFinite(pinhole.RayTo(pinhole.Origin(), distance).direction));
}

/// A pixel at the border looks past it, by its filter's radius.
TEST(Camera, WhatAFilterSeesBeyondTheBorderProjects) {
  for (Camera camera : AllCameras()) {
    if (camera.name == "axe") {
      continue;  // its polynomial folds a few pixels beyond the image
    }
    camera = ScaledCamera(camera, 20, 12);
    camera.filter = {PixelFilter::Shape::kTent, 3.0, 0.0};
    const CameraModel model(camera);
    for (const Vec2& at : {Vec2{-2.5, -2.5}, Vec2{22.5, 6.0}, Vec2{22.5, 14.5}, Vec2{3.0, 14.5}}) {
      const Ray ray = model.RayThrough(at.x, at.y);
      const auto projection = model.Project(ray.origin + ray.direction);
      ASSERT_TRUE(projection.has_value()) << camera.name << " " << at.x << " " << at.y;
      EXPECT_NEAR(projection->u, at.x, kPixelRounding);
      EXPECT_NEAR(projection->v, at.y, kPixelRounding);
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::camera_test
