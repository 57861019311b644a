#include "tests/optim/diagnostics/gradient_cases.h"
#include "tests/optim/diagnostics/gradient_scenes.h"

// Lights that are off in a view: neither its image nor a term of its derivative knows of them.
namespace pathfit::optim::gradient_switched_lights_test {
namespace {

using renderer::ParameterKind;
using renderer::Scene;

constexpr int kLamp = 0, kPanel = 1, kSecondPanel = 2;

/// A cube above a floor, under a point light and two panels.
Scene ThreeLamps() {
  Scene scene =
      tests::AboveUnderPanel(tests::Placed(tests::Cube(), 0.35, {0.1, 0.75, 0.0}, {0.3, 0.6, 0.2}));
  scene.meshes.push_back({"second panel", tests::Ceiling(0.4, {-1.6, 2.0, 0.8}), 2, {}});
  scene.emitters.push_back(tests::Panel(3, {6, 8, 7}));
  return scene;
}

GradientCheckOptions Options() {
  GradientCheckOptions options = tests::OptionsForMotion(renderer::DerivativeForm::kImage, 1);
  options.render.spp_direct = 96.0;
  return options;
}

GradientCheckResult Rise(const Scene& scene, const GradientCheckOptions& options) {
  renderer::ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectTranslation, 1);
  return CheckGradient(scene, scene.sensors[0], -1, layout, {0.3, 1.0, 0.4}, options);
}

TEST(SwitchedLights, MovingThingUnderThoseThatShine) {
  for (const std::vector<int>& off :
       {std::vector<int>{kLamp}, {kPanel}, {kLamp, kSecondPanel}, {kPanel, kSecondPanel}}) {
    Scene scene = ThreeLamps();
    scene.sensors[0].lights_off = off;
    GradientCheckOptions options = Options();
    options.difference_spp = 192;
    const GradientCheckResult result = Rise(scene, options);
    const std::string name =
        "cube, " + std::to_string(off.size()) + " off, first " + std::to_string(off.front());
    tests::ExpectRightDerivative(name, result, {Term::kInterior, Term::kPrimary, Term::kDirect});
    // What all lights together do is found out.
    scene.sensors[0].lights_off.clear();
    GradientCheckResult mutant = result;
    options.difference_spp = 1;
    mutant.terms = Rise(scene, options).terms;
    EXPECT_FALSE(tests::Accepts(Compare(mutant, tests::kTile))) << name;
  }
}

TEST(SwitchedLights, PlacesOfThoseThatShine) {
  Scene scene = ThreeLamps();
  scene.sensors[0].lights_off = {kPanel};
  tests::CheckKind("lamp position, panel off",
                   scene,
                   ParameterKind::kLightPosition,
                   kLamp,
                   Options(),
                   1.0,
                   {Term::kInterior, Term::kDirect});
  scene.sensors[0].lights_off = {kLamp};
  tests::CheckKind("panel vertices, lamp off",
                   scene,
                   ParameterKind::kVertexPositions,
                   2,
                   Options(),
                   1.0,
                   {Term::kInterior, Term::kDirect});
}

}  // namespace
}  // namespace pathfit::optim::gradient_switched_lights_test
