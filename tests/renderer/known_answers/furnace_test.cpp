#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/renderer/known_answers/known_answer.h"

// Path_space 6.3, C16 and C18: closed rooms in which the radiance is the same everywhere, so that
// no motion changes anything and the terms of the derivative cancel.
namespace pathfit::tests::furnace_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::Rgb;

constexpr int kReplicates = 20;
constexpr double kEmitted = 0.5;
constexpr double kAlbedo = 0.7;

void Flip(Mesh& mesh) {
  for (renderer::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

/// A room whose walls (mesh 0) shine and reflect. The sensor inside sees one of them: in image form
/// points slide over their surface, and next to a concave corner the interior's variance is
/// infinite.
renderer::Scene Furnace() {
  renderer::Scene scene;
  scene.materials = {{"wall", renderer::LambertBsdf{}, Rgb::Constant(kAlbedo)}};
  Mesh room = Cube();
  Flip(room);
  for (Vec3& p : room.positions) p += Vec3{0.1 * p.y * p.z, 0.05 * p.x, 0.2 * p.x * p.y};
  scene.meshes = {{"room", room, 0, {}}};
  scene.sensors = {CameraAt({0.7, -0.1, 0.0}, {-0.9, -0.2, -0.1}, 1.3, 1, 1)};
  return scene;
}
void Shine(renderer::Scene& scene, int mesh) {
  renderer::AreaEmitter light;
  light.mesh = mesh;
  light.intensity = Rgb::Constant(kEmitted);
  scene.emitters.push_back({"glow", renderer::LightFrame::kWorld, {}, light});
}
/// A tilted box before the wall that the sensor sees.
const Vec3 kBlockCentre{-0.55, -0.15, -0.05};
Mesh Block() {
  Mesh mesh = Cube();
  for (Vec3& p : mesh.positions) p = p * 0.2;
  renderer::ApplyTransform({renderer::RotationFromVector({0.4, 0.3, 0.5}), kBlockCentre}, mesh);
  return mesh;
}

renderer::RenderOptions Options(DerivativeForm form, int bounces) {
  renderer::RenderOptions options;
  options.max_bounces = bounces;
  options.rr_depth = 100;
  options.form = form;
  options.spp = 8192;
  options.sppe = 4096;
  options.spp_direct = options.spp_indirect = 8192;
  options.spp_pixel = 8192;
  return options;
}

/// Zero, although its terms are not: a term left out or with the wrong sign would show.
void ExpectCancels(const std::string& name, const TermReplicates& found) {
  constexpr double kScale = 0.3;  // radiance times motion per size of the room
  ExpectKnown(name, found.Total(), {0.0, kScale});
  const double error = EstimateMean(found.Total()).error;
  for (std::size_t t = 0; t < kNumTerms; ++t) {
    if (std::abs(EstimateMean(found.terms[t]).mean) <= 10.0 * error) continue;
    for (const double factor : {0.0, -1.0}) {
      std::array<double, kNumTerms> mutant{1, 1, 1, 1, 1};
      mutant[t] = factor;
      const MeanAndError wrong = EstimateMean(found.Total(mutant));
      EXPECT_GT(std::abs(wrong.mean), 4.0 * wrong.error)
          << name << ", term " << t << " times " << factor;
    }
  }
}

TEST(Furnace, C16RadianceAndItsDerivativeByAlbedo) {
  renderer::Scene scene = Furnace();
  Shine(scene, 0);
  const renderer::Renderer renderer(scene);
  for (const int bounces : {0, 1, 2, 5, 60}) {
    const C16Answer c16 = C16Furnace(kEmitted, kAlbedo, bounces);
    renderer::RenderOptions options = Options(DerivativeForm::kImage, bounces);
    options.spp = 1024;
    const std::string name = "_" + std::to_string(bounces);
    ExpectKnown("L" + name,
                Channel(PrimalReplicates(renderer, scene.sensors[0], options, kReplicates), 0),
                {c16.value});
    const Motion albedo = Motion(scene).Add(ParameterKind::kBaseColor, 0, Vec3{1, 1, 1});
    ExpectKnown("dL/drho" + name,
                DerivativeByTerm(renderer, scene.sensors[0], albedo, options, kReplicates).Total(),
                {c16.d_albedo, 0.1});
  }
}

class FurnaceForms : public ::testing::TestWithParam<DerivativeForm> {};

TEST_P(FurnaceForms, C16NoMotionOfTheWallsMatters) {
  renderer::Scene scene = Furnace();
  Shine(scene, 0);
  const renderer::Renderer renderer(scene);
  for (const int bounces : {1, 2}) {
    ExpectCancels(
        "dL_" + std::to_string(bounces),
        DerivativeByTerm(
            renderer,
            scene.sensors[0],
            Motion(scene).Vertices(
                0,
                [](const Vec3& p) {
                  return Vec3{0.5 * p.x + 0.2 * p.y * p.z, 0.3 * p.x, 0.4 * p.x * p.y - 0.3};
                }),
            Options(GetParam(), bounces),
            kReplicates));
  }
}

TEST_P(FurnaceForms, C16NorOfAnOccluderThatIsAsBright) {
  renderer::Scene scene = Furnace();
  scene.meshes.push_back({"block", Block(), 0, {}});
  scene.meshes[1].pose.pivot = kBlockCentre;
  Shine(scene, 0);
  Shine(scene, 1);
  const renderer::Renderer renderer(scene);
  const auto expect = [&](const std::string& name, const Motion& motion, int bounces) {
    renderer::RenderOptions options = Options(GetParam(), bounces);
    if (name == "dL_camera_2") {  // visible points slide: noisier
      options.spp *= 4;
      options.spp_direct *= 4;
    }
    ExpectCancels(name, DerivativeByTerm(renderer, scene.sensors[0], motion, options, kReplicates));
  };
  const Motion pose = Motion(scene)
                          .Add(ParameterKind::kObjectTranslation, 1, Vec3{0.4, 0.3, -0.2})
                          .Add(ParameterKind::kObjectRotation, 1, Vec3{0.5, -0.3, 0.8})
                          .Add(ParameterKind::kObjectScale, 1, std::vector{0.5});
  expect("dL_block_1", pose, 1);
  expect("dL_block_2", pose, 2);
  expect("dL_corner_2",
         Motion(scene).Vertices(
             1,
             [&](const Vec3& p) {
               return p == scene.meshes[1].mesh.positions[3] ? Vec3{0.8, 0.5, -0.6} : Vec3{};
             }),
         2);
  expect("dL_camera_2",
         Motion(scene)
             .Add(ParameterKind::kCameraPosition, 0, Vec3{0.3, -0.2, 0.4})
             .Add(ParameterKind::kCameraRotation, 0, Vec3{0.2, 0.4, -0.1}),
         2);
}

INSTANTIATE_TEST_SUITE_P(PathSpace63,
                         FurnaceForms,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

TEST(Furnace, C18IntegratingSphere) {
  // One sphere in two meshes: the cap shines and is black, the rest is white.
  const Mesh sphere = renderer::MakeIcosphere(3, 1.0);
  std::array<Mesh, 2> parts;
  std::array<double, 2> areas{};
  for (const renderer::Triangle& t : sphere.triangles) {
    const auto at = [&](std::size_t i) { return sphere.positions[static_cast<std::size_t>(t[i])]; };
    const std::size_t part = (at(0) + at(1) + at(2)).z > 3.0 * 0.8 ? 1 : 0;
    areas[part] += 0.5 * Norm(Cross(at(1) - at(0), at(2) - at(0)));
    parts[part].triangles.push_back({t[0], t[2], t[1]});
  }
  for (Mesh& part : parts) {
    part.positions = sphere.positions;
    renderer::WeldPositions(part);
  }
  const double albedo = 0.8;
  const C18Answer c18 = C18IntegratingSphere(areas[1] / (areas[0] + areas[1]), albedo);
  renderer::Scene scene;
  scene.materials = {{"white", renderer::LambertBsdf{}, Rgb::Constant(albedo)},
                     {"black", renderer::LambertBsdf{}, Rgb{}}};
  scene.meshes = {{"wall", parts[0], 0, {}}, {"cap", parts[1], 1, {}}};
  renderer::AreaEmitter light;
  light.mesh = 1;
  scene.emitters = {{"cap", renderer::LightFrame::kWorld, {}, light}};
  scene.sensors = {CameraAt({0, 0, 0}, {0.5, 0.2, -0.7}, 1.0, 1, 1)};
  const renderer::Renderer renderer(scene);
  renderer::RenderOptions options = Options(DerivativeForm::kImage, 64);
  options.rr_depth = 12;
  options.spp = 1024;
  options.spp_direct = options.spp_indirect = 1024;  // no edge hides anything
  constexpr double kMesh = 0.01;                     // flat faces do not light themselves
  const double reflected = albedo / std::numbers::pi;
  ExpectKnown("L",
              Channel(PrimalReplicates(renderer, scene.sensors[0], options, kReplicates), 0),
              {reflected * c18.value, 0.0, kMesh});
  const auto derivative = [&](const Motion& motion) {
    return DerivativeByTerm(renderer, scene.sensors[0], motion, options, kReplicates).Total();
  };
  ExpectKnown("dL/drho",
              derivative(Motion(scene).Add(ParameterKind::kBaseColor, 0, Vec3{1, 1, 1})),
              {reflected * c18.d_albedo + c18.value / std::numbers::pi, 0.0, kMesh});
  ExpectKnown("dL/dradius",
              derivative(Motion(scene)
                             .Add(ParameterKind::kObjectScale, 0, std::vector{1.0})
                             .Add(ParameterKind::kObjectScale, 1, std::vector{1.0})),
              {0.0, reflected * c18.value, 1e-6});
}

}  // namespace
}  // namespace pathfit::tests::furnace_test
