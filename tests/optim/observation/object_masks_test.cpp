#include "optim/observation/object_masks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "renderer/core/parallel.h"
#include "tests/optim/observation/ball_views.h"

namespace pathfit::optim::object_masks_test {
namespace {

using renderer::Image;
using renderer::Rgb;
using renderer::Vec3;

const Vec3 kLookedAt = kCenter + Vec3{0.05, 0.02, -0.03};
constexpr double kFills = 0.75;  // radius of the ball that fills the pictures

/// Photos of a striped ball before a wall that darkens downwards, with noise, without masks.
ObservationSet PhotosOfBall(const Rgb& ball, const Rgb& wall) {
  ObservationSet set = BallFromAllSides();
  set.mask_meaning = MaskMeaning::kNone;
  std::uint64_t state = 1;
  const auto noise = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return 0.04 * (static_cast<double>(state >> 40U) / static_cast<double>(1U << 24U) - 0.5);
  };
  for (View& view : set.views) {
    const Image mask = view.mask.Unpack();
    Image photo(kSize, kSize, 3);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double share = static_cast<double>(mask.At(x, y, 0));
        const Rgb object = ball * (0.8 + 0.2 * std::sin(0.5 * x));
        const Rgb color = object * share + wall * ((1.0 - share) * (1.0 - 0.5 * y / kSize));
        for (int c = 0; c < 3; ++c) {
          const double value = (c == 0 ? color.r : c == 1 ? color.g : color.b) + noise();
          photo.At(x, y, c) = static_cast<float>(std::clamp(value, 0.0, 1.0));
        }
      }
    }
    view.photo = photo;
    view.mask = PackedImage();
  }
  return set;
}

ObservationSet OchreBeforeBlue() { return PhotosOfBall({0.6, 0.4, 0.15}, {0.1, 0.2, 0.5}); }

TEST(ObjectMasks, FindsABallByItsColour) {
  const ObservationSet photos = OchreBeforeBlue();
  const std::optional<ObjectMasks> found = MakeObjectMasks(photos, kLookedAt, kFills);
  ASSERT_TRUE(found);
  EXPECT_GT(found->agreement, 0.9);
  ASSERT_EQ(found->masks.size(), photos.views.size());
  for (std::size_t i = 0; i < photos.views.size(); ++i) {
    const Image truth = BallMask(photos.views[i].camera, kCenter, kRadius);
    EXPECT_GT(MaskIou(found->masks[i], truth), 0.97) << photos.views[i].name;
  }
}

TEST(ObjectMasks, WhatOnePhotoDoesNotShowTheOthersTell) {
  ObservationSet photos = OchreBeforeBlue();
  Image dark = photos.views[3].photo.Unpack();
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize / 2; ++x) {  // half of the ball looks like the wall
      for (int c = 0; c < 3; ++c) dark.At(x, y, c) = dark.At(2, y, c);
    }
  }
  photos.views[3].photo = dark;
  const std::optional<ObjectMasks> found = MakeObjectMasks(photos, kLookedAt, kFills);
  ASSERT_TRUE(found);
  const Image truth = BallMask(photos.views[3].camera, kCenter, kRadius);
  EXPECT_GT(MaskIou(found->masks[3], truth), 0.75);
}

TEST(ObjectMasks, ThereAreNoneWhereColoursDoNotTell) {
  const ObservationSet grey = PhotosOfBall({0.3, 0.3, 0.3}, {0.3, 0.3, 0.3});
  EXPECT_FALSE(MakeObjectMasks(grey, kLookedAt, kFills));
  ObservationSet flat = OchreBeforeBlue();
  for (View& view : flat.views) view.photo = ConstantImage(kSize, kSize, 3, 0.5F);
  EXPECT_FALSE(MakeObjectMasks(flat, kLookedAt, kFills));
}

TEST(ObjectMasks, ThereAreNoneWhereNothingIsLookedAt) {
  EXPECT_FALSE(MakeObjectMasks({}, kLookedAt, kFills));
  EXPECT_FALSE(MakeObjectMasks(OchreBeforeBlue(), kLookedAt, 0.0));
  EXPECT_FALSE(MakeObjectMasks(OchreBeforeBlue(), kLookedAt + Vec3{0.0, 50.0, 0.0}, kFills));
}

TEST(ObjectMasks, SameBitsForAnyNumberOfThreads) {
  const ObservationSet photos = OchreBeforeBlue();
  const auto with = [&](int num_threads) {
    const renderer::ThreadLimit limit(num_threads);
    return MakeObjectMasks(photos, kLookedAt, kFills);
  };
  const auto one = with(1), four = with(4);
  ASSERT_TRUE(one && four);
  for (std::size_t i = 0; i < one->masks.size(); ++i) {
    EXPECT_EQ(one->masks[i].data, four->masks[i].data);
  }
}

}  // namespace
}  // namespace pathfit::optim::object_masks_test
