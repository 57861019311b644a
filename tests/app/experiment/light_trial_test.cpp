#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "app/experiment/light_choice.h"
#include "renderer/io/ply_file.h"
#include "tests/optim/observation/observation_files.h"
#include "tests/optim/round/synthetic_fit.h"

namespace pathfit::app::light_trial_test {
namespace {

const std::filesystem::path kConfig = "/set/draft.yaml";  // is not written

/// Photos of a patterned ball by its own cameras, under some light.
FoundInput PhotosUnder(const std::vector<renderer::Emitter>& lights) {
  renderer::Scene scene = tests::BallScene(3, 8, 28);
  for (std::size_t i = 0; i < scene.meshes[0].mesh.colors.size(); ++i) {
    const renderer::Vec3& p = scene.meshes[0].mesh.positions[i];
    scene.meshes[0].mesh.colors[i] =
        renderer::Rgb{0.5, 0.4, 0.3} * (1.0 + 0.4 * std::sin(5.0 * p.x));
  }
  scene.emitters = lights;
  FoundInput input;
  input.observations = tests::Photograph(scene, 8);
  input.options.images_dir = "/set/images";
  input.options.cameras = "/set/transforms.json";
  input.options.masks.meaning = optim::MaskMeaning::kSilhouette;
  input.num_masks = scene.sensors.size();
  input.layout = FindCameraLayout(scene.sensors);
  input.background = Background{.change = 0.5, .structure = 0.3};
  return input;
}

/// Bright at one side.
renderer::Emitter Surroundings(renderer::LightFrame frame) {
  renderer::Emitter light = tests::GradientEnvironment(8, 4);
  light.frame = frame;
  return light;
}

renderer::Emitter Flash() {
  renderer::Emitter light;
  light.name = "flash";
  light.light =
      renderer::PointEmitter{.position = {0.0, 0.16, 0.0}, .intensity = {25.0, 25.0, 25.0}};
  light.frame = renderer::LightFrame::kCamera;
  return light;
}

void ExpectTrial(const FoundInput& input,
                 DraftLight light,
                 const std::filesystem::path& mesh = {}) {
  std::string problem;
  const auto choice = LightByTrial(input, mesh, kConfig, problem);
  ASSERT_TRUE(choice);
  EXPECT_STREQ(WordOf(choice->light), WordOf(light)) << choice->reason;
}

TEST(LightTrial, LightThatStandsStillIsFoundByTrial) {
  ExpectTrial(PhotosUnder({Surroundings(renderer::LightFrame::kWorld)}), DraftLight::kWorld);
}

TEST(LightTrial, LightThatGoesWithTheCameraIsFoundByTrial) {
  FoundInput input = PhotosUnder({Surroundings(renderer::LightFrame::kCamera)});
  input.background = Background{.change = 0.01, .structure = 0.0};
  ExpectTrial(input, DraftLight::kCamera);  // nothing else moved
}

TEST(LightTrial, AFlashIsFoundByTrialWhereTheBackgroundChanges) {
  ExpectTrial(PhotosUnder({Flash()}), DraftLight::kFlash);
}

TEST(LightTrial, WhereTheBackgroundChangesNothingButAFlashGoesWithTheCamera) {
  std::string problem;
  const auto choice = LightByTrial(
      PhotosUnder({Surroundings(renderer::LightFrame::kCamera)}), {}, kConfig, problem);
  ASSERT_TRUE(choice);
  EXPECT_STRNE(WordOf(choice->light), WordOf(DraftLight::kCamera)) << choice->reason;
}

TEST(LightTrial, AMeshThatIsGivenIsTheStart) {
  const optim::TempFolder folder;
  renderer::WritePly(folder.path() / "ball.ply", renderer::MakeIcosphere(6, 1.0));
  FoundInput input = PhotosUnder({Flash()});
  // Photos without masks are left out, and say nothing alone.
  for (std::size_t i = 0; i < 3; ++i) input.observations.views[i].mask = {};
  FoundInput bare = input;
  for (optim::View& view : bare.observations.views) view.mask = {};
  std::string problem;
  EXPECT_FALSE(LightByTrial(bare, folder.path() / "ball.ply", kConfig, problem));
  ExpectTrial(input, DraftLight::kFlash, folder.path() / "ball.ply");
}

TEST(LightTrial, WhatBoundsNoBodyTellsNothing) {
  FoundInput input = PhotosUnder({Flash()});
  input.observations.views.resize(1);
  std::string problem;
  EXPECT_FALSE(LightByTrial(input, {}, kConfig, problem));
  EXPECT_FALSE(problem.empty());
}

TEST(LightTrial, BlackPhotosTellNothing) {
  FoundInput input = PhotosUnder({Flash()});
  for (optim::View& view : input.observations.views) {
    renderer::Image black = view.photo.Unpack();
    std::ranges::fill(black.data, 0.0F);
    view.photo = black;
  }
  std::string problem;
  EXPECT_FALSE(LightByTrial(input, {}, kConfig, problem));
  EXPECT_NE(problem.find("there is nothing to fit to"), std::string::npos) << problem;
}

TEST(LightTrial, OverexposedPhotosTellNothing) {
  FoundInput input = PhotosUnder({Flash()});
  for (optim::View& view : input.observations.views) {
    renderer::Image clipped(view.photo.width(), view.photo.height(), 1);
    std::ranges::fill(clipped.data, 1.0F);
    view.clipped = clipped;
  }
  std::string problem;
  EXPECT_FALSE(LightByTrial(input, {}, kConfig, problem));
  EXPECT_NE(problem.find("the object is clipped in the photos"), std::string::npos) << problem;
  // The others are enough.
  for (std::size_t i = 1; i < input.observations.views.size(); ++i) {
    input.observations.views[i].clipped = {};
  }
  ExpectTrial(input, DraftLight::kFlash);
}

}  // namespace
}  // namespace pathfit::app::light_trial_test
