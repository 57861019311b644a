#include "tests/optim/diagnostics/gradient_cases.h"
#include "tests/optim/diagnostics/gradient_scenes.h"

// What lies around a scene out of its light and sight changes no derivative, however large it is,
// however it is tilted and wherever it stands.
namespace pathfit::optim::gradient_surroundings_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::ParameterLayout;
using renderer::Scene;
using renderer::Transform;
using renderer::Vec3;
using tests::ExpectedTerms;

constexpr int kTile = 8;

struct Place {
  const char* name;
  double floor;  ///< half width, units of the scene above it
  Transform world = {};
};
std::vector<Place> Places() {
  const Transform tilted{renderer::RotationFromVector({0.4, 0.3, -0.2}), {0, 0, 0}};
  const Transform away{tilted.linear, {200, -100, 150}};
  return {{"floor of 10", 10.0},
          {"floor of 100", 1e2},
          {"floor of 3000", 3e3},
          {"floor of 30000", 3e4},
          {"tilted floor of 3000", 3e3, tilted},
          {"tilted floor of 30000", 3e4, tilted},
          {"far from the origin", 10.0, away}};
}

/// The scene with a floor (mesh 0) of this size, moved as a whole.
Scene At(const Place& place, Scene scene) {
  scene.meshes[0].mesh = tests::Floor(place.floor);
  for (renderer::SceneMesh& m : scene.meshes) renderer::ApplyTransform(place.world, m.mesh);
  for (renderer::Emitter& e : scene.emitters) {
    if (auto* lamp = std::get_if<renderer::PointEmitter>(&e.light)) {
      lamp->position = place.world.Point(lamp->position);
    }
  }
  renderer::Camera& camera = scene.sensors[0];
  camera.world_from_camera = place.world * camera.world_from_camera;
  camera.rotation = place.world.linear * camera.rotation;
  return scene;
}

/// The derivative by a translation of `mesh` in every place against the difference in the first,
/// which is drawn once and sharper; the derivatives with a `share` of the usual samples.
void ExpectSameEverywhere(const std::string& name,
                          const Scene& scene,
                          int mesh,
                          const Vec3& rate,
                          int max_bounces,
                          double share,
                          double step,
                          const ExpectedTerms& terms) {
  const auto check = [&](const Place& place, const GradientCheckOptions& options) {
    const Scene there = At(place, scene);
    ParameterLayout layout(there);
    layout.Add(ParameterKind::kObjectTranslation, mesh);
    const Vec3 v = place.world.linear * rate;
    return CheckGradient(there, there.sensors[0], -1, layout, {v.x, v.y, v.z}, options);
  };
  GradientCheckOptions options = tests::OptionsForMotion(DerivativeForm::kImage, max_bounces);
  options.render.spp = 1;
  options.render.terms = {Term::kInterior};
  options.difference_spp *= 5;
  options.step = step;
  const GradientCheckResult difference = check(Places().front(), options);
  for (const Place& place : Places()) {
    for (const DerivativeForm form : {DerivativeForm::kImage, DerivativeForm::kMaterial}) {
      options = tests::Share(tests::OptionsForMotion(form, max_bounces), share);
      options.difference_spp = 1;
      options.render.seed = 1000;
      tests::ExpectRightDerivative(tests::InForm(name + ", " + place.name, form),
                                   tests::Against(difference, check(place, options)),
                                   terms,
                                   kTile);
    }
  }
}

TEST(Surroundings, BoxOnAFloor) {
  ExpectSameEverywhere(
      "box",
      tests::AboveUnderPanel(tests::Placed(tests::Cube(), 0.4, {0, 0.4, 0}, {0, 0.5, 0})),
      1,
      {0.7, 0.0, 0.5},
      1,
      0.5,
      2.5e-3,
      {Term::kPrimary, Term::kDirect});
}

/// Large things move under small ones.
TEST(Surroundings, FloorUnderABox) {
  ExpectSameEverywhere(
      "floor",
      tests::AboveUnderPanel(tests::Placed(tests::Cube(), 0.4, {0, 0.9, 0}, {0.2, 0.5, 0.1})),
      0,
      {0.1, 0.8, 0.2},
      1,
      0.5,
      1e-3,
      {Term::kInterior, Term::kDirect});
}

/// Two plates close to each other, the upper one of which slides: by less than the gap.
TEST(Surroundings, PlatesAboveAFloor) {
  Scene scene = tests::AboveUnderPanel(tests::Floor(0.5, 0.502));
  scene.meshes.push_back({"lower", tests::Placed(tests::Floor(0.6), 1.0, {0.1, 0.5, 0.0}), 0, {}});
  ExpectSameEverywhere(
      "plates", scene, 1, {0.7, 0.0, 0.5}, 1, 0.75, 5e-4, {Term::kPrimary, Term::kDirect});
}

/// A floor that is small against the thing above it, from which it is lit and seen: nothing may be
/// judged by the size of the smaller one. Each picture is another, so each has its own difference.
TEST(Surroundings, BoxOverASmallFloor) {
  const Scene scene =
      tests::AboveUnderPanel(tests::Placed(tests::Cube(), 0.4, {0.1, 0.9, 0}, {0.2, 0.5, 0.1}));
  for (const Place& place :
       {Place{"floor of 0.001", 1e-3}, Place{"floor of 0.1", 1e-1}, Place{"floor of 1", 1.0}}) {
    const Scene there = At(place, scene);
    ParameterLayout layout(there);
    layout.Add(ParameterKind::kObjectTranslation, 1);
    ExpectedTerms terms = {Term::kPrimary};
    if (place.floor == 1.0) terms.push_back(Term::kDirect);
    tests::CheckInBothForms(
        there,
        -1,
        layout,
        {0.7, 0.0, 0.5},
        [](DerivativeForm form) { return tests::OptionsForMotion(form, 1); },
        [&](const GradientCheckResult& result, DerivativeForm form) {
          tests::ExpectRightDerivative(
              tests::InForm(std::string("box, ") + place.name, form), result, terms, kTile);
        });
  }
}

}  // namespace
}  // namespace pathfit::optim::gradient_surroundings_test
