#include "tests/renderer/theory/geometry_term.h"

#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::tests::geometry_term_test {
namespace {

using renderer::OrientedPoint;
using renderer::Pinhole;
using renderer::PinholeImage;
using renderer::PinholeMotion;
using renderer::Vec3;
using renderer::Vector3;
using J = ceres::Jet<double, 1>;

constexpr double kRounding = 1e-13;
constexpr double kDifference = 1e-9;

/// a + t b in number type T.
template <class T>
Vector3<T> Moved(const Vec3& a, const Vec3& b, const T& t) {
  return {a.x + t * b.x, a.y + t * b.y, a.z + t * b.z};
}
template <class T>
OrientedPoint<T> Moved(const OrientedPoint<double>& a, const OrientedPoint<double>& b, const T& t) {
  return {Moved(a.x, b.x, t), Moved(a.n, b.n, t)};
}

struct Pair {
  OrientedPoint<double> x{{0.1, -0.2, 0.3}, {0.28, 0.0, 0.96}};
  OrientedPoint<double> y{{0.7, 0.5, 1.9}, {0.48, -0.6, -0.64}};
  OrientedPoint<double> x_rate{{0.3, -0.4, 0.2}, {0.48, 0.7, -0.14}};
  OrientedPoint<double> y_rate{{-0.6, 0.1, 0.5}, {0.4, 0.32, 0.0}};
};

TEST(GeometryTerm, IsSymmetricAndWhatItSays) {
  const Pair p;
  const Vec3 d = p.y.x - p.x.x;
  const double r = Norm(d);
  const double expected = std::abs(Dot(p.x.n, d / r)) * std::abs(Dot(p.y.n, d / r)) / (r * r);
  EXPECT_NEAR(GeometryTerm(p.x, p.y), expected, kRounding);
  EXPECT_EQ(GeometryTerm(p.x, p.y), GeometryTerm(p.y, p.x));
}

TEST(GeometryTerm, LogDerivativeThreeWays) {
  const Pair p;
  const double hand = LogGeometryTermDerivative(p.x, p.y, p.x_rate, p.y_rate);
  const auto g = [&](const auto& t) {
    return GeometryTerm(Moved(p.x, p.x_rate, t), Moved(p.y, p.y_rate, t));
  };
  const J jet = g(J(0.0, 0));
  EXPECT_NEAR(hand, jet.v[0] / jet.a, kRounding);
  EXPECT_NEAR(hand, RiddersDerivative(g, 0.0, 0.1) / g(0.0), kDifference);
}

TEST(GeometryTerm, RigidMotionKeepsItAndScalingBringsMinusTwice) {
  const Pair p;
  const Vec3 spin{0.4, -0.3, 0.9};
  const auto rigid = [&](const OrientedPoint<double>& a) -> OrientedPoint<double> {
    return {Vec3{0.1, 0.2, 0.3} + Cross(spin, a.x), Cross(spin, a.n)};
  };
  EXPECT_NEAR(LogGeometryTermDerivative(p.x, p.y, rigid(p.x), rigid(p.y)), 0.0, kRounding);
  EXPECT_NEAR(LogGeometryTermDerivative(p.x, p.y, {p.x.x, {}}, {p.y.x, {}}), -2.0, kRounding);
}

struct View {
  Pinhole<double> camera{
      {0.2, -0.1, -0.4}, {0.8, 0.0, -0.6}, {0.0, -1.0, 0.0}, {0.6, 0.0, 0.8}, 300.0};
  PinholeMotion<double> motion{{0.4, 0.3, -0.2}, {0.1, -0.5, 0.25}};
  OrientedPoint<double> x{{0.9, 0.3, 1.7}, {0.0, 0.6, -0.8}};
  OrientedPoint<double> x_rate{{-0.6, 0.1, 0.5}, {0.3, 0.4, 0.3}};

  /// The camera after time t: axes to first order in t, which is all a derivative sees.
  template <class T>
  [[nodiscard]] Pinhole<T> At(const T& t) const {
    const auto turned = [&](const Vec3& axis) { return Moved(axis, Cross(motion.spin, axis), t); };
    return {Moved(camera.centre, motion.velocity, t),
            turned(camera.right),
            turned(camera.down),
            turned(camera.axis),
            T(camera.focal)};
  }
};

TEST(PinholeWeight, LogDerivativeThreeWays) {
  const View v;
  const double hand = LogPinholeWeightDerivative(v.camera, v.motion, v.x, v.x_rate);
  const auto weight = [&](const auto& t) {
    return PinholeWeight(v.At(t), Moved(v.x, v.x_rate, t));
  };
  const J jet = weight(J(0.0, 0));
  EXPECT_NEAR(hand, jet.v[0] / jet.a, kRounding);
  EXPECT_NEAR(hand, RiddersDerivative(weight, 0.0, 0.1) / weight(0.0), kDifference);
}

TEST(PinholeWeight, ImageVelocityThreeWays) {
  const View v;
  const PinholeImage<double> hand = ImageVelocity(v.camera, v.motion, v.x.x, v.x_rate.x);
  const auto image = [&](const auto& t) { return ImageOf(v.At(t), Moved(v.x.x, v.x_rate.x, t)); };
  const PinholeImage<J> jet = image(J(0.0, 0));
  EXPECT_NEAR(hand.u, jet.u.v[0], 1e-11);  // hundreds of pixels per unit
  EXPECT_NEAR(hand.v, jet.v.v[0], 1e-11);
  EXPECT_NEAR(hand.u, RiddersDerivative([&](double t) { return image(t).u; }, 0.0, 0.1), 1e-6);
  EXPECT_NEAR(hand.v, RiddersDerivative([&](double t) { return image(t).v; }, 0.0, 0.1), 1e-6);
}

TEST(PinholeWeight, IsPixelAreaPerSurfaceArea) {
  const View v;
  const Vec3 side = Normalized(Cross(v.x.n, Vec3{1, 0, 0}));
  const Vec3 other = Cross(v.x.n, side);
  const PinholeMotion<double> still;
  const PinholeImage<double> a = ImageVelocity(v.camera, still, v.x.x, side);
  const PinholeImage<double> b = ImageVelocity(v.camera, still, v.x.x, other);
  const double area = std::abs(a.u * b.v - a.v * b.u);
  EXPECT_NEAR(PinholeWeight(v.camera, v.x) / area, 1.0, 1e-12);
}

TEST(PinholeWeight, FilterLogDerivativeFollowsTheImageVelocity) {
  const View v;
  const auto filter = [](const auto& p) {
    using std::exp;
    return exp(-(p.u * p.u + 0.5 * p.v * p.v) * 1e-4);
  };
  const PinholeImage<double> at = ImageOf(v.camera, v.x.x);
  const double h = filter(at);
  const PinholeImage<double> gradient{-2e-4 * at.u * h, -1e-4 * at.v * h};
  const auto measured = [&](const auto& t) {
    return filter(ImageOf(v.At(t), Moved(v.x.x, v.x_rate.x, t)));
  };
  const double hand =
      FilterLogDerivative(h, gradient, ImageVelocity(v.camera, v.motion, v.x.x, v.x_rate.x));
  EXPECT_NEAR(hand, measured(J(0.0, 0)).v[0] / h, 1e-10);
  EXPECT_NEAR(hand, RiddersDerivative(measured, 0.0, 0.02) / h, 1e-6);
}

TEST(PinholeWeight, CommonRigidMotionChangesNothing) {
  View v;
  const Vec3 drift{0.1, 0.2, 0.3};
  v.motion.velocity = drift + Cross(v.motion.spin, v.camera.centre);
  v.x_rate = {drift + Cross(v.motion.spin, v.x.x), Cross(v.motion.spin, v.x.n)};
  EXPECT_NEAR(LogPinholeWeightDerivative(v.camera, v.motion, v.x, v.x_rate), 0.0, kRounding);
  const PinholeImage<double> velocity = ImageVelocity(v.camera, v.motion, v.x.x, v.x_rate.x);
  EXPECT_NEAR(std::hypot(velocity.u, velocity.v), 0.0, 1e-11);
}

TEST(PinholeWeight, CameraMotionIsMinusTheMotionOfEverythingElse) {  // C27
  const View v;
  const PinholeMotion<double> still;
  const OrientedPoint<double> opposite{
      -(v.motion.velocity + Cross(v.motion.spin, v.x.x - v.camera.centre)),
      -Cross(v.motion.spin, v.x.n)};
  EXPECT_NEAR(LogPinholeWeightDerivative(v.camera, v.motion, v.x, {}),
              LogPinholeWeightDerivative(v.camera, still, v.x, opposite),
              kRounding);
}

}  // namespace
}  // namespace pathfit::tests::geometry_term_test
