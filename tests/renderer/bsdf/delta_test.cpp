#include <array>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/bsdf/bsdf.h"
#include "renderer/bsdf/fresnel_kernel.h"
#include "renderer/bsdf/metals.h"
#include "tests/renderer/bsdf/direction_quadrature.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::delta_test {
namespace {

using tests::DirectionAt;
const Vec3 kNormal = Normalized(Vec3{0.3, -0.5, 0.7});
const Rgb kBase{0.9, 0.6, 0.2};

MirrorBsdf GoldMirror() {
  const Metal gold = NamedMetal("gold").value();
  return {gold.eta, gold.k};
}

/// A unit direction with this cosine to kNormal.
Vec3 OutAt(double cos_o) {
  const Vec3 t = Normalized(Cross(kNormal, Vec3{0.2, 0.9, 0.1}));
  return kNormal * cos_o + t * std::sqrt(1.0 - cos_o * cos_o);
}

TEST(DeltaBsdf, AreTheSmoothModels) {
  EXPECT_TRUE(IsDelta(MirrorBsdf{}));
  EXPECT_TRUE(IsDelta(SmoothDielectricBsdf{}));
  EXPECT_TRUE(IsTransmissive(SmoothDielectricBsdf{}));
  EXPECT_TRUE(IsTransmissive(RoughDielectricBsdf{}));
  for (const Bsdf& bsdf :
       {Bsdf{LambertBsdf{}}, Bsdf{MetallicRoughnessBsdf{}}, Bsdf{RoughConductorBsdf{}}}) {
    EXPECT_FALSE(IsDelta(bsdf));
    EXPECT_FALSE(IsTransmissive(bsdf));
    EXPECT_TRUE(IsBlack(EvalDelta(bsdf, {}, 0.5, false).value));
    EXPECT_EQ(RelativeEta(bsdf, {}), 1.0);
  }
  EXPECT_FALSE(IsDelta(RoughDielectricBsdf{}));
  EXPECT_FALSE(IsTransmissive(MirrorBsdf{}));
}

TEST(DeltaBsdf, HaveNoValueAndNoDensity) {
  const BsdfCosines mirrored{0.6, 0.6, 2.0 * 0.36 - 1.0};
  for (const Bsdf& bsdf : {Bsdf{MirrorBsdf{}}, Bsdf{SmoothDielectricBsdf{}}}) {
    EXPECT_TRUE(IsBlack(EvalBsdf(bsdf, {}, mirrored)));
    EXPECT_TRUE(IsBlack(EvalBsdfPartials(bsdf, {}, mirrored).value));
    EXPECT_EQ(BsdfPdf(bsdf, {}, mirrored), 0.0);
    EXPECT_EQ(MirroredPairPdf(bsdf, {}, mirrored), 0.0);
  }
}

TEST(DeltaBsdf, MirrorReflectsAboutTheNormalAndAbsorbsFromBelow) {
  for (const double cos_o : {1e-3, 0.2, 0.7, 1.0}) {
    const Vec3 wo = OutAt(cos_o);
    for (const bool mirrored : {false, true}) {
      const auto sample = SampleBsdf(GoldMirror(), {kBase}, kNormal, wo, 0.3, 0.6, 0.9, mirrored);
      ASSERT_TRUE(sample);
      EXPECT_TRUE(sample->delta);
      EXPECT_EQ(sample->pdf, 1.0);
      EXPECT_NEAR(Norm(Normalized(sample->wi + wo) - kNormal), 0.0, 1e-10);
      EXPECT_NEAR(Norm(sample->wi), 1.0, 1e-14);
    }
  }
  EXPECT_FALSE(SampleBsdf(GoldMirror(), {kBase}, kNormal, -OutAt(0.1), 0.3, 0.6, 0.9));
  EXPECT_TRUE(IsBlack(EvalDelta(GoldMirror(), {kBase}, -0.1, false).value));
  EXPECT_TRUE(IsBlack(EvalDelta(GoldMirror(), {kBase}, 0.5, true).value));
}

TEST(DeltaBsdf, MirrorWithoutIndexReflectsItsColour) {
  for (const double cos_o : {0.01, 0.5, 1.0}) {
    const DeltaPartials p = EvalDelta(MirrorBsdf{}, {kBase}, cos_o, false);
    EXPECT_EQ(p.value, kBase);
    EXPECT_EQ(p.d_base_color, Rgb::Constant(1.0));
    for (const Rgb& d : {p.d_cos_o, p.d_eta, p.d_k}) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(d[c], 0.0, 1e-12);
    }
  }
}

TEST(DeltaBsdf, SmoothDielectricRefractsBySnellAndKeepsItsEnergy) {
  const double eta = 1.5;
  for (const bool inside : {false, true}) {
    const BsdfInputs in{{1, 1, 1}, 0.5, 0.0, inside};
    const double here_over_beyond = inside ? eta : 1.0 / eta;
    EXPECT_NEAR(RelativeEta(SmoothDielectricBsdf{eta}, in), here_over_beyond, 1e-15);
    for (const double cos_o : {0.8, 0.95, 1.0}) {
      const Vec3 wo = OutAt(cos_o);
      const auto r = SampleBsdf(SmoothDielectricBsdf{eta}, in, kNormal, wo, 0.5, 0.5, 0.0);
      const auto t = SampleBsdf(SmoothDielectricBsdf{eta}, in, kNormal, wo, 0.5, 0.5, 0.999);
      ASSERT_TRUE(r && t);
      EXPECT_NEAR(r->pdf + t->pdf, 1.0, 1e-15);
      EXPECT_NEAR(Dot(r->wi, kNormal), cos_o, 1e-12);
      const Vec3 tangent_o = wo - kNormal * cos_o;
      const Vec3 tangent_t = t->wi - kNormal * Dot(t->wi, kNormal);
      EXPECT_LT(Dot(t->wi, kNormal), 0.0);
      EXPECT_NEAR(Norm(t->wi), 1.0, 1e-12);
      EXPECT_NEAR(Norm(tangent_t + tangent_o * here_over_beyond), 0.0, 1e-12);
      // Energy through the interface: the radiance weight without the squared index ratio.
      const double reflected = EvalDelta(SmoothDielectricBsdf{eta}, in, cos_o, false).value.r;
      const double through = EvalDelta(SmoothDielectricBsdf{eta}, in, cos_o, true).value.r /
                             (here_over_beyond * here_over_beyond);
      EXPECT_NEAR(reflected + through, 1.0, 1e-14);
    }
  }
}

TEST(DeltaBsdf, SmoothDielectricReflectsAllBeyondTheCriticalAngle) {
  const BsdfInputs in{{1, 1, 1}, 0.5, 0.0, true};
  const double cos_o = 0.6;  // the critical cosine of 1.5 is 0.745
  const auto sample =
      SampleBsdf(SmoothDielectricBsdf{1.5}, in, kNormal, OutAt(cos_o), 0, 0, 0.9999);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->pdf, 1.0);
  EXPECT_NEAR(Dot(sample->wi, kNormal), cos_o, 1e-12);
  EXPECT_EQ(EvalDelta(SmoothDielectricBsdf{1.5}, in, cos_o, false).value.g, 1.0);
  EXPECT_TRUE(IsBlack(EvalDelta(SmoothDielectricBsdf{1.5}, in, cos_o, true).value));
}

TEST(DeltaBsdf, PartialsAreDifferences) {
  const auto check = [](auto model, bool inside, double cos_o, bool transmit) {
    const BsdfInputs in{kBase, 0.5, 0.0, inside};
    const DeltaPartials p = EvalDelta(model, in, cos_o, transmit);
    for (int c = 0; c < 3; ++c) {
      const auto expect = [&](double partial, double x, auto value) {
        EXPECT_LT(tests::RelativeError(partial, tests::RiddersDerivative(value, x, 4e-3)), 1e-7)
            << "channel " << c << " cos_o " << cos_o << " inside " << inside;
      };
      expect(p.d_cos_o[c], cos_o, [&](double x) {
        return EvalDelta(model, in, x, transmit).value[c];
      });
      expect(p.d_base_color[c], kBase[c], [&](double x) {
        BsdfInputs moved = in;
        moved.base_color[c] = x;
        return EvalDelta(model, moved, cos_o, transmit).value[c];
      });
      if constexpr (std::is_same_v<decltype(model), MirrorBsdf>) {
        expect(p.d_eta[c], model.eta[c], [&](double x) {
          MirrorBsdf moved = model;
          moved.eta[c] = x;
          return EvalDelta(moved, in, cos_o, transmit).value[c];
        });
        expect(p.d_k[c], model.k[c], [&](double x) {
          MirrorBsdf moved = model;
          moved.k[c] = x;
          return EvalDelta(moved, in, cos_o, transmit).value[c];
        });
      } else {
        expect(p.d_eta[c], model.eta, [&](double x) {
          return EvalDelta(SmoothDielectricBsdf{x}, in, cos_o, transmit).value[c];
        });
        EXPECT_EQ(p.d_k[c], 0.0);
      }
    }
  };
  for (const double cos_o : {0.02, 0.3, 0.8, 0.99}) {
    check(GoldMirror(), false, cos_o, false);
    for (const double eta : {1.5, 0.75}) {
      for (const bool transmit : {false, true}) {
        check(SmoothDielectricBsdf{eta}, false, cos_o, transmit);
        check(SmoothDielectricBsdf{eta}, true, cos_o, transmit);
      }
    }
  }
}

/// path_space 6.3, C20b: a slab passes T = t_in t_out / (1 - R^2) with all inner reflections.
TEST(DeltaBsdf, SlabTransmitsTheKnownShareAndDerivative) {
  const SmoothDielectricBsdf glass{1.5};
  const BsdfInputs outside;
  BsdfInputs inside;
  inside.from_inside = true;
  const DeltaPartials in = EvalDelta(glass, outside, 1.0, true);
  const DeltaPartials out = EvalDelta(glass, inside, 1.0, true);
  const DeltaPartials back = EvalDelta(glass, inside, 1.0, false);
  const double r = back.value.r;
  const double transmitted = in.value.r * out.value.r / (1.0 - r * r);
  const double by_eta = transmitted * (in.d_eta.r / in.value.r + out.d_eta.r / out.value.r +
                                       2.0 * r * back.d_eta.r / (1.0 - r * r));
  EXPECT_NEAR(transmitted, 9.230769230769e-01, 1e-12);
  EXPECT_NEAR(by_eta, -2.366863905325e-01, 1e-12);
  EXPECT_NEAR(back.d_eta.r, 0.128, 1e-14);
}

}  // namespace
}  // namespace pathfit::renderer::delta_test
