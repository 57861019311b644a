#include "tests/renderer/theory/directional_dual.h"

#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::tests::directional_dual_test {
namespace {

using renderer::DirectionalDual;

template <class T>
T Everything(const T& x) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  T y = sin(x) * 2.0 - cos(x * x) / (1.5 + x);
  y += sqrt(1.0 + x * x);
  y -= 0.25 * x;
  y *= -x;
  return y;
}

TEST(DirectionalDual, FirstDerivativeAgreesWithJetAndDifferences) {
  const double x = 0.7;
  const double d = Everything(DirectionalDual<double>(x, 1.0)).d;
  EXPECT_NEAR(d, Everything(ceres::Jet<double, 1>(x, 0)).v[0], 1e-14);
  EXPECT_NEAR(d, RiddersDerivative(Everything<double>, x, 0.1), 1e-9);
}

TEST(DirectionalDual, NestedGivesTheSecondDerivative) {
  using D = DirectionalDual<double>;
  const double x = 0.7;
  const double second = Everything(DirectionalDual<D>(D(x, 1.0), D(1.0))).d.d;
  const auto first = [](double at) { return Everything(D(at, 1.0)).d; };
  EXPECT_NEAR(second, RiddersDerivative(first, x, 0.1), 1e-9);
}

}  // namespace
}  // namespace pathfit::tests::directional_dual_test
