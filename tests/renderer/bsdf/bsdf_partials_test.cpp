#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "renderer/bsdf/bsdf.h"
#include "renderer/bsdf/microfacet_kernel.h"
#include "renderer/math/vector.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::bsdf_partials_test {
namespace {

constexpr double kSameFormula = 1e-10;
constexpr double kDifference = 1e-6;
constexpr int kArguments = 9;
constexpr std::array<const char*, kArguments> kNames = {
    "cos_i", "cos_o", "dot_io", "base", "roughness", "metallic", "eta", "k", "specular"};

enum class Kind { kMetallicRoughness, kConductor, kDielectric };

constexpr auto kGgx = MicrofacetDistribution::kGgx;
constexpr auto kBeckmann = MicrofacetDistribution::kBeckmann;

/// One channel of the models as formulas of all arguments, written a second time.
template <class Distribution, class T>
T Formula(Kind kind, bool from_inside, const std::array<T, kArguments>& x) {
  using std::sqrt;
  const auto& [cos_i, cos_o, dot_io, base, roughness, metallic, eta, k, specular_share] = x;
  const T alpha = roughness * roughness;
  const T half = sqrt((T(1.0) + dot_io) * T(0.5));
  if (kind == Kind::kDielectric) {
    const T e = from_inside ? T(1.0) / eta : eta;
    return ScalarPart(cos_i) < 0.0
               ? base * MicrofacetTransmission<Distribution>(cos_i, cos_o, dot_io, alpha, e)
               : base * FresnelDielectric(half, e) *
                     MicrofacetReflection<Distribution>(cos_i, cos_o, dot_io, alpha);
  }
  const T specular = MicrofacetReflection<Distribution>(cos_i, cos_o, dot_io, alpha);
  if (kind == Kind::kConductor) {
    return base * FresnelConductor(half, eta, k) * specular;
  }
  const auto fresnel_of = [&](const T& f0) { return f0 + (T(1.0) - f0) * SchlickWeight(dot_io); };
  const T fresnel =
      specular_share * fresnel_of(T(0.04)) * (T(1.0) - metallic) + fresnel_of(base) * metallic;
  return (T(1.0) - fresnel) * base * (T(1.0) - metallic) * T(std::numbers::inv_pi) +
         fresnel * specular;
}

struct Model {
  Kind kind;
  bool from_inside;
  MicrofacetDistribution distribution = kGgx;
};

/// The constants of the model that are also inputs must not matter: the inputs replace them.
Bsdf BsdfOf(const Model& model, const std::array<double, kArguments>& x) {
  switch (model.kind) {
    case Kind::kMetallicRoughness:
      return MetallicRoughnessBsdf{0.9, 0.1, x[8]};
    case Kind::kConductor:
      return RoughConductorBsdf{0.9, Rgb::Constant(x[6]), Rgb::Constant(x[7]), model.distribution};
    case Kind::kDielectric:
      return RoughDielectricBsdf{0.9, x[6], model.distribution};
  }
  return {};
}

/// The same channel by EvalBsdf.
double Value(const Model& model, const std::array<double, kArguments>& x) {
  const BsdfInputs in{Rgb::Constant(x[3]), x[4], x[5], model.from_inside};
  const BsdfCosines c{x[0], x[1], x[2]};
  return EvalBsdf(BsdfOf(model, x), in, c).g;
}

BsdfPartials Partials(const Model& model, const std::array<double, kArguments>& x) {
  const BsdfInputs in{Rgb::Constant(x[3]), x[4], x[5], model.from_inside};
  const BsdfCosines c{x[0], x[1], x[2]};
  return EvalBsdfPartials(BsdfOf(model, x), in, c);
}

std::array<double, kArguments> AsArray(const BsdfPartials& p) {
  return {p.d_cos_i.g,
          p.d_cos_o.g,
          p.d_dot_io.g,
          p.d_base_color.g,
          p.d_roughness.g,
          p.d_metallic.g,
          p.d_eta.g,
          p.d_k.g,
          p.d_specular.g};
}

struct Case {
  Model model;
  std::array<double, kArguments> x;
};

/// Each model at ordinary, mirror-like and grazing directions; the dielectric on both sides, seen
/// from both.
std::vector<Case> Cases() {
  std::vector<Case> cases;
  const auto add =
      [&](Kind kind, bool inside, Vec3 wi, Vec3 wo, double roughness, double eta, double k) {
        wi = Normalized(wi);
        wo = Normalized(wo);
        for (const double metallic : {0.0, 0.3, 1.0}) {
          const double specular = 0.3 + 0.6 * metallic;
          cases.push_back({{kind, inside},
                           {wi.z, wo.z, Dot(wi, wo), 0.7, roughness, metallic, eta, k, specular}});
          if (kind != Kind::kMetallicRoughness) break;
        }
        if (kind == Kind::kMetallicRoughness) return;
        // Beckmann's lobe has an end: not where nothing is left of it.
        const Vec3 h = Normalized(wi.z > 0.0 ? wi + wo : wo + wi * (inside ? 1.0 / eta : eta));
        if ((1.0 / (h.z * h.z) - 1.0) / std::pow(roughness, 4) < 30.0) {
          cases.push_back(cases.back());
          cases.back().model.distribution = kBeckmann;
        }
      };
  const std::array<std::array<Vec3, 2>, 5> reflections = {{{{{0.5, 0.2, 0.8}, {-0.3, 0.1, 0.7}}},
                                                           {{{0.62, 0.02, 0.8}, {-0.6, 0.0, 0.8}}},
                                                           {{{0.9, 0.3, 0.06}, {-0.8, 0.1, 0.3}}},
                                                           {{{0.3, 0.1, 0.4}, {-0.9, 0.2, 0.025}}},
                                                           {{{0.1, 0.9, 0.5}, {0.7, -0.2, 0.4}}}}};
  for (const auto& [wi, wo] : reflections) {
    for (const double roughness : {0.2, 0.5, 1.0}) {
      add(Kind::kMetallicRoughness, false, wi, wo, roughness, 1.5, 1.0);
      add(Kind::kConductor, false, wi, wo, roughness, 0.42, 2.47);
      add(Kind::kConductor, false, wi, wo, roughness, 2.9, 3.1);
      add(Kind::kDielectric, false, wi, wo, roughness, 1.5, 1.0);
      add(Kind::kDielectric, true, wi, wo, roughness, 1.5, 1.0);
    }
  }
  const std::array<std::array<Vec3, 2>, 3> into_dense = {
      {{{{-0.3, 0.05, -0.9}, {0.5, 0.1, 0.8}}},
       {{{-0.68, -0.06, -0.75}, {0.95, 0.1, 0.04}}},
       {{{-0.1, -0.02, -0.99}, {0.16, 0.02, 0.98}}}}};
  for (const auto& [wi, wo] : into_dense) {
    for (const double roughness : {0.2, 0.5, 1.0}) {
      add(Kind::kDielectric, false, wi, wo, roughness, 1.5, 1.0);
      add(Kind::kDielectric, true, -wo, -wi, roughness, 1.5, 1.0);
    }
  }
  return cases;
}

std::string Name(const Case& at, std::size_t argument) {
  return std::string(kNames[argument]) + " of model " +
         std::to_string(static_cast<int>(at.model.kind)) +
         (at.model.distribution == kBeckmann ? " (Beckmann)" : "") +
         (at.model.from_inside ? " inside" : " outside") + " cos_i " + std::to_string(at.x[0]) +
         " cos_o " + std::to_string(at.x[1]) + " roughness " + std::to_string(at.x[4]);
}

TEST(BsdfPartials, EqualJetsOfTheFormulasAndDifferencesOfTheValues) {
  using J = ceres::Jet<double, kArguments>;
  for (const Case& at : Cases()) {
    std::array<J, kArguments> jets;
    for (std::size_t i = 0; i < kArguments; ++i) jets[i] = J(at.x[i], static_cast<int>(i));
    const auto [kind, from_inside, distribution] = at.model;
    const J by_jet = distribution == kBeckmann ? Formula<Beckmann>(kind, from_inside, jets)
                                               : Formula<Ggx>(kind, from_inside, jets);
    const BsdfPartials p = Partials(at.model, at.x);
    const double value = Value(at.model, at.x);
    ASSERT_GT(value, 0.0) << Name(at, 0);
    EXPECT_LT(tests::RelativeError(p.value.g, value, 0.0), 1e-12);
    EXPECT_LT(tests::RelativeError(by_jet.a, value, 0.0), 1e-12);
    const std::array<double, kArguments> partials = AsArray(p);
    for (std::size_t i = 0; i < kArguments; ++i) {
      const auto along = [&](double y) {
        std::array<double, kArguments> moved = at.x;
        moved[i] = y;
        return Value(at.model, moved);
      };
      const double alpha = at.x[4] * at.x[4];
      const double scale = value / alpha;
      // Directions and the index move cos_h, whose scale is alpha^2.
      const double step = i < 3 || i == 6 ? 0.02 * alpha * alpha : 0.02 * alpha;
      EXPECT_LT(tests::RelativeError(partials[i], by_jet.v[static_cast<int>(i)], scale),
                kSameFormula)
          << Name(at, i);
      if (i != 1 || at.x[1] - step > kMinCosO) {
        EXPECT_LT(tests::RelativeError(
                      partials[i], tests::RiddersDerivative(along, at.x[i], step), scale),
                  kDifference)
            << Name(at, i);
      }
    }
  }
}

/// Interpolated normals may turn away from the camera: the value goes on smoothly and its partials
/// stay those of the value.
TEST(BsdfPartials, HoldBelowTheLeastCosineToo) {
  for (const Case& at : Cases()) {
    for (const double cos_o : {0.004, -0.02, -0.3}) {
      const bool across = at.x[0] < 0.0;
      const double cos_i = across ? -0.6 : 0.55;
      std::array<double, kArguments> x = at.x;
      x[0] = cos_i;
      x[1] = cos_o;
      x[2] = cos_i * cos_o - 0.9 * std::sqrt((1.0 - cos_i * cos_i) * (1.0 - cos_o * cos_o));
      const std::array<double, kArguments> partials = AsArray(Partials(at.model, x));
      const double value = Value(at.model, x);
      EXPECT_TRUE(std::isfinite(value));
      for (std::size_t i = 0; i < kArguments; ++i) {
        const auto along = [&](double y) {
          std::array<double, kArguments> moved = x;
          moved[i] = y;
          return Value(at.model, moved);
        };
        const double alpha = x[4] * x[4];
        EXPECT_LT(tests::RelativeError(
                      partials[i],
                      tests::RiddersDerivative(along, x[i], std::min(0.004, 0.02 * alpha)),
                      std::max(value / alpha, 1e-3)),
                  kDifference)
            << Name(at, i) << " at " << cos_o;
      }
    }
  }
}

TEST(BsdfPartials, OfLambertAreThoseOfAConstant) {
  const Rgb base{0.8, 0.35, 0.1};
  const BsdfPartials p = EvalBsdfPartials(LambertBsdf{}, {base}, {0.5, -0.6, 0.2});
  EXPECT_EQ(p.value, base * std::numbers::inv_pi);
  EXPECT_EQ(p.d_base_color, Rgb::Constant(std::numbers::inv_pi));
  for (const Rgb& zero : {p.d_cos_i,
                          p.d_cos_o,
                          p.d_dot_io,
                          p.d_roughness,
                          p.d_metallic,
                          p.d_specular,
                          p.d_eta,
                          p.d_k})
    EXPECT_TRUE(IsBlack(zero));
}

TEST(BsdfPartials, ActChannelByChannel) {
  const Rgb base{0.8, 0.35, 0.1};
  const RoughConductorBsdf gold{0.5, {0.19, 0.42, 1.38}, {3.4, 2.47, 1.91}};
  const BsdfCosines c{0.6, 0.7, 0.1};
  const BsdfInputs in{base, 0.4};
  const BsdfPartials all = EvalBsdfPartials(gold, in, c);
  for (int i = 0; i < 3; ++i) {
    const RoughConductorBsdf one{0.5, Rgb::Constant(gold.eta[i]), Rgb::Constant(gold.k[i])};
    const BsdfPartials p = EvalBsdfPartials(one, {Rgb::Constant(base[i]), 0.4}, c);
    EXPECT_EQ(all.value[i], p.value[i]);
    EXPECT_EQ(all.d_eta[i], p.d_eta[i]);
    EXPECT_EQ(all.d_k[i], p.d_k[i]);
    EXPECT_EQ(all.d_base_color[i], p.d_base_color[i]);
  }
}

TEST(BsdfPartials, RoughnessBelowTheLeastCountsAsTheLeast) {
  for (const Bsdf& bsdf : {Bsdf{MetallicRoughnessBsdf{}},
                           Bsdf{RoughConductorBsdf{}},
                           Bsdf{RoughDielectricBsdf{}},
                           Bsdf{RoughConductorBsdf{.distribution = kBeckmann}},
                           Bsdf{RoughDielectricBsdf{.distribution = kBeckmann}}}) {
    const BsdfCosines c{0.7, 0.7, -0.02 + 1e-6};
    const BsdfInputs least{{1, 1, 1}, kMinRoughness, 0.5};
    const BsdfInputs below{{1, 1, 1}, 0.0, 0.5};
    EXPECT_EQ(EvalBsdf(bsdf, below, c), EvalBsdf(bsdf, least, c));
    EXPECT_TRUE(IsBlack(EvalBsdfPartials(bsdf, below, c).d_roughness));
    EXPECT_FALSE(IsBlack(EvalBsdfPartials(bsdf, least, c).d_roughness));
  }
}

}  // namespace
}  // namespace pathfit::renderer::bsdf_partials_test
