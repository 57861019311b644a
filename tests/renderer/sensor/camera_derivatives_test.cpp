#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "renderer/sensor/camera.h"
#include "tests/renderer/sensor/projection_formula.h"
#include "tests/renderer/sensor/test_cameras.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::camera_derivatives_test {
namespace {

using tests::AllCameras;
using tests::IntrinsicsOf;
using tests::RelativeError;
using tests::RiddersDerivative;

constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;
constexpr int kNum = CameraModel::kNumIntrinsics;

/// First Ridders step of an intrinsic: far below what folds the lens.
double StepOf(const Camera& camera, int i) { return i < 4 ? 1e-3 * camera.fx : 1e-3; }

std::size_t At(int i) { return static_cast<std::size_t>(i); }

/// Points in view: on three rays, at different depths.
std::vector<Vec3> PointsInView(const Camera& camera) {
  const CameraModel model(camera);
  std::vector<Vec3> out;
  for (const auto& [u, v, depth] :
       {std::array{0.1, 0.2, 1.0}, std::array{0.9, 0.7, 2.5}, std::array{0.45, 0.95, 0.7}}) {
    const Ray ray = model.RayThrough(u * camera.width, v * camera.height);
    out.push_back(ray.origin + ray.direction * depth);
  }
  return out;
}

TEST(CameraDerivatives, PixelByIntrinsicsThreeWays) {
  using J = ceres::Jet<double, kNum>;
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    for (const Vec3& x : PointsInView(camera)) {
      std::array<J, kNum> variables;
      for (int i = 0; i < kNum; ++i) variables[At(i)] = J(IntrinsicsOf(camera)[At(i)], i);
      const auto jet = tests::ProjectByFormula<J>(camera, variables, {J(x.x), J(x.y), J(x.z)});
      const auto hand = model.PixelByIntrinsics(x);
      for (int i = 0; i < kNum; ++i) {
        EXPECT_LT(RelativeError(hand[At(i)].x, jet[0].v[i]), kSameFormula) << camera.name << i;
        EXPECT_LT(RelativeError(hand[At(i)].y, jet[1].v[i]), kSameFormula) << camera.name << i;
        if (i >= tests::NumFreeIntrinsics(camera)) {
          continue;
        }
        for (const bool second : {false, true}) {
          const auto along = [&](double value) {
            const auto p = CameraModel(tests::WithIntrinsic(camera, i, value)).Project(x);
            return second ? p->v : p->u;
          };
          const double difference =
              RiddersDerivative(along, IntrinsicsOf(camera)[At(i)], StepOf(camera, i));
          const double derivative = second ? hand[At(i)].y : hand[At(i)].x;
          EXPECT_LT(RelativeError(derivative, difference), kDifference) << camera.name << i;
        }
      }
    }
  }
}

/// A point carried along by the ray of a fixed pixel stays in that pixel: the exact identity
/// d pixel / d number + (du, dv) . d point / d number = 0; and differences.
TEST(CameraDerivatives, RayByIntrinsicsHoldsThePixelAndAgreesWithDifferences) {
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    for (const auto& [share_u, share_v] :
         {std::array{0.1, 0.2}, std::array{0.9, 0.7}, std::array{0.0, 1.0}}) {
      const double u = share_u * camera.width;
      const double v = share_v * camera.height;
      const CameraModel::RayIntrinsics by = model.RayByIntrinsics(u, v);
      const Ray ray = model.RayThrough(u, v);
      constexpr double kDistance = 1.3;
      const Vec3 x = ray.origin + ray.direction * kDistance;
      const auto pixel = model.PixelByIntrinsics(x);
      const auto projection = model.Project(x);
      ASSERT_TRUE(projection.has_value());
      for (int i = 0; i < kNum; ++i) {
        const Vec3 moved = by.origin[At(i)] + by.direction[At(i)] * kDistance;
        const double scale = std::hypot(pixel[At(i)].x, pixel[At(i)].y) + 1e-3;
        EXPECT_NEAR(pixel[At(i)].x + Dot(projection->du, moved), 0.0, kSameFormula * scale);
        EXPECT_NEAR(pixel[At(i)].y + Dot(projection->dv, moved), 0.0, kSameFormula * scale);
        EXPECT_NEAR(Dot(by.direction[At(i)], ray.direction), 0.0, 1e-14) << "stays a unit vector";
        if (i >= tests::NumFreeIntrinsics(camera)) {
          EXPECT_EQ(moved, Vec3{});
          continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
          const auto along = [&](bool origin, double value) {
            const Ray r = CameraModel(tests::WithIntrinsic(camera, i, value)).RayThrough(u, v);
            return origin ? r.origin[axis] : r.direction[axis];
          };
          const double at = IntrinsicsOf(camera)[At(i)];
          const double step = StepOf(camera, i);
          const double floor = i < 4 ? 1.0 / camera.fx : 1.0;
          const double direction =
              RiddersDerivative([&](double value) { return along(false, value); }, at, step);
          const double origin =
              RiddersDerivative([&](double value) { return along(true, value); }, at, step);
          EXPECT_LT(RelativeError(by.direction[At(i)][axis], direction, floor), kDifference)
              << camera.name << " " << i;
          EXPECT_LT(RelativeError(by.origin[At(i)][axis], origin, floor), kDifference)
              << camera.name << " " << i;
        }
      }
    }
  }
}

/// Value and derivative by two variables, on any number type: gives the Jacobian of the lens, which
/// a Jet then differentiates once more.
template <class T>
struct Pair {
  T v, dx, dy;
  explicit Pair(double value) : v(value), dx(0.0), dy(0.0) {}
  Pair(const T& value, const T& by_x, const T& by_y) : v(value), dx(by_x), dy(by_y) {}
  friend Pair operator+(const Pair& a, const Pair& b) {
    return {a.v + b.v, a.dx + b.dx, a.dy + b.dy};
  }
  friend Pair operator*(const Pair& a, const Pair& b) {
    return {a.v * b.v, a.dx * b.v + a.v * b.dx, a.dy * b.v + a.v * b.dy};
  }
};

/// log |n . (du x dv)| by the definition: product of the Jacobians of its three maps.
template <class T>
T LogDensityByFormula(const Camera& camera,
                      const std::array<T, 9>& k,
                      const Vector3<T>& x,
                      const Vector3<T>& n) {
  using std::abs;
  using std::log;
  const Transform pose = CameraPose(camera);
  const Vector3<T> p = tests::InCamera(pose, x);
  const Vector3<T> m = tests::InCamera({pose.linear, {}}, n);
  if (camera.projection == ProjectionKind::kOrthographic) {
    return log(k[0] * k[1] * abs(m.z));
  }
  const T depth = -p.z;
  const T zero(0.0);
  const T one(1.0);
  using P = Pair<T>;
  const auto constant = [&](const T& c) { return P(c, zero, zero); };
  const auto lens = tests::DistortByFormula<P>(
      {constant(k[4]), constant(k[5]), constant(k[6]), constant(k[7]), constant(k[8])},
      P(p.x / depth, one, zero),
      P(-p.y / depth, zero, one));
  const T determinant = lens[0].dx * lens[1].dy - lens[0].dy * lens[1].dx;
  // Rows of d (x / depth, -y / depth) / d p.
  const Vector3<T> a{one / depth, zero, p.x / (depth * depth)};
  const Vector3<T> b{zero, -one / depth, -p.y / (depth * depth)};
  return log(k[0] * k[1] * abs(determinant * Dot(m, Cross(a, b))));
}

TEST(CameraDerivatives, DensityThreeWays) {
  constexpr int kVariables = 6 + kNum;
  using J = ceres::Jet<double, kVariables>;
  const Vec3 n = Normalized(Vec3{0.3, 0.5, 0.9});
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    for (const Vec3& x : PointsInView(camera)) {
      std::array<J, kNum> k;
      for (int i = 0; i < kNum; ++i) k[At(i)] = J(IntrinsicsOf(camera)[At(i)], 6 + i);
      const J jet = LogDensityByFormula<J>(
          camera, k, {J(x.x, 0), J(x.y, 1), J(x.z, 2)}, {J(n.x, 3), J(n.y, 4), J(n.z, 5)});
      const CameraModel::PixelDensity hand = model.DensityAt(x, n);
      EXPECT_NEAR(std::log(hand.value), jet.a, 1e-12);
      const auto projection = model.Project(x);
      const double by_rows = std::abs(Dot(n, Cross(projection->du, projection->dv)));
      EXPECT_LT(RelativeError(hand.value, by_rows, 0.0), 1e-12);
      const auto log_density = [](const CameraModel& m, const Vec3& at, const Vec3& normal) {
        return std::log(m.DensityAt(at, normal).value);
      };
      for (int i = 0; i < 3; ++i) {
        EXPECT_LT(RelativeError(hand.d_x[i], jet.v[i]), kSameFormula) << camera.name;
        EXPECT_LT(RelativeError(hand.d_n[i], jet.v[3 + i]), kSameFormula) << camera.name;
        const auto moved = [i](Vec3 vector, double value) {
          vector[i] = value;
          return vector;
        };
        const auto along_x = [&](double t) { return log_density(model, moved(x, t), n); };
        const auto along_n = [&](double t) { return log_density(model, x, moved(n, t)); };
        EXPECT_LT(RelativeError(hand.d_x[i], RiddersDerivative(along_x, x[i], 1e-3)), kDifference);
        EXPECT_LT(RelativeError(hand.d_n[i], RiddersDerivative(along_n, n[i], 1e-3)), kDifference);
      }
      for (int i = 0; i < kNum; ++i) {
        EXPECT_LT(RelativeError(hand.d_intrinsics[At(i)], jet.v[6 + i]), kSameFormula)
            << camera.name << " " << i;
        if (i >= tests::NumFreeIntrinsics(camera)) {
          EXPECT_EQ(hand.d_intrinsics[At(i)], 0.0);
          continue;
        }
        const auto along = [&](double value) {
          return log_density(CameraModel(tests::WithIntrinsic(camera, i, value)), x, n);
        };
        const double difference =
            RiddersDerivative(along, IntrinsicsOf(camera)[At(i)], StepOf(camera, i));
        EXPECT_LT(RelativeError(hand.d_intrinsics[At(i)], difference), kDifference)
            << camera.name << " " << i;
      }
    }
  }
}

TEST(CameraDerivatives, DensityOfAPinholeIsTheClosedForm) {
  const Camera camera = tests::PinholeCamera();
  const CameraModel model(camera);
  const Vec3 n = Normalized(Vec3{-0.2, 0.7, 0.4});
  for (const Vec3& x : PointsInView(camera)) {
    const Vec3 y = x - model.Origin();
    const double depth = -Dot(model.Pose().linear.z, y);
    const double expected = camera.fx * camera.fy * std::abs(Dot(n, y)) / (depth * depth * depth);
    EXPECT_LT(RelativeError(model.DensityAt(x, n).value, expected, 0.0), 1e-14);
  }
}

/// Area of the image of a small parallelogram of the surface, over its area.
TEST(CameraDerivatives, DensityIsTheRatioOfAreas) {
  const Vec3 n = Normalized(Vec3{0.3, 0.5, 0.9});
  const Vec3 s = Normalized(Cross(n, Vec3{0, 0, 1}));
  const Vec3 t = Cross(n, s);
  constexpr double kHalf = 1e-4;
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    for (const Vec3& x : PointsInView(camera)) {
      const auto pixel = [&](double a, double b) {
        const auto p = model.Project(x + s * (a * kHalf) + t * (b * kHalf));
        return Vec2{p->u, p->v};
      };
      const Vec2 d1 = pixel(1, 1) - pixel(-1, -1);
      const Vec2 d2 = pixel(-1, 1) - pixel(1, -1);
      const double area = 0.5 * std::abs(d1.x * d2.y - d1.y * d2.x);  // by its diagonals
      const double ratio = area / (4.0 * kHalf * kHalf);
      EXPECT_LT(RelativeError(model.DensityAt(x, n).value, ratio, 0.0), 3e-7) << camera.name;
    }
  }
}

TEST(CameraDerivatives, AreZeroWhereNothingIsSeen) {
  for (const Camera& camera : AllCameras()) {
    const CameraModel model(camera);
    const Vec3 z = model.Pose().linear.z;
    const Vec3 behind = model.Origin() + z;
    const Vec3 aside = model.Origin() - z + model.Pose().linear.x * 100.0;
    const Vec3 seen = model.RayThrough(camera.cx, camera.cy).origin - z;
    const Vec3 edge_on = model.Pose().linear.x;
    for (const auto& [x, n] :
         {std::pair{behind, z}, std::pair{aside, z}, std::pair{model.Origin(), z}}) {
      EXPECT_EQ(model.DensityAt(x, n).value, 0.0);
      EXPECT_EQ(model.DensityAt(x, n).d_x, Vec3{});
      for (const Vec2& d : model.PixelByIntrinsics(x)) EXPECT_EQ(d, Vec2{});
    }
    const CameraModel::PixelDensity grazing = model.DensityAt(seen, edge_on);
    EXPECT_NEAR(grazing.value, 0.0, 1e-8);
    EXPECT_TRUE(IsFinite(grazing.d_n));
  }
}

}  // namespace
}  // namespace pathfit::renderer::camera_derivatives_test
