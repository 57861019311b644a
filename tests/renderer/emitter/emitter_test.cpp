#include "renderer/emitter/emitter.h"

#include <numbers>

#include <gtest/gtest.h>

#include "renderer/math/frame.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/finite_difference.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::emitter_test {
namespace {

constexpr double kRounding = 1e-12;

EnvironmentEmitter Gradient(int width, int height) {
  return std::get<EnvironmentEmitter>(tests::GradientEnvironment(width, height).light);
}
Rgb Radiance(const EnvironmentEmitter& environment, const Vec3& direction) {
  return EnvironmentRadianceAt(environment, EnvironmentUv(direction));
}

/// u = atan2(d.x, -d.z) / (2 pi) mod 1, v = acos(d.y) / pi; the convention of equirectangular maps
/// with +y up.
TEST(EnvironmentUv, KnownDirections) {
  const auto expect = [](const Vec3& d, double u, double v) {
    const Vec2 uv = EnvironmentUv(d);
    EXPECT_NEAR(uv.x, u, kRounding);
    EXPECT_NEAR(uv.y, v, kRounding);
  };
  expect({0, 0, -1}, 0.0, 0.5);
  expect({1, 0, 0}, 0.25, 0.5);
  expect({0, 0, 1}, 0.5, 0.5);
  expect({-1, 0, 0}, 0.75, 0.5);
  EXPECT_NEAR(EnvironmentUv({0, 1, 0}).y, 0.0, kRounding);
  EXPECT_NEAR(EnvironmentUv({0, -1, 0}).y, 1.0, kRounding);
}

TEST(EnvironmentUv, DirectionUndoesUv) {
  CounterRng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec2 uv{rng.Next(), 0.01 + 0.98 * rng.Next()};
    const Vec2 back = EnvironmentUv(EnvironmentDirection(uv));
    EXPECT_NEAR(back.x, uv.x, 1e-10);
    EXPECT_NEAR(back.y, uv.y, 1e-10);
  }
}

TEST(EnvironmentTexels, CentresLieAtHalfIntegersAndRowZeroIsTheUpperPole) {
  EnvironmentEmitter environment = Gradient(8, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; ++x) {
      const Vec3 d = EnvironmentDirection({(x + 0.5) / 8.0, (y + 0.5) / 4.0});
      const Rgb expected = environment.texels[static_cast<std::size_t>(8 * y + x)];
      const Rgb radiance = Radiance(environment, d);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c], expected[c], kRounding);
    }
  }
  environment.texels.assign(32, {0, 0, 0});
  for (std::size_t x = 0; x < 8; ++x) environment.texels[x] = {1, 1, 1};
  EXPECT_NEAR(Radiance(environment, {0, 1, 0}).r, 1.0, kRounding);
  EXPECT_NEAR(Radiance(environment, {0, -1, 0}).r, 0.0, kRounding);
}

TEST(EnvironmentTexels, UWrapsAround) {
  EnvironmentEmitter environment = Gradient(8, 4);
  const Rgb at_seam = Radiance(environment, EnvironmentDirection({0.0, 0.375}));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(
        at_seam[c], 0.5 * (environment.texels[8][c] + environment.texels[15][c]), kRounding);
  }
}

TEST(EnvironmentTexels, WeightsSumToOneAndReproduceTheRadiance) {
  EnvironmentEmitter environment = Gradient(5, 3);
  environment.intensity = {0.5, 2.0, 1.5};
  CounterRng rng(2);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 d = EnvironmentDirection({rng.Next(), rng.Next()});
    const TexelWeights lookup = EnvironmentTexelWeights(environment, EnvironmentUv(d));
    double sum = 0.0;
    Rgb radiance;
    for (std::size_t k = 0; k < 4; ++k) {
      ASSERT_GE(lookup.weight[k], 0.0);
      ASSERT_GE(lookup.texel[k], 0);
      ASSERT_LT(lookup.texel[k], 15);
      sum += lookup.weight[k];
      radiance += environment.texels[static_cast<std::size_t>(lookup.texel[k])] * lookup.weight[k];
    }
    EXPECT_NEAR(sum, 1.0, kRounding);
    const Rgb direct = Radiance(environment, d);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(direct[c], environment.intensity[c] * radiance[c], kRounding);
  }
}

TEST(EnvironmentTexels, OneTexelIsAConstant) {
  const EnvironmentEmitter environment =
      std::get<EnvironmentEmitter>(tests::ConstantEnvironment({0.25, 0.5, 0.75}).light);
  EXPECT_EQ(Radiance(environment, {0.6, 0.8, 0.0}), (Rgb{0.25, 0.5, 0.75}));
}

TEST(EnvironmentTexels, OddSizesAndPolesStayInside) {
  for (const auto& [width, height] :
       {std::pair{1, 2}, std::pair{2, 1}, std::pair{1, 7}, std::pair{7, 1}}) {
    const EnvironmentEmitter environment = Gradient(width, height);
    for (const Vec3& d :
         {Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}, Vec3{-1e-17, 0, -1}, Vec3{1e-17, 0, -1}}) {
      const TexelWeights lookup = EnvironmentTexelWeights(environment, EnvironmentUv(d));
      for (const int texel : lookup.texel) {
        EXPECT_GE(texel, 0);
        EXPECT_LT(texel, width * height);
      }
      EXPECT_TRUE(IsFinite(Radiance(environment, d)));
    }
  }
}

/// Directions inside each bilinear square, close to the poles included; along two tangents.
TEST(EnvironmentGradient, AgreesWithDifferences) {
  constexpr int kWidth = 8;
  constexpr int kHeight = 5;
  EnvironmentEmitter environment = Gradient(kWidth, kHeight);
  environment.intensity = {0.5, 2.0, 1.5};
  for (int y = 0; y <= kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      // Squares lie between texel centres; the first and the last row are half as high.
      const double v = std::clamp((y - 0.1) / kHeight, 0.02, 0.98);
      const Vec3 d = EnvironmentDirection({(x + 0.07) / kWidth, v});
      const std::array<Vec3, 3> gradient = EnvironmentGradient(environment, d);
      const Frame frame = Frame::FromNormal(d);
      for (int c = 0; c < 3; ++c) {
        const Vec3& slope = gradient[static_cast<std::size_t>(c)];
        EXPECT_NEAR(Dot(slope, d), 0.0, kRounding * 10.0);
        for (const Vec3& tangent : {frame.s, frame.t}) {
          const auto along = [&](double t) {
            return Radiance(environment, Normalized(d + tangent * t))[c];
          };
          EXPECT_NEAR(Dot(slope, tangent), tests::RiddersDerivative(along, 0.0, 0.01), 1e-6)
              << "square " << x << ", " << y << " channel " << c;
        }
      }
    }
  }
}

TEST(EnvironmentGradient, IsZeroForConstantsAndFiniteAtPolesSeamAndBorders) {
  const EnvironmentEmitter constant =
      std::get<EnvironmentEmitter>(tests::ConstantEnvironment({1, 2, 3}).light);
  EXPECT_EQ(EnvironmentGradient(constant, {0.6, 0.8, 0.0})[1], (Vec3{0, 0, 0}));
  for (const auto& [width, height] :
       {std::pair{1, 2}, std::pair{2, 1}, std::pair{1, 7}, std::pair{7, 1}, std::pair{8, 4}}) {
    const EnvironmentEmitter environment = Gradient(width, height);
    for (const double x : {0.0, 1e-300, 1e-20, 1e-9, 1e-6}) {
      for (const double y : {1.0, -1.0}) {
        for (const Vec3& gradient : EnvironmentGradient(environment, {x, y, 0.0})) {
          EXPECT_TRUE(IsFinite(gradient));
          EXPECT_LT(Norm(gradient), 1e7) << "no more than its bound at the fading distance";
        }
      }
      for (const Vec3& gradient : EnvironmentGradient(environment, {-x, 0.0, -1.0})) {
        EXPECT_TRUE(IsFinite(gradient));
      }
    }
    EXPECT_EQ(Norm(EnvironmentGradient(environment, {0.0, 1.0, 0.0})[0]), 0.0);
  }
}

TEST(LightIntensity, NamesTheFactorOfEveryLight) {
  Emitter sky = tests::ConstantEnvironment({1, 1, 1});
  Emitter lamp{"lamp", LightFrame::kWorld, {}, PointEmitter{}};
  Emitter sun{"sun", LightFrame::kWorld, {}, DirectionalEmitter{}};
  Emitter spot{"spot", LightFrame::kWorld, {}, SpotEmitter{}};
  Emitter projector{"projector", LightFrame::kWorld, {}, ProjectorEmitter{}};
  Emitter panel{"panel", LightFrame::kWorld, {}, AreaEmitter{}};
  for (Emitter* e : {&sky, &lamp, &sun, &spot, &projector, &panel}) {
    LightIntensity(*e) = {1, 2, 3};
    EXPECT_EQ(LightIntensity(std::as_const(*e)), (Rgb{1, 2, 3}));
  }
  EXPECT_EQ(std::get<DirectionalEmitter>(sun.light).irradiance, (Rgb{1, 2, 3}));
}

}  // namespace
}  // namespace pathfit::renderer::emitter_test
