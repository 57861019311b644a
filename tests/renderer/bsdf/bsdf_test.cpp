#include "renderer/bsdf/bsdf.h"

#include <array>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/renderer/bsdf/direction_quadrature.h"

namespace pathfit::renderer::bsdf_test {
namespace {

const Rgb kBase{0.8, 0.35, 0.1};

const std::vector<Bsdf>& OpaqueModels() {
  static const std::vector<Bsdf> models = {
      LambertBsdf{},
      MetallicRoughnessBsdf{},
      RoughConductorBsdf{},
      RoughConductorBsdf{.distribution = MicrofacetDistribution::kBeckmann}};
  return models;
}

struct Case {
  double roughness, metallic;
  BsdfCosines cosines;
};
constexpr std::array<Case, 6> kCases = {{{0.5, 0.0, {0.8, 0.7, 0.3}},
                                         {0.5, 1.0, {0.6, 0.9, 0.2}},
                                         {0.3, 0.4, {0.9, 0.85, 0.6}},
                                         {1.0, 0.7, {0.2, 0.5, -0.5}},
                                         {0.2, 0.2, {0.4, 0.5, -0.5}},
                                         {0.7, 0.5, {0.3, 0.25, 0.9}}}};

TEST(Bsdf, OpaqueModelsAreZeroBelowTheSurface) {
  for (const Bsdf& bsdf : OpaqueModels()) {
    for (const BsdfCosines& c : {BsdfCosines{-0.1, 0.5, 0.0}, BsdfCosines{0.0, 0.5, 0.0}}) {
      const BsdfInputs in{kBase, 0.4, 0.3};
      EXPECT_TRUE(IsBlack(EvalBsdf(bsdf, in, c)));
      EXPECT_TRUE(IsBlack(EvalBsdfPartials(bsdf, in, c).value));
      EXPECT_EQ(BsdfPdf(bsdf, in, c), 0.0);
      EXPECT_EQ(MirroredPairPdf(bsdf, in, c), 0.0);
    }
  }
}

TEST(Bsdf, IsReciprocal) {
  for (const Bsdf& bsdf : OpaqueModels()) {
    for (const Case& at : kCases) {
      const BsdfInputs in{kBase, at.roughness, at.metallic};
      const BsdfCosines swapped{at.cosines.cos_o, at.cosines.cos_i, at.cosines.dot_io};
      const Rgb a = EvalBsdf(bsdf, in, at.cosines);
      const Rgb b = EvalBsdf(bsdf, in, swapped);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-12 * a[c]);
    }
  }
}

/// Opposite directions have no half vector, directions behind the surface come from interpolated
/// normals, and textures hold any roughness; nothing may become infinite.
TEST(Bsdf, StaysFiniteForDegenerateDirections) {
  std::vector<Bsdf> models = OpaqueModels();
  models.insert(models.end(),
                {RoughDielectricBsdf{0.5, 1.5},
                 RoughDielectricBsdf{0.5, 0.6},
                 RoughDielectricBsdf{0.5, 1.5, MicrofacetDistribution::kBeckmann},
                 RoughConductorBsdf{0.5, {0, 0, 0}, {0, 0, 0}},
                 RoughConductorBsdf{0.5, {0.5, 1.0, 2.0}, {0, 0, 0}}});
  for (const Bsdf& bsdf : models) {
    for (const double roughness : {0.0, kMinRoughness, 0.5, 1.0}) {
      for (const bool inside : {false, true}) {
        for (const BsdfCosines& c : {BsdfCosines{1e-8, 1e-8, -1.0},
                                     BsdfCosines{1e-12, 1.0, 1e-12},
                                     BsdfCosines{1.0, 1.0, 1.0},
                                     BsdfCosines{-1.0, 1.0, -1.0},
                                     BsdfCosines{-1e-9, 0.02, -0.9998},
                                     BsdfCosines{1.0, -1.0, -1.0},
                                     BsdfCosines{0.1, -0.1, -1.0},
                                     BsdfCosines{-0.1, -0.1, 1.0}}) {
          const BsdfInputs in{kBase, roughness, 0.4, inside};
          EXPECT_TRUE(IsFinite(EvalBsdf(bsdf, in, c)));
          const BsdfPartials p = EvalBsdfPartials(bsdf, in, c);
          for (const Rgb& d : {p.value,
                               p.d_cos_i,
                               p.d_cos_o,
                               p.d_dot_io,
                               p.d_base_color,
                               p.d_roughness,
                               p.d_metallic,
                               p.d_specular,
                               p.d_eta,
                               p.d_k})
            EXPECT_TRUE(IsFinite(d));
          EXPECT_TRUE(std::isfinite(BsdfPdf(bsdf, in, c)));
          EXPECT_TRUE(std::isfinite(MirroredPairPdf(bsdf, in, c)));
          EXPECT_GE(MirroredPairPdf(bsdf, in, c), 0.0);
        }
      }
    }
  }
}

TEST(Bsdf, FollowsTheGltfFormula) {
  // Specification, appendix B: dielectric = mix(diffuse, specular, F with f0 = 0.04); metal =
  // specular tinted by F.
  const BsdfCosines c{0.8, 0.6, 0.5};
  const double weight = std::pow(1.0 - std::sqrt(0.75), 5);
  const MetallicRoughnessBsdf model;
  const Rgb black = EvalBsdf(model, {{0, 0, 0}, 0.5, 0.0}, c);
  const double specular = black.r / (0.04 + 0.96 * weight);
  const Rgb dielectric = EvalBsdf(model, {kBase, 0.5, 0.0}, c);
  const Rgb metal = EvalBsdf(model, {kBase, 0.5, 1.0}, c);
  for (int i = 0; i < 3; ++i) {
    const double f = 0.04 + 0.96 * weight;
    EXPECT_NEAR(dielectric[i], (1.0 - f) * kBase[i] * std::numbers::inv_pi + f * specular, 1e-12);
    EXPECT_NEAR(metal[i], (kBase[i] + (1.0 - kBase[i]) * weight) * specular, 1e-12);
  }
  for (const double factor : {0.0, 0.25, 1.0}) {
    const double share = factor * (0.04 + 0.96 * weight);
    const Rgb dull = EvalBsdf(MetallicRoughnessBsdf{0.5, 0.0, factor}, {kBase, 0.5, 0.0}, c);
    EXPECT_NEAR(dull.r, (1.0 - share) * kBase.r * std::numbers::inv_pi + share * specular, 1e-12);
  }
}

/// White GGX metal in a constant environment.
struct Reflectance {
  double value, by_alpha;
};
Reflectance WhiteMetal(const Bsdf& bsdf, double alpha, double cos_o) {
  const Vec3 wo = tests::DirectionAt(cos_o, 0.0);
  const BsdfInputs in{{1, 1, 1}, std::sqrt(alpha), 1.0};
  const auto at = [&](const Vec3& wi) {
    return EvalBsdfPartials(bsdf, in, {wi.z, wo.z, Dot(wi, wo)});
  };
  return {tests::HemisphereIntegral(32, 192, [&](const Vec3& wi) { return at(wi).value.r * wi.z; }),
          tests::HemisphereIntegral(32, 192, [&](const Vec3& wi) {
            return at(wi).d_roughness.r * wi.z;
          }) / (2.0 * in.roughness)};
}

/// path_space 6.3, C20; the figures there are good to the relative errors in the last column.
TEST(Bsdf, WhiteReflectorHasTheKnownReflectanceAndDerivativeByAlpha) {
  const RoughConductorBsdf perfect{0.5, {0, 0, 0}, {0, 0, 0}};
  for (const Bsdf& bsdf : {Bsdf{perfect}, Bsdf{MetallicRoughnessBsdf{}}}) {
    const Reflectance normal = WhiteMetal(bsdf, 0.3, 1.0);
    EXPECT_NEAR(normal.value, 8.773584157886e-01, 9.3e-6 * 0.88);
    EXPECT_NEAR(normal.by_alpha, -8.261023256234e-01, 3.3e-7 * 0.83);
    const Reflectance oblique = WhiteMetal(bsdf, 0.3, std::sqrt(0.5));
    EXPECT_NEAR(oblique.value, 8.453962137678e-01, 5.0e-7 * 0.85);
    EXPECT_NEAR(oblique.by_alpha, -8.300498981922e-01, 7.2e-6 * 0.83);
  }
}

/// Radiance through the interface is larger in the dense medium by the squared index: what is
/// reciprocal is f over the squared index on the side of wo.  [Walter2007]
TEST(Bsdf, RoughDielectricIsReciprocalUpToTheSquaredIndex) {
  for (const RoughDielectricBsdf& glass :
       {RoughDielectricBsdf{0.5, 1.5},
        RoughDielectricBsdf{0.5, 0.7},
        RoughDielectricBsdf{0.5, 1.5, MicrofacetDistribution::kBeckmann}}) {
    const double eta = glass.eta;
    for (const double roughness : {0.2, 0.5, 0.9}) {
      for (int k = 0; k < 40; ++k) {
        const Vec3 wo = tests::DirectionAt(0.1 + 0.02 * k, 0.3);
        const Vec3 wi = -tests::DirectionAt(0.95 - 0.015 * k, 0.3 + 0.01 * k);
        const double dot = Dot(wi, wo);
        const double out = EvalBsdf(glass, {{1, 1, 1}, roughness, 0.0, false}, {wi.z, wo.z, dot}).r;
        const double in = EvalBsdf(glass, {{1, 1, 1}, roughness, 0.0, true}, {-wo.z, -wi.z, dot}).r;
        EXPECT_NEAR(in, eta * eta * out, 1e-11 * (in + 1e-12));
        const double mirrored = EvalBsdf(glass, {{1, 1, 1}, roughness}, {-wi.z, wo.z, -dot}).r;
        const double swapped = EvalBsdf(glass, {{1, 1, 1}, roughness}, {wo.z, -wi.z, -dot}).r;
        EXPECT_NEAR(mirrored, swapped, 1e-12 * mirrored);
      }
    }
  }
}

/// Power reflected and transmitted (the latter without the squared index ratio of radiance) of
/// light from wo, over a lattice in the unit cube of SampleBsdf.
double ScatteredPower(const Bsdf& bsdf, const BsdfInputs& in, double cos_o) {
  constexpr int kPoints = 20000;
  const Vec3 wo = tests::DirectionAt(cos_o, 0.0);
  const double ratio = RelativeEta(bsdf, in);
  double sum = 0.0;
  for (int k = 0; k < kPoints; ++k) {
    const auto turn = [k](double step) { return std::fmod(0.5 + step * k, 1.0); };
    const auto sample = SampleBsdf(bsdf,
                                   in,
                                   {0, 0, 1},
                                   wo,
                                   turn(0.8191725133961645),
                                   turn(0.6710436067037893),
                                   turn(0.5497004779019703));
    if (sample) {
      const BsdfCosines c{sample->wi.z, wo.z, Dot(sample->wi, wo)};
      const double scale = c.cos_i < 0.0 ? 1.0 / (ratio * ratio) : 1.0;
      sum += EvalBsdf(bsdf, in, c).g * std::abs(c.cos_i) * scale / sample->pdf;
    }
  }
  return sum / kPoints;
}

/// What neighbouring microfacets shadow is lost; the loss falls as alpha^2, that of Beckmann, which
/// has no steep facets, faster.
void CheckLoss(MicrofacetDistribution distribution) {
  for (const double eta : {1.5, 1.0 / 1.33}) {
    for (const bool inside : {false, true}) {
      for (const double cos_o : {0.3, 0.7, 1.0}) {
        const auto loss = [&](double roughness) {
          const BsdfInputs in{{1, 1, 1}, roughness, 0.0, inside};
          return 1.0 - ScatteredPower(RoughDielectricBsdf{0.5, eta, distribution}, in, cos_o);
        };
        constexpr double kLattice = 5e-4;
        EXPECT_NEAR(loss(kMinRoughness), 0.0, kLattice);
        const double smooth = loss(0.1);
        const double medium = loss(0.2);
        const double rough = loss(0.4);
        const std::string at = std::to_string(eta) + (inside ? " inside " : " outside ") +
                               std::to_string(cos_o) + ": " + std::to_string(smooth) + " " +
                               std::to_string(medium) + " " + std::to_string(rough);
        EXPECT_GT(smooth, -kLattice) << at;
        EXPECT_LT(smooth, 4e-3) << at;
        EXPECT_LT(smooth, 0.2 * medium + kLattice) << at;
        EXPECT_LT(medium, 0.3 * rough + kLattice) << at;
        EXPECT_LT(rough, 0.2) << at;
        EXPECT_GT(loss(1.0), 0.0) << at;
        EXPECT_LT(loss(1.0), 0.6) << at;
      }
    }
  }
}
TEST(Bsdf, RoughDielectricKeepsEnergy) { CheckLoss(MicrofacetDistribution::kGgx); }
TEST(Bsdf, BeckmannDielectricKeepsEnergy) { CheckLoss(MicrofacetDistribution::kBeckmann); }

}  // namespace
}  // namespace pathfit::renderer::bsdf_test
