#include "renderer/image/similarity.h"

#include <cmath>

#include <gtest/gtest.h>

namespace pathfit::renderer::similarity_test {
namespace {

Image Constant(float value) {
  Image image(24, 20, 3);
  for (float& v : image.data) v = value;
  return image;
}

Image Pattern(double phase) {
  Image image(24, 20, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<float>(0.5 + 0.4 * std::sin(0.7 * static_cast<double>(i) + phase));
  }
  return image;
}

TEST(StructuralSimilarity, OfEqualPicturesIsOne) {
  EXPECT_NEAR(StructuralSimilarity(Pattern(0.0), Pattern(0.0), {}), 1.0, 1e-12);
  EXPECT_LT(StructuralSimilarity(Pattern(0.0), Pattern(1.5), {}), 0.5);
}

/// Without structure only the means differ: (2 a b + C1) / (a^2 + b^2 + C1).
TEST(StructuralSimilarity, OfConstantPicturesComparesTheirMeans) {
  const double a = 0.25, b = 0.75, c1 = 1e-4;
  EXPECT_NEAR(StructuralSimilarity(Constant(0.25F), Constant(0.75F), {}),
              (2.0 * a * b + c1) / (a * a + b * b + c1),
              1e-6);
}

TEST(StructuralSimilarity, WhatHasNoWeightIsInNoWindow) {
  Image left(24, 20, 1);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 12; ++x) left.At(x, y, 0) = 1.0F;
  }
  Image spoiled = Pattern(0.0);
  for (int y = 0; y < 20; ++y) {
    for (int x = 12; x < 24; ++x) spoiled.At(x, y, 1) = 1.0F - spoiled.At(x, y, 1);
  }
  EXPECT_NEAR(StructuralSimilarity(Pattern(0.0), spoiled, left), 1.0, 1e-12);
  EXPECT_LT(StructuralSimilarity(Pattern(0.0), spoiled, {}), 0.99);
  EXPECT_TRUE(std::isnan(StructuralSimilarity(Pattern(0.0), spoiled, Image(24, 20, 1))));
}

}  // namespace
}  // namespace pathfit::renderer::similarity_test
