#include "tests/optim/diagnostics/gradient_scenes.h"

#include <string>

#include "renderer/core/error.h"
#include "renderer/derivative/derivative_limits.h"
#include "tests/optim/diagnostics/gradient_cases.h"

// Scenes that boundary terms find difficult: right, or refused and said by name.
namespace pathfit::optim::gradient_scenes_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::PixelFilter;
using renderer::Rgb;
using renderer::Scene;
using renderer::Vec3;
using tests::CheckKind;
using tests::CheckKindInBothForms;
using tests::ExpectedTerms;

using tests::Above;
using tests::AboveUnderPanel;

constexpr DerivativeForm kImage = DerivativeForm::kImage;
constexpr DerivativeForm kMaterial = DerivativeForm::kMaterial;
const ExpectedTerms kShadows = {Term::kInterior, Term::kPrimary, Term::kDirect};

GradientCheckOptions Moving(DerivativeForm form = kImage, int max_bounces = 1) {
  return tests::OptionsForMotion(form, max_bounces);
}
GradientCheckOptions OneBounce(DerivativeForm form) { return Moving(form); }

Mesh Box(const Vec3& at = {0, 0.7, 0}) {
  return tests::Placed(tests::Cube(), 0.4, at, {0.3, 0.6, 0.2});
}

/// Turned so that no triangle is edge-on to the camera or the lamp, where no derivative exists.
Mesh Ball(bool smooth) {
  return tests::Placed(tests::Ball(0.5, {0, 0, 0}, smooth), 1.0, {0, 0.8, 0}, {0.1, 0.2, 0.3});
}

TEST(DifficultScenes, CubeWithItsShadow) {
  const Scene scene = AboveUnderPanel(Box());
  CheckKindInBothForms(
      "cube vertices", scene, ParameterKind::kVertexPositions, 1, OneBounce, 1.0, kShadows);
  CheckKindInBothForms(
      "cube rotation", scene, ParameterKind::kObjectRotation, 1, OneBounce, 1.0, kShadows);
}

TEST(DifficultScenes, MeshWithAUvSeam) {
  Mesh ball = renderer::MakeIcosphere(1, 0.5);
  renderer::SetSphereUvs(ball);
  Scene scene = Above(tests::Placed(ball, 1.0, {0, 0.7, 0}, {0.2, 2.8, 0.1}));
  scene.textures = {tests::Pattern("globe", 6, 4, 0.1, 0.9)};
  scene.textures[0].wrap = renderer::TextureWrap::kRepeat;
  scene.materials[1].base_color_texture = 0;
  CheckKind(
      "UV seam, vertices", scene, ParameterKind::kVertexPositions, 1, Moving(), 1.0, kShadows);
  CheckKind("UV seam, UVs", scene, ParameterKind::kUvs, 1, Moving(), 0.5, {Term::kInterior});
}

Scene UnderPanelAlone(const Mesh& thing) {
  Scene scene = AboveUnderPanel(thing);
  scene.emitters.erase(scene.emitters.begin());
  return scene;
}
TEST(DifficultScenes, FlatAndSmoothBalls) {
  Scene smooth = Above(Ball(true));
  Scene flat = AboveUnderPanel(Ball(false));
  for (Scene* scene : {&smooth, &flat}) {
    scene->materials[1].bsdf = renderer::MetallicRoughnessBsdf{0.5, 0.5};
  }
  CheckKindInBothForms(
      "smooth ball, lamp", smooth, ParameterKind::kVertexPositions, 1, OneBounce, 1.0, kShadows);
  CheckKindInBothForms("flat ball, lamp and panel",
                       flat,
                       ParameterKind::kVertexPositions,
                       1,
                       OneBounce,
                       1.0,
                       kShadows);
}

/// Bending a coarse mesh with interpolated normals under an extended light: presumably its
/// triangles stop to reflect all at once where the light sinks below their planes, which is no
/// edge.
TEST(DifficultScenes, PanelSetsBehindTrianglesOfACoarseSmoothBall) {
  const Scene scene = UnderPanelAlone(Ball(true));
  renderer::ParameterLayout layout(scene);
  layout.Add(ParameterKind::kVertexPositions, 1);
  tests::ExpectLimit(
      "coarse smooth ball, panel", scene, layout, tests::RandomDirection(layout, 5), Moving());
}

/// Without its lower part: the border is a silhouette and throws a shadow, and the inside is seen.
Scene OpenCap(bool two_sided) {
  Mesh cap = renderer::MakeIcosphere(1, 0.6);
  std::erase_if(cap.triangles.Edit(), [&](const renderer::Triangle& t) {
    double height = 0.0;
    for (const std::int32_t i : t) height += cap.positions[static_cast<std::size_t>(i)].y;
    return height < 0.1;
  });
  renderer::WeldPositions(cap);
  Scene scene = Above(tests::Placed(cap, 1.0, {0, 0.7, 0}, {-2.2, 0.3, 0}));
  scene.materials[1].two_sided = two_sided;
  return scene;
}
TEST(DifficultScenes, OpenMeshOfOneAndTwoSides) {
  for (const bool two_sided : {false, true}) {
    CheckKindInBothForms(two_sided ? "two-sided cap" : "one-sided cap",
                         OpenCap(two_sided),
                         ParameterKind::kVertexPositions,
                         1,
                         OneBounce,
                         1.0,
                         {Term::kPrimary, Term::kDirect});
  }
}

TEST(DifficultScenes, SunThatGrazesTheSidesOfACube) {
  for (const Vec3& direction : {Vec3{0, -1, 0}, Vec3{0, -1, -0.5}}) {
    Scene scene = Above(tests::Placed(tests::Cube(), 0.3, {0, 0.5, 0}));
    renderer::DirectionalEmitter sun;
    sun.direction = renderer::Normalized(direction);
    sun.irradiance = {3.0, 3.0, 3.0};
    scene.emitters = {{"sun", renderer::LightFrame::kWorld, {}, sun}};
    CheckKindInBothForms("grazing sun",
                         scene,
                         ParameterKind::kObjectTranslation,
                         1,
                         OneBounce,
                         1.0,
                         {Term::kPrimary, Term::kDirect});
  }
}

TEST(DifficultScenes, SliverAtTheBorderOfAnOpenMesh) {
  Mesh tent;
  tent.positions = {{-0.5, 0, 0.3}, {0.5, 0, 0.3}, {0.05, 0, 0.3 - 1e-6}, {0, 0.8, -0.3}};
  tent.triangles = {{0, 1, 2}, {1, 3, 2}, {0, 2, 3}};
  const Scene scene = Above(tests::Placed(tent, 1.0, {0, 0.5, 0}, {0.1, 0.3, 0.05}));
  CheckKindInBothForms("sliver",
                       scene,
                       ParameterKind::kObjectTranslation,
                       1,
                       OneBounce,
                       1.0,
                       {Term::kPrimary, Term::kDirect});
}

TEST(DifficultScenes, ObjectAcrossTheFilmBorder) {
  for (const PixelFilter::Shape shape : {PixelFilter::Shape::kBox, PixelFilter::Shape::kTent}) {
    Scene scene = Above(Box());
    scene.sensors = {tests::CameraAt({1.5, 2.6, 3.4}, {0.95, 0.3, 0}, 26.0, 16, 16)};
    scene.sensors[0].rotation = {0.0, 0.0, 0.2};
    const bool box = shape == PixelFilter::Shape::kBox;
    if (!box) scene.sensors[0].filter = {shape, 1.0};
    CheckKindInBothForms(box ? "film border, box" : "film border, tent",
                         scene,
                         ParameterKind::kVertexPositions,
                         1,
                         OneBounce,
                         1.0,
                         {Term::kPrimary});
  }
}

TEST(DifficultScenes, ThinSheet) {
  Mesh sheet = tests::Cube();
  renderer::ApplyTransform({{{0.6, 0, 0}, {0, 5e-4, 0}, {0, 0, 0.5}}, {0, 0, 0}}, sheet);
  const Scene scene = AboveUnderPanel(tests::Placed(sheet, 1.0, {0, 0.6, 0}, {0.3, 0.4, 0.1}));
  CheckKindInBothForms(
      "sheet of 1e-3", scene, ParameterKind::kObjectTranslation, 1, OneBounce, 1.0, kShadows);
}

TEST(DifficultScenes, RoughGlassBall) {
  Scene scene = Above(Ball(true));
  scene.emitters[0] = tests::GradientEnvironment(8, 4);
  scene.materials[1].bsdf = renderer::RoughDielectricBsdf{0.5, 1.4};
  scene.materials[1].base_color = {0.9, 1.0, 0.8};
  GradientCheckOptions options = Moving(kImage, 3);
  options.render.spp = 192;
  options.replicates = 32;
  constexpr double kMinSignal = 3.0;  // light that takes three bounces is noisy
  CheckKind("rough glass, index",
            scene,
            ParameterKind::kEta,
            1,
            options,
            1.0,
            {Term::kInterior},
            tests::kTile,
            kMinSignal);
  CheckKind("rough glass, translation",
            scene,
            ParameterKind::kObjectTranslation,
            1,
            options,
            1.0,
            {Term::kInterior, Term::kPrimary},
            tests::kTile,
            kMinSignal);
}

/// What flat mirrors show directly is right, but not the silhouettes of smooth ones; that edges in
/// them are missing is announced.
TEST(DifficultScenes, Mirrors) {
  Scene scene = Above(Ball(false));
  scene.meshes.erase(scene.meshes.begin());
  scene.emitters[0] = tests::GradientEnvironment(8, 4);
  scene.materials[1].bsdf = renderer::MirrorBsdf{};
  CheckKind("mirror ball, vertices",
            scene,
            ParameterKind::kVertexPositions,
            0,
            Moving(),
            1.0,
            {Term::kInterior, Term::kPrimary});

  scene.meshes[0].mesh = Ball(true);
  renderer::ParameterLayout pose(scene);
  pose.Add(ParameterKind::kObjectTranslation, 0);
  tests::ExpectRightDerivative(
      "smooth mirror ball moves",
      CheckGradient(scene, scene.sensors[0], -1, pose, {0.5, 0.6, -0.7}, Moving()),
      {Term::kInterior, Term::kPrimary});

  scene = Above(Box());
  scene.materials[0].bsdf = renderer::MirrorBsdf{};
  renderer::ParameterLayout layout(scene);
  layout.Add(ParameterKind::kVertexPositions, 1);
  const auto limits = renderer::DerivativeLimits(scene, layout);
  ASSERT_EQ(limits.size(), 1U);
  EXPECT_EQ(limits[0].rfind("'floor' is a mirror", 0), 0U) << limits[0];
  const std::vector<double> direction(static_cast<std::size_t>(layout.NumScalars()), 1.0);
  EXPECT_THROW(CheckGradient(scene, scene.sensors[0], -1, layout, direction, Moving(kMaterial)),
               renderer::SceneError);
}

/// Nothing moves, but what is seen through the glass does.
TEST(DifficultScenes, IndexOfSmoothGlass) {
  Scene scene = Above(tests::Ball(0.5, {0, 0.8, 0}, true, 5));
  scene.meshes.erase(scene.meshes.begin());
  scene.emitters[0] = tests::GradientEnvironment(8, 4);
  scene.materials[1].bsdf = renderer::SmoothDielectricBsdf{1.4};
  GradientCheckOptions options = Moving(kImage, 4);
  options.render.spp = 1024;
  options.difference_spp = 2048;
  options.step = 4e-3;
  CheckKind("smooth glass, index", scene, ParameterKind::kEta, 1, options, 0.5, {Term::kInterior});
  renderer::ParameterLayout layout(scene);
  layout.Add(ParameterKind::kEta, 1);
  EXPECT_EQ(renderer::DerivativeLimits(scene, layout).size(), 1U);
}

TEST(DifficultScenes, LampInABowl) {
  Mesh bowl = renderer::MakeIcosphere(1, 0.7);
  std::erase_if(bowl.triangles.Edit(), [&](const renderer::Triangle& t) {
    double height = 0.0;
    for (const std::int32_t i : t) height += bowl.positions[static_cast<std::size_t>(i)].y;
    return height > 0.3;
  });
  renderer::WeldPositions(bowl);
  Scene scene = Above(tests::Placed(bowl, 1.0, {0, 0.8, 0}, {0.8, 0.3, 0.2}));
  scene.emitters[0] = tests::Lamp({0.05, 0.85, 0.1}, {1.0, 0.9, 0.8});
  CheckKindInBothForms(
      "lamp in a bowl", scene, ParameterKind::kVertexPositions, 1, OneBounce, 1.0, kShadows);
}

/// The panel shines, and keeps the lamp's light from the floor.
TEST(DifficultScenes, MovingLightThatBlocks) {
  Scene scene = AboveUnderPanel(Box({0.4, 0.5, 0.3}));
  scene.meshes[2].mesh = tests::Ceiling(0.35, {0.2, 1.5, -0.1});
  scene.emitters[0] = tests::Lamp({0.6, 3.5, 0.4}, {16, 14, 12});
  CheckKindInBothForms("light that blocks",
                       scene,
                       ParameterKind::kVertexPositions,
                       2,
                       OneBounce,
                       1.0,
                       {Term::kInterior, Term::kDirect});
}

TEST(DifficultScenes, CameraInAClosedRoom) {
  Scene scene = Above(Box({0.2, -0.5, -0.3}));
  scene.meshes[0] = {"room", tests::Inverted(tests::Cube()), 0, {}};
  scene.emitters[0] = tests::Lamp({-0.3, 0.8, 0.2}, {0.9, 0.8, 0.7});
  scene.sensors = {tests::CameraAt({0.3, 0.5, 0.8}, {0.0, -0.3, -0.4}, 11.0, 16, 16)};
  scene.sensors[0].rotation = {0.0, 0.0, 0.2};
  CheckKindInBothForms("room vertices",
                       scene,
                       ParameterKind::kVertexPositions,
                       0,
                       OneBounce,
                       1.0,
                       {Term::kInterior});
  CheckKindInBothForms(
      "box in a room",
      scene,
      ParameterKind::kVertexPositions,
      1,
      [](DerivativeForm form) { return Moving(form, 2); },
      1.0,
      kShadows);
}

/// Two leaves of one mesh are all the light: the last reflection meets them, in their fold from
/// close by.
TEST(DifficultScenes, FoldThatShines) {
  Mesh fold;
  fold.positions = {{-1, 0, 1}, {1, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {1, 1, -0.2}, {-1, 1, -0.2}};
  fold.triangles = {{0, 1, 2}, {0, 2, 3}, {3, 2, 4}, {3, 4, 5}};
  Scene scene = Above(fold);
  scene.meshes = {{"fold", fold, 0, {}}};
  scene.emitters = {tests::Panel(0, {1.0, 1.5, 2.0})};
  for (const DerivativeForm form : {kImage, kMaterial}) {
    CheckKind(std::string("shining fold") + (form == kImage ? ", image" : ", material"),
              scene,
              ParameterKind::kVertexPositions,
              0,
              Moving(form),
              1.0,
              {Term::kInterior, form == kImage ? Term::kPrimary : Term::kPixel});
  }
}

TEST(DifficultScenes, LampNextToASurface) {
  Scene scene = Above(Box({-0.3, 0.7, 0}));
  scene.emitters[0] = tests::Lamp({0.6, 0.02, 0.4}, {0.8, 0.7, 0.6});
  GradientCheckOptions options = Moving();
  options.step = 1e-2;
  CheckKind("lamp 2 cm above the floor, box",
            scene,
            ParameterKind::kVertexPositions,
            1,
            options,
            1.0,
            {Term::kPrimary});
  options.step = 2.5e-3;
  options.render.spp = 768;
  CheckKind("lamp 2 cm above the floor, lamp",
            scene,
            ParameterKind::kLightPosition,
            0,
            options,
            1.0,
            {Term::kInterior});
}

TEST(DifficultScenes, OrthographicCamera) {
  Scene scene = Above(Box());
  scene.emitters.push_back(tests::Sun({0.45, -1.0, -0.3}, {0.8, 0.9, 1.0}));
  scene.sensors[0].projection = renderer::ProjectionKind::kOrthographic;
  scene.sensors[0].fx = scene.sensors[0].fy = 6.5;
  CheckKindInBothForms(
      "orthographic, box", scene, ParameterKind::kVertexPositions, 1, OneBounce, 1.0, kShadows);
  CheckKindInBothForms("orthographic, camera turns",
                       scene,
                       ParameterKind::kCameraRotation,
                       0,
                       OneBounce,
                       0.5,
                       {Term::kPrimary});
}

}  // namespace
}  // namespace pathfit::optim::gradient_scenes_test
