#include "tests/optim/diagnostics/gradient_cases.h"
#include "tests/optim/diagnostics/gradient_scenes.h"

// Light that is reflected more than twice: a path with several segments that can graze an edge is
// counted once for each of them, up to its last reflection.
namespace pathfit::optim::gradient_bounces_test {
namespace {

using renderer::DerivativeForm;
using renderer::ParameterKind;
using renderer::ParameterLayout;
using renderer::Scene;
using renderer::Vec3;
using tests::ExpectedTerms;

constexpr int kBounces = 4;

/// A bright closed room with a lamp; a block (mesh 1) floats in it.
Scene Room(const Vec3& eye, const Vec3& target, double focal) {
  Scene scene;
  scene.materials = {{"room", renderer::LambertBsdf{}, {0.8, 0.7, 0.75}},
                     {"block", renderer::LambertBsdf{}, {0.6, 0.7, 0.8}}};
  const auto block = tests::Placed(tests::Cube(), 0.35, {0.2, -0.35, -0.3}, {0.3, 0.6, 0.2});
  scene.meshes = {{"room", tests::Inverted(tests::Cube()), 0, {}}, {"block", block, 1, {}}};
  scene.emitters = {tests::Lamp({-0.3, 0.7, 0.2}, {0.9, 0.8, 0.7})};
  scene.sensors = {tests::CameraAt(eye, target, focal, 4, 4)};
  scene.sensors[0].rotation = {0.0, 0.0, 0.2};
  return scene;
}

/// The block rises. The step is large: little light changes sides of an edge, and what is reflected
/// often is smooth.
GradientCheckResult Rise(const Scene& scene, DerivativeForm form, int max_bounces, double step) {
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectTranslation, 1);
  GradientCheckOptions options = tests::OptionsForMotion(form, max_bounces);
  options.render.spp = 256;
  options.difference_spp = 2560;
  options.render.sppe = options.render.spp_pixel = 128.0;
  options.render.spp_direct = 256.0;
  options.render.spp_indirect = 768.0;
  options.step = step;
  if (max_bounces < kBounces) {  // of a mutant
    options.render.terms = {renderer::DerivativeTerm::kDirect, renderer::DerivativeTerm::kIndirect};
    options.difference_spp = 1;
  }
  return CheckGradient(scene, scene.sensors[0], -1, layout, {0.2, 1.0, 0.3}, options);
}

void ExpectRightRise(const std::string& name,
                     const Scene& scene,
                     DerivativeForm form,
                     double step,
                     int tile,
                     const ExpectedTerms& terms) {
  const GradientCheckResult result = Rise(scene, form, kBounces, step);
  tests::ExpectRightDerivative(name, result, terms, tile);
  // Edges that know of one reflection less are found out.
  const GradientCheckResult shorter = Rise(scene, form, kBounces - 1, step);
  GradientCheckResult mutant = result;
  for (const Term term : {Term::kDirect, Term::kIndirect}) {
    mutant.terms[static_cast<std::size_t>(term)] = shorter[term];
  }
  const GradientComparison c = Compare(mutant, tile);
  std::printf("%-34s z_rms %5.2f\n", "  with one reflection less", c.z_rms);
  EXPECT_FALSE(tests::Accepts(c)) << name;
}

/// The camera sees the ceiling only: all is interreflection, and the forms are the same.
TEST(Bounces, BlockBelowTheView) {
  ExpectRightRise("room, ceiling",
                  Room({0.3, 0.3, 0.8}, {-0.2, 1.0, -0.3}, 6.0),
                  DerivativeForm::kImage,
                  4e-2,
                  4,
                  {Term::kInterior, Term::kDirect, Term::kIndirect});
}

class BouncesInBothForms : public ::testing::TestWithParam<DerivativeForm> {};

TEST_P(BouncesInBothForms, BlockInTheView) {
  ExpectRightRise(GetParam() == DerivativeForm::kImage ? "room, image" : "room, material",
                  Room({0.3, 0.5, 0.8}, {0.0, -0.3, -0.4}, 2.75),
                  GetParam(),
                  1e-2,
                  2,
                  {Term::kInterior, Term::kPrimary, Term::kDirect, Term::kIndirect});
}

INSTANTIATE_TEST_SUITE_P(Bounces,
                         BouncesInBothForms,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

}  // namespace
}  // namespace pathfit::optim::gradient_bounces_test
