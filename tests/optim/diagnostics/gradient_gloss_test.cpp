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
using tests::OptionsOfForm;

constexpr auto kGgx = MicrofacetDistribution::kGgx;
constexpr auto kBeckmann = MicrofacetDistribution::kBeckmann;
constexpr Rgb kEta{0.4, 0.9, 1.2}, kK{2.5, 2.0, 1.5};

struct Case {
  const char* name;
  ParameterKind kind;
  int object;
  double scale;  ///< largest entry of the direction
};

std::string Name(const Case& c, MicrofacetDistribution distribution) {
  return std::string(c.name) + (distribution == kBeckmann ? ", beckmann" : ", ggx");
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
                    const std::vector<Case>& cases) {
  const Scene scene = Highlight(renderer::RoughConductorBsdf{roughness, kEta, kK, distribution},
                                roughness * roughness);
  const auto options_of = [](DerivativeForm form) {
    GradientCheckOptions options;
    options.replicates = 32;
    options.render.spp = 8;
    options.difference_spp = 32;
    options.render.spp_pixel = 16.0;
    options.render.form = form;
    options.step = 1e-3;  // the differences are sharper than 1e-4
    return options;
  };
  for (const Case& c : cases) {
    tests::CheckKindInBothForms(
        Name(c, distribution), scene, c.kind, c.object, options_of, c.scale, {Term::kInterior});
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

TEST(GradientGloss, HighlightOfTheLeastRoughness) {
  CheckHighlight(kGgx, renderer::kMinRoughness, CasesOfHighlight(0.03));
}
TEST(GradientGloss, HighlightOfBeckmann) {
  CheckHighlight(kBeckmann, renderer::kMinRoughness, CasesOfHighlight(0.03));
  CheckHighlight(kBeckmann, 0.4, CasesOfHighlight(0.4));
}

/// A thing in a sky: directions are drawn from the lobe. The noise of one path grows as 1 / alpha.
Scene Reflection(const renderer::Mesh& mesh, const renderer::Bsdf& bsdf) {
  Scene scene;
  scene.materials = {{"thing", bsdf, {0.9, 0.8, 0.7}}};
  scene.meshes = {{"thing", mesh, 0, {}}};
  scene.emitters = {tests::GradientEnvironment(8, 4)};
  scene.sensors = {tests::CameraAt({0.2, 0.3, 4}, {0, 0, 0}, 32.0, 16, 16)};
  return scene;
}

OptionsOfForm ReflectionOptions(int spp) {
  return [spp](DerivativeForm form) {
    GradientCheckOptions options = tests::OptionsForMotion(form, 1);
    options.render.spp = spp;
    options.render.antithetic = true;
    options.difference_spp = 256;
    options.step = 1e-2;
    return options;
  };
}
constexpr double kMinSignal = 4.0;

void CheckReflection(const Scene& scene,
                     MicrofacetDistribution distribution,
                     int spp,
                     const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    tests::CheckKindInBothForms(Name(c, distribution),
                                scene,
                                c.kind,
                                c.object,
                                ReflectionOptions(spp),
                                c.scale,
                                {Term::kInterior},
                                kMinSignal);
  }
}
/// Of a mesh that rests, whose forms are the same.
void CheckNormals(const Scene& scene, MicrofacetDistribution distribution, int spp) {
  const Case c{"ball.normals", ParameterKind::kVertexNormals, 0, 1.0};
  tests::CheckKind(Name(c, distribution),
                   scene,
                   c.kind,
                   c.object,
                   ReflectionOptions(spp)(DerivativeForm::kImage),
                   c.scale,
                   {Term::kInterior},
                   tests::kTile,
                   kMinSignal);
}

/// Smooth and flat: of the flat one no triangle's horizon cuts the lobe.
renderer::Mesh Smooth() { return tests::Ball(0.8, {0, 0, 0}, true, 2); }
renderer::Mesh Flat() { return tests::Ball(0.8, {0, 0, 0}, false, 1); }

const std::vector<Case> kMoves = {{"ball.rotation", ParameterKind::kObjectRotation, 0, 1.0},
                                  {"ball.vertices", ParameterKind::kVertexPositions, 0, 0.4}};

TEST(GradientGloss, ReflectionOfTheLeastRoughness) {
  const renderer::RoughConductorBsdf metal{renderer::kMinRoughness, kEta, kK};
  CheckNormals(Reflection(Smooth(), metal), kGgx, 768);
  CheckReflection(Reflection(Flat(), metal), kGgx, 384, kMoves);
}

TEST(GradientGloss, ReflectionOfBeckmann) {
  const renderer::RoughConductorBsdf metal{0.3, kEta, kK, kBeckmann};
  CheckNormals(Reflection(Smooth(), metal), kBeckmann, 128);
  CheckReflection(Reflection(Flat(), metal), kBeckmann, 128, kMoves);
}

/// The sky through the surface of a block of rough glass, seen obliquely: what is let through,
/// whose lobe ends smoothly.
TEST(GradientGloss, RefractionOfBeckmann) {
  const Scene scene =
      Reflection(tests::Placed(tests::Plate(0.7, 0.6, 0.0), 1.0, {0, 0, 0}, {0.5, 0.7, 0.1}),
                 renderer::RoughDielectricBsdf{0.5, 1.5, kBeckmann});
  CheckReflection(scene,
                  kBeckmann,
                  64,
                  {{"glass.eta", ParameterKind::kEta, 0, 1.0},
                   {"pane.rotation", ParameterKind::kObjectRotation, 0, 1.0}});
}

}  // namespace
}  // namespace pathfit::optim::gradient_gloss_test
