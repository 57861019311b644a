#include "renderer/math/dual.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::renderer::dual_test {
namespace {

constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;

/// All operations of Dual, with constants on both sides.
template <class T>
T Mixture(const T& x, const T& y, const T& z) {
  using std::sqrt;
  return sqrt(x * x + y / (z + T(2.0))) - (-x) * (T(3.0) - z) / (y * y) + T(0.5);
}

TEST(Dual, AgreesWithJetAndWithDifferences) {
  const double at[3] = {0.7, 1.3, 0.4};
  using D = Dual<3>;
  using J = ceres::Jet<double, 3>;
  const D d = Mixture(D::Variable(at[0], 0), D::Variable(at[1], 1), D::Variable(at[2], 2));
  const J j = Mixture(J(at[0], 0), J(at[1], 1), J(at[2], 2));
  EXPECT_EQ(d.v, j.a);
  EXPECT_EQ(d.v, Mixture(at[0], at[1], at[2]));
  for (int i = 0; i < 3; ++i) {
    const auto along = [&](double value) {
      double p[3] = {at[0], at[1], at[2]};
      p[i] = value;
      return Mixture(p[0], p[1], p[2]);
    };
    const double by_dual = d.d[static_cast<std::size_t>(i)];
    EXPECT_LT(tests::RelativeError(by_dual, j.v[i]), kSameFormula) << i;
    EXPECT_LT(tests::RelativeError(by_dual, tests::RiddersDerivative(along, at[i], 0.1)),
              kDifference)
        << i;
  }
}

TEST(Dual, ConstantsHaveNoDerivative) {
  const Dual<2> sum = Dual<2>(3.0) * Dual<2>(2.0);
  EXPECT_EQ(sum.v, 6.0);
  EXPECT_EQ(sum.d[0], 0.0);
  EXPECT_EQ(sum.d[1], 0.0);
}

}  // namespace
}  // namespace pathfit::renderer::dual_test
