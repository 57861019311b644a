#include <cmath>

#include <gtest/gtest.h>

#include "optim/round/fit.h"
#include "renderer/geometry/mesh_primitives.h"
#include "tests/optim/round/free_fit.h"
#include "tests/optim/round/synthetic_fit.h"

// Where things are, found again from other starts: objects, cameras and lights, by shading,
// silhouettes and shadows. The tolerances are two to three times what was measured, and several
// times below the error of the start.
namespace pathfit::fit_places_test {
namespace {

using optim::FitResult;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using renderer::Vec3;

constexpr int kSize = 48;

class FitPlacesTest : public tests::FreeFit {
 protected:
  Scene Fit(const Scene& start, const Scene& truth, int num_rounds) {
    optim::StageSpec stage = Stage(num_rounds, spp_, 8 * spp_);
    stage.samples.sppe = sppe_;
    spec_.stages = CoarseAndFine(stage);
    spec_.seed = 3;
    result_ = optim::RunFit(start, tests::Photograph(truth, 256), spec_, observer_, {});
    return result_.scene;
  }

  int spp_ = 8;
  double sppe_ = 4.0;
  tests::RecordingObserver observer_;
  FitResult result_;
};

// A slab with coloured corners over a floor that is bright in one corner, under two lamps.
// Whether the floor's own edges are seen decides which numbers of a camera look alike.
Scene SlabScene(int num_views, double floor_size = 2.0) {
  Scene scene;
  renderer::Mesh slab = renderer::MakeCube();
  for (Vec3& p : slab.positions) {
    slab.colors.push_back({0.5 + 0.4 * p.x, 0.5 + 0.3 * p.y, 0.5 + 0.4 * p.z * p.x});
    p = {0.6 * p.x, 0.4 * p.y, 0.25 * p.z};
  }
  slab.color_triangles = slab.triangles;
  renderer::Mesh floor = renderer::MakeRectangle();
  for (Vec3& p : floor.positions) {
    floor.colors.push_back(p.x > 0 && p.y > 0 ? Rgb{0.8, 0.7, 0.2} : Rgb{0.3, 0.3, 0.3});
    p = {floor_size * p.x, floor_size * p.y, -0.5};
  }
  floor.color_triangles = floor.triangles;
  scene.meshes = {{"slab", slab, 0}, {"floor", floor, 0}};
  scene.materials = {{"paint", renderer::LambertBsdf{}, {0.5, 0.5, 0.5}, true}};
  const auto lamp = [](const char* name, const Vec3& position, const Rgb& intensity) {
    return renderer::Emitter{
        name, renderer::LightFrame::kWorld, {}, renderer::PointEmitter{position, intensity}};
  };
  scene.emitters = {lamp("warm", {1.5, -2.0, 3.0}, {25, 20, 15}),
                    lamp("cold", {-2.5, 1.0, 2.0}, {8, 10, 14})};
  for (int i = 0; i < num_views; ++i) {
    const double angle = 2.2 * i + 0.4;
    const Vec3 origin{1.5 * std::sin(angle), 1.5 * std::cos(angle), 1.3 + 0.2 * (i % 2)};
    scene.sensors.push_back(tests::CameraAt(origin, {0, 0, -0.2}, 0.75 * kSize, kSize, kSize));
    scene.sensors.back().name = "view" + std::to_string(i);
  }
  return scene;
}

// A floor seen from above, under one lamp, with a square that throws a hard shadow on it. The
// square is above the cameras, which see its shadow only.
Scene ShadowScene(int num_views) {
  Scene scene;
  renderer::Mesh square = renderer::MakeRectangle();
  renderer::ApplyTransform({{{0.25, 0, 0}, {0, 0.3, 0}, {0, 0, 1}}, {0.3, -0.2, 2.0}}, square);
  renderer::Mesh floor = renderer::MakeRectangle();
  renderer::ApplyTransform({{{3, 0, 0}, {0, 3, 0}, {0, 0, 1}}, {}}, floor);
  scene.meshes = {{"square", square, 0}, {"floor", floor, 0}};
  scene.materials = {{"grey", renderer::LambertBsdf{}, {0.6, 0.6, 0.6}}};
  scene.emitters = {{"lamp",
                     renderer::LightFrame::kWorld,
                     {},
                     renderer::PointEmitter{{0.6, -0.4, 4.0}, {16, 16, 16}}}};
  for (int i = 0; i < num_views; ++i) {
    const Vec3 origin{0.4 * i - 0.4, -0.9, 1.5};
    scene.sensors.push_back(tests::CameraAt(origin, {0, 0, 0}, 0.9 * kSize, kSize, kSize));
    scene.sensors.back().name = "view" + std::to_string(i);
  }
  return scene;
}

TEST_F(FitPlacesTest, ObjectPoseFromThreeViews) {
  const Scene truth = SlabScene(4);  // the last is held out
  Scene start = truth;
  start.meshes[0].pose.translation = {0.12, -0.1, 0.08};
  start.meshes[0].pose.rotation = {0.1, -0.12, 0.15};
  Free(ParameterKind::kObjectTranslation, 0);
  Free(ParameterKind::kObjectRotation, 0);
  const Scene result = Fit(start, truth, 8);
  EXPECT_LT(Norm(result.meshes[0].pose.translation), 0.003) << "of 0.18; a pixel is 0.06";
  EXPECT_LT(Norm(result.meshes[0].pose.rotation), 0.006) << "of 0.22";
}

TEST_F(FitPlacesTest, PoseOfOneCamera) {
  const Scene truth = SlabScene(3);
  Scene start = truth;
  start.sensors[1].world_from_camera.translation += Vec3{0.1, -0.08, 0.06};
  start.sensors[1].rotation = {0.03, -0.02, 0.04};
  Free(ParameterKind::kCameraPosition, 1).gaussian = optim::GaussianPriorSpec{{}, 0.1};
  Free(ParameterKind::kCameraRotation, 1).gaussian = optim::GaussianPriorSpec{{}, 0.05};
  spp_ = 8;
  sppe_ = 32.0;
  const Scene result = Fit(start, truth, 8);
  const renderer::Camera& found = result.sensors[1];
  const renderer::Camera& right = truth.sensors[1];
  EXPECT_LT(Norm(found.world_from_camera.translation - right.world_from_camera.translation), 0.04)
      << "of 0.14";
  EXPECT_LT(Norm(found.rotation), 0.01) << "of 0.054";
  EXPECT_EQ(result.sensors[0].world_from_camera, truth.sensors[0].world_from_camera);
}

// Held-out photos tell of the scene, not of where their cameras were thought to be.
TEST_F(FitPlacesTest, HeldOutCamerasFollowTheirOwnPhotos) {
  const Scene truth = SlabScene(4);  // the last is held out
  Scene start = truth;
  for (std::size_t i : {1, 3}) {
    start.sensors[i].world_from_camera.translation += Vec3{0.05, -0.04, 0.03};
    start.sensors[i].rotation = {0.02, -0.01, 0.02};
  }
  Free(ParameterKind::kCameraPosition, -1).gaussian = optim::GaussianPriorSpec{{}, 0.1};
  Free(ParameterKind::kCameraRotation, -1).gaussian = optim::GaussianPriorSpec{{}, 0.05};
  sppe_ = 32.0;
  const Scene result = Fit(start, truth, 8);
  const Vec3 off = result.sensors[3].world_from_camera.translation -
                   truth.sensors[3].world_from_camera.translation;
  EXPECT_LT(Norm(off), 0.03) << "of 0.07";
  EXPECT_LT(Norm(result.sensors[3].rotation), 0.01) << "of 0.03";
  const auto& stages = observer_.stages;
  EXPECT_GT(stages.back().psnr_linear_val, stages.front().psnr_linear_val + 3.0);
  EXPECT_GT(stages.back().psnr_linear_val, stages.back().psnr_linear_fit - 3.0);
}

// Not together with the position: a step back looks much like a zoom, which takes many rounds.
TEST_F(FitPlacesTest, FocalLengthOfACameraThatTurned) {
  const Scene truth = SlabScene(3, 0.9);
  Scene start = truth;
  renderer::Camera& camera = start.sensors[1];
  camera.rotation = {0.03, -0.02, 0.04};
  camera.fx *= 1.04;
  camera.fy *= 1.04;
  Free(ParameterKind::kCameraRotation, 1).gaussian = optim::GaussianPriorSpec{{}, 0.05};
  Free(ParameterKind::kFocal, 1).gaussian = optim::GaussianPriorSpec{{}, 0.05 * camera.fx};
  spp_ = 8;
  sppe_ = 32.0;
  const Scene result = Fit(start, truth, 8);
  const renderer::Camera& found = result.sensors[1];
  EXPECT_LT(Norm(found.rotation), 0.006) << "of 0.054";
  EXPECT_NEAR(found.fx / truth.sensors[1].fx, 1.0, 0.002) << "1.04";
  EXPECT_NEAR(found.fy / truth.sensors[1].fy, 1.0, 0.002) << "1.04";
}

TEST_F(FitPlacesTest, CamerasAndObjectTogetherStayWhereTheyBegan) {
  const Scene truth = SlabScene(4);
  Scene start = truth;
  start.meshes.pop_back();  // the slab alone: everything may turn together
  Scene photographed = start;
  start.meshes[0].pose.translation = {0.06, -0.05, 0.04};
  for (std::size_t i = 0; i < 3; ++i) {
    start.sensors[i].rotation = {0.01 * static_cast<double>(i), -0.01, 0.0};
  }
  Free(ParameterKind::kObjectTranslation, 0);
  Free(ParameterKind::kObjectRotation, 0);
  Free(ParameterKind::kCameraPosition, -1).gaussian = optim::GaussianPriorSpec{{}, 0.07};
  Free(ParameterKind::kCameraRotation, -1).gaussian = optim::GaussianPriorSpec{{}, 0.02};
  const Scene result = Fit(start, photographed, 6);
  EXPECT_GT(observer_.stages.back().psnr_linear_fit, 30.0);
  Vec3 drift;
  for (std::size_t i = 0; i < 3; ++i) {
    drift += result.sensors[i].world_from_camera.translation -
             start.sensors[i].world_from_camera.translation;
  }
  EXPECT_LT(Norm(drift) / 3.0, 0.1) << "of all cameras together";
  EXPECT_LT(Norm(result.sensors[3].world_from_camera.translation -
                 start.sensors[3].world_from_camera.translation),
            0.1)
      << "held out: where the others go";
  EXPECT_GT(observer_.stages.back().psnr_linear_val, 24.0);
}

TEST_F(FitPlacesTest, LightPositionFromAHardShadow) {
  const Scene truth = ShadowScene(3);
  Scene start = truth;
  std::get<renderer::PointEmitter>(start.emitters[0].light).position += Vec3{0.25, 0.2, 0.0};
  Free(ParameterKind::kLightPosition, 0);
  const Scene result = Fit(start, truth, 8);
  const Vec3 error = std::get<renderer::PointEmitter>(result.emitters[0].light).position -
                     std::get<renderer::PointEmitter>(truth.emitters[0].light).position;
  EXPECT_LT(Norm(error), 0.006) << "of 0.32";
}

/// One camera, and in each of its photos one of the lamps.
TEST_F(FitPlacesTest, LampsThatWereSwitchedBetweenPhotosOfOneCamera) {
  Scene truth = SlabScene(1);
  truth.sensors.resize(3, truth.sensors[0]);
  truth.sensors[0].lights_off = {1};
  truth.sensors[1].lights_off = {0};
  Scene start = truth;
  for (renderer::Emitter& lamp : start.emitters) {
    auto& point = std::get<renderer::PointEmitter>(lamp.light);
    point.position += Vec3{0.3, 0.2, -0.2};
    point.intensity = {15, 15, 15};
  }
  for (const int lamp : {0, 1}) {
    Free(ParameterKind::kLightPosition, lamp);
    Free(ParameterKind::kLightIntensity, lamp);
  }
  const Scene result = Fit(start, truth, 12);
  for (const std::size_t lamp : {0U, 1U}) {
    const auto& found = std::get<renderer::PointEmitter>(result.emitters[lamp].light);
    const auto& right = std::get<renderer::PointEmitter>(truth.emitters[lamp].light);
    EXPECT_LT(Norm(found.position - right.position), 0.02) << "of 0.41";
    EXPECT_NEAR(found.intensity.r / right.intensity.r, 1.0, 0.02);
  }
}

TEST_F(FitPlacesTest, OccluderOutsideTheViewsFromItsShadow) {
  const Scene truth = ShadowScene(3);
  Scene start = truth;
  start.meshes[0].pose.translation = {0.12, -0.1, 0.15};
  Free(ParameterKind::kObjectTranslation, 0);
  const Scene result = Fit(start, truth, 8);
  EXPECT_LT(Norm(result.meshes[0].pose.translation), 0.003) << "of 0.22";
}

TEST_F(FitPlacesTest, WithoutTheDirectTermTheOccluderStaysWhereItIs) {
  const Scene truth = ShadowScene(3);
  Scene start = truth;
  start.meshes[0].pose.translation = {0.12, -0.1, 0.15};
  Free(ParameterKind::kObjectTranslation, 0);
  spec_.estimators.terms.Set(renderer::DerivativeTerm::kDirect, false);
  const Scene result = Fit(start, truth, 2);
  EXPECT_NEAR(
      Norm(result.meshes[0].pose.translation - start.meshes[0].pose.translation), 0.0, 1e-9);
}

TEST_F(FitPlacesTest, SpotDirectionAndAngles) {
  Scene truth = ShadowScene(3);
  truth.meshes.erase(truth.meshes.begin());
  renderer::SpotEmitter spot;
  spot.position = {0.1, 0.1, 3.0};
  spot.intensity = {12, 12, 12};
  spot.inner_angle = 0.12;
  spot.outer_angle = 0.25;
  truth.emitters = {{"spot", renderer::LightFrame::kWorld, {}, spot}};
  Scene start = truth;
  start.emitters[0].rotation = {0.06, -0.05, 0.0};
  auto& moved = std::get<renderer::SpotEmitter>(start.emitters[0].light);
  moved.inner_angle = 0.05;
  moved.outer_angle = 0.33;
  Free(ParameterKind::kLightRotation, 0);
  Free(ParameterKind::kSpotAngles, 0);
  const Scene result = Fit(start, truth, 8);
  const Vec3 axis = renderer::RotationFromVector(result.emitters[0].rotation) * Vec3{0, 0, -1};
  const auto& found = std::get<renderer::SpotEmitter>(result.emitters[0].light);
  EXPECT_LT(Norm(axis - Vec3{0, 0, -1}), 0.0005) << "of 0.078";
  EXPECT_NEAR(found.inner_angle, 0.12, 0.002) << "from 0.05";
  EXPECT_NEAR(found.outer_angle, 0.25, 0.002) << "from 0.33";
  EXPECT_NEAR(result.emitters[0].rotation.z, 0.0, 1e-9) << "nothing shows a turn about the axis";
}

// Nothing shows how a lamp turns about its axis, which must neither wander nor hide what is known.
TEST_F(FitPlacesTest, DirectionsOfLampsWithoutTurnsAboutTheirAxes) {
  Scene truth = SlabScene(3);
  const auto lamp = [](const Vec3& direction, const Rgb& irradiance) {
    return renderer::DirectionalEmitter{Normalized(direction), irradiance};
  };
  truth.emitters[0].light = lamp({-0.3, 0.5, -0.8}, {3, 2, 1});
  truth.emitters[1].light = lamp({0.6, 0.1, -0.5}, {0.5, 1, 2});
  Scene start = truth;
  start.emitters[0].light = lamp({-0.1, 0.2, -0.8}, {3, 2, 1});
  start.emitters[1].light = lamp({0.4, -0.3, -0.5}, {0.5, 1, 2});
  for (const int i : {0, 1}) {
    Free(ParameterKind::kLightRotation, i).name = i == 0 ? "warm.rotation" : "cold.rotation";
  }
  const Scene result = Fit(start, truth, 16);
  for (const std::size_t i : {0U, 1U}) {
    const auto& from = std::get<renderer::DirectionalEmitter>(start.emitters[i].light).direction;
    const auto& to = std::get<renderer::DirectionalEmitter>(truth.emitters[i].light).direction;
    const Vec3& rotation = result.emitters[i].rotation;
    EXPECT_LT(Norm(renderer::RotationFromVector(rotation) * from - to), 0.004) << "of 0.4";
    EXPECT_NEAR(Dot(rotation, from), 0.0, 1e-6);
    for (const double error :
         result_.standard_errors.at(i == 0 ? "warm.rotation" : "cold.rotation")) {
      EXPECT_GT(error, 1e-6);
      EXPECT_LT(error, 0.01);
    }
  }
}

// Photos with stripes that nothing in the scene explains.
optim::ObservationSet StripedPhotos(const Scene& truth) {
  optim::ObservationSet observations = tests::Photograph(truth, 64);
  const auto edit = [](renderer::Image& photo) {
    for (std::size_t i = 0; i < photo.data.size(); ++i) {
      photo.data[i] *= i / 18 % 2 == 0 ? 1.3F : 0.7F;
    }
  };
  tests::EditPhotos(edit, observations);
  return observations;
}

// Weakly determined turns wander on for ever where the scene cannot explain the photos.
TEST_F(FitPlacesTest, LampsLeaveSmallPhotosWhereTheCostNoLongerFalls) {
  Scene start = SlabScene(3);
  start.emitters[0].light =
      renderer::DirectionalEmitter{Normalized(Vec3{-0.1, 0.2, -0.8}), {3, 2, 1}};
  Scene truth = start;
  truth.emitters[0].light =
      renderer::DirectionalEmitter{Normalized(Vec3{-0.3, 0.5, -0.8}), {3, 2, 1}};
  Free(ParameterKind::kLightRotation, 0);
  optim::StageSpec stage = Stage(60, 64, 512);
  stage.coarse_to_fine = true;
  spec_.stages = {stage};
  optim::RunFit(start, StripedPhotos(truth), spec_, observer_, {});
  int rounds_of_first = 0;
  for (const optim::RoundReport& round : observer_.rounds) {
    rounds_of_first += round.image_scale < observer_.rounds.back().image_scale / 2 ? 1 : 0;
  }
  EXPECT_GT(rounds_of_first, 2);
  EXPECT_LT(rounds_of_first, 12) << "of 16 that this level may have";
}

// However precise renderings could get: the photos' own errors are larger.
TEST_F(FitPlacesTest, EndsWhereWhatIsLeftIsSmallBesideWhatNothingExplains) {
  const Scene truth = SlabScene(4);
  Scene start = truth;
  start.meshes[0].pose.translation = {0.12, -0.1, 0.08};
  start.meshes[0].pose.rotation = {0.1, -0.12, 0.15};
  Free(ParameterKind::kObjectTranslation, 0);
  Free(ParameterKind::kObjectRotation, 0);
  optim::StageSpec stage = Stage(60, 8, 8);
  stage.samples.sppe = 0.5;
  stage.samples.spp_direct = 0.005;  // derivatives have more noise than images
  stage.stop_relative_cost = 0.0;    // chance alone, which would end it before, does not
  spec_.stages = {stage};
  const Scene result = optim::RunFit(start, StripedPhotos(truth), spec_, observer_, {}).scene;
  EXPECT_LT(observer_.rounds.size(), 45U);
  EXPECT_EQ(observer_.stages.back().stop_reason,
            "converged: the last steps were within their error");
  EXPECT_LT(Norm(result.meshes[0].pose.translation), 0.02) << "of 0.18";
}

// From one photo, 19 degrees away: its corners look alike, and steps lead into another valley,
// which other starts at the size of small photos tell.
TEST_F(FitPlacesTest, ACubeThatIsTurnedFarEnoughToLookLikeAnother) {
  const Vec3 place{0.778, 0.846, 0.102};
  renderer::Mesh cube = renderer::MakeCube();
  const renderer::Mat3 turn = renderer::RotationFromVector({-0.5507, 0.0496, 0.6985});
  for (Vec3& p : cube.positions) p = place + turn * p * 0.3276;
  renderer::Mesh floor = renderer::MakeRectangle();
  for (Vec3& p : floor.positions) p = {2.5 * p.x, 0.0, -2.5 * p.y};
  Scene truth;
  truth.meshes = {{"cube", cube, 0}, {"floor", floor, 1}};
  truth.meshes[0].pose.pivot = place;
  truth.materials = {{"yellow", renderer::LambertBsdf{}, {0.7, 0.6, 0.3}},
                     {"grey", renderer::LambertBsdf{}, {0.54, 0.56, 0.54}}};
  renderer::EnvironmentEmitter sky;
  sky.intensity = {0.2, 0.18, 0.28};
  const Vec3 down = renderer::Normalized(Vec3{0.141, -0.889, 0.437});
  truth.emitters = {{"sky", renderer::LightFrame::kWorld, {}, sky},
                    {"sun",
                     renderer::LightFrame::kWorld,
                     {},
                     renderer::DirectionalEmitter{down, {3.0, 2.2, 2.8}}}};
  constexpr int kSmall = 32;
  renderer::Camera camera =
      tests::CameraAt({3.2, 2.36, -0.05}, {0.0, 0.3, 0.0}, 38.6, kSmall, kSmall);
  camera.name = "view";
  truth.sensors = {camera, camera};  // the last is held out
  truth.sensors[1].name = "other";
  const Vec3 wanted{0.2601, 0.0343, 0.1990};
  Scene start = truth;
  truth.meshes[0].pose.rotation = wanted;

  Free(ParameterKind::kObjectRotation, 0);
  optim::StageSpec stage;
  stage.name = "turn";
  stage.free = {0};
  spec_.stages = {stage};
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    spec_.seed = seed;
    const Scene result =
        optim::RunFit(start, tests::Photograph(truth, 256), spec_, observer_, {}).scene;
    EXPECT_LT(Norm(result.meshes[0].pose.rotation - wanted), 0.02) << "of 0.33, seed " << seed;
  }
}

}  // namespace
}  // namespace pathfit::fit_places_test
