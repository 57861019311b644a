#include "optim/diagnostics/gradient_check.h"

#include <numbers>

#include "renderer/core/error.h"
#include "tests/optim/diagnostics/gradient_cases.h"

namespace pathfit::optim::gradient_check_test {
namespace {

using renderer::ParameterKind;
using renderer::Scene;
using renderer::Vec3;
using tests::CheckKind;

GradientCheckOptions Smooth(int max_bounces = 1, int spp = 64) {
  GradientCheckOptions options;
  options.replicates = 24;
  options.render.spp = spp;
  options.difference_spp = spp;
  options.step = 2e-2;
  options.render.max_bounces = max_bounces;
  return options;
}
/// Parameters in which the image is linear or quadratic: a long step costs no accuracy. It must be
/// long, because displaced sampling densities push random numbers across borders (choice of lobe or
/// texel), which a short step makes rare and large.
GradientCheckOptions Linear(int max_bounces = 1) {
  GradientCheckOptions options = Smooth(max_bounces);
  options.step = 0.15;
  return options;
}
/// Moving edges: the difference counts samples that change sides, and is wrong by the first order
/// on tiles whose border an edge crosses within the step.
GradientCheckOptions Moving(int max_bounces = 1) {
  GradientCheckOptions options = Smooth(max_bounces);
  options.render.sppe = 24.0;
  options.difference_spp = 1024;
  options.step = 2.5e-3;
  return options;
}

/// A convex ball, alone: nothing shadows anything.
Scene Ball() {
  Scene scene = tests::BallAndWall();
  scene.meshes.pop_back();
  scene.sensors = {tests::CameraAt({0.2, 0.3, 4.0}, {0, 0, 0}, 28.0, 16, 16)};
  return scene;
}
Scene GlossyBall() {
  Scene scene = Ball();
  scene.meshes[0].material = 1;
  return scene;
}

TEST(GradientCheck, DiffuseBallVertices) {
  CheckKind("ball vertices", Ball(), ParameterKind::kVertexPositions, 0, Moving());
}
TEST(GradientCheck, DiffuseBallSmoothParameters) {
  CheckKind("ball colours", Ball(), ParameterKind::kVertexColors, 0, Smooth());
  CheckKind("sky intensity", Ball(), ParameterKind::kLightIntensity, 0, Linear());
  CheckKind("lamp intensity", Ball(), ParameterKind::kLightIntensity, 1, Linear());
  CheckKind("sun intensity", Ball(), ParameterKind::kLightIntensity, 2, Linear());
  CheckKind("sky texels", Ball(), ParameterKind::kEnvironmentTexels, 0, Linear());
  CheckKind("exposure", Ball(), ParameterKind::kExposure, 0, Linear());
}
TEST(GradientCheck, GlossyBall) {
  CheckKind("glossy ball vertices", GlossyBall(), ParameterKind::kVertexPositions, 0, Moving());
  CheckKind("glossy ball base colour", GlossyBall(), ParameterKind::kBaseColor, 1, Linear());
  CheckKind("glossy ball roughness", GlossyBall(), ParameterKind::kRoughness, 1, Smooth());
  CheckKind("glossy ball metallic", GlossyBall(), ParameterKind::kMetallic, 1, Linear());
  CheckKind("glossy ball sky texels", GlossyBall(), ParameterKind::kEnvironmentTexels, 0, Linear());
}

/// Texels at 0 cannot become less: everything is taken a step inside.
TEST(GradientCheck, BlackSky) {
  Scene scene = Ball();
  auto& sky = std::get<renderer::EnvironmentEmitter>(scene.emitters[0].light);
  sky.texels.assign(sky.texels.size(), renderer::Rgb(0.0, 0.0, 0.0));
  CheckKind("black sky texels", scene, ParameterKind::kEnvironmentTexels, 0, Linear());
}

TEST(GradientCheck, StepsThatShowNothingAreRefused) {
  const Scene scene = Ball();
  renderer::ParameterLayout layout(scene);
  layout.Add(ParameterKind::kLightIntensity, 1);
  for (const double step : {1e300, 1e-300}) {
    GradientCheckOptions options = Linear();
    options.step = step;
    EXPECT_THROW(CheckGradient(scene, scene.sensors[0], 0, layout, {1.0, 0.0, 0.0}, options),
                 renderer::SceneError);
  }
}

TEST(GradientCheck, AMetalWithoutRealIndexIsTakenAStepInside) {
  Scene scene = Ball();
  scene.materials[static_cast<std::size_t>(scene.meshes[0].material)].bsdf =
      renderer::MirrorBsdf{.eta = {0.0, 0.0, 0.0}, .k = {4.0, 3.0, 2.0}};
  renderer::ParameterLayout layout(scene);
  layout.Add(ParameterKind::kEta, scene.meshes[0].material);
  GradientCheckOptions options = Smooth(1, 4);
  options.replicates = 2;
  EXPECT_NO_THROW(CheckGradient(scene, scene.sensors[0], 0, layout, {1.0, 1.0, 1.0}, options));
}

TEST(GradientCheck, BallBeforeAHiddenSky) {
  Scene scene = Ball();
  scene.environment_visible = false;
  CheckKind("ball vertices, hidden sky", scene, ParameterKind::kVertexPositions, 0, Moving());
}

TEST(GradientCheck, BallUnderASkyCarriedByTheCamera) {
  Scene scene = Ball();
  scene.emitters[0].frame = renderer::LightFrame::kCamera;
  std::get<renderer::EnvironmentEmitter>(scene.emitters[0].light).frame_from_light =
      renderer::RotationAboutAxis(renderer::Normalized(Vec3{1, 1, 0}), 0.9);
  scene.sensors = {tests::CameraAt({3.0, 1.0, 2.0}, {0, 0, 0}, 28.0, 16, 16)};
  CheckKind("ball vertices, camera sky", scene, ParameterKind::kVertexPositions, 0, Moving());
  CheckKind("camera sky texels", scene, ParameterKind::kEnvironmentTexels, 0, Linear());
}

TEST(GradientCheck, BallThroughADistortingLens) {
  Scene scene = Ball();
  scene.sensors[0].fx = 34.0;
  scene.sensors[0].fy = 30.0;
  scene.sensors[0].cx = 7.0;
  scene.sensors[0].distortion = {-0.5, 0.3, -0.1, 0.03, -0.02};
  CheckKind("ball vertices, distortion", scene, ParameterKind::kVertexPositions, 0, Moving());
}

/// A ball that crosses the image border, with part of it out of sight.
TEST(GradientCheck, BallAcrossTheFilmBorder) {
  Scene scene = Ball();
  scene.sensors = {tests::CameraAt({0.9, 0.5, 4.0}, {0.9, 0.5, 0}, 28.0, 16, 16)};
  CheckKind("ball vertices, film border", scene, ParameterKind::kVertexPositions, 0, Moving());
}

Scene CubeScene() {
  Scene scene = GlossyBall();
  scene.meshes[0].mesh = tests::Cube();
  scene.meshes[0].name = "cube";
  scene.sensors = {tests::CameraAt({3.0, 3.5, 4.0}, {0, 0, 0}, 22.0, 16, 16)};
  return scene;
}

TEST(GradientCheck, FlatCubeWithCreases) {
  CheckKind("cube vertices", CubeScene(), ParameterKind::kVertexPositions, 0, Moving());
}

/// Every face with colours of its own: the image jumps across all edges, the diagonals included.
TEST(GradientCheck, CubeWithColorBorders) {
  Scene scene = CubeScene();
  scene.meshes[0].material = 0;
  renderer::Mesh& mesh = scene.meshes[0].mesh;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto first = static_cast<std::int32_t>(mesh.colors.size());
    for (int k = 0; k < 3; ++k) {
      const double s = 3.0 * static_cast<double>(i) + k;
      mesh.colors.push_back({0.5 + 0.45 * std::sin(5.0 * s),
                             0.5 + 0.45 * std::cos(3.0 * s),
                             0.5 + 0.4 * std::sin(7.0 * s)});
    }
    mesh.color_triangles.push_back({first, first + 1, first + 2});
  }
  CheckKind("cube vertices, colour borders", scene, ParameterKind::kVertexPositions, 0, Moving());
  CheckKind("cube separately indexed colours", scene, ParameterKind::kVertexColors, 0, Smooth());
}

/// A convex cap, open below, seen from outside: borders are silhouettes, too.
TEST(GradientCheck, OpenCapWithBorder) {
  Scene scene = GlossyBall();
  renderer::Mesh& mesh = scene.meshes[0].mesh;
  mesh.color_triangles.clear();
  mesh.colors.clear();
  std::erase_if(mesh.triangles.Edit(), [&](const renderer::Triangle& t) {
    double height = 0.0;
    for (const std::int32_t i : t) height += mesh.positions[static_cast<std::size_t>(i)].y;
    return height < 0.9;
  });
  renderer::WeldPositions(mesh);
  scene.sensors = {tests::CameraAt({1.0, 4.5, 2.0}, {0, 0.5, 0}, 40.0, 16, 16)};
  CheckKind("open cap vertices", scene, ParameterKind::kVertexPositions, 0, Moving());
}

/// Two plates like an open book with a lamp between them: each sees the other and the lamp from all
/// its points, so that interreflection has no shadow edges.
Scene Book() {
  Scene scene = tests::BallAndWall();
  const auto page = [](double side) {
    renderer::Mesh mesh = tests::Plate(0.8, 0.8, 0.0);
    renderer::ApplyTransform(
        {renderer::RotationAboutAxis({0, 1, 0}, -side * 1.1), {side * 0.8, 0, 0}}, mesh);
    return mesh;
  };
  scene.meshes = {{"left", page(-1.0), 0}, {"right", page(1.0), 1}};
  scene.materials[0].vertex_colors = false;
  scene.materials[0].base_color = {0.8, 0.6, 0.9};
  scene.emitters = {{"lamp",
                     renderer::LightFrame::kWorld,
                     {},
                     renderer::PointEmitter{{0.1, 0.2, 0.9}, {3, 4, 5}}}};
  scene.sensors = {tests::CameraAt({0.2, 0.5, 3.5}, {0, 0, 0}, 26.0, 16, 16)};
  return scene;
}

/// At the spine the pages touch: the difference is less smooth there, error bars of few replicates
/// are too small.
GradientCheckOptions MovingPages(int max_bounces) {
  GradientCheckOptions options = Moving(max_bounces);
  options.step *= 0.5;
  options.replicates *= 2;
  options.difference_spp /= 2;
  return options;
}
TEST(GradientCheck, BookOfTwoBounces) {
  CheckKind(
      "book left vertices, 2 bounces", Book(), ParameterKind::kVertexPositions, 0, MovingPages(2));
  CheckKind(
      "book right vertices, 2 bounces", Book(), ParameterKind::kVertexPositions, 1, MovingPages(2));
}
TEST(GradientCheck, BookOfFourBounces) {
  CheckKind(
      "book left vertices, 4 bounces", Book(), ParameterKind::kVertexPositions, 0, MovingPages(4));
  CheckKind(
      "book right vertices, 4 bounces", Book(), ParameterKind::kVertexPositions, 1, MovingPages(4));
}
TEST(GradientCheck, BookSmoothParameters) {
  for (const int bounces : {2, 4}) {
    const std::string tail = ", " + std::to_string(bounces) + " bounces";
    CheckKind("book Lambert colour" + tail, Book(), ParameterKind::kBaseColor, 0, Linear(bounces));
    CheckKind("book glossy colour" + tail, Book(), ParameterKind::kBaseColor, 1, Linear(bounces));
    CheckKind("book roughness" + tail, Book(), ParameterKind::kRoughness, 1, Smooth(bounces, 256));
    CheckKind("book metallic" + tail, Book(), ParameterKind::kMetallic, 1, Linear(bounces));
    CheckKind("book lamp" + tail, Book(), ParameterKind::kLightIntensity, 0, Linear(bounces));
  }
}

/// The camera's own flash: shadows lie exactly behind their casters, so a ball before a wall needs
/// no shadow term.
TEST(GradientCheck, BallBeforeAWallUnderTheFlash) {
  Scene scene = tests::BallAndWall();
  scene.emitters = {{"flash",
                     renderer::LightFrame::kCamera,
                     {},
                     renderer::PointEmitter{{0, 0, 0}, {20, 20, 20}}}};
  scene.sensors = {tests::CameraAt({0.2, 0.3, 4.0}, {0, 0, 0}, 28.0, 16, 16)};
  CheckKind("flash, ball vertices", scene, ParameterKind::kVertexPositions, 0, Moving());
  CheckKind("flash, wall vertices", scene, ParameterKind::kVertexPositions, 1, Moving());
}

/// A bowl seen over its rim, inside and outside at once: folds have both faces on one side, and
/// what lies behind them is the bowl itself.
Scene BowlUnderTheFlash() {
  Scene scene = GlossyBall();
  renderer::Mesh& mesh = scene.meshes[0].mesh;
  mesh.color_triangles.clear();
  mesh.colors.clear();
  std::erase_if(mesh.triangles.Edit(), [&](const renderer::Triangle& t) {
    double height = 0.0;
    for (const std::int32_t i : t) height += mesh.positions[static_cast<std::size_t>(i)].y;
    return height > 0.2;
  });
  renderer::WeldPositions(mesh);
  scene.emitters = {{"flash",
                     renderer::LightFrame::kCamera,
                     {},
                     renderer::PointEmitter{{0, 0, 0}, {20, 20, 20}}}};
  scene.sensors = {tests::CameraAt({0.7, 1.3, 4.0}, {0, -0.3, 0}, 36.0, 16, 16)};
  return scene;
}
TEST(GradientCheck, BowlSeenOverItsRim) {
  CheckKind("bowl vertices", BowlUnderTheFlash(), ParameterKind::kVertexPositions, 0, Moving());
}
TEST(GradientCheck, OneSidedBowlIsBlackInside) {
  Scene scene = BowlUnderTheFlash();
  scene.materials[1].two_sided = false;
  CheckKind("one-sided bowl vertices", scene, ParameterKind::kVertexPositions, 0, Moving());
}

TEST(GradientCheck, RoomSeenFromInside) {
  Scene scene = CubeScene();
  scene.emitters = {
      {"flash", renderer::LightFrame::kCamera, {}, renderer::PointEmitter{{0, 0, 0}, {4, 3, 5}}}};
  scene.sensors = {tests::CameraAt({0.3, 0.2, 0.5}, {-0.3, -0.4, -1}, 7.3, 16, 16)};
  CheckKind("room vertices", scene, ParameterKind::kVertexPositions, 0, Moving());
}

/// Millimetres, away from the origin: no tolerance may be absolute.
TEST(GradientCheck, SmallAndFarFromTheOrigin) {
  constexpr double kScale = 1e-3;
  Scene scene = BowlUnderTheFlash();
  const renderer::Transform place{{{kScale, 0, 0}, {0, kScale, 0}, {0, 0, kScale}},
                                  {3.0, -2.0, 1.0}};
  renderer::ApplyTransform(place, scene.meshes[0].mesh);
  scene.sensors[0].world_from_camera.translation =
      place.Point(scene.sensors[0].world_from_camera.translation);
  std::get<renderer::PointEmitter>(scene.emitters[0].light).intensity =
      renderer::Rgb::Constant(20.0 * kScale * kScale);
  CheckKind("small bowl vertices", scene, ParameterKind::kVertexPositions, 0, Moving(), kScale);
}

/// Moving all vertices is moving the camera back, when the lights are at infinity or carried along.
TEST(GradientCheck, MovingTheSceneEqualsMovingTheCameraBack) {
  Scene scene = Ball();  // its colours slide through the pixels: both terms count
  scene.emitters[1].frame = renderer::LightFrame::kCamera;
  const Vec3 velocity{0.6, -0.4, 0.7};
  const tests::VertexMotion motion = tests::MoveMesh(scene, [&](const Vec3&) { return velocity; });
  const GradientCheckOptions options = Moving();
  GradientCheckResult result =
      CheckGradient(scene, scene.sensors[0], -1, motion.layout, motion.direction, options);
  const renderer::Renderer renderer(scene);
  const auto image_at = [&](double step, std::size_t replicate) {
    renderer::Camera camera = scene.sensors[0];
    camera.world_from_camera.translation += velocity * step;
    renderer::RenderOptions render;
    render.spp = options.difference_spp;
    render.seed = 1000 + replicate;
    return renderer.RenderPrimal(camera, render);
  };
  for (std::size_t r = 0; r < result.difference.size(); ++r) {
    const renderer::Film back = image_at(-options.step, r);
    const renderer::Film forth = image_at(options.step, r);
    for (std::size_t i = 0; i < back.pixels.size(); ++i) {
      result.difference[r].pixels[i] = (back.pixels[i] - forth.pixels[i]) * (0.5 / options.step);
    }
  }
  tests::ExpectRightDerivative("scene against camera", result, {Term::kInterior, Term::kPrimary});
}

}  // namespace
}  // namespace pathfit::optim::gradient_check_test
