#include <string>
#include <vector>

#include "tests/optim/diagnostics/gradient_cases.h"
#include "tests/optim/diagnostics/gradient_scenes.h"

// The narrowest lobes, and those of both distributions, against central differences.
namespace pathfit::optim::gradient_gloss_test {
namespace {

using renderer::DerivativeForm;
using renderer::MicrofacetDistribution;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using tests::ExpectedTerms;

constexpr auto kGgx = MicrofacetDistribution::kGgx;
constexpr auto kBeckmann = MicrofacetDistribution::kBeckmann;
constexpr Rgb kEta{0.4, 0.9, 1.2}, kK{2.5, 2.0, 1.5};

struct Case {
  const char* name;
  ParameterKind kind;
  int object;
  double scale;  ///< largest entry of the direction
};

std::string Name(const Case& c, MicrofacetDistribution distribution, DerivativeForm form) {
  return std::string(c.name) + (distribution == kBeckmann ? ", beckmann" : ", ggx") +
         (form == DerivativeForm::kImage ? "" : ", material");
}

/// The highlight of a lamp on a metal plate, as wide as the picture: no noise but that of pixels.
Scene Highlight(const renderer::Bsdf& bsdf, double alpha) {
  Scene scene;
  scene.materials = {{"metal", bsdf, {0.9, 0.8, 0.7}}};
  scene.meshes = {{"plate", tests::Plate(1.0, 1.0, 0.0), 0, {}}};
  scene.emitters = {tests::Lamp({0.6, 0.2, 1.5}, {3, 4, 5})};
  scene.emitters.push_back(tests::Lamp({0.6, 0.2 + 2.0 * alpha, 1.5}, {1, 1, 1}));
  scene.emitters.back().name = "other";
  // Mirror images of each other about the middle of the picture.
  scene.sensors = {tests::CameraAt({-0.6, -0.2, 1.5}, {0, 0, 0}, 4.0 / alpha, 16, 16)};
  return scene;
}

void CheckHighlight(MicrofacetDistribution distribution,
                    double roughness,
                    DerivativeForm form,
                    const std::vector<Case>& cases) {
  const Scene scene = Highlight(renderer::RoughConductorBsdf{roughness, kEta, kK, distribution},
                                roughness * roughness);
  for (const Case& c : cases) {
    GradientCheckOptions options;
    options.replicates = 32;
    options.render.spp = 32;
    options.difference_spp = 128;
    options.render.spp_pixel = 64.0;
    options.render.form = form;
    options.step = 1e-3;  // the differences are sharper than 1e-4
    tests::CheckKind(
        Name(c, distribution, form), scene, c.kind, c.object, options, c.scale, {Term::kInterior});
  }
}

std::vector<Case> CasesOfHighlight(double roughness) {
  const double alpha = roughness * roughness;
  return {{"metal.roughness", ParameterKind::kRoughness, 0, roughness},
          {"metal.eta", ParameterKind::kEta, 0, 1.0},
          {"plate.rotation", ParameterKind::kObjectRotation, 0, alpha},
          {"plate.vertices", ParameterKind::kVertexPositions, 0, alpha},
          {"lamp.position", ParameterKind::kLightPosition, 0, alpha},
          {"camera.position", ParameterKind::kCameraPosition, 0, alpha}};
}

class HighlightInBothForms : public ::testing::TestWithParam<DerivativeForm> {};

TEST_P(HighlightInBothForms, OfTheLeastRoughness) {
  CheckHighlight(kGgx, renderer::kMinRoughness, GetParam(), CasesOfHighlight(0.03));
}
TEST_P(HighlightInBothForms, OfBeckmann) {
  CheckHighlight(kBeckmann, renderer::kMinRoughness, GetParam(), CasesOfHighlight(0.03));
  CheckHighlight(kBeckmann, 0.4, GetParam(), CasesOfHighlight(0.4));
}

INSTANTIATE_TEST_SUITE_P(GradientGloss,
                         HighlightInBothForms,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

/// A thing in a sky: directions are drawn from the lobe. The noise of one path grows as 1 / alpha.
Scene Reflection(const renderer::Mesh& mesh, const renderer::Bsdf& bsdf) {
  Scene scene;
  scene.materials = {{"thing", bsdf, {0.9, 0.8, 0.7}}};
  scene.meshes = {{"thing", mesh, 0, {}}};
  scene.emitters = {tests::GradientEnvironment(8, 4)};
  scene.sensors = {tests::CameraAt({0.2, 0.3, 4}, {0, 0, 0}, 32.0, 16, 16)};
  return scene;
}

void CheckReflection(const Scene& scene,
                     MicrofacetDistribution distribution,
                     DerivativeForm form,
                     int spp,
                     const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    GradientCheckOptions options = tests::OptionsForMotion(form, 1);
    options.render.spp = spp;
    options.render.antithetic = true;
    options.difference_spp = 256;
    options.step = 1e-2;
    constexpr double kMinSignal = 4.0;
    tests::CheckKind(Name(c, distribution, form),
                     scene,
                     c.kind,
                     c.object,
                     options,
                     c.scale,
                     {Term::kInterior},
                     tests::kTile,
                     kMinSignal);
  }
}

/// Smooth and flat: of the flat one no triangle's horizon cuts the lobe.
renderer::Mesh Smooth() { return tests::Ball(0.8, {0, 0, 0}, true, 2); }
renderer::Mesh Flat() { return tests::Ball(0.8, {0, 0, 0}, false, 1); }

const std::vector<Case> kNormals = {{"ball.normals", ParameterKind::kVertexNormals, 0, 1.0}};
const std::vector<Case> kMoves = {{"ball.rotation", ParameterKind::kObjectRotation, 0, 1.0},
                                  {"ball.vertices", ParameterKind::kVertexPositions, 0, 0.4}};

TEST(GradientGloss, ReflectionOfTheLeastRoughness) {
  const renderer::RoughConductorBsdf metal{renderer::kMinRoughness, kEta, kK};
  CheckReflection(Reflection(Smooth(), metal), kGgx, DerivativeForm::kImage, 768, kNormals);
  CheckReflection(Reflection(Flat(), metal), kGgx, DerivativeForm::kImage, 768, kMoves);
  CheckReflection(Reflection(Flat(), metal), kGgx, DerivativeForm::kMaterial, 768, kMoves);
}

TEST(GradientGloss, ReflectionOfBeckmann) {
  const renderer::RoughConductorBsdf metal{0.3, kEta, kK, kBeckmann};
  CheckReflection(Reflection(Smooth(), metal), kBeckmann, DerivativeForm::kImage, 128, kNormals);
  CheckReflection(Reflection(Flat(), metal), kBeckmann, DerivativeForm::kImage, 128, kMoves);
  CheckReflection(Reflection(Flat(), metal), kBeckmann, DerivativeForm::kMaterial, 128, kMoves);
}

/// The sky through the surface of a block of rough glass, seen obliquely: what is let through,
/// whose lobe ends smoothly.
TEST(GradientGloss, RefractionOfBeckmann) {
  const Scene scene =
      Reflection(tests::Placed(tests::Plate(0.7, 0.6, 0.0), 1.0, {0, 0, 0}, {0.5, 0.7, 0.1}),
                 renderer::RoughDielectricBsdf{0.5, 1.5, kBeckmann});
  for (const DerivativeForm form : {DerivativeForm::kImage, DerivativeForm::kMaterial}) {
    CheckReflection(scene,
                    kBeckmann,
                    form,
                    256,
                    {{"glass.eta", ParameterKind::kEta, 0, 1.0},
                     {"pane.rotation", ParameterKind::kObjectRotation, 0, 1.0}});
  }
}

}  // namespace
}  // namespace pathfit::optim::gradient_gloss_test
