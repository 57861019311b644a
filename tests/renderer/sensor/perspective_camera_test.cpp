#include "renderer/sensor/perspective_camera.h"

#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer {
namespace {

constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;
constexpr double kPixelRounding = 1e-9;

/// Intrinsics of the axe photographs (data set axe_turntable, first sensor).
PerspectiveCamera AxeCamera() {
  PerspectiveCamera camera;
  camera.name = "axe";
  camera.width = 1024;
  camera.height = 683;
  camera.fx = 2400.1110774652225;
  camera.fy = 2401.2830067022664;
  camera.cx = 516.4634165229311;
  camera.cy = 304.13975884046266;
  camera.distortion = {0.05228029183302142, 1.4826426326959588, -12.25221025290341, 0.0, 0.0};
  camera.world_from_camera = {{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, {0, 0, 0}};
  return camera;
}
PerspectiveCamera WideCamera() {
  PerspectiveCamera camera;
  camera.name = "wide";
  camera.width = 200;
  camera.height = 120;
  camera.fx = 110.0;
  camera.fy = 105.0;
  camera.cx = 95.0;
  camera.cy = 64.0;
  camera.distortion = {-0.20, 0.06, -0.005, 0.01, -0.015};
  camera.world_from_camera = LookAt({0.4, -0.3, 2.0}, {0.1, 0.0, 0.0}, {0.1, 1.0, 0.0});
  return camera;
}
PerspectiveCamera BarrelToPincushion() {
  PerspectiveCamera camera = WideCamera();
  camera.distortion = {0.35, -0.1, 0.02, -0.02, 0.01};
  return camera;
}

TEST(PerspectiveCamera, PixelCentresAndAxes) {
  PerspectiveCamera camera;
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

TEST(PerspectiveCamera, ProjectUndoesRayThroughAlsoWithStrongDistortion) {
  for (const PerspectiveCamera& camera : {AxeCamera(), WideCamera(), BarrelToPincushion()}) {
    const CameraModel model(camera);
    CounterRng rng(3, 0, 0, 0, 0);
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

/// The projection written once more, on any number type.
template <class T>
std::array<T, 2> ProjectByFormula(const PerspectiveCamera& camera, const Vector3<T>& x) {
  const Transform m = RigidInverse(camera.world_from_camera);
  const auto row = [&](double a, double b, double c, double d) {
    return x.x * T(a) + x.y * T(b) + x.z * T(c) + T(d);
  };
  const T px = row(m.linear.x.x, m.linear.y.x, m.linear.z.x, m.translation.x);
  const T py = row(m.linear.x.y, m.linear.y.y, m.linear.z.y, m.translation.y);
  const T pz = row(m.linear.x.z, m.linear.y.z, m.linear.z.z, m.translation.z);
  const T a = px / -pz;
  const T b = -py / -pz;
  const LensDistortion& k = camera.distortion;
  const T r2 = a * a + b * b;
  const T radial = T(1.0) + T(k.k1) * r2 + T(k.k2) * r2 * r2 + T(k.k3) * r2 * r2 * r2;
  const T u = a * radial + T(2.0 * k.p1) * a * b + T(k.p2) * (r2 + T(2.0) * a * a);
  const T v = b * radial + T(k.p1) * (r2 + T(2.0) * b * b) + T(2.0 * k.p2) * a * b;
  return {u * T(camera.fx) + T(camera.cx), v * T(camera.fy) + T(camera.cy)};
}

TEST(PerspectiveCamera, ProjectionDerivativesThreeWays) {
  using J = ceres::Jet<double, 3>;
  for (const PerspectiveCamera& camera : {AxeCamera(), WideCamera(), BarrelToPincushion()}) {
    const CameraModel model(camera);
    for (const auto& [u, v, depth] :
         {std::array{0.1, 0.2, 1.0}, std::array{0.9, 0.7, 2.5}, std::array{0.5, 0.95, 0.7}}) {
      const Ray ray = model.RayThrough(u * camera.width, v * camera.height);
      const Vec3 x = ray.origin + ray.direction * depth;
      const auto hand = model.Project(x);
      ASSERT_TRUE(hand.has_value());
      const auto jet = ProjectByFormula<J>(camera, {J(x.x, 0), J(x.y, 1), J(x.z, 2)});
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

TEST(PerspectiveCamera, RefusesDistortionThatFoldsInsideTheImage) {
  PerspectiveCamera camera = WideCamera();
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
TEST(PerspectiveCamera, PointsBeyondTheFieldOfViewDoNotProject) {
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

TEST(PerspectiveCamera, RefusesBadNumbersNamingTheCamera) {
  const auto refuse = [](auto change) {
    PerspectiveCamera camera = WideCamera();
    change(camera);
    EXPECT_THROW(CameraModel{camera}, SceneError);
  };
  refuse([](PerspectiveCamera& c) { c.width = 0; });
  refuse([](PerspectiveCamera& c) { c.fx = 0.0; });
  refuse([](PerspectiveCamera& c) { c.fy = -1.0; });
  refuse([](PerspectiveCamera& c) { c.cx = std::nan(""); });
  refuse([](PerspectiveCamera& c) { c.distortion.k2 = INFINITY; });
  refuse([](PerspectiveCamera& c) { c.gain = 0.0; });
  refuse([](PerspectiveCamera& c) { c.world_from_camera.translation.x = std::nan(""); });
  refuse([](PerspectiveCamera& c) {
    c.world_from_camera.linear.x = c.world_from_camera.linear.x * 1.01;
  });
  refuse(
      [](PerspectiveCamera& c) { c.world_from_camera.linear.x = -c.world_from_camera.linear.x; });
}

TEST(PerspectiveCamera, ScaledAndCroppedCamerasSeeTheSameRays) {
  const PerspectiveCamera camera = WideCamera();
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
}

}  // namespace
}  // namespace pathfit::renderer
