#include "renderer/bsdf/microfacet_kernel.h"

#include <array>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "renderer/math/dual.h"
#include "renderer/math/vector.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer {
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

TEST(MicrofacetKernel, DualJetAndDifferencesAgree) {
  using D = Dual<4>;
  using J = ceres::Jet<double, 4>;
  for (const Point& p : kPoints) {
    const std::array<double, 4> at = {p.cos_i, p.cos_o, p.dot_io, p.alpha};
    const D by_dual = MicrofacetReflection(
        D::Variable(at[0], 0), D::Variable(at[1], 1), D::Variable(at[2], 2), D::Variable(at[3], 3));
    const J by_jet = MicrofacetReflection(J(at[0], 0), J(at[1], 1), J(at[2], 2), J(at[3], 3));
    EXPECT_LT(tests::RelativeError(by_dual.v, by_jet.a, 0.0), kSameFormula);
    for (std::size_t i = 0; i < 4; ++i) {
      const auto along = [&](double value) {
        std::array<double, 4> q = at;
        q[i] = value;
        return MicrofacetReflection(q[0], q[1], q[2], q[3]);
      };
      // Relative to the value's own scale of change, its size over alpha.
      const double scale = by_dual.v / p.alpha;
      const double step = i == 3 ? 0.2 * p.alpha : 0.02 * p.alpha;
      EXPECT_LT(tests::RelativeError(by_dual.d[i], by_jet.v[static_cast<int>(i)], scale),
                kSameFormula);
      EXPECT_LT(
          tests::RelativeError(by_dual.d[i], tests::RiddersDerivative(along, at[i], step), scale),
          kDifference)
          << "variable " << i << " at alpha " << p.alpha;
    }
  }
}

TEST(MicrofacetKernel, PartialsByHandAreThoseOfDualNumbers) {
  using D = Dual<4>;
  for (const Point& p : kPoints) {
    const D d = MicrofacetReflection(D::Variable(p.cos_i, 0),
                                     D::Variable(p.cos_o, 1),
                                     D::Variable(p.dot_io, 2),
                                     D::Variable(p.alpha, 3));
    const MicrofacetPartials h = MicrofacetReflectionPartials(p.cos_i, p.cos_o, p.dot_io, p.alpha);
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

TEST(MicrofacetKernel, TransmissionDualJetAndDifferencesAgree) {
  using D = Dual<5>;
  using J = ceres::Jet<double, 5>;
  for (const Passage& q : kPassages) {
    const Vec3 wi = Normalized(q.wi);
    const Vec3 wo = Normalized(q.wo);
    const std::array<double, 5> at = {wi.z, wo.z, Dot(wi, wo), q.alpha, q.e};
    const D by_dual = MicrofacetTransmission(D::Variable(at[0], 0),
                                             D::Variable(at[1], 1),
                                             D::Variable(at[2], 2),
                                             D::Variable(at[3], 3),
                                             D::Variable(at[4], 4));
    const J by_jet =
        MicrofacetTransmission(J(at[0], 0), J(at[1], 1), J(at[2], 2), J(at[3], 3), J(at[4], 4));
    ASSERT_GT(by_dual.v, 0.0);
    EXPECT_LT(tests::RelativeError(by_dual.v, by_jet.a, 0.0), kSameFormula);
    for (std::size_t i = 0; i < 5; ++i) {
      const auto along = [&](double value) {
        std::array<double, 5> p = at;
        p[i] = value;
        return MicrofacetTransmission(p[0], p[1], p[2], p[3], p[4]);
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
TEST(MicrofacetKernel, TransmissionEqualsTheTextbookProduct) {
  for (const Passage& q : kPassages) {
    const Vec3 wi = Normalized(q.wi);
    const Vec3 wo = Normalized(q.wo);
    Vec3 h = Normalized(-(wo + wi * q.e));
    if (h.z < 0.0) h = -h;
    const double a2 = q.alpha * q.alpha;
    const double c2 = h.z * h.z;
    const double d = a2 / (std::numbers::pi * std::pow(c2 * (a2 - 1.0) + 1.0, 2));
    const auto lambda = [&](double c) {
      return 0.5 * (std::sqrt(1.0 + a2 * (1.0 / (c * c) - 1.0)) - 1.0);
    };
    const double g2 = 1.0 / (1.0 + lambda(wi.z) + lambda(wo.z));
    const double fresnel = FresnelDielectric(Dot(wo, h), q.e);
    const double length = q.e * Dot(wi, h) + Dot(wo, h);
    const double expected = std::abs(Dot(wi, h) * Dot(wo, h) / (wi.z * wo.z)) * (1.0 - fresnel) *
                            d * g2 / (length * length);
    EXPECT_LT(tests::RelativeError(
                  MicrofacetTransmission(wi.z, wo.z, Dot(wi, wo), q.alpha, q.e), expected, 0.0),
              kSameFormula);
  }
}

TEST(MicrofacetKernel, SchlickWeightDualJetAndDifferencesAgree) {
  for (const double dot : {-0.9, -0.3, 0.0, 0.6, 0.95}) {
    const auto by_dual = SchlickWeight(Dual<1>::Variable(dot, 0));
    const auto by_jet = SchlickWeight(ceres::Jet<double, 1>(dot, 0));
    const auto along = [](double value) { return SchlickWeight(value); };
    EXPECT_LT(tests::RelativeError(by_dual.d[0], by_jet.v[0]), kSameFormula);
    EXPECT_LT(tests::RelativeError(by_dual.d[0], tests::RiddersDerivative(along, dot, 0.02)),
              kDifference);
  }
}

TEST(MicrofacetKernel, SchlickWeightRunsFromZeroAtNormalToOneAtGrazing) {
  EXPECT_EQ(SchlickWeight(1.0), 0.0);
  EXPECT_EQ(SchlickWeight(-1.0), 1.0);
  EXPECT_NEAR(SchlickWeight(0.0), std::pow(1.0 - std::sqrt(0.5), 5), 1e-15);
}

TEST(MicrofacetKernel, IsReciprocal) {
  for (const Point& p : kPoints) {
    EXPECT_NEAR(MicrofacetReflection(p.cos_i, p.cos_o, p.dot_io, p.alpha),
                MicrofacetReflection(p.cos_o, p.cos_i, p.dot_io, p.alpha),
                1e-12 * MicrofacetReflection(p.cos_i, p.cos_o, p.dot_io, p.alpha));
  }
}

/// The textbook route: D(h), Lambda, G2 from angles, independently of the kernel's rearranged form.
TEST(MicrofacetKernel, EqualsTheTextbookProduct) {
  for (const Point& p : kPoints) {
    const double cos_h = (p.cos_i + p.cos_o) / std::sqrt(2.0 + 2.0 * p.dot_io);
    const double tan2 = 1.0 / (cos_h * cos_h) - 1.0;
    const double a2 = p.alpha * p.alpha;
    const double d =
        1.0 / (std::numbers::pi * a2 * std::pow(cos_h, 4) * std::pow(1.0 + tan2 / a2, 2));
    const auto lambda = [&](double c) {
      return 0.5 * (std::sqrt(1.0 + a2 * (1.0 / (c * c) - 1.0)) - 1.0);
    };
    const double g2 = 1.0 / (1.0 + lambda(p.cos_i) + lambda(p.cos_o));
    const double expected = d * g2 / (4.0 * p.cos_i * p.cos_o);
    EXPECT_LT(tests::RelativeError(
                  MicrofacetReflection(p.cos_i, p.cos_o, p.dot_io, p.alpha), expected, 0.0),
              1e-12);
  }
}

}  // namespace
}  // namespace pathfit::renderer
