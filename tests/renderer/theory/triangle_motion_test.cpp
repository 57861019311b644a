#include "tests/renderer/theory/triangle_motion.h"

#include <cmath>
#include <type_traits>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "renderer/geometry/triangle_kernel.h"
#include "tests/renderer/theory/evolving_surface.h"
#include "tests/support/finite_difference.h"

namespace pathfit::tests::triangle_motion_test {
namespace {

using renderer::AreaRatio;
using renderer::Dot;
using renderer::TriangleGeometry;
using renderer::TriangleMotion;
using renderer::Vec3;
using renderer::Vector3;

constexpr double kPrinted = 1e-12;

/// The worked example of path_space 1.3.
TriangleMotion<double> WorkedExample() {
  return {{Vec3{0.1, -0.2, 0.3}, Vec3{1.2, 0.1, -0.4}, Vec3{0.3, 0.9, 0.5}},
          {Vec3{0.2, -0.1, 0.4}, Vec3{-0.3, 0.5, 0.1}, Vec3{0.6, 0.2, -0.7}}};
}
TriangleGeometry Resting(const TriangleMotion<double>& m) {
  return TriangleGeometry::Make(m.p[0], m.p[1], m.p[2]);
}

TEST(TriangleMotion, WorkedNumbersOfThePaper) {
  const auto m = WorkedExample();
  EXPECT_EQ(AreaRatio(m, 0.0), 1.0);
  EXPECT_NEAR(AreaRatioDerivative(m), -0.28225128444652026, kPrinted);
  EXPECT_NEAR(AreaRatioSecondDerivative(m), -0.12609269088791786, kPrinted);
  EXPECT_NEAR(AreaRatio(m, 0.1), 0.9708313415287617, kPrinted);
  EXPECT_NEAR(AreaRatio(m, 0.8), 0.6171101686886431, kPrinted);
  const Vec3 normal_rate = UnitNormalDerivative(m);
  EXPECT_NEAR(normal_rate.x, 0.3856359595056904, kPrinted);
  EXPECT_NEAR(normal_rate.y, 0.5934802196708122, kPrinted);
  EXPECT_NEAR(normal_rate.z, -0.09254344983324403, kPrinted);
}

TEST(TriangleMotion, AreaRatioIsTheRatioOfAnySmallParallelogram) {  // S 33, 38, 39
  const auto m = WorkedExample();
  for (const double a : {1.0, 0.1, 1e-3}) {
    const auto parallelogram = [&](double pi) {
      const Vec3 corner = PointOf(m, 0.2, 0.3, pi);
      return Norm(
          Cross(PointOf(m, 0.2 + a, 0.3, pi) - corner, PointOf(m, 0.2, 0.3 + a, pi) - corner));
    };
    EXPECT_NEAR(parallelogram(0.8) / parallelogram(0.0), AreaRatio(m, 0.8), 1e-12) << a;
  }
  EXPECT_NEAR(0.5 * Norm(AreaVector(m, 0.0)), 0.5 * Resting(m).double_area, 1e-15);
}

TEST(TriangleMotion, HandDerivativesAgreeWithJetsAndDifferences) {
  using J = ceres::Jet<double, 1>;
  using JJ = renderer::DirectionalDual<J>;
  const auto m = WorkedExample();
  TriangleMotion<J> jet;
  TriangleMotion<JJ> second;
  for (std::size_t k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      jet.p[k][i] = J(m.p[k][i]);
      jet.v[k][i] = J(m.v[k][i]);
      second.p[k][i] = JJ(m.p[k][i]);
      second.v[k][i] = JJ(m.v[k][i]);
    }
  }
  EXPECT_NEAR(AreaRatioDerivative(m), AreaRatio(jet, J(0.0, 0)).v[0], 1e-14);
  const JJ pi(J(0.0, 0), J(1.0));
  EXPECT_NEAR(AreaRatioSecondDerivative(m), AreaRatio(second, pi).d.v[0], 1e-14);
  const auto ratio = [&](double at) { return AreaRatio(m, at); };
  EXPECT_NEAR(AreaRatioDerivative(m), RiddersDerivative(ratio, 0.0, 0.1), 1e-10);
  const auto ratio_rate = [&](double at) {
    return RiddersDerivative([&](double pi2) { return AreaRatio(m, pi2); }, at, 0.05);
  };
  EXPECT_NEAR(AreaRatioSecondDerivative(m), RiddersDerivative(ratio_rate, 0.0, 0.1), 1e-8);
  const Vector3<J> normal = Normalized(AreaVector(jet, J(0.0, 0)));
  const Vector3<J> point = PointOf(jet, J(0.2), J(0.3), J(0.4, 0));
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(UnitNormalDerivative(m)[i], normal[i].v[0], 1e-14);
    EXPECT_NEAR(VelocityOf(m, 0.2, 0.3)[i], point[i].v[0], 1e-14);
    const auto component = [&](double at) { return Normalized(AreaVector(m, at))[i]; };
    EXPECT_NEAR(UnitNormalDerivative(m)[i], RiddersDerivative(component, 0.0, 0.1), 1e-10);
  }
}

TEST(TriangleMotion, DivergenceOfVelocityIsAreaRatioDerivative) {
  const auto m = WorkedExample();
  EXPECT_NEAR(VelocityDivergence(m), AreaRatioDerivative(m), 1e-14);
  // And the same as that of the evolving surface with barycentrics as labels.
  const auto surface = [&](const auto& at) {
    using T = std::decay_t<decltype(at.pi)>;
    TriangleMotion<T> lifted;
    for (std::size_t k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) {
        lifted.p[k][i] = T(m.p[k][i]);
        lifted.v[k][i] = T(m.v[k][i]);
      }
    }
    return PointOf(lifted, at.xi1, at.xi2, at.pi);
  };
  const renderer::LocalPoint<double> at{0.2, 0.3, 0.0};
  EXPECT_NEAR(VelocityDivergence(surface, at), AreaRatioDerivative(m), 1e-14);
  EXPECT_NEAR(AreaRatio(surface, 0.0, renderer::LocalPoint<double>{0.2, 0.3, 0.8}),
              AreaRatio(m, 0.8),
              1e-14);
  EXPECT_NEAR(Norm(LocalVelocity(surface, at) - VelocityOf(m, 0.2, 0.3)), 0.0, 1e-14);
}

TEST(TriangleMotion, ProductionKernelsAreItsPartials) {
  const auto m = WorkedExample();
  const TriangleGeometry triangle = Resting(m);
  const auto gradients = BarycentricGradients(triangle);
  double growth = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    growth += Dot(gradients[i], m.v[i]);
    // The bracket of path_space 1.3: n x (p_k - p_j) / 2A.
    const Vec3 bracket =
        Cross(triangle.n, m.p[(i + 2) % 3] - m.p[(i + 1) % 3]) / triangle.double_area;
    EXPECT_NEAR(Norm(gradients[i] - bracket), 0.0, 1e-14);
  }
  EXPECT_NEAR(growth, AreaRatioDerivative(m), 1e-14);
  const Vec3 adjoint{0.3, -1.1, 0.7};
  const auto pulled_back = NormalAdjoint(triangle, adjoint);
  double change = 0.0;
  for (std::size_t i = 0; i < 3; ++i) change += Dot(pulled_back[i], m.v[i]);
  EXPECT_NEAR(change, Dot(adjoint, UnitNormalDerivative(m)), 1e-14);
}

TEST(TriangleMotion, RigidMotionKeepsAreaAndScalingDoublesItsRate) {
  auto m = WorkedExample();
  const Vec3 spin{0.4, -0.3, 0.9};
  for (std::size_t i = 0; i < 3; ++i) m.v[i] = Vec3{0.2, 0.5, -0.1} + Cross(spin, m.p[i]);
  EXPECT_NEAR(AreaRatioDerivative(m), 0.0, 1e-15);
  EXPECT_NEAR(Norm(UnitNormalDerivative(m) - Cross(spin, Resting(m).n)), 0.0, 1e-15);
  for (std::size_t i = 0; i < 3; ++i) m.v[i] = m.p[i] * 0.7;
  EXPECT_NEAR(AreaRatioDerivative(m), 2.0 * 0.7, 1e-14);
  EXPECT_NEAR(Norm(UnitNormalDerivative(m)), 0.0, 1e-15);
}

}  // namespace
}  // namespace pathfit::tests::triangle_motion_test
