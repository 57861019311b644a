#include "app/output/synthetic_photos.h"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include "renderer/io/exr_file.h"
#include "renderer/io/image_file.h"
#include "tests/support/test_scenes.h"

namespace pathfit::app::synthetic_photos_test {
namespace {

namespace fs = std::filesystem;
using renderer::Image;

struct Moments {
  double mean = 0.0, variance = 0.0;
};
Moments NoiseOf(const PhotoErrors& errors, float value) {
  Image image(300, 200, 3);
  for (float& v : image.data) v = value;
  AddNoise(errors, 4, image);
  Moments m;
  const auto count = static_cast<double>(image.data.size());
  for (const float v : image.data) m.mean += (static_cast<double>(v) - value) / count;
  for (const float v : image.data) {
    m.variance += std::pow(static_cast<double>(v) - value - m.mean, 2.0) / count;
  }
  return m;
}

// 180 000 numbers: a variance is known to 0.33 %, four of which are allowed.
TEST(SyntheticPhotos, NoiseHasTheVarianceThatWasAskedFor) {
  const PhotoErrors errors{.seed = 3, .noise = 0.02, .shot = 0.001};
  for (const float value : {0.0F, 0.5F, 2.0F}) {
    const Moments m = NoiseOf(errors, value);
    const double variance = 0.0004 + 0.001 * static_cast<double>(value);
    EXPECT_NEAR(m.variance / variance, 1.0, 0.014) << value;
    EXPECT_NEAR(m.mean, 0.0, 4.0 * std::sqrt(variance / 180000.0)) << value;
  }
  const Moments none = NoiseOf({.seed = 3}, 0.5F);
  EXPECT_EQ(none.variance, 0.0);
}

TEST(SyntheticPhotos, ErrorsFollowSeedAndPhoto) {
  const auto noisy = [](std::uint64_t seed, std::uint64_t photo) {
    Image image(8, 8, 3);
    AddNoise({.seed = seed, .noise = 0.1}, photo, image);
    return image.data;
  };
  EXPECT_EQ(noisy(1, 2), noisy(1, 2));
  EXPECT_NE(noisy(1, 2), noisy(1, 3));
  EXPECT_NE(noisy(1, 2), noisy(2, 2));
}

TEST(SyntheticPhotos, ExposuresAndCamerasAreOffByTheirSigmas) {
  constexpr int kPhotos = 4000;
  const PhotoErrors errors{.seed = 5, .exposure_sigma_ev = 0.3, .pose_sigma = 0.01};
  const renderer::Camera camera = tests::CameraAt({0, 0, 5}, {0, 0, 0}, 100.0, 64, 48);
  renderer::Box box;
  box.Include(renderer::Vec3{-1, -1, 0});
  box.Include(renderer::Vec3{1, 1, 2});  // its middle is 4 away
  double ev = 0.0, moved = 0.0, turned = 0.0;
  for (std::uint64_t i = 0; i < kPhotos; ++i) {
    ev += std::pow(ExposureErrorEv(errors, i), 2.0) / kPhotos;
    const renderer::Camera believed = BelievedCamera(errors, i, box, camera);
    moved += std::pow(Norm(believed.world_from_camera.translation - renderer::Vec3{0, 0, 5}), 2.0) /
             (3.0 * kPhotos);
    const renderer::Mat3& r = believed.world_from_camera.linear;
    turned += std::acos(std::min(1.0, 0.5 * (r.x.x + r.y.y + r.z.z - 1.0))) *
              std::acos(std::min(1.0, 0.5 * (r.x.x + r.y.y + r.z.z - 1.0))) / (3.0 * kPhotos);
    EXPECT_EQ(believed.fx, camera.fx);
  }
  EXPECT_NEAR(std::sqrt(ev), 0.3, 0.015);
  EXPECT_NEAR(std::sqrt(moved), 0.04, 0.002);
  EXPECT_NEAR(std::sqrt(turned), 0.01, 0.0005);
  const renderer::Camera same = BelievedCamera({.seed = 5}, 0, box, camera);
  EXPECT_EQ(same.world_from_camera, camera.world_from_camera);
}

TEST(SyntheticPhotos, FilesHoldWhatTheirFormatCan) {
  const fs::path folder =
      fs::temp_directory_path() / ("pathfit_photos_" + std::to_string(getpid()));
  fs::create_directories(folder);
  Image image(16, 16, 3);
  for (float& v : image.data) v = 0.25F;
  image.At(3, 4, 1) = 1.5F;
  for (const char* name : {"a.exr", "a.png", "a.jpg"}) WritePhoto(folder / name, image, 90);
  const Image exr = renderer::ReadExr(folder / "a.exr");
  EXPECT_EQ(exr.At(3, 4, 1), 1.5F);
  const renderer::DecodedImage png = renderer::ReadImageFile(folder / "a.png", false);
  EXPECT_EQ(png.bits, 8);
  EXPECT_EQ(png.image.At(3, 4, 1), 1.0F);
  EXPECT_NEAR(png.image.At(0, 0, 0), 0.537F, 0.003F);  // sRGB of 1/4
  const renderer::DecodedImage jpg = renderer::ReadImageFile(folder / "a.jpg", false);
  EXPECT_NEAR(jpg.image.At(15, 15, 0), 0.537F, 0.02F);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace pathfit::app::synthetic_photos_test
