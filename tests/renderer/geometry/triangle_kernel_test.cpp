#include "renderer/geometry/triangle_kernel.h"

#include <array>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::renderer::triangle_kernel_test {
namespace {

constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;
constexpr double kRounding = 1e-13;

// The worked triangle of path_space 1.3 and its velocities.
constexpr std::array<double, 9> kCorners = {.1, -.2, .3, 1.2, .1, -.4, .3, .9, .5};
constexpr std::array<double, 9> kVelocities = {.2, -.1, .4, -.3, .5, .1, .6, .2, -.7};

template <class T>
Vector3<T> Corner(const std::array<T, 9>& p, std::size_t i) {
  return {p[3 * i], p[3 * i + 1], p[3 * i + 2]};
}
TriangleGeometry Worked(const std::array<double, 9>& p = kCorners) {
  return TriangleGeometry::Make(Corner(p, 0), Corner(p, 1), Corner(p, 2));
}

template <class T>
T LogArea(const std::array<T, 9>& p) {
  using std::log;
  return log(Norm(Cross(Corner(p, 1) - Corner(p, 0), Corner(p, 2) - Corner(p, 0))));
}
/// A fixed vector times the unit normal: its gradient is what NormalAdjoint returns for that
/// vector.
const Vec3 kAdjoint{0.7, -1.1, 0.4};
template <class T>
T AlongNormal(const std::array<T, 9>& p) {
  const Vector3<T> n = Normalized(Cross(Corner(p, 1) - Corner(p, 0), Corner(p, 2) - Corner(p, 0)));
  return n.x * T(kAdjoint.x) + n.y * T(kAdjoint.y) + n.z * T(kAdjoint.z);
}

/// hand = Jet to 1e-10, hand = difference to 1e-6, for all nine coordinates.
template <class F>
void CheckThreeWays(F f, const std::array<Vec3, 3>& hand) {
  using J = ceres::Jet<double, 9>;
  std::array<J, 9> jets;
  for (std::size_t i = 0; i < 9; ++i) jets[i] = J(kCorners[i], static_cast<int>(i));
  const J by_jet = f(jets);
  for (std::size_t i = 0; i < 9; ++i) {
    const double by_hand = hand[i / 3][static_cast<int>(i % 3)];
    const auto along = [&](double value) {
      std::array<double, 9> p = kCorners;
      p[i] = value;
      return f(p);
    };
    EXPECT_LT(tests::RelativeError(by_hand, by_jet.v[static_cast<int>(i)]), kSameFormula) << i;
    EXPECT_LT(tests::RelativeError(by_hand, tests::RiddersDerivative(along, kCorners[i], 0.05)),
              kDifference)
        << i;
  }
}

TEST(TriangleKernel, LogAreaGradientThreeWays) {
  CheckThreeWays([](const auto& p) { return LogArea(p); }, BarycentricGradients(Worked()));
}

TEST(TriangleKernel, NormalAdjointThreeWays) {
  CheckThreeWays([](const auto& p) { return AlongNormal(p); }, NormalAdjoint(Worked(), kAdjoint));
}

TEST(TriangleKernel, AreaRatioDerivativeOfTheWorkedExample) {
  const std::array<Vec3, 3> gradients = BarycentricGradients(Worked());
  double j = 0.0;
  for (std::size_t i = 0; i < 3; ++i) j += Dot(gradients[i], Corner(kVelocities, i));
  EXPECT_NEAR(j, -0.28225128444652026, kRounding);
}

TEST(TriangleKernel, NormalDerivativeOfTheWorkedExample) {
  const Vec3 expected{0.3856359595056904, 0.5934802196708122, -0.09254344983324403};
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 unit;
    unit[axis] = 1.0;
    const std::array<Vec3, 3> adjoint = NormalAdjoint(Worked(), unit);
    double derivative = 0.0;
    for (std::size_t i = 0; i < 3; ++i) derivative += Dot(adjoint[i], Corner(kVelocities, i));
    EXPECT_NEAR(derivative, expected[axis], kRounding) << axis;
  }
}

TEST(TriangleKernel, RigidMotionKeepsTheArea) {
  const std::array<Vec3, 3> gradients = BarycentricGradients(Worked());
  const Vec3 spin{0.3, -0.2, 0.9};
  double translation = 0.0;
  double rotation = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    translation += Dot(gradients[i], Vec3{1, 2, 3});
    rotation += Dot(gradients[i], Cross(spin, Corner(kCorners, i)));
  }
  EXPECT_NEAR(translation, 0.0, kRounding);
  EXPECT_NEAR(rotation, 0.0, kRounding);
}

TEST(TriangleKernel, BarycentricGradientsMoveTheWeightsOfAPoint) {
  const TriangleGeometry t = Worked();
  const std::array<Vec3, 3> gradients = BarycentricGradients(t);
  const Vec3 step = (t.e1 * 0.3 - t.e2 * 0.8) * 1e-3;
  const auto weights = [&](const Vec3& x) {
    const PlaneHit hit = IntersectPlane(t, x + t.n, -t.n);
    return std::array<double, 3>{1.0 - hit.b1 - hit.b2, hit.b1, hit.b2};
  };
  const Vec3 x = t.Point(0.2, 0.5);
  for (std::size_t i = 0; i < 3; ++i) {
    // Weights are linear, so a difference has only rounding error.
    EXPECT_NEAR(weights(x + step)[i] - weights(x)[i], Dot(gradients[i], step), 1e-14);
  }
}

TEST(TriangleKernel, IntersectPlaneFindsThePoint) {
  const TriangleGeometry t = Worked();
  const Vec3 x = t.Point(0.25, 0.4);
  const Vec3 origin{0.5, 0.6, 4.0};
  const PlaneHit hit = IntersectPlane(t, origin, Normalized(x - origin));
  EXPECT_NEAR(hit.distance, Norm(x - origin), kRounding);
  EXPECT_NEAR(hit.b1, 0.25, kRounding);
  EXPECT_NEAR(hit.b2, 0.4, kRounding);
}

TEST(TriangleKernel, NormalFollowsTheWinding) {
  const TriangleGeometry t = TriangleGeometry::Make({0, 0, 0}, {2, 0, 0}, {0, 3, 0});
  EXPECT_EQ(t.n, (Vec3{0, 0, 1}));
  EXPECT_EQ(t.double_area, 6.0);
}

}  // namespace
}  // namespace pathfit::renderer::triangle_kernel_test
