#include "renderer/texture/texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace pathfit::renderer::texture_test {
namespace {

Texture MakeTexture(int width, int height, TextureWrap wrap) {
  Texture texture;
  texture.width = width;
  texture.height = height;
  texture.wrap = wrap;
  texture.texels.clear();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int i = 0; i < width * height; ++i) {
    texture.texels.push_back({uniform(random), uniform(random), uniform(random)});
  }
  return texture;
}

Rgb TexelAt(const Texture& texture, int x, int row) {
  return texture.texels[static_cast<std::size_t>(row * texture.width + x)];
}

void ExpectNear(const Rgb& a, const Rgb& b, double tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance);
}

/// Weights sum to one, are not negative, and reproduce the value.
void ExpectConsistent(const Texture& texture, const TextureLookup& lookup) {
  double sum = 0.0;
  Rgb value;
  for (std::size_t k = 0; k < 4; ++k) {
    ASSERT_GE(lookup.texel[k], 0);
    ASSERT_LT(lookup.texel[k], texture.width * texture.height);
    EXPECT_GE(lookup.weight[k], 0.0);
    sum += lookup.weight[k];
    value += texture.texels[static_cast<std::size_t>(lookup.texel[k])] * lookup.weight[k];
  }
  EXPECT_NEAR(sum, 1.0, 1e-14);
  ExpectNear(value, lookup.value, 1e-15);
  EXPECT_TRUE(IsFinite(lookup.du) && IsFinite(lookup.dv));
}

constexpr TextureWrap kWraps[] = {TextureWrap::kRepeat, TextureWrap::kClamp};

TEST(Texture, TexelCentresHoldTheTexelsAndVRunsUp) {
  for (const TextureWrap wrap : kWraps) {
    const Texture texture = MakeTexture(5, 3, wrap);
    for (int row = 0; row < 3; ++row) {
      for (int x = 0; x < 5; ++x) {
        const Vec2 uv = {(x + 0.5) / 5.0, 1.0 - (row + 0.5) / 3.0};
        ExpectNear(TextureValue(texture, uv), TexelAt(texture, x, row), 1e-14);
      }
    }
  }
}

TEST(Texture, IsBilinearBetweenCentres) {
  Texture texture;
  texture.width = texture.height = 2;
  // Bottom row 1, 2; top row 4, 8 (red only).
  texture.texels = {{4, 0, 0}, {8, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  texture.wrap = TextureWrap::kClamp;
  const TextureLookup lookup = LookUpTexture(texture, {0.25 + 0.5 * 0.3, 0.25 + 0.5 * 0.8});
  EXPECT_NEAR(lookup.value.r, 0.2 * (0.7 * 1 + 0.3 * 2) + 0.8 * (0.7 * 4 + 0.3 * 8), 1e-14);
  // One unit of u is two texels.
  EXPECT_NEAR(lookup.du.r, 2.0 * (0.2 * (2 - 1) + 0.8 * (8 - 4)), 1e-13);
  EXPECT_NEAR(lookup.dv.r, 2.0 * (0.7 * (4 - 1) + 0.3 * (8 - 2)), 1e-13);
}

TEST(Texture, SlopesAgreeWithDifferences) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-2.5, 3.5);
  const std::pair<int, int> sizes[] = {{1, 1}, {1, 4}, {7, 1}, {6, 5}};
  int compared = 0;
  for (const TextureWrap wrap : kWraps) {
    for (const auto& [width, height] : sizes) {
      const Texture texture = MakeTexture(width, height, wrap);
      for (int i = 0; i < 200; ++i) {
        const Vec2 uv = {uniform(random), uniform(random)};
        const double h = 1e-5;
        // The value is piecewise bilinear: skip intervals that hold a kink, at k + 1/2 texels.
        const auto near_kink = [h](double t, int size) {
          const double place = t * size - 0.5;
          return std::abs(place - std::round(place)) < 2.0 * h * size;
        };
        if (near_kink(uv.x, width) || near_kink(uv.y, height)) continue;
        const TextureLookup lookup = LookUpTexture(texture, uv);
        ExpectConsistent(texture, lookup);
        const auto at = [&](double du, double dv) {
          return TextureValue(texture, {uv.x + du, uv.y + dv});
        };
        // Differences of a linear function err by rounding only: 1e-16 / 1e-5.
        ExpectNear((at(h, 0) - at(-h, 0)) / (2 * h), lookup.du, 1e-9);
        ExpectNear((at(0, h) - at(0, -h)) / (2 * h), lookup.dv, 1e-9);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 1500);
}

TEST(Texture, RepeatIsContinuousAndSmoothAcrossTheSeam) {
  const Texture texture = MakeTexture(4, 3, TextureWrap::kRepeat);
  for (const double v : {0.1, 0.5, 0.97}) {
    const TextureLookup left = LookUpTexture(texture, {1.0 - 1e-12, v});
    const TextureLookup right = LookUpTexture(texture, {1.0 + 1e-12, v});
    ExpectNear(left.value, right.value, 1e-10);
    ExpectNear(left.du, right.du, 1e-9);
    const TextureLookup below = LookUpTexture(texture, {v, -1e-12});
    const TextureLookup above = LookUpTexture(texture, {v, 1e-12});
    ExpectNear(below.value, above.value, 1e-10);
    ExpectNear(below.dv, above.dv, 1e-9);
  }
  // Half way between the last and the first column.
  const Vec2 seam = {0.0, 1.0 - 0.5 / 3.0};
  ExpectNear(
      TextureValue(texture, seam), (TexelAt(texture, 3, 0) + TexelAt(texture, 0, 0)) * 0.5, 1e-14);
  ExpectNear(LookUpTexture(texture, {-1e-20, 0.4}).value, TextureValue(texture, {0.0, 0.4}), 1e-14);
}

TEST(Texture, RepeatHasPeriodOneHoweverFarOut) {
  const Texture texture = MakeTexture(8, 5, TextureWrap::kRepeat);
  for (const double shift : {1.0, -3.0, 1024.0, -1048576.0}) {
    // Dyadic, so that the shifted coordinates are exact.
    const Vec2 uv = {0.3125, 0.71875};
    const TextureLookup here = LookUpTexture(texture, uv);
    const TextureLookup there = LookUpTexture(texture, {uv.x + shift, uv.y - shift});
    EXPECT_EQ(here.value, there.value);
    EXPECT_EQ(here.texel, there.texel);
    EXPECT_EQ(here.du, there.du);
    EXPECT_EQ(here.dv, there.dv);
  }
}

TEST(Texture, ClampHoldsTheBorderWithoutSlope) {
  const Texture texture = MakeTexture(4, 3, TextureWrap::kClamp);
  const TextureLookup corner = LookUpTexture(texture, {-0.5, 7.0});
  EXPECT_EQ(corner.value, TexelAt(texture, 0, 0));
  EXPECT_TRUE(IsBlack(corner.du) && IsBlack(corner.dv));
  EXPECT_EQ(TextureValue(texture, {9.0, -9.0}), TexelAt(texture, 3, 2));
  // Beyond the last centre in u only: v keeps its slope.
  const TextureLookup edge = LookUpTexture(texture, {0.05, 0.4});
  EXPECT_TRUE(IsBlack(edge.du));
  EXPECT_FALSE(IsBlack(edge.dv));
  // On the outermost centres: the slope towards larger coordinates.
  const TextureLookup first = LookUpTexture(texture, {0.125, 0.5});
  ExpectNear(first.du, (TexelAt(texture, 1, 1) - TexelAt(texture, 0, 1)) * 4.0, 1e-12);
  EXPECT_TRUE(IsBlack(LookUpTexture(texture, {0.875, 0.5}).du));
}

TEST(Texture, OneTexelIsConstant) {
  for (const TextureWrap wrap : kWraps) {
    Texture texture;
    texture.texels = {{0.2, 0.4, 0.8}};
    texture.wrap = wrap;
    for (const double t : {-3.7, 0.0, 0.5, 1.0, 12.25}) {
      const TextureLookup lookup = LookUpTexture(texture, {t, 0.3 - t});
      ExpectConsistent(texture, lookup);
      ExpectNear(lookup.value, {0.2, 0.4, 0.8}, 1e-15);
      EXPECT_TRUE(IsBlack(lookup.du) && IsBlack(lookup.dv));
    }
  }
}

TEST(Texture, SurvivesEveryNumber) {
  const double big = std::numeric_limits<double>::max();
  const double inf = std::numeric_limits<double>::infinity();
  const double tiny = std::numeric_limits<double>::denorm_min();
  for (const TextureWrap wrap : kWraps) {
    const Texture texture = MakeTexture(3, 4, wrap);
    for (const double u : {big, -big, inf, -inf, std::nan(""), tiny, -tiny, -1e-17, 1e15 + 0.5}) {
      ExpectConsistent(texture, LookUpTexture(texture, {u, 0.5}));
      ExpectConsistent(texture, LookUpTexture(texture, {0.5, u}));
      ExpectConsistent(texture, LookUpTexture(texture, {u, u}));
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::texture_test
