#include "renderer/derivative/derivative_limits.h"

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "tests/support/probe.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::derivative_limits_test {
namespace {

/// A ball above a floor, as one sensor sees it.
Scene BallAboveFloor() {
  Scene scene = tests::BallAndWall();
  Mesh ball = MakeIcosphere(1, 0.3);
  for (Vec3& p : ball.positions) p.z += 0.5;
  scene.meshes = {{"floor", tests::Plate(1.0, 1.0, 0.0), 0, {}}, {"ball", ball, 0, {}}};
  scene.materials[0].vertex_colors = false;
  scene.sensors = {tests::CameraAt({0, 0, 3}, {0, 0, 0}, 30.0, 16, 16)};
  return scene;
}

std::vector<std::string> Limits(const Scene& scene, ParameterKind kind, int object) {
  ParameterLayout layout(scene);
  layout.Add(kind, object);
  return DerivativeLimits(scene, layout);
}

void ExpectOne(const std::vector<std::string>& limits, const std::string& part) {
  ASSERT_EQ(limits.size(), 1U);
  EXPECT_NE(limits[0].find(part), std::string::npos) << limits[0];
}

TEST(DerivativeLimits, NoneForABallThatHovers) {
  const Scene scene = BallAboveFloor();
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 1).empty());
}

TEST(DerivativeLimits, MeshesThatTouchOrCut) {
  Scene scene = BallAboveFloor();
  scene.meshes[1].mesh = MakeCube();
  for (Vec3& p : scene.meshes[1].mesh.positions) p = p * 0.25 + Vec3{0.1, 0.05, 0.25};
  ExpectOne(Limits(scene, ParameterKind::kObjectTranslation, 1), "'floor' and 'ball' touch");
  EXPECT_TRUE(Limits(scene, ParameterKind::kCameraPosition, 0).empty()) << "both stay";
  for (Vec3& p : scene.meshes[1].mesh.positions) p.z -= 0.01;
  ExpectOne(Limits(scene, ParameterKind::kObjectTranslation, 1), "'floor' and 'ball' cut");
  ParameterLayout camera(scene);
  camera.Add(ParameterKind::kCameraPosition, 0);
  ExpectOne(DerivativeLimits(scene, camera, DerivativeForm::kImage), "cut");
  EXPECT_TRUE(DerivativeLimits(scene, camera).empty()) << "the material form is taken, and has it";
}

// What a camera's image form lacks and the material form has.
TEST(DefaultForm, IsTheMaterialOneWhereCamerasMoveOverCutsAndProjectors) {
  const auto form_of = [](const Scene& scene, ParameterKind kind, int object) {
    ParameterLayout layout(scene);
    layout.Add(kind, object);
    return DefaultForm(scene, layout);
  };
  const Scene apart = BallAboveFloor();
  EXPECT_EQ(form_of(apart, ParameterKind::kFocal, 0), DerivativeForm::kImage);
  Scene cut = apart;
  for (Vec3& p : cut.meshes[1].mesh.positions) p.z -= 0.5;
  EXPECT_EQ(form_of(cut, ParameterKind::kFocal, 0), DerivativeForm::kMaterial);
  EXPECT_EQ(form_of(cut, ParameterKind::kExposure, 0), DerivativeForm::kImage);
  EXPECT_EQ(form_of(cut, ParameterKind::kObjectTranslation, 1), DerivativeForm::kImage);
  Scene projected = apart;
  projected.emitters.push_back({"beamer", LightFrame::kWorld, {}, ProjectorEmitter{}});
  EXPECT_EQ(form_of(projected, ParameterKind::kCameraPosition, 0), DerivativeForm::kMaterial);
  EXPECT_TRUE(Limits(projected, ParameterKind::kCameraPosition, 0).empty());
  ParameterLayout camera(projected);
  camera.Add(ParameterKind::kCameraPosition, 0);
  ExpectOne(DerivativeLimits(projected, camera, DerivativeForm::kImage),
            "the material form has it");
  ExpectOne(Limits(projected, ParameterKind::kObjectTranslation, 1), "by moving things");
  projected.materials[0].bsdf = MirrorBsdf{};
  EXPECT_EQ(form_of(projected, ParameterKind::kCameraPosition, 0), DerivativeForm::kImage)
      << "mirrors have no other";
}

TEST(DerivativeLimits, SurfacesInOnePlaneAndMeshesThatMeetThemselves) {
  Scene scene = BallAboveFloor();
  scene.meshes[1].mesh = tests::Plate(0.5, 0.5, 0.0);
  ExpectOne(Limits(scene, ParameterKind::kObjectTranslation, 1),
            "'floor' and 'ball' lie on each other in one plane");
  ExpectOne(Limits(scene, ParameterKind::kCameraPosition, 0), "in one plane");
  EXPECT_TRUE(Limits(scene, ParameterKind::kBaseColor, 0).empty());
  scene.meshes.push_back({"cube", MakeCube(), 0, {}});
  for (Vec3& p : scene.meshes[2].mesh.positions) p = p * 0.1 + Vec3{0.2, 0.1, 0.5};
  ExpectOne(Limits(scene, ParameterKind::kObjectTranslation, 2), "in one plane");
  scene.meshes.pop_back();

  // On a cube it is seen from above, whichever way it is wound; the floor it stands on is not.
  scene.meshes[1].mesh = tests::Plate(0.1, 0.1, 0.2);
  scene.meshes.push_back({"cube", MakeCube(), 0, {}});
  for (Vec3& p : scene.meshes[2].mesh.positions) p = p * 0.1 + Vec3{0.03, 0.02, 0.1};
  for (int turned = 0; turned < 2; ++turned) {
    ExpectOne(Limits(scene, ParameterKind::kCameraPosition, 0),
              "'ball' and 'cube' lie on each other in one plane");
    for (Triangle& t : scene.meshes[1].mesh.triangles) std::swap(t[1], t[2]);
  }
  scene.meshes.pop_back();

  const auto two_cubes = [&](double distance) {
    Mesh& mesh = scene.meshes[1].mesh;
    mesh = MakeCube();
    Mesh other = mesh;
    for (Vec3& p : other.positions) p += Vec3{0.3, 0.2, distance};
    for (const Triangle& t : other.triangles) {
      mesh.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
    }
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (Vec3& p : mesh.positions) p = p * 0.1 + Vec3{0, 0, 0.5};
  };
  two_cubes(1.5);
  ExpectOne(Limits(scene, ParameterKind::kCameraPosition, 0), "'ball' cuts itself");
  ExpectOne(Limits(scene, ParameterKind::kObjectTranslation, 1), "'ball' cuts itself");
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 0).empty()) << "it stays";
  two_cubes(2.0);
  EXPECT_TRUE(Limits(scene, ParameterKind::kCameraPosition, 0).empty());
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 1).empty());
  ExpectOne(Limits(scene, ParameterKind::kVertexPositions, 1), "parts of 'ball' touch");
  two_cubes(2.5);
  EXPECT_TRUE(Limits(scene, ParameterKind::kVertexPositions, 1).empty());
}

TEST(DerivativeLimits, RoughGlassByMotionAndByItsIndex) {
  Scene scene = BallAboveFloor();
  scene.materials[0].bsdf = RoughDielectricBsdf{0.5, 1.4};
  scene.meshes.pop_back();
  ExpectOne(Limits(scene, ParameterKind::kObjectTranslation, 0), "is rough glass");
  ExpectOne(Limits(scene, ParameterKind::kEta, 0), "is rough glass");
  EXPECT_TRUE(Limits(scene, ParameterKind::kRoughness, 0).empty());
  // Its lobe ends smoothly.
  scene.materials[0].bsdf = RoughDielectricBsdf{0.5, 1.4, MicrofacetDistribution::kBeckmann};
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 0).empty());
}

TEST(DerivativeLimits, NarrowLobes) {
  Scene scene = BallAboveFloor();
  scene.materials[0].bsdf = RoughConductorBsdf{0.1};
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 1).empty());
  scene.materials[0].bsdf = RoughConductorBsdf{0.05};
  const std::vector<std::string> limits = Limits(scene, ParameterKind::kObjectTranslation, 1);
  ASSERT_EQ(limits.size(), 2U) << "floor and ball";
  EXPECT_NE(limits[0].find("'floor' is nearly a mirror in places"), std::string::npos);
  EXPECT_TRUE(Limits(scene, ParameterKind::kRoughness, 0).empty()) << "nothing moves";
  scene.materials[0].bsdf = MetallicRoughnessBsdf{1.0};
  Texture worn{"worn", 2, 1, {}, TextureWrap::kClamp, true};
  worn.texels = {Rgb::Constant(0.5), Rgb::Constant(0.04)};
  scene.textures = {worn};
  scene.materials[0].roughness_texture = 0;
  EXPECT_EQ(Limits(scene, ParameterKind::kObjectTranslation, 1).size(), 2U);
  worn.height = 100;
  worn.texels = std::vector<Rgb>(200, Rgb::Constant(0.5));
  worn.texels[7] = Rgb::Constant(0.04);
  scene.textures = {worn};
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 1).empty()) << "a few texels";
}

TEST(DerivativeLimits, PlaneOfAParallelSensorThroughAMesh) {
  Scene scene = BallAboveFloor();
  Camera& camera = scene.sensors[0];
  camera.projection = ProjectionKind::kOrthographic;
  camera.fx = camera.fy = 8.0;
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 1).empty()) << "all before it";
  camera.world_from_camera.translation = {0, 0, 0.6};
  ExpectOne(Limits(scene, ParameterKind::kObjectTranslation, 1), "'ball' is cut by the plane");
  ExpectOne(Limits(scene, ParameterKind::kCameraPosition, 0), "'ball' is cut by the plane");
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 0).empty()) << "not the floor";
  camera.world_from_camera.translation = {5, 0, 0.6};
  EXPECT_TRUE(Limits(scene, ParameterKind::kObjectTranslation, 1).empty()) << "beside the picture";
}

}  // namespace
}  // namespace pathfit::renderer::derivative_limits_test
