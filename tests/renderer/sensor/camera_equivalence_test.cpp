#include <cmath>

#include <gtest/gtest.h>

#include "renderer/sensor/camera.h"
#include "tests/renderer/sensor/test_cameras.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::camera_equivalence_test {
namespace {

using tests::AllCameras;
using tests::RelativeError;
using tests::RiddersDerivative;

constexpr double kRounding = 1e-12;
constexpr double kDifference = 1e-6;

std::vector<Vec3> PointsInView(const Camera& camera) {
  const CameraModel model(camera);
  std::vector<Vec3> out;
  for (const auto& [u, v, depth] :
       {std::array{0.15, 0.2, 1.0}, std::array{0.85, 0.7, 2.5}, std::array{0.45, 0.9, 0.7}}) {
    const Ray ray = model.RayThrough(u * camera.width, v * camera.height);
    out.push_back(ray.origin + ray.direction * depth);
  }
  return out;
}

Vec3 SurfaceNormal() { return Normalized(Vec3{0.3, 0.5, 0.9}); }

/// Camera and world moved by the same rigid motion see the same; derivatives by the point turn.
TEST(CameraEquivalence, MovingTheCameraEqualsMovingTheWorldBack) {
  const Transform motion{RotationFromVector({0.7, -1.2, 0.4}), {0.5, -2.0, 1.5}};
  const Transform back = RigidInverse(motion);
  const Vec3 normal = SurfaceNormal();
  for (const Camera& camera : AllCameras()) {
    Camera moved = camera;
    // `rotation` acts after world_from_camera, about the centre: the motion comes after both.
    moved.world_from_camera = motion * CameraPose(camera);
    moved.rotation = {};
    const CameraModel model(camera);
    const CameraModel moved_model(moved);
    for (const Vec3& y : PointsInView(camera)) {
      const Vec3 x = motion.Point(y);  // seen by the moved camera as y = back x by the other
      const auto a = moved_model.Project(x);
      const auto b = model.Project(back.Point(x));
      ASSERT_TRUE(a.has_value() && b.has_value());
      const double scale = Norm(b->du);
      EXPECT_NEAR(a->u, b->u, 1e-9);
      EXPECT_NEAR(a->v, b->v, 1e-9);
      EXPECT_NEAR(a->depth, b->depth, kRounding);
      EXPECT_LT(Norm(a->du - motion.Direction(b->du)), kRounding * scale);
      EXPECT_LT(Norm(a->dv - motion.Direction(b->dv)), kRounding * scale);
      const auto density = moved_model.DensityAt(x, motion.Direction(normal));
      const auto expected = model.DensityAt(y, normal);
      EXPECT_LT(RelativeError(density.value, expected.value, 0.0), kRounding);
      EXPECT_LT(Norm(density.d_x - motion.Direction(expected.d_x)), 1e-10);
      EXPECT_LT(Norm(density.d_n - motion.Direction(expected.d_n)), 1e-10);
    }
  }
}

/// Where a camera looks, as a function of one component of a pose parameter.
Camera WithPose(const Camera& camera, bool rotates, int axis, double value) {
  Camera out = camera;
  (rotates ? out.rotation : out.world_from_camera.translation)[axis] = value;
  return out;
}

double PoseValue(const Camera& camera, bool rotates, int axis) {
  return (rotates ? camera.rotation : camera.world_from_camera.translation)[axis];
}

/// Velocity, in the camera's view, of a world point at x with the camera's component `axis` moving
/// at unit rate: the world moves back.
Vec3 WorldVelocity(const Camera& camera, bool rotates, int axis, const Vec3& x) {
  Vec3 unit;
  unit[axis] = 1.0;
  if (!rotates) {
    return -unit;
  }
  const Vec3 turn = RotationLeftJacobian(camera.rotation) * unit;
  return -Cross(turn, x - camera.world_from_camera.translation);
}

TEST(CameraEquivalence, ProjectionByPoseIsMinusTheProjectionByTheWorldsMotion) {
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    for (const Vec3& x : PointsInView(camera)) {
      const auto here = model.Project(x);
      for (const bool rotates : {false, true}) {
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3 velocity = WorldVelocity(camera, rotates, axis, x);
          for (const bool second : {false, true}) {
            const auto along = [&](double value) {
              const auto p = CameraModel(WithPose(camera, rotates, axis, value)).Project(x);
              return second ? p->v : p->u;
            };
            const double difference =
                RiddersDerivative(along, PoseValue(camera, rotates, axis), 1e-3);
            const Vec3& row = second ? here->dv : here->du;
            EXPECT_LT(RelativeError(Dot(row, velocity), difference, Norm(row)), kDifference)
                << camera.name;
          }
        }
      }
    }
  }
}

TEST(CameraEquivalence, DensityByPoseIsThatOfTheWorldsMotion) {
  const Vec3 normal = SurfaceNormal();
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    for (const Vec3& x : PointsInView(camera)) {
      const auto here = model.DensityAt(x, normal);
      for (const bool rotates : {false, true}) {
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3 velocity = WorldVelocity(camera, rotates, axis, x);
          // The normal is a direction: it turns with the world and does not translate.
          const Vec3 turn =
              rotates
                  ? WorldVelocity(camera, true, axis, camera.world_from_camera.translation + normal)
                  : Vec3{};
          const auto along = [&](double value) {
            const CameraModel moved(WithPose(camera, rotates, axis, value));
            return std::log(moved.DensityAt(x, normal).value);
          };
          const double difference =
              RiddersDerivative(along, PoseValue(camera, rotates, axis), 1e-3);
          const double by_world = Dot(here.d_x, velocity) + Dot(here.d_n, turn);
          EXPECT_LT(RelativeError(by_world, difference), kDifference) << camera.name;
        }
      }
    }
  }
}

TEST(CameraEquivalence, RaysTurnWithTheCamera) {
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    const double u = 0.2 * camera.width;
    const double v = 0.7 * camera.height;
    const Ray ray = model.RayThrough(u, v);
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 unit;
      unit[axis] = 1.0;
      const Vec3 turn = RotationLeftJacobian(camera.rotation) * unit;
      const Vec3 direction = Cross(turn, ray.direction);
      const Vec3 origin = Cross(turn, ray.origin - model.Origin());
      for (int i = 0; i < 3; ++i) {
        const auto along = [&](bool of_origin, double value) {
          const Ray r = CameraModel(WithPose(camera, true, axis, value)).RayThrough(u, v);
          return of_origin ? r.origin[i] : r.direction[i];
        };
        const double at = camera.rotation[axis];
        EXPECT_NEAR(RiddersDerivative([&](double t) { return along(false, t); }, at, 1e-2),
                    direction[i],
                    1e-9);
        EXPECT_NEAR(
            RiddersDerivative([&](double t) { return along(true, t); }, at, 1e-2), origin[i], 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::camera_equivalence_test
