#include "app/experiment/start_check.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "app/experiment/camera_layout.h"
#include "renderer/core/error.h"
#include "tests/app/experiment/ball_start.h"

namespace pathfit::app::start_check_test {
namespace {

bool Says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class StartCheckTest : public BallStart {
 protected:
  [[nodiscard]] StartCheck Check() const { return CheckStart(config_, experiment_); }
  /// what() of the exception of this type, empty if there is none.
  template <class Error>
  [[nodiscard]] std::string Refusal() const {
    try {
      static_cast<void>(Check());
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  void ExpectOneWarning(const std::string& part) const {
    const StartCheck check = Check();
    ASSERT_EQ(check.warnings.size(), 1U);
    EXPECT_TRUE(Says(check.warnings[0], part)) << check.warnings[0];
  }
  void SetMasks(float (*value)(float)) {
    for (optim::View& view : experiment_.observations.views) {
      renderer::Image mask = view.mask.Unpack();
      for (float& v : mask.data) v = value(v);
      view.mask = mask;
    }
  }
  void MoveBall(const renderer::Vec3& by) {
    for (renderer::Vec3& p : experiment_.scene.meshes[0].mesh.positions) p += by;
  }
};

TEST_F(StartCheckTest, HasNothingAgainstAGoodStart) {
  const StartCheck check = Check();
  EXPECT_TRUE(check.warnings.empty()) << check.warnings.front();
  ASSERT_EQ(check.views.size(), 5U);
  for (const ViewStart& view : check.views) {
    EXPECT_GT(view.iou, 0.95);
    EXPECT_NEAR(view.covered, view.masked, 0.03);
  }
  EXPECT_TRUE(check.views.back().validation);
}

TEST_F(StartCheckTest, RefusesMasksThatAreBlackEverywhere) {
  SetMasks([](float) { return 0.0F; });
  const std::string text = Refusal<optim::ObservationError>();
  EXPECT_TRUE(Says(text, "all 4 fitted photos are black")) << text;
  config_.input->photos.masks.invert = true;
  EXPECT_TRUE(Says(Refusal<optim::ObservationError>(), "is invert meant?"));
}

TEST_F(StartCheckTest, NamesPhotosWhoseMaskIsBlack) {
  optim::View& view = experiment_.observations.views[1];
  view.mask = renderer::Image(view.mask.width(), view.mask.height(), 1);
  ExpectOneWarning("black in 1 of 4 fitted photos (view1)");
}

TEST_F(StartCheckTest, WhiteMasksAreNotTakenForInvertedOnes) {
  SetMasks([](float) { return 1.0F; });
  const StartCheck check = Check();
  ASSERT_FALSE(check.warnings.empty());
  EXPECT_TRUE(Says(check.warnings[0], "white throughout")) << check.warnings[0];
  for (const std::string& text : check.warnings) EXPECT_FALSE(Says(text, "inverted")) << text;
}

TEST_F(StartCheckTest, NamesThePhotoThatIsUnlikeTheOthers) {
  optim::View& view = experiment_.observations.views[2];
  renderer::Image mask = view.mask.Unpack();
  for (int y = 0; y < mask.height; ++y) {
    for (int x = mask.width / 2; x < mask.width; ++x) mask.At(x, y, 0) = 0.0F;
  }
  view.mask = mask;
  ExpectOneWarning("hardly in 1 of 4 fitted photos (view2)");
}

TEST_F(StartCheckTest, NamesUnknownsThatStartOutsideTheirBounds) {
  optim::UnknownSpec& colors = experiment_.fit.unknowns.emplace_back();
  colors.name = "ball.colors";
  colors.kind = renderer::ParameterKind::kVertexColors;
  colors.lower = 0.01;
  colors.upper = 0.595;  // by less than can matter
  EXPECT_TRUE(Check().warnings.empty());
  colors.upper = 0.5;
  ExpectOneWarning("unknowns.ball.colors: 486 of 486 numbers start outside");
}

TEST_F(StartCheckTest, WarnsOfTexturesThatAreFinerThanThePhotos) {
  renderer::Texture& texture = experiment_.scene.textures.emplace_back();
  texture.name = "paint";
  optim::UnknownSpec& texels = experiment_.fit.unknowns.emplace_back();
  texels.name = "paint.texels";
  texels.kind = renderer::ParameterKind::kTextureTexels;
  const auto resize = [&](int side) {
    texture.width = texture.height = side;
    texture.texels = std::vector<renderer::Rgb>(static_cast<std::size_t>(side * side));
  };
  resize(512);
  ExpectOneWarning("unknowns.paint.texels: 262144 texels, but objects fill ");
  texels.total_variation_weight = 1e-3;
  EXPECT_TRUE(Check().warnings.empty()) << "neighbours tell";
  texels.total_variation_weight = 0.0;
  resize(8);
  EXPECT_TRUE(Check().warnings.empty());
}

TEST_F(StartCheckTest, RefusesPhotosThatAreBlack) {
  std::vector<optim::View>& views = experiment_.observations.views;
  const renderer::Image black(views[0].photo.width(), views[0].photo.height(), 3);
  views[1].photo = black;
  ExpectOneWarning("1 of 4 fitted photos (view1) are black inside");
  for (optim::View& view : views) view.photo = black;
  EXPECT_TRUE(Says(Refusal<optim::ObservationError>(), "all 4 fitted photos are black"));
}

TEST_F(StartCheckTest, WarnsOfPhotosThatAreClippedThroughout) {
  optim::View& view = experiment_.observations.views[0];
  renderer::Image clipped(view.photo.width(), view.photo.height(), 1);
  for (float& v : clipped.data) v = 1.0F;
  view.clipped = clipped;
  ExpectOneWarning("is clipped in 1 of 4 fitted photos (view0)");
}

TEST_F(StartCheckTest, RefusesAnErosionThatLeavesNothing) {
  experiment_.observations.mask_erode_px = 30;
  const std::string text = Refusal<ConfigError>();
  EXPECT_TRUE(Says(text, "input.masks.erode_px: 30 pixels leave nothing")) << text;
  const std::size_t at = text.find("allows ");
  ASSERT_NE(at, std::string::npos);
  experiment_.observations.mask_erode_px = std::stoi(text.substr(at + 7));
  const StartCheck check = Check();
  ASSERT_EQ(check.warnings.size(), 1U) << "what the message allows does not leave nothing";
  EXPECT_TRUE(Says(check.warnings[0], "less than a tenth of the mask")) << check.warnings[0];
}

TEST_F(StartCheckTest, SeesInvertedMasks) {
  SetMasks([](float v) { return 1.0F - v; });
  StartCheck check = Check();
  ASSERT_EQ(check.warnings.size(), 1U);
  EXPECT_TRUE(Says(check.warnings[0], "look inverted")) << check.warnings[0];
  EXPECT_TRUE(Says(check.warnings[0], "input.masks.invert: true")) << check.warnings[0];
}

TEST_F(StartCheckTest, RefusesAnObjectBesideAllPictures) {
  MoveBall({0.0, 0.0, 40.0});
  EXPECT_TRUE(Says(Refusal<renderer::SceneError>(), "in no fitted photo; "));
  MoveBall({0.0, 100.0, -40.0});
  const std::string text = Refusal<renderer::SceneError>();
  EXPECT_TRUE(Says(text, "ball.yaml: the object is in no fitted photo")) << text;
}

TEST_F(StartCheckTest, KnowsCamerasThatLookAway) {
  for (std::size_t i = 0; i < experiment_.scene.sensors.size(); ++i) {
    renderer::Camera& camera = experiment_.observations.views[i].camera;
    renderer::Mat3& axes = camera.world_from_camera.linear;
    axes = {-axes.x, axes.y, -axes.z};
    experiment_.scene.sensors[i] = camera;
  }
  const std::string text = Refusal<renderer::SceneError>();
  EXPECT_TRUE(Says(text, "5 of 5 cameras look away")) << text;
}

TEST_F(StartCheckTest, KnowsAnotherUnit) {
  for (renderer::Vec3& p : experiment_.scene.meshes[0].mesh.positions) p *= 0.2;
  ExpectOneWarning("times the area of the masks");
  for (renderer::Vec3& p : experiment_.scene.meshes[0].mesh.positions) p *= 1e-4;
  EXPECT_TRUE(Says(Refusal<renderer::SceneError>(), "smaller than a pixel"));
}

TEST_F(StartCheckTest, NamesPhotosThatDoNotShowTheObject) {
  renderer::Camera& camera = experiment_.observations.views[0].camera;
  camera.cx += 500.0;
  experiment_.scene.sensors[0] = camera;
  ExpectOneWarning("not seen in 1 of 4 fitted photos (view0)");
}

TEST_F(StartCheckTest, IouIsUnknownWithoutMasks) {
  experiment_.observations.mask_meaning = optim::MaskMeaning::kNone;
  for (optim::View& view : experiment_.observations.views) view.mask = {};
  for (const ViewStart& view : Check().views) {
    EXPECT_TRUE(std::isnan(view.iou));
    EXPECT_TRUE(std::isnan(view.masked));
  }
}

TEST(CameraLayout, FindsWhatCamerasLookAt) {
  renderer::Scene scene = tests::BallScene(1, 12, 64);
  for (renderer::Camera& camera : scene.sensors) {
    camera.world_from_camera.translation += renderer::Vec3{5.0, -2.0, 1.0};
  }
  const std::optional<CameraLayout> layout = FindCameraLayout(scene.sensors);
  ASSERT_TRUE(layout);
  EXPECT_LT(Norm(layout->centre - renderer::Vec3{5.0, -2.0, 1.0}), 1e-9);
  EXPECT_NEAR(layout->distance, 4.0, 1e-9);
  EXPECT_NEAR(layout->radius, 4.0 * 32.0 / scene.sensors[0].fx, 1e-9);
  EXPECT_EQ(layout->num_behind, 0);
}

TEST(CameraLayout, IsUnknownOfParallelAxes) {
  std::vector<renderer::Camera> cameras(2, tests::BallScene(1, 1, 64).sensors[0]);
  cameras[1].world_from_camera.translation += renderer::Vec3{1.0, 0.0, 0.0};
  EXPECT_FALSE(FindCameraLayout(cameras));
  EXPECT_FALSE(FindCameraLayout({}));
}

TEST_F(StartCheckTest, AFloorThatFillsThePicturesIsNoInvertedMask) {
  SetMasks([](float) { return 1.0F; });
  renderer::Mesh& ball = experiment_.scene.meshes[0].mesh;
  for (renderer::Vec3& p : ball.positions) p = p * 1.7;
  StartCheck check = Check();
  ASSERT_GT(check.views[0].iou, 0.5);
  EXPECT_TRUE(check.warnings.empty()) << check.warnings.front();
  // What was carved from the masks agrees with them anyway.
  config_.geometry.emplace_back().geometry = VisualHullGeometry{};
  check = Check();
  ASSERT_EQ(check.warnings.size(), 1U);
  EXPECT_TRUE(Says(check.warnings[0], "inverted")) << check.warnings[0];
}

TEST_F(StartCheckTest, WhatIsCarvedFitsMasksThatFitTheCameras) {
  std::vector<renderer::Vec3> positions = experiment_.scene.meshes[0].mesh.positions;
  for (renderer::Vec3& p : positions) p = p * 0.9;  // a mask that misses something carves it away
  experiment_.scene.meshes[0].mesh.positions = positions;
  EXPECT_TRUE(Check().warnings.empty()) << "a mesh of one's own may differ so much";
  config_.geometry.emplace_back().geometry = VisualHullGeometry{};
  ExpectOneWarning("agrees with them to a median IoU of 0.79 only");
  ExpectOneWarning("misses a part of the object");
  optim::View& view = experiment_.observations.views[1];
  renderer::Image mask = view.mask.Unpack();
  for (float& v : mask.data) v = 1.0F - v;
  view.mask = mask;
  StartCheck check = Check();
  ASSERT_FALSE(check.warnings.empty());
  EXPECT_TRUE(Says(check.warnings[0], "inverted")) << check.warnings[0];
  EXPECT_TRUE(Says(check.warnings[0], "1 of 4 fitted photos (view1)")) << check.warnings[0];
}

TEST_F(StartCheckTest, HeldOutMasksShowSidesThatNothingBounds) {
  optim::View& view = experiment_.observations.views.back();
  renderer::Image mask = view.mask.Unpack();
  for (int y = 0; y < mask.height; ++y) {
    for (int x = mask.width / 2; x < mask.width; ++x) mask.At(x, y, 0) = 0.0F;
  }
  view.mask = mask;
  EXPECT_TRUE(Check().warnings.empty());
  config_.geometry.emplace_back().geometry = VisualHullGeometry{};
  ExpectOneWarning("held-out photos to a median IoU of 0.49 only");
}

TEST_F(StartCheckTest, OutlinesLieBetweenTheInsideAndTheOutside) {
  renderer::Image image(4, 3, 1);
  image.At(1, 1, 0) = 1.0F;
  double length = 0.0;
  for (const auto& [from, to] : Outline(image)) {
    for (const renderer::Vec2& p : {from, to}) {
      // A diamond about the centre of the pixel.
      EXPECT_NEAR(std::abs(p.x - 1.5) + std::abs(p.y - 1.5), 0.5, 1e-12);
    }
    length += std::hypot(to.x - from.x, to.y - from.y);
  }
  EXPECT_NEAR(length, 4.0 * std::sqrt(0.5), 1e-12);
  for (float& v : image.data) v = 1.0F;
  length = 0.0;
  for (const auto& [from, to] : Outline(image)) length += std::hypot(to.x - from.x, to.y - from.y);
  EXPECT_GT(length, 10.0);  // closed along the border
  EXPECT_TRUE(Outline(renderer::Image(4, 3, 1)).empty());
}

TEST_F(StartCheckTest, OutlinesTheStartAndTheMask) {
  const StartCheck check = Check();
  EXPECT_GT(check.box.HalfDiagonal(), 0.0);
  for (const ViewStart& view : check.views) {
    ASSERT_FALSE(view.outline.empty());
    ASSERT_FALSE(view.mask_outline.empty());
    double x = 0.0, mask_x = 0.0;
    for (const OutlinePiece& piece : view.outline) x += piece.from.x;
    for (const OutlinePiece& piece : view.mask_outline) mask_x += piece.from.x;
    x /= static_cast<double>(view.outline.size());
    mask_x /= static_cast<double>(view.mask_outline.size());
    EXPECT_NEAR(x, mask_x, 0.05 * view.width);
  }
}

}  // namespace
}  // namespace pathfit::app::start_check_test
