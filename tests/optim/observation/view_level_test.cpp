#include <gtest/gtest.h>

#include "optim/observation/observation.h"
#include "tests/optim/observation/observation_files.h"

namespace pathfit::optim::view_level_test {
namespace {

using renderer::Image;

/// 12x8 pixels, mask of the columns 4 to 9.
View MakeView() {
  View view;
  view.camera.width = 12;
  view.camera.height = 8;
  view.camera.fx = view.camera.fy = 10.0;
  view.camera.cx = 6.0;
  view.camera.cy = 4.0;
  view.photo = ConstantImage(12, 8, 3, 0.25F);
  Image mask = ConstantImage(12, 8, 1, 0.0F);
  for (int y = 0; y < 8; ++y) {
    for (int x = 4; x < 10; ++x) {
      mask.At(x, y, 0) = 1.0F;
    }
  }
  view.mask = mask;
  Image clipped = ConstantImage(12, 8, 1, 0.0F);
  clipped.At(0, 0, 0) = 1.0F;
  view.clipped = clipped;
  return view;
}

TEST(ViewLevelTest, AveragesEverythingToTheScale) {
  const ObservationSet set{
      .views = {}, .mask_meaning = MaskMeaning::kSilhouette, .mask_erode_px = 0, .assumptions = {}};
  const ViewLevel level = PackedLevel(MakeView(), set, 0.25).Unpack();
  EXPECT_EQ(level.photo.width, 3);
  EXPECT_EQ(level.photo.height, 2);
  EXPECT_EQ(level.camera.width, 3);
  EXPECT_EQ(level.camera.fx, 2.5);
  EXPECT_EQ(level.camera.cy, 1.0);
  EXPECT_NEAR(level.photo.At(1, 1, 2), 0.25F, 1e-6F);
  EXPECT_NEAR(level.mask.At(0, 0, 0), 0.0F, 1e-6F);
  EXPECT_NEAR(level.mask.At(1, 0, 0), 1.0F, 1e-6F);
  EXPECT_NEAR(level.mask.At(2, 0, 0), 0.5F, 1e-6F);
  EXPECT_NEAR(level.clipped.At(0, 0, 0), 1.0F / 16.0F, 1e-6F);
  EXPECT_EQ(level.color_weight.data, level.mask.data);
}

TEST(ViewLevelTest, SizesAreRoundedAndNeverZero) {
  const ObservationSet set;
  EXPECT_EQ(PackedLevel(MakeView(), set, 0.3).Unpack().photo.width, 4);
  EXPECT_EQ(PackedLevel(MakeView(), set, 0.3).Unpack().photo.height, 2);
  EXPECT_EQ(PackedLevel(MakeView(), set, 0.01).Unpack().photo.height, 1);
}

TEST(ViewLevelTest, ColoursCountInsideTheErodedMask) {
  ObservationSet set{
      .views = {}, .mask_meaning = MaskMeaning::kSilhouette, .mask_erode_px = 1, .assumptions = {}};
  const ViewLevel level = PackedLevel(MakeView(), set, 1.0).Unpack();
  EXPECT_EQ(level.color_weight.At(4, 4, 0), 0.0F);
  EXPECT_EQ(level.color_weight.At(5, 4, 0), 1.0F);
  EXPECT_EQ(level.color_weight.At(9, 4, 0), 0.0F);
  EXPECT_EQ(level.mask.At(4, 4, 0), 1.0F);
  EXPECT_NEAR(PackedLevel(MakeView(), set, 0.5).Unpack().color_weight.At(2, 2, 0), 0.5F, 1e-6F);
  set.mask_meaning = MaskMeaning::kIgnore;
  EXPECT_EQ(PackedLevel(MakeView(), set, 1.0).Unpack().color_weight.At(4, 4, 0), 0.0F);
}

TEST(ViewLevelTest, WhatIsBehindTheObjectIsNotAveragedIntoIt) {
  // The object is .25 before a white wall; its column 9 is half a pixel of it.
  View view = MakeView();
  Image photo = ConstantImage(12, 8, 3, 0.25F);
  Image mask = view.mask.Unpack();
  for (int y = 0; y < 8; ++y) {
    mask.At(9, y, 0) = 0.5F;
    for (int x = 0; x < 12; ++x) {
      const float share = mask.At(x, y, 0);
      for (int c = 0; c < 3; ++c) photo.At(x, y, c) = 0.25F * share + 0.9F * (1.0F - share);
    }
  }
  view.photo = photo;
  view.mask = mask;
  ObservationSet set{
      .views = {}, .mask_meaning = MaskMeaning::kSilhouette, .mask_erode_px = 0, .assumptions = {}};
  EXPECT_EQ(PackedLevel(view, set, 1.0).Unpack().photo.data, photo.data) << "may be rendered";
  set.black_background = true;
  for (const double scale : {1.0, 0.25}) {
    const ViewLevel level = PackedLevel(view, set, scale).Unpack();
    for (int x = 0; x < level.photo.width; ++x) {
      EXPECT_NEAR(level.photo.At(x, 1, 1), 0.25F * level.mask.At(x, 1, 0), 1e-6F) << x;
    }
  }
  // Colours beside an alpha channel: nothing is behind them.
  view.photo = ConstantImage(12, 8, 3, 0.25F);
  view.straight_alpha = true;
  EXPECT_NEAR(PackedLevel(view, set, 1.0).Unpack().photo.At(9, 1, 1), 0.125F, 1e-6F);
}

TEST(ViewLevelTest, WhatIsNoDataIsNotAveragedIntoData) {
  View view = MakeView();
  Image photo = ConstantImage(12, 8, 3, 0.25F);
  for (int y = 0; y < 8; ++y) {
    for (const int x : {0, 1, 2, 3, 10, 11}) photo.At(x, y, 0) = 0.9F;
  }
  view.photo = photo;
  ObservationSet set;
  set.mask_meaning = MaskMeaning::kIgnore;
  const ViewLevel level = PackedLevel(view, set, 0.25).Unpack();
  EXPECT_NEAR(level.photo.At(2, 1, 0), 0.25F, 1e-6F) << "half of it is data";
  EXPECT_NEAR(level.photo.At(0, 1, 0), 0.9F, 1e-6F) << "counts for nothing";
}

TEST(ViewLevelTest, WithoutMasksAllColoursCount) {
  ObservationSet set;
  EXPECT_EQ(PackedLevel(MakeView(), set, 0.5).Unpack().color_weight.At(0, 0, 0), 1.0F);
  set.mask_meaning = MaskMeaning::kIgnore;
  View view = MakeView();
  view.mask = Image();
  view.clipped = Image();
  const ViewLevel level = PackedLevel(view, set, 0.5).Unpack();
  EXPECT_EQ(level.color_weight.At(0, 0, 0), 1.0F);
  EXPECT_TRUE(level.mask.Empty());
  EXPECT_TRUE(level.clipped.Empty());
}

TEST(MaskIou, IsIntersectionOverUnion) {
  Image coverage = ConstantImage(4, 1, 1, 0.0F);
  Image mask = coverage;
  EXPECT_EQ(MaskIou(coverage, mask), 1.0);
  coverage.At(0, 0, 0) = coverage.At(1, 0, 0) = 0.6F;
  mask.At(1, 0, 0) = mask.At(2, 0, 0) = 1.0F;
  mask.At(3, 0, 0) = 0.5F;  // exactly half is not inside
  EXPECT_DOUBLE_EQ(MaskIou(coverage, mask), 1.0 / 3.0);
}

}  // namespace
}  // namespace pathfit::optim::view_level_test
