#include "renderer/bsdf/bsdf.h"

#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::renderer {
namespace {

constexpr double kDifference = 1e-6;
const Rgb kBase{0.8, 0.35, 0.1};

struct Case {
  MetallicRoughnessBsdf bsdf;
  BsdfCosines cosines;
};
const std::array<Case, 6> kCases = {{{{0.5, 0.0}, {0.8, 0.7, 0.3}},
                                     {{0.5, 1.0}, {0.6, 0.9, 0.2}},
                                     {{0.3, 0.4}, {0.9, 0.85, 0.6}},
                                     {{1.0, 0.7}, {0.2, 0.5, -0.5}},
                                     {{0.2, 0.2}, {0.4, 0.5, -0.5}},
                                     {{0.7, 0.5}, {0.3, 0.25, 0.9}}}};

/// Partial of every channel against the difference of EvalBsdf when `set(value)` changes one
/// argument.
template <class Set>
void ExpectPartial(const Case& at, double x, double step, const Rgb& partial, Set set) {
  for (int c = 0; c < 3; ++c) {
    const auto along = [&](double value) {
      Case moved = at;
      Rgb base = kBase;
      set(moved, base, value);
      return EvalBsdf(moved.bsdf, base, moved.cosines)[c];
    };
    EXPECT_LT(tests::RelativeError(partial[c], tests::RiddersDerivative(along, x, step)),
              kDifference)
        << "channel " << c << " roughness " << at.bsdf.roughness << " metallic "
        << at.bsdf.metallic;
  }
}

TEST(Bsdf, PartialsOfMetallicRoughnessAreDifferences) {
  for (const Case& at : kCases) {
    const BsdfPartials p = EvalBsdfPartials(at.bsdf, kBase, at.cosines);
    const Rgb value = EvalBsdf(at.bsdf, kBase, at.cosines);
    for (int c = 0; c < 3; ++c) EXPECT_LT(tests::RelativeError(p.value[c], value[c], 0.0), 1e-12);
    const double step = 0.05 * at.bsdf.roughness * at.bsdf.roughness;
    ExpectPartial(at, at.cosines.cos_i, step, p.d_cos_i, [](Case& m, Rgb&, double x) {
      m.cosines.cos_i = x;
    });
    ExpectPartial(at, at.cosines.cos_o, step, p.d_cos_o, [](Case& m, Rgb&, double x) {
      m.cosines.cos_o = x;
    });
    ExpectPartial(at, at.cosines.dot_io, step, p.d_dot_io, [](Case& m, Rgb&, double x) {
      m.cosines.dot_io = x;
    });
    ExpectPartial(at, at.bsdf.roughness, 0.05, p.d_roughness, [](Case& m, Rgb&, double x) {
      m.bsdf.roughness = x;
    });
    ExpectPartial(at, at.bsdf.metallic, 0.05, p.d_metallic, [](Case& m, Rgb&, double x) {
      m.bsdf.metallic = x;
    });
    for (int k = 0; k < 3; ++k) {
      Rgb diagonal;
      diagonal[k] = p.d_base_color[k];
      ExpectPartial(at, kBase[k], 0.05, diagonal, [k](Case&, Rgb& base, double x) { base[k] = x; });
    }
  }
}

TEST(Bsdf, PartialsOfLambertAreThoseOfAConstant) {
  const BsdfPartials p = EvalBsdfPartials(LambertBsdf{}, kBase, {0.5, 0.6, 0.2});
  EXPECT_EQ(p.value, kBase * std::numbers::inv_pi);
  EXPECT_EQ(p.d_base_color, Rgb::Constant(std::numbers::inv_pi));
  for (const Rgb& zero : {p.d_cos_i, p.d_cos_o, p.d_dot_io, p.d_roughness, p.d_metallic})
    EXPECT_TRUE(IsBlack(zero));
}

TEST(Bsdf, IsZeroBelowTheSurface) {
  for (const Bsdf& bsdf : {Bsdf{LambertBsdf{}}, Bsdf{MetallicRoughnessBsdf{0.4, 0.3}}}) {
    for (const BsdfCosines& c :
         {BsdfCosines{-0.1, 0.5, 0.0}, BsdfCosines{0.5, -0.1, 0.0}, BsdfCosines{0.0, 0.5, 0.0}}) {
      EXPECT_TRUE(IsBlack(EvalBsdf(bsdf, kBase, c)));
      EXPECT_TRUE(IsBlack(EvalBsdfPartials(bsdf, kBase, c).value));
      EXPECT_EQ(BsdfPdf(bsdf, kBase, c), 0.0);
    }
  }
}

TEST(Bsdf, IsReciprocal) {
  for (const Case& at : kCases) {
    const BsdfCosines swapped{at.cosines.cos_o, at.cosines.cos_i, at.cosines.dot_io};
    const Rgb a = EvalBsdf(at.bsdf, kBase, at.cosines);
    const Rgb b = EvalBsdf(at.bsdf, kBase, swapped);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-12 * a[c]);
  }
}

/// Light exactly opposite to the camera (both grazing) has no half vector; nothing may become
/// infinite.
TEST(Bsdf, StaysFiniteForOppositeDirections) {
  for (const double roughness : {kMinRoughness, 0.5, 1.0}) {
    const MetallicRoughnessBsdf bsdf{roughness, 1.0};
    for (const BsdfCosines& c : {BsdfCosines{1e-8, 1e-8, -1.0},
                                 BsdfCosines{1e-12, 1.0, 1e-12},
                                 BsdfCosines{1.0, 1.0, 1.0}}) {
      EXPECT_TRUE(IsFinite(EvalBsdf(bsdf, kBase, c)));
      const BsdfPartials p = EvalBsdfPartials(bsdf, kBase, c);
      for (const Rgb& d : {p.d_cos_i, p.d_cos_o, p.d_dot_io, p.d_roughness, p.d_metallic})
        EXPECT_TRUE(IsFinite(d));
      EXPECT_TRUE(std::isfinite(BsdfPdf(bsdf, kBase, c)));
    }
  }
}

TEST(Bsdf, FollowsTheGltfFormula) {
  // Specification, appendix B: dielectric = mix(diffuse, specular, F with f0 = 0.04); metal =
  // specular tinted by F.
  const BsdfCosines c{0.8, 0.6, 0.5};
  const double weight = std::pow(1.0 - std::sqrt(0.75), 5);
  const Rgb black = EvalBsdf(MetallicRoughnessBsdf{0.5, 0.0}, {0, 0, 0}, c);
  const double specular = black.r / (0.04 + 0.96 * weight);
  const Rgb dielectric = EvalBsdf(MetallicRoughnessBsdf{0.5, 0.0}, kBase, c);
  const Rgb metal = EvalBsdf(MetallicRoughnessBsdf{0.5, 1.0}, kBase, c);
  for (int i = 0; i < 3; ++i) {
    const double f = 0.04 + 0.96 * weight;
    EXPECT_NEAR(dielectric[i], (1.0 - f) * kBase[i] * std::numbers::inv_pi + f * specular, 1e-12);
    EXPECT_NEAR(metal[i], (kBase[i] + (1.0 - kBase[i]) * weight) * specular, 1e-12);
  }
}

}  // namespace
}  // namespace pathfit::renderer
