#include "renderer/bsdf/fresnel_kernel.h"

#include <array>
#include <complex>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::renderer::fresnel_kernel_test {
namespace {

constexpr double kSameFormula = 1e-11;
constexpr double kDifference = 1e-7;

/// Fresnel's equations with complex arithmetic.
double ByComplexNumbers(double c, std::complex<double> index) {
  const std::complex<double> t = std::sqrt(index * index - (1.0 - c * c));
  const double s = std::norm((c - t) / (c + t));
  const double p = std::norm((index * index * c - t) / (index * index * c + t));
  return 0.5 * (s + p);
}

TEST(FresnelDielectric, NormalIncidenceHasTheKnownReflectanceAndDerivative) {
  // path_space 6.3, C20b, eta = 1.5.
  const auto f = FresnelDielectric(Dual<1>(1.0), Dual<1>::Variable(1.5, 0));
  EXPECT_NEAR(f.v, 0.04, 1e-15);
  EXPECT_NEAR(f.d[0], 0.128, 1e-15);
}

TEST(FresnelDielectric, IsTheSameFromBothSidesAlongOneRay) {
  for (const double eta : {1.1, 1.5, 2.4}) {
    for (const double c : {0.05, 0.3, 0.8, 1.0}) {
      const double refracted = std::sqrt(1.0 - (1.0 - c * c) / (eta * eta));
      EXPECT_NEAR(FresnelDielectric(c, eta), FresnelDielectric(refracted, 1.0 / eta), 1e-12);
    }
  }
}

TEST(FresnelDielectric, VanishesForParallelLightAtBrewstersAngleAndReflectsAllBeyondTheCritical) {
  const double eta = 1.5;
  const double c = 1.0 / std::sqrt(1.0 + eta * eta);
  const double s = (1.0 - eta * eta) / (1.0 + eta * eta);
  EXPECT_NEAR(FresnelDielectric(c, eta), 0.5 * s * s, 1e-14);
  const double critical = std::sqrt(1.0 - 1.0 / (eta * eta));
  EXPECT_LT(FresnelDielectric(critical + 1e-4, 1.0 / eta), 1.0);
  EXPECT_EQ(FresnelDielectric(critical - 1e-4, 1.0 / eta), 1.0);
  EXPECT_TRUE(IsTotalReflection(critical - 1e-4, 1.0 / eta));
  EXPECT_FALSE(IsTotalReflection(critical + 1e-4, 1.0 / eta));
  EXPECT_EQ(FresnelDielectric(0.0, eta), 1.0);
}

TEST(FresnelDielectric, DualJetAndDifferencesAgree) {
  using D = Dual<2>;
  using J = ceres::Jet<double, 2>;
  for (const double e : {1.0 / 2.4, 1.0 / 1.5, 0.95, 1.33, 1.5, 2.4}) {
    for (const double c : {0.02, 0.2, 0.6, 0.93, 0.99}) {
      if (std::abs(e * e - 1.0 + c * c) < 0.02) continue;  // the critical angle
      const D by_dual = FresnelDielectric(D::Variable(c, 0), D::Variable(e, 1));
      const J by_jet = FresnelDielectric(J(c, 0), J(e, 1));
      EXPECT_EQ(IsTotalReflection(c, e), by_dual.v == 1.0);
      const auto by_c = [&](double x) { return FresnelDielectric(x, e); };
      const auto by_e = [&](double x) { return FresnelDielectric(c, x); };
      EXPECT_NEAR(by_dual.v, by_jet.a, 1e-15);
      for (int i = 0; i < 2; ++i) {
        EXPECT_LT(tests::RelativeError(by_dual.d[static_cast<std::size_t>(i)], by_jet.v[i]),
                  kSameFormula);
      }
      EXPECT_LT(tests::RelativeError(by_dual.d[0], tests::RiddersDerivative(by_c, c, 5e-3)),
                kDifference);
      EXPECT_LT(tests::RelativeError(by_dual.d[1], tests::RiddersDerivative(by_e, e, 5e-3)),
                kDifference);
    }
  }
}

TEST(FresnelConductor, EqualsComplexArithmetic) {
  for (const double eta : {0.05, 0.4, 1.0, 1.4, 3.0}) {
    for (const double k : {0.0, 0.01, 0.5, 2.5, 7.0}) {
      for (const double c : {1e-6, 0.1, 0.5, 0.9, 1.0}) {
        EXPECT_NEAR(FresnelConductor(c, eta, k), ByComplexNumbers(c, {eta, k}), 1e-11)
            << eta << " " << k << " " << c;
      }
    }
  }
}

TEST(FresnelConductor, HasTheTextbookValueAtNormalIncidenceAndIsADielectricWithoutAbsorption) {
  const double eta = 0.42;
  const double k = 2.47;
  EXPECT_NEAR(FresnelConductor(1.0, eta, k),
              ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k),
              1e-14);
  for (const double e : {0.7, 1.5}) {
    for (const double c : {0.1, 0.5, 0.95})
      EXPECT_NEAR(FresnelConductor(c, e, 0.0), FresnelDielectric(c, e), 1e-12);
  }
}

TEST(FresnelConductor, ReflectsAllWithoutAnIndex) {
  using D = Dual<3>;
  for (const double c : {0.0, 1e-8, 0.3, 1.0 - 1e-13, 1.0}) {
    const D f = FresnelConductor(D::Variable(c, 0), D::Variable(0.0, 1), D::Variable(0.0, 2));
    EXPECT_EQ(f.v, 1.0);
    for (const double d : f.d) EXPECT_NEAR(d, 0.0, 1e-9);
  }
}

TEST(FresnelConductor, DualJetAndDifferencesAgree) {
  using D = Dual<3>;
  using J = ceres::Jet<double, 3>;
  for (const auto& [eta, k] :
       {std::array{0.2, 3.9}, {0.06, 3.6}, {1.4, 7.6}, {2.9, 3.1}, {1.5, 0.2}}) {
    for (const double c : {0.02, 0.2, 0.6, 0.98}) {
      const std::array<double, 3> at = {c, eta, k};
      const D by_dual = FresnelConductor(D::Variable(c, 0), D::Variable(eta, 1), D::Variable(k, 2));
      const J by_jet = FresnelConductor(J(c, 0), J(eta, 1), J(k, 2));
      for (std::size_t i = 0; i < 3; ++i) {
        const auto along = [&](double x) {
          std::array<double, 3> q = at;
          q[i] = x;
          return FresnelConductor(q[0], q[1], q[2]);
        };
        EXPECT_LT(tests::RelativeError(by_dual.d[i], by_jet.v[static_cast<int>(i)]), kSameFormula);
        EXPECT_LT(tests::RelativeError(by_dual.d[i], tests::RiddersDerivative(along, at[i], 5e-3)),
                  kDifference)
            << "variable " << i << " eta " << eta << " k " << k << " c " << c;
      }
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::fresnel_kernel_test
