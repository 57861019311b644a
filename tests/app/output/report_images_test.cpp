#include "app/output/report_images.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "renderer/image/color.h"

namespace pathfit::app::report_images_test {
namespace {

using renderer::Image;

Image Constant(int width, int height, int channels, float value) {
  Image image(width, height, channels);
  std::fill(image.data.begin(), image.data.end(), value);
  return image;
}

// Averages are sums of up to a few dozen floats.
constexpr float kRounding = 1e-5F;

TEST(ReducedImage, OnlyShrinks) {
  EXPECT_EQ(ReducedImage(Image(100, 50, 3), 512).width, 100);
  const Image reduced = ReducedImage(Constant(1024, 100, 3, 0.25F), 512);
  EXPECT_EQ(reduced.width, 512);
  EXPECT_EQ(reduced.height, 50);
  for (const float v : reduced.data) EXPECT_NEAR(v, 0.25F, kRounding);
  EXPECT_EQ(ReducedImage(Image(2000, 1, 1), 512).height, 1);
}

TEST(EncodedImage, ShowsWhatIsNotANumber) {
  Image image = Constant(2, 1, 3, 4.0F);
  image.At(1, 0, 2) = std::numeric_limits<float>::quiet_NaN();
  const Image encoded = EncodedImage(image);
  EXPECT_EQ(encoded.At(0, 0, 0), 1.0F);
  EXPECT_EQ(encoded.At(1, 0, 0), 1.0F);
  EXPECT_EQ(encoded.At(1, 0, 1), 0.0F);
}

TEST(DifferenceImage, IsWhiteForEqualBlueForDarkRedForBright) {
  const Image grey = Constant(1, 1, 3, 0.2F);
  const Image equal = DifferenceImage(grey, grey, {});
  EXPECT_EQ(equal.data, (std::vector<float>{1.0F, 1.0F, 1.0F}));
  const Image bright = DifferenceImage(Constant(1, 1, 3, 0.9F), grey, {});
  EXPECT_GT(bright.At(0, 0, 0), bright.At(0, 0, 2) + 0.5F);
  const Image dark = DifferenceImage(Constant(1, 1, 3, 0.0F), grey, {});
  EXPECT_GT(dark.At(0, 0, 2), dark.At(0, 0, 0) + 0.5F);
  // Half the scale is half way between white and the colour.
  const double encoded = renderer::SrgbFromLinear(0.2) + 0.5 * kDifferenceScale;
  const Image half = DifferenceImage(
      Constant(1, 1, 3, static_cast<float>(renderer::LinearFromSrgb(encoded))), grey, {});
  EXPECT_NEAR(half.At(0, 0, 1), 0.5F * (1.0F + bright.At(0, 0, 1)), 1e-4F);
  const Image masked = DifferenceImage(Constant(1, 1, 3, 0.9F), grey, Constant(1, 1, 1, 0.0F));
  EXPECT_EQ(masked.At(0, 0, 0), masked.At(0, 0, 2));
}

TEST(SilhouetteImage, TellsWhichSideSeesTheObject) {
  const Image one = Constant(1, 1, 1, 1.0F), none = Constant(1, 1, 1, 0.0F);
  const Image rendered = SilhouetteImage(one, none);
  EXPECT_GT(rendered.At(0, 0, 0), rendered.At(0, 0, 2) + 0.5F);
  const Image mask = SilhouetteImage(none, one);
  EXPECT_GT(mask.At(0, 0, 2), mask.At(0, 0, 0) + 0.5F);
  EXPECT_EQ(SilhouetteImage(none, none).At(0, 0, 1), 1.0F);
  const Image both = SilhouetteImage(one, one);
  EXPECT_EQ(both.At(0, 0, 0), both.At(0, 0, 2));
}

TEST(EnvironmentPicture, IsTwiceAsWideAsHighAndExposed) {
  renderer::EnvironmentEmitter environment;
  environment.intensity = {2.0, 2.0, 2.0};
  EXPECT_NEAR(EnvironmentExposure(environment), 0.4, 1e-12);
  const Image picture = EnvironmentPicture(environment, 0.4);
  EXPECT_EQ(picture.width, 256);
  EXPECT_EQ(picture.height, 128);
  EXPECT_NEAR(static_cast<double>(picture.At(5, 5, 0)), renderer::SrgbFromLinear(0.8), 1e-5);
  environment.intensity = {0.0, 0.0, 0.0};
  EXPECT_EQ(EnvironmentExposure(environment), 1.0);
  environment.width = 1024;
  environment.height = 512;
  environment.texels.assign(1024 * 512, {1.0, 1.0, 1.0});
  EXPECT_EQ(EnvironmentPicture(environment, 1.0).width, kThumbnailPx);
}

}  // namespace
}  // namespace pathfit::app::report_images_test
