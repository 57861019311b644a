#include "renderer/image/color.h"

#include <gtest/gtest.h>

namespace pathfit::renderer::color_test {
namespace {

TEST(Color, SrgbRoundTripIsExactToRounding) {
  for (int code = 0; code <= 255; ++code) {
    const double encoded = code / 255.0;
    EXPECT_NEAR(SrgbFromLinear(LinearFromSrgb(encoded)), encoded, 1e-7) << code;
  }
}

TEST(Color, KnownValuesOfTheStandard) {
  EXPECT_EQ(LinearFromSrgb(0.0), 0.0);
  EXPECT_NEAR(LinearFromSrgb(1.0), 1.0, 1e-15);
  EXPECT_NEAR(LinearFromSrgb(0.5), 0.21404114048223255, 1e-12);
  EXPECT_NEAR(LinearFromSrgb(0.04045), 0.04045 / 12.92, 1e-15) << "the linear foot";
}

TEST(Color, BranchesMeetAndGrowBeyondOne) {
  EXPECT_NEAR(LinearFromSrgb(0.04045 + 1e-9), LinearFromSrgb(0.04045), 1e-7);
  EXPECT_NEAR(SrgbFromLinear(0.0031308 + 1e-9), SrgbFromLinear(0.0031308), 1e-7);
  EXPECT_GT(SrgbFromLinear(2.0), 1.0);
}

}  // namespace
}  // namespace pathfit::renderer::color_test
