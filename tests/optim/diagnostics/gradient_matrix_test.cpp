#include <string>
#include <vector>

#include "tests/optim/diagnostics/gradient_cases.h"
#include "tests/optim/diagnostics/gradient_scenes.h"

// Every kind of parameter against central differences in one scene with every kind of light.
// tests/scenes/gradcheck_matrix.yaml is a similar scene for `pathfit gradcheck`.
namespace pathfit::optim::gradient_matrix_test {
namespace {

using renderer::DerivativeForm;
using renderer::ParameterKind;
using renderer::PixelFilter;
using renderer::Scene;
using tests::ExpectedTerms;

// Indices of the scene below.
constexpr int kFloor = 0, kBall = 1, kBox = 2, kPanel = 4;                     // meshes
constexpr int kGlossMaterial = 1, kMetalMaterial = 2;                          // materials
constexpr int kPaint = 0, kSheen = 1, kGlow = 2, kSlide = 3;                   // textures
constexpr int kSky = 0, kPanelLight = 1, kSpot = 2, kProjector = 3, kSun = 4;  // lights
constexpr int kWall = 3, kLamp = 5;

Scene MatrixScene() {
  using renderer::Rgb;
  Scene scene;
  renderer::Mesh wall = tests::Plate(1.6, 1.0, 0.0);
  // Away from the floor: paths across a corner have derivatives of any size.
  renderer::ApplyTransform({{}, {0, 1.1, -1.9}}, wall);
  wall.colors = {{0.8, 0.3, 0.4}, {0.3, 0.7, 0.5}, {0.5, 0.4, 0.9}, {0.6, 0.8, 0.2}};
  wall.color_triangles = wall.triangles;
  scene.meshes = {{"floor", tests::Floor(1.6), 0, {}},
                  {"ball", tests::Ball(0.45, {-0.5, 0.6, 0.2}, true), kGlossMaterial, {}},
                  {"box",
                   tests::Placed(tests::Cube(), 0.3, {0.6, 0.6, -0.2}, {0.3, 0.6, 0.2}),
                   kMetalMaterial,
                   {{0.6, 0.6, -0.2}, {}, {}, 1.0}},
                  {"wall", wall, 3, {}},
                  {"panel", tests::Ceiling(0.5, {-0.2, 3.2, 0.3}), 4, {}}};
  scene.materials = {
      {"carpet", renderer::MetallicRoughnessBsdf{0.5, 0.2}},
      {"gloss", renderer::MetallicRoughnessBsdf{0.5, 0.4}, {0.7, 0.5, 0.3}},
      {"metal", renderer::RoughConductorBsdf{0.55, {0.4, 0.9, 1.2}, {2.5, 2.0, 1.5}}, {1, 1, 1}},
      {"paint", renderer::LambertBsdf{}, {0.5, 0.5, 0.5}, true},
      {"black", renderer::LambertBsdf{}, {0, 0, 0}}};
  scene.materials[0].base_color_texture = kPaint;
  scene.materials[0].roughness_texture = kSheen;
  scene.textures = {tests::Pattern("paint", 4, 4, 0.2, 0.8),
                    tests::Pattern("sheen", 3, 3, 0.4, 0.8, true),
                    tests::Pattern("glow", 2, 2, 0.5, 1.5),
                    tests::Slide("slide", 6)};
  scene.emitters = {tests::GradientEnvironment(8, 4),
                    tests::Panel(kPanel, {6, 7, 8}, kGlow),
                    tests::Spot({1.6, 1.9, 1.4}, {0.2, 0.3, 0.0}, {7, 5, 6}),
                    tests::Projector({-1.6, 1.8, 1.6}, {0, 0.2, 0}, Rgb{2.5, 2.0, 3.0}, kSlide),
                    tests::Sun({0.5, -1.0, -0.3}, {0.7, 0.9, 0.8}),
                    tests::Lamp({0.4, 2.0, 1.2}, {3, 2, 2.5})};
  renderer::LightIntensity(scene.emitters[kSky]) = Rgb::Constant(0.4);
  scene.sensors = {tests::CameraAt({0.3, 1.7, 4.0}, {0, 0.6, 0}, 17.0, 16, 16)};
  // Tilted: an edge along a row of pixels would cross the border of a tile as a whole.
  scene.sensors[0].rotation = {0.0, 0.05, 0.25};
  scene.sensors[0].distortion = {-0.15, 0.08, -0.02, 0.01, -0.01};
  return scene;
}

GradientCheckOptions Budget(DerivativeForm form, int spp, int difference_spp, double step) {
  GradientCheckOptions options;
  options.replicates = 24;
  options.render.spp = spp;
  options.difference_spp = difference_spp;
  options.render.sppe = 24.0;
  options.render.spp_direct = 48.0;
  options.render.spp_indirect = 16.0;
  options.render.spp_pixel = 16.0;
  options.step = step;
  options.render.max_bounces = 2;
  options.render.form = form;
  return options;
}
struct Case {
  const char* name;
  ParameterKind kind;
  int object;
  double scale = 1.0;  ///< largest entry of the direction
  ExpectedTerms terms = {};
  double share = 1.0;  ///< of the usual samples: fewer where they tell enough
};

// Pictures of a second or less: what is asked of their sharpness is less than elsewhere, and
// mutants of the terms named with a case must be found all the same.
constexpr double kMinSignal = 4.0;
/// What moves, in both forms and with one filter.
void CheckMoving(const Case& c, PixelFilter::Shape filter) {
  Scene scene = MatrixScene();
  std::string name = c.name;
  if (filter == PixelFilter::Shape::kTent) {
    scene.sensors[0].filter = {filter, 1.0};
    name += ", tent";
  }
  const bool camera = renderer::TraitsOf(c.kind).list == renderer::ObjectList::kSensors;
  const bool sky = c.kind == ParameterKind::kLightRotation && c.object == kSky;
  const auto options_of = [&](DerivativeForm form) {
    const bool image = form == DerivativeForm::kImage;
    GradientCheckOptions options = Budget(form, image && !camera ? 32 : 96, 160, 2e-2);
    if (sky && !image) {
      // The background is a surface that turns: large terms cancel.
      options.render.spp = 384;
      options.render.spp_pixel = 128.0;
    }
    if (c.kind == ParameterKind::kLightPosition && c.object == kProjector) {
      options.difference_spp = 640;  // its shadows are small: few samples change sides
    }
    return tests::Share(options, c.share);
  };
  const tests::KindMotion motion(scene, c.kind, c.object, c.scale);
  tests::CheckInBothForms(scene,
                          motion.sensor,
                          motion.layout,
                          motion.direction,
                          options_of,
                          [&](const GradientCheckResult& result, DerivativeForm form) {
                            tests::ExpectRightDerivative(tests::InForm(name, form),
                                                         result,
                                                         c.terms,
                                                         tests::kTile,
                                                         sky && form == DerivativeForm::kMaterial
                                                             ? 0.5 * kMinSignal
                                                             : kMinSignal);
                          });
}

/// What moves nothing: equal random numbers make the same paths, and the difference is sharp.
void CheckResting(const Scene& scene, double step, const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    tests::CheckKind(c.name,
                     scene,
                     c.kind,
                     c.object,
                     tests::Share(Budget(DerivativeForm::kImage, 64, 64, step), c.share),
                     c.scale,
                     {Term::kInterior},
                     tests::kTile,
                     kMinSignal);
  }
}

TEST(GradientMatrix, SurfacesAndTexels) {
  CheckResting(
      MatrixScene(),
      2e-2,
      {{"wall.colors", ParameterKind::kVertexColors, kWall, 1.0, {}, 0.25},
       {"gloss.base_color", ParameterKind::kBaseColor, kGlossMaterial},
       {"gloss.roughness", ParameterKind::kRoughness, kGlossMaterial},
       {"gloss.metallic", ParameterKind::kMetallic, kGlossMaterial},
       {"gloss.specular", ParameterKind::kSpecular, kGlossMaterial, 10.0},
       {"metal.eta", ParameterKind::kEta, kMetalMaterial, 1.0, {}, 0.25},
       {"metal.k", ParameterKind::kExtinction, kMetalMaterial, 1.0, {}, 0.25},
       {"paint.texels (base colour)", ParameterKind::kTextureTexels, kPaint, 1.0, {}, 0.25},
       {"sheen.texels (roughness)", ParameterKind::kTextureTexels, kSheen},
       {"glow.texels (emission)", ParameterKind::kTextureTexels, kGlow, 5.0}});
}

/// The slide is bright up to its border, so that no step makes a texel negative.
TEST(GradientMatrix, TexelsOfMetalAndOfASlide) {
  Scene scene = MatrixScene();
  const int alloy = static_cast<int>(scene.textures.size());
  scene.textures.push_back(tests::Pattern("alloy", 3, 3, 0.2, 0.8, true));
  scene.textures[kSlide] = tests::Pattern("slide", 6, 6, 0.2, 1.0);
  scene.materials[0].metallic_texture = alloy;
  CheckResting(
      scene,
      2e-2,
      {{"alloy.texels (metallic)", ParameterKind::kTextureTexels, alloy},
       {"slide.texels (projector)", ParameterKind::kTextureTexels, kSlide, 5.0, {}, 0.25}});
}

TEST(GradientMatrix, PowerOfLights) {
  CheckResting(MatrixScene(),
               5e-2,
               {{"sky.intensity", ParameterKind::kLightIntensity, kSky, 1.0, {}, 0.25},
                {"panel.intensity", ParameterKind::kLightIntensity, kPanelLight, 60.0, {}, 0.25},
                {"spot.intensity", ParameterKind::kLightIntensity, kSpot, 10.0, {}, 0.25},
                {"projector.intensity", ParameterKind::kLightIntensity, kProjector, 10.0, {}, 0.25},
                {"sun.intensity", ParameterKind::kLightIntensity, kSun, 1.0, {}, 0.25},
                {"lamp.intensity", ParameterKind::kLightIntensity, kLamp, 1.0, {}, 0.25},
                {"spot.angles", ParameterKind::kSpotAngles, kSpot, 0.2, {}, 0.25},
                {"sky.texels", ParameterKind::kEnvironmentTexels, kSky, 1.0, {}, 0.25},
                {"camera.exposure", ParameterKind::kExposure, 0, 1.0, {}, 0.25}});
}

std::vector<Case> Shapes() {
  return {{"ball.vertices",
           ParameterKind::kVertexPositions,
           kBall,
           0.4,
           {Term::kInterior, Term::kPrimary, Term::kDirect}},
          {"ball.normals", ParameterKind::kVertexNormals, kBall, 1.0, {Term::kInterior}},
          {"floor.uvs", ParameterKind::kUvs, kFloor, 1.0, {Term::kInterior}},
          {"box.translation",
           ParameterKind::kObjectTranslation,
           kBox,
           1.0,
           {Term::kPrimary, Term::kDirect}},
          {"box.rotation", ParameterKind::kObjectRotation, kBox, 1.0, {Term::kInterior}},
          {"box.scale", ParameterKind::kObjectScale, kBox, 1.0, {Term::kPrimary, Term::kDirect}},
          {"panel.vertices",
           ParameterKind::kVertexPositions,
           kPanel,
           1.0,
           {Term::kInterior, Term::kDirect}}};
}
std::vector<Case> Lights() {
  return {
      {"lamp.position",
       ParameterKind::kLightPosition,
       kLamp,
       1.0,
       {Term::kInterior, Term::kDirect},
       0.5},
      {"spot.position",
       ParameterKind::kLightPosition,
       kSpot,
       1.0,
       {Term::kInterior, Term::kDirect},
       0.6},
      {"projector.position",
       ParameterKind::kLightPosition,
       kProjector,
       1.0,
       {Term::kInterior, Term::kDirect},
       0.4},
      {"sky.rotation", ParameterKind::kLightRotation, kSky, 1.0, {Term::kInterior, Term::kDirect}},
      {"sun.rotation",
       ParameterKind::kLightRotation,
       kSun,
       1.0,
       {Term::kInterior, Term::kDirect},
       0.25},
      {"spot.rotation", ParameterKind::kLightRotation, kSpot, 1.0, {Term::kInterior}, 0.25},
      {"projector.rotation",
       ParameterKind::kLightRotation,
       kProjector,
       1.0,
       {Term::kInterior},
       0.25}};
}
std::vector<Case> Cameras() {
  return {
      {"camera.position", ParameterKind::kCameraPosition, 0, 0.5, {Term::kPrimary}, 0.35},
      {"camera.rotation", ParameterKind::kCameraRotation, 0, 0.2, {Term::kPrimary}, 0.35},
      {"camera.focal", ParameterKind::kFocal, 0, 5.0, {Term::kPrimary}, 0.35},
      {"camera.principal_point", ParameterKind::kPrincipalPoint, 0, 3.0, {Term::kPrimary}, 0.35},
      {"camera.distortion", ParameterKind::kRadialDistortion, 0, 1.0, {Term::kPrimary}, 0.35},
      {"camera.tangential", ParameterKind::kTangentialDistortion, 0, 0.3, {Term::kPrimary}, 0.35}};
}

TEST(GradientMatrix, Shapes) {
  for (const Case& c : Shapes()) CheckMoving(c, PixelFilter::Shape::kBox);
}
TEST(GradientMatrix, Lights) {
  for (const Case& c : Lights()) CheckMoving(c, PixelFilter::Shape::kBox);
}
TEST(GradientMatrix, Cameras) {
  for (const Case& c : Cameras()) CheckMoving(c, PixelFilter::Shape::kBox);
}
TEST(GradientMatrix, TentFilter) {
  for (Case c : {Shapes()[3], Cameras()[0], Cameras()[2]}) {
    c.share = 0.6;
    CheckMoving(c, PixelFilter::Shape::kTent);
  }
}

}  // namespace
}  // namespace pathfit::optim::gradient_matrix_test
