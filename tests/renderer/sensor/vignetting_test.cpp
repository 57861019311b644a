#include "renderer/sensor/vignetting.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/renderer/sensor/test_cameras.h"

namespace pathfit::renderer::vignetting_test {
namespace {

Camera Darkening() {
  Camera camera = tests::PinholeCamera();
  camera.gain = 2.0;
  camera.red = 1.5;
  camera.vignetting = {-0.3, -0.1, 0.05};
  return camera;
}

TEST(Vignetting, SlopeIsTheDerivative) {
  const Vignetting v{-0.3, 0.2, -0.15};
  for (const double r2 : {0.0, 0.3, 1.0, 1.4}) {
    constexpr double kStep = 1e-6;
    EXPECT_NEAR(v.LogSlope(r2), (v.LogAt(r2 + kStep) - v.LogAt(r2 - kStep)) / (2.0 * kStep), 1e-9);
    EXPECT_EQ(v.At(r2), std::exp(v.LogAt(r2)));
  }
}

TEST(Vignetting, IsOneInTheMiddleAndOfTheSumInTheCorners) {
  Camera camera = Darkening();
  camera.width = 1001;
  camera.height = 601;
  camera.fx = 900.0;
  camera.fy = 800.0;
  camera.cx = 500.5;
  camera.cy = 300.5;
  EXPECT_EQ(camera.PixelGains(500, 300), (Rgb{3.0, 2.0, 2.0}));
  // A pixel's centre lies half a pixel inside the corner.
  for (const int x : {0, 1000}) {
    for (const int y : {0, 600}) {
      EXPECT_NEAR(camera.PixelGains(x, y).g, 2.0 * std::exp(-0.3 - 0.1 + 0.05), 2e-3);
      EXPECT_NEAR(camera.PixelGains(x, y).r, 3.0 * std::exp(-0.3 - 0.1 + 0.05), 3e-3);
    }
  }
  EXPECT_LT(camera.PixelGains(1000, 600).g, camera.PixelGains(900, 600).g);
}

TEST(Vignetting, StaysWithThePictureWhereItIsScaledOrCropped) {
  const Camera camera = Darkening();
  const Camera crop = CroppedCamera(camera, 30, 20, 90, 70);
  const Camera large = ScaledCamera(camera, 5 * camera.width, 3 * camera.height);
  for (const int x : {30, 77, 119}) {
    for (const int y : {20, 50, 89}) {
      const double gain = camera.PixelGains(x, y).g;
      EXPECT_NEAR(crop.PixelGains(x - 30, y - 20).g, gain, 1e-14);
      EXPECT_NEAR(large.PixelGains(5 * x + 2, 3 * y + 1).g, gain, 1e-14);
    }
  }
}

TEST(Vignetting, IsAFactorThatNumbersHold) {
  Camera camera = Darkening();
  EXPECT_NO_THROW(CameraModel{camera});
  camera.vignetting = {-12.0, 0.0, 0.0};
  EXPECT_NO_THROW(CameraModel{camera});
  for (const double v1 : {-30.0, 30.0}) {
    camera.vignetting = {v1, 0.0, 0.0};
    EXPECT_THROW(CameraModel{camera}, SceneError);
  }
  camera.vignetting = {-200.0, 200.0, 0.0};
  EXPECT_THROW(CameraModel{camera}, SceneError) << "a dark ring before the corners";
  camera.vignetting = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  EXPECT_THROW(CameraModel{camera}, SceneError);
}

TEST(Vignetting, IsForgottenWithTheOtherResponses) {
  Camera camera = Darkening();
  camera.ForgetResponse();
  EXPECT_EQ(camera.PixelGains(0, 0), (Rgb{1.0, 1.0, 1.0}));
}

TEST(Vignetting, BelongsToTheLens) {
  const Camera camera = Darkening();
  Camera other = camera;
  other.gain = 1.0;
  other.rotation = {0.1, 0.2, 0.3};
  EXPECT_TRUE(HaveSameLens(camera, other));
  other.vignetting.v2 = 0.0;
  EXPECT_FALSE(HaveSameLens(camera, other));
  other = camera;
  other.fx += 1e-9;
  EXPECT_FALSE(HaveSameLens(camera, other));
}

}  // namespace
}  // namespace pathfit::renderer::vignetting_test
