#include "renderer/bsdf/microfacet_kernel.h"

#include <array>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "renderer/math/dual.h"
#include "renderer/math/vector.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::microfacet_kernel_test {
namespace {

constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;

struct Point {
  double cos_i, cos_o, dot_io, alpha;
};
constexpr std::array<Point, 6> kPoints = {{{0.8, 0.7, 0.3, 0.3},
                                           {0.95, 0.9, 0.75, 0.05},
                                           {0.2, 0.9, 0.1, 0.9},
                                           {0.5, 0.5, -0.4, 0.5},
                                           {0.15, 0.25, -0.6, 0.2},
                                           {0.99, 0.99, 0.97, 1.0}}};

/// D and Lambda from angles, as [Walter2007] and [Heitz2014] write them.
double TextbookDensity(Ggx /*distribution*/, double cos_h, double alpha) {
  const double tan2 = 1.0 / (cos_h * cos_h) - 1.0;
  const double a2 = alpha * alpha;
  return 1.0 / (std::numbers::pi * a2 * std::pow(cos_h, 4) * std::pow(1.0 + tan2 / a2, 2));
}
double TextbookDensity(Beckmann /*distribution*/, double cos_h, double alpha) {
  const double tan = std::tan(std::acos(cos_h));
  return std::exp(-std::pow(tan / alpha, 2)) /
         (std::numbers::pi * alpha * alpha * std::pow(cos_h, 4));
}
double TextbookLambda(Ggx /*distribution*/, double cos, double alpha) {
  return 0.5 * (std::sqrt(1.0 + alpha * alpha * (1.0 / (cos * cos) - 1.0)) - 1.0);
}
double TextbookLambda(Beckmann /*distribution*/, double cos, double alpha) {
  const double a = 1.0 / (alpha * std::tan(std::acos(cos)));
  return 0.5 * (std::exp(-a * a) / (a * std::sqrt(std::numbers::pi)) - std::erfc(a));
}

template <class Distribution>
class MicrofacetKernel : public ::testing::Test {};
using Distributions = ::testing::Types<Ggx, Beckmann>;
TYPED_TEST_SUITE(MicrofacetKernel, Distributions);

TYPED_TEST(MicrofacetKernel, DualJetAndDifferencesAgree) {
  using Distribution = TypeParam;
  using D = Dual<4>;
  using J = ceres::Jet<double, 4>;
  for (const Point& p : kPoints) {
    const std::array<double, 4> at = {p.cos_i, p.cos_o, p.dot_io, p.alpha};
    const D by_dual = MicrofacetReflection<Distribution>(
        D::Variable(at[0], 0), D::Variable(at[1], 1), D::Variable(at[2], 2), D::Variable(at[3], 3));
    const J by_jet =
        MicrofacetReflection<Distribution>(J(at[0], 0), J(at[1], 1), J(at[2], 2), J(at[3], 3));
    EXPECT_LT(tests::RelativeError(by_dual.v, by_jet.a, 0.0), kSameFormula);
    for (std::size_t i = 0; i < 4; ++i) {
      const auto along = [&](double value) {
        std::array<double, 4> q = at;
        q[i] = value;
        return MicrofacetReflection<Distribution>(q[0], q[1], q[2], q[3]);
      };
      // Relative to the value's own scale of change, its size over alpha.
      const double scale = by_dual.v / p.alpha;
      // Beckmann falls off as fast as exp(-tan^2 / alpha^2).
      const double step = i == 3 ? 0.005 * p.alpha : 0.02 * p.alpha;
      EXPECT_LT(tests::RelativeError(by_dual.d[i], by_jet.v[static_cast<int>(i)], scale),
                kSameFormula);
      EXPECT_LT(
          tests::RelativeError(by_dual.d[i], tests::RiddersDerivative(along, at[i], step), scale),
          kDifference)
          << "variable " << i << " at alpha " << p.alpha;
    }
  }
}

TYPED_TEST(MicrofacetKernel, PartialsByHandAreThoseOfDualNumbers) {
  using Distribution = TypeParam;
  using D = Dual<4>;
  for (const Point& p : kPoints) {
    const D d = MicrofacetReflection<Distribution>(D::Variable(p.cos_i, 0),
                                                   D::Variable(p.cos_o, 1),
                                                   D::Variable(p.dot_io, 2),
                                                   D::Variable(p.alpha, 3));
    const MicrofacetPartials h =
        MicrofacetReflectionPartials<Distribution>(p.cos_i, p.cos_o, p.dot_io, p.alpha);
    EXPECT_LT(tests::RelativeError(h.value, d.v, 0.0), kSameFormula);
    const std::array<double, 4> by_hand = {h.d_cos_i, h.d_cos_o, h.d_dot_io, h.d_alpha};
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LT(tests::RelativeError(by_hand[i], d.d[i], d.v / p.alpha), kSameFormula)
          << "variable " << i << " at alpha " << p.alpha;
    }
  }
}

struct Passage {
  double alpha, e;
  Vec3 wi, wo;
};
/// Directions near refraction of each other and away from it, into and out of the dense side.
const std::array<Passage, 6> kPassages = {{{0.3, 1.5, {-0.3, 0.05, -0.9}, {0.5, 0.1, 0.8}},
                                           {0.1, 1.5, {-0.2, 0.0, -0.95}, {0.3, 0.02, 0.9}},
                                           {0.6, 1.0 / 1.5, {-0.7, 0.2, -0.6}, {0.3, 0.1, 0.9}},
                                           {0.9, 1.33, {-0.7, -0.05, -0.7}, {0.9, 0.1, 0.2}},
                                           {0.5, 1.0 / 2.4, {-0.95, 0.0, -0.1}, {0.4, 0.1, 0.9}},
                                           {0.4, 2.4, {-0.42, -0.06, -0.9}, {0.99, 0.1, 0.03}}}};

TYPED_TEST(MicrofacetKernel, TransmissionDualJetAndDifferencesAgree) {
  using Distribution = TypeParam;
  using D = Dual<5>;
  using J = ceres::Jet<double, 5>;
  for (const Passage& q : kPassages) {
    const Vec3 wi = Normalized(q.wi);
    const Vec3 wo = Normalized(q.wo);
    const std::array<double, 5> at = {wi.z, wo.z, Dot(wi, wo), q.alpha, q.e};
    const D by_dual = MicrofacetTransmission<Distribution>(D::Variable(at[0], 0),
                                                           D::Variable(at[1], 1),
                                                           D::Variable(at[2], 2),
                                                           D::Variable(at[3], 3),
                                                           D::Variable(at[4], 4));
    const J by_jet = MicrofacetTransmission<Distribution>(
        J(at[0], 0), J(at[1], 1), J(at[2], 2), J(at[3], 3), J(at[4], 4));
    ASSERT_GT(by_dual.v, 0.0);
    EXPECT_LT(tests::RelativeError(by_dual.v, by_jet.a, 0.0), kSameFormula);
    for (std::size_t i = 0; i < 5; ++i) {
      const auto along = [&](double value) {
        std::array<double, 5> p = at;
        p[i] = value;
        return MicrofacetTransmission<Distribution>(p[0], p[1], p[2], p[3], p[4]);
      };
      const double scale = by_dual.v / q.alpha;
      EXPECT_LT(tests::RelativeError(by_dual.d[i], by_jet.v[static_cast<int>(i)], scale),
                kSameFormula);
      EXPECT_LT(tests::RelativeError(
                    by_dual.d[i], tests::RiddersDerivative(along, at[i], 0.02 * q.alpha), scale),
                kDifference)
          << "variable " << i << " at alpha " << q.alpha << " e " << q.e;
    }
  }
}

/// Half vector, Fresnel, D and G2 from vectors, as [Walter2007] writes them.
TYPED_TEST(MicrofacetKernel, TransmissionEqualsTheTextbookProduct) {
  using Distribution = TypeParam;
  for (const Passage& q : kPassages) {
    const Vec3 wi = Normalized(q.wi);
    const Vec3 wo = Normalized(q.wo);
    Vec3 h = Normalized(-(wo + wi * q.e));
    if (h.z < 0.0) h = -h;
    const double d = TextbookDensity(Distribution{}, h.z, q.alpha);
    const double g2 = 1.0 / (1.0 + TextbookLambda(Distribution{}, -wi.z, q.alpha) +
                             TextbookLambda(Distribution{}, wo.z, q.alpha));
    const double fresnel = FresnelDielectric(Dot(wo, h), q.e);
    const double length = q.e * Dot(wi, h) + Dot(wo, h);
    const double expected = std::abs(Dot(wi, h) * Dot(wo, h) / (wi.z * wo.z)) * (1.0 - fresnel) *
                            d * g2 / (length * length);
    EXPECT_LT(tests::RelativeError(
                  MicrofacetTransmission<Distribution>(wi.z, wo.z, Dot(wi, wo), q.alpha, q.e),
                  expected,
                  0.0),
              kSameFormula);
  }
}

/// Over the slopes r of the microfacets, of which half are below alpha.
template <class F>
double SlopeIntegral(double alpha, F f) {
  constexpr int kRadii = 4000;
  constexpr int kTurns = 128;
  double sum = 0.0;
  for (int i = 0; i < kRadii; ++i) {
    const double t = (i + 0.5) / kRadii;
    const double r = alpha * t / (1.0 - t);
    const double dr = alpha / ((1.0 - t) * (1.0 - t) * kRadii);
    double ring = 0.0;
    for (int j = 0; j < kTurns; ++j) {
      ring += f(r, std::cos(2.0 * std::numbers::pi * (j + 0.5) / kTurns));
    }
    sum += ring * r * dr * 2.0 * std::numbers::pi / kTurns;
  }
  return sum;
}

/// What makes a distribution of normals: their areas add up to that of the surface seen from above,
/// and to ProjectedArea from anywhere else, fronts and backs.
TYPED_TEST(MicrofacetKernel, AreasOfMicrofacetsAddUp) {
  using Distribution = TypeParam;
  for (const double alpha : {9e-4, 0.02, 0.3, 1.0}) {
    const auto cos4_density = [&](double r) {
      const double cos_h2 = 1.0 / (1.0 + r * r);
      return Distribution::Density(cos_h2, alpha) * cos_h2 * cos_h2;
    };
    EXPECT_NEAR(SlopeIntegral(alpha, [&](double r, double) { return cos4_density(r); }), 1.0, 1e-6)
        << alpha;
    for (const double tan : {0.3 / alpha, 1.0 / alpha, 3.0 / alpha, 0.1, 3.0}) {
      const double cos = 1.0 / std::sqrt(1.0 + tan * tan);
      const double sum = SlopeIntegral(alpha, [&](double r, double turn) {
        return cos4_density(r) * cos * std::abs(1.0 - tan * r * turn);
      });
      EXPECT_NEAR(sum / Distribution::ProjectedArea(cos, alpha), 1.0, 2e-3) << alpha << " " << tan;
    }
  }
}

/// In the lobe of the least roughness, where 1 - cos_h^2 is below 1e-6 and keeps ten digits.
TYPED_TEST(MicrofacetKernel, HoldsInTheNarrowestLobe) {
  using Distribution = TypeParam;
  using D = Dual<4>;
  const double alpha = kMinRoughness * kMinRoughness;
  for (const double cos_o : {0.02, 0.3, 0.9}) {
    for (const double slope : {0.1, 1.0, 2.5}) {
      // h tilted across the plane of wo and n.
      const Vec3 wo{std::sqrt(1.0 - cos_o * cos_o), 0.0, cos_o};
      const Vec3 h = Normalized(Vec3{0.3 * slope * alpha, slope * alpha, 1.0});
      const Vec3 wi = h * (2.0 * Dot(wo, h)) - wo;
      const std::array<double, 4> at = {wi.z, wo.z, Dot(wi, wo), alpha};
      const double expected = TextbookDensity(Distribution{}, h.z, alpha) /
                              (1.0 + TextbookLambda(Distribution{}, wi.z, alpha) +
                               TextbookLambda(Distribution{}, wo.z, alpha)) /
                              (4.0 * wi.z * wo.z);
      const MicrofacetPartials by_hand =
          MicrofacetReflectionPartials<Distribution>(at[0], at[1], at[2], at[3]);
      // Cosines are right to 1e-16, cos_h^2 to that over (wi + wo)^2, D to that over alpha^2.
      const double rounding = 1e-15 / ((2.0 + 2.0 * at[2]) * alpha * alpha);
      EXPECT_LT(tests::RelativeError(by_hand.value, expected, 0.0), rounding) << cos_o;
      EXPECT_LT(tests::RelativeError(
                    MicrofacetReflection<Distribution>(at[0], at[1], at[2], at[3]), expected, 0.0),
                rounding);
      const D d = MicrofacetReflection<Distribution>(
          D::Variable(at[0], 0), D::Variable(at[1], 1), D::Variable(at[2], 2), D(at[3]));
      // How the lobe follows a tilt of the normal: terms of 1 / alpha^2 cancel down to 1 / alpha.
      const Vec3 tilt{0.6, 0.8, 0.0};
      const double by_tilt = by_hand.d_cos_i * Dot(tilt, wi) + by_hand.d_cos_o * Dot(tilt, wo);
      const double by_dual = d.d[0] * Dot(tilt, wi) + d.d[1] * Dot(tilt, wo);
      const auto tilted = [&](double t) {
        const Vec3 n = Normalized(Vec3{tilt.x * t, tilt.y * t, 1.0});
        return MicrofacetReflection<Distribution>(Dot(n, wi), Dot(n, wo), at[2], alpha);
      };
      const double scale = expected / alpha;
      EXPECT_LT(tests::RelativeError(by_tilt, by_dual, scale), 1e-7);
      EXPECT_LT(
          tests::RelativeError(by_tilt, tests::RiddersDerivative(tilted, 0.0, 0.1 * alpha), scale),
          2e-5)
          << cos_o << " " << slope;
      const auto rougher = [&](double a) {
        return MicrofacetReflection<Distribution>(at[0], at[1], at[2], a);
      };
      EXPECT_LT(tests::RelativeError(
                    by_hand.d_alpha, tests::RiddersDerivative(rougher, alpha, 0.1 * alpha), scale),
                1e-6)
          << cos_o << " " << slope;
    }
  }
}

/// Beckmann has no microfacets across the surface, however h gets there.
TEST(Beckmann, EndsWithoutNotANumber) {
  for (const double cos_h2 : {0.0, 1e-300, 1e-20, 1e-3}) {
    EXPECT_EQ(Beckmann::Density(cos_h2, 0.03), 0.0);
    const auto d = Beckmann::Density(Dual<2>::Variable(cos_h2, 0), Dual<2>::Variable(0.03, 1));
    EXPECT_EQ(d.d[0], 0.0);
    EXPECT_EQ(d.d[1], 0.0);
  }
}

TEST(SchlickWeight, DualJetAndDifferencesAgree) {
  for (const double dot : {-0.9, -0.3, 0.0, 0.6, 0.95}) {
    const auto by_dual = SchlickWeight(Dual<1>::Variable(dot, 0));
    const auto by_jet = SchlickWeight(ceres::Jet<double, 1>(dot, 0));
    const auto along = [](double value) { return SchlickWeight(value); };
    EXPECT_LT(tests::RelativeError(by_dual.d[0], by_jet.v[0]), kSameFormula);
    EXPECT_LT(tests::RelativeError(by_dual.d[0], tests::RiddersDerivative(along, dot, 0.02)),
              kDifference);
  }
}

TEST(SchlickWeight, RunsFromZeroAtNormalToOneAtGrazing) {
  EXPECT_EQ(SchlickWeight(1.0), 0.0);
  EXPECT_EQ(SchlickWeight(-1.0), 1.0);
  EXPECT_NEAR(SchlickWeight(0.0), std::pow(1.0 - std::sqrt(0.5), 5), 1e-15);
}

TYPED_TEST(MicrofacetKernel, IsReciprocal) {
  using Distribution = TypeParam;
  for (const Point& p : kPoints) {
    EXPECT_NEAR(MicrofacetReflection<Distribution>(p.cos_i, p.cos_o, p.dot_io, p.alpha),
                MicrofacetReflection<Distribution>(p.cos_o, p.cos_i, p.dot_io, p.alpha),
                1e-12 * MicrofacetReflection<Distribution>(p.cos_i, p.cos_o, p.dot_io, p.alpha));
  }
}

/// The textbook route: D(h), Lambda, G2 from angles, independently of the kernel's rearranged form.
TYPED_TEST(MicrofacetKernel, EqualsTheTextbookProduct) {
  using Distribution = TypeParam;
  for (const Point& p : kPoints) {
    const double cos_h = (p.cos_i + p.cos_o) / std::sqrt(2.0 + 2.0 * p.dot_io);
    const double d = TextbookDensity(Distribution{}, cos_h, p.alpha);
    const double g2 = 1.0 / (1.0 + TextbookLambda(Distribution{}, p.cos_i, p.alpha) +
                             TextbookLambda(Distribution{}, p.cos_o, p.alpha));
    const double expected = d * g2 / (4.0 * p.cos_i * p.cos_o);
    EXPECT_LT(
        tests::RelativeError(
            MicrofacetReflection<Distribution>(p.cos_i, p.cos_o, p.dot_io, p.alpha), expected, 0.0),
        1e-12);
  }
}

}  // namespace
}  // namespace pathfit::renderer::microfacet_kernel_test
