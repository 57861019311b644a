#include "renderer/derivative/derivative_limits.h"
#include "tests/optim/diagnostics/gradient_cases.h"
#include "tests/optim/diagnostics/gradient_scenes.h"

// Things that touch each other while they move: what one covers of the other loses its light, and
// segments between them become as short as can be.
namespace pathfit::optim::gradient_contacts_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::ParameterLayout;
using renderer::Scene;
using renderer::Vec3;
using tests::ExpectedTerms;

// Errors at a contact reach far: large tiles see them before small ones do.
constexpr int kTile = 8;

/// In both forms, a translation of mesh 1.
void ExpectRightTranslation(const std::string& name,
                            const Scene& scene,
                            const Vec3& rate,
                            int max_bounces,
                            int spp_factor,
                            const ExpectedTerms& terms,
                            int replicates_factor = 1) {
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectTranslation, 1);
  tests::CheckInBothForms(
      scene,
      -1,
      layout,
      {rate.x, rate.y, rate.z},
      [&](DerivativeForm form) {
        GradientCheckOptions options = tests::OptionsForMotion(form, max_bounces);
        options.render.spp *= spp_factor;
        options.replicates *= replicates_factor;
        return options;
      },
      [&](const GradientCheckResult& result, DerivativeForm form) {
        tests::ExpectRightDerivative(tests::InForm(name, form), result, terms, kTile);
      });
}

Mesh StandingBox(const Vec3& at = {0, 0.4, 0}) {
  return tests::Placed(tests::Cube(), 0.4, at, {0, 0.5, 0});
}
/// With a wall behind the thing, which sees what the camera does not.
void AddBackWall(Scene& scene) {
  scene.meshes.push_back(
      {"wall", tests::Placed(renderer::MakeRectangle(), 2.0, {0, 1, -1.2}), 0, {}});
}

TEST(Contacts, BoxSlidesOverAFloor) {
  ExpectRightTranslation("standing box",
                         tests::AboveUnderPanel(StandingBox()),
                         {0.7, 0.0, 0.5},
                         1,
                         1,
                         {Term::kPrimary, Term::kDirect});
}

TEST(Contacts, BoxAndFloorLightEachOther) {
  ExpectRightTranslation("standing box, two bounces",
                         tests::AboveUnderPanel(StandingBox()),
                         {0.7, 0.0, 0.5},
                         2,
                         2,
                         {Term::kInterior, Term::kPrimary, Term::kDirect},
                         2);
}

/// Light from the floor reaches the camera by the wall: only the indirect term knows that the box
/// covers more of it.
TEST(Contacts, WallSeesTheFloorGetCovered) {
  Scene scene = tests::AboveUnderPanel(StandingBox());
  scene.materials[1].base_color = {0.0, 0.0, 0.0};
  AddBackWall(scene);
  ExpectRightTranslation("standing black box and wall",
                         scene,
                         {0.3, 0.0, 0.9},
                         2,
                         1,
                         {Term::kPrimary, Term::kDirect, Term::kIndirect});
}

TEST(Contacts, LampStandsOnTheFloor) {
  Scene scene = tests::Above(StandingBox());
  scene.materials[1].base_color = {0.0, 0.0, 0.0};
  scene.emitters[0] = tests::Panel(1, {2, 2, 2});
  scene.meshes.push_back(
      {"post", tests::Placed(tests::Cube(), 0.15, {0.7, 0.3, 0.5}, {0.1, 0.2, 0.3}), 0, {}});
  ExpectRightTranslation(
      "standing lamp", scene, {0.7, 0.0, 0.5}, 1, 2, {Term::kInterior, Term::kPrimary});
}

/// Its edges touch two surfaces at once.
TEST(Contacts, BoxSlidesAlongACorner) {
  Mesh box = tests::Placed(tests::Cube(), 0.4, {0.0, 0.4, -0.8});
  Scene scene = tests::AboveUnderPanel(box);
  AddBackWall(scene);
  ExpectRightTranslation("box in a corner",
                         scene,
                         {1.0, 0.0, 0.0},
                         2,
                         2,
                         {Term::kInterior, Term::kPrimary, Term::kDirect});
}

/// The line in which two meshes cut each other is no edge of either: no term moves it.
TEST(Contacts, BoxInTheFloor) {
  const Scene scene = tests::Above(tests::Placed(tests::Cube(), 0.4, {0, 0.1, 0}, {0.3, 0.6, 0.2}));
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectTranslation, 1);
  tests::ExpectLimit("sunk box rises",
                     scene,
                     layout,
                     {0.0, 1.0, 0.0},
                     tests::OptionsForMotion(DerivativeForm::kImage, 1));
}

}  // namespace
}  // namespace pathfit::optim::gradient_contacts_test
