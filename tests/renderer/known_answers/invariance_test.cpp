#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/renderer/known_answers/known_answer.h"
#include "tests/renderer/known_answers/one_pixel_scene.h"

// Path_space 6.4: C28 what common motions do, C34-C36 other meshes of the same surface, C37 light
// and receiver exchanged.
namespace pathfit::tests::invariance_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;
using Object = OnePixelScene::Object;

constexpr int kReplicates = 20;

renderer::RenderOptions Options(DerivativeForm form) {
  renderer::RenderOptions options;
  options.form = form;
  options.guide = renderer::GuideKind::kNone;
  options.spp = 4096;
  options.sppe = 16384;
  options.spp_direct = options.spp_indirect = 32768;
  options.spp_pixel = 32768;
  return options;
}

/// Both estimate the same.
void ExpectEqual(const std::string& name,
                 const std::vector<double>& one,
                 const std::vector<double>& other,
                 double scale) {
  const MeanAndError a = EstimateMean(one);
  const MeanAndError b = EstimateMean(other);
  const double error = std::hypot(a.error, b.error);
  std::ostringstream text;
  text << a.mean << " and " << b.mean << " sigma " << error << " z " << (a.mean - b.mean) / error;
  ::testing::Test::RecordProperty(name, text.str());
  EXPECT_LE(std::abs(a.mean - b.mean), 4.0 * error + 1e-12 * scale) << name << ": " << text.str();
  EXPECT_LE(error, 0.02 * scale) << name << ": " << text.str();
}

// Rounding of sums of some thousand paths of size 1.
constexpr double kZero = 1e-12;
// Rays start beside surfaces by a constant length, which does not grow with the scene.
constexpr double kZeroButOffset = 1e-5;

class Invariance : public ::testing::TestWithParam<DerivativeForm> {};

/// Three bounces of coloured light between things of all kinds.
renderer::Scene Everything() {
  renderer::Scene scene = BallAndWall();
  std::erase_if(scene.emitters, [](const renderer::Emitter& e) { return e.name == "lamp"; });
  Mesh light = Plate(0.5, 0.4, 0.0);
  renderer::ApplyTransform({renderer::RotationFromVector({2.2, 0.4, 0.0}), Vec3{0.4, 1.6, 1.0}},
                           light);
  scene.materials.push_back({"black", renderer::LambertBsdf{}, {0.0, 0.0, 0.0}});
  scene.meshes.push_back({"panel", light, 2, {}});
  renderer::AreaEmitter area;
  area.mesh = 2;
  area.intensity = {3.0, 2.0, 4.0};
  scene.emitters.push_back({"panel", renderer::LightFrame::kWorld, {}, area});
  renderer::Camera& camera = scene.sensors[0];
  camera = renderer::ScaledCamera(camera, 4, 4);
  return scene;
}

renderer::RenderOptions FewSamples(DerivativeForm form) {
  renderer::RenderOptions options;
  options.form = form;
  options.max_bounces = 3;
  options.spp = 64;
  options.sppe = options.spp_direct = options.spp_indirect = options.spp_pixel = 256;
  return options;
}

void ExpectZero(const renderer::Scene& scene,
                const Motion& motion,
                const renderer::RenderOptions& options,
                double zero = kZero) {
  const renderer::Renderer renderer(scene);
  const TermReplicates found = DerivativeByTerm(renderer, scene.sensors[0], motion, options, 2);
  for (std::size_t t = 0; t < kNumTerms; ++t) {
    for (const double value : found.terms[t]) {
      EXPECT_LT(std::abs(value), zero) << "term " << t;
    }
  }
}

TEST_P(Invariance, C28CommonTranslation) {
  const renderer::Scene scene = Everything();
  Motion motion(scene);
  const Vec3 shift{0.3, -0.2, 0.4};
  for (int mesh = 0; mesh < 3; ++mesh) {
    motion.Vertices(mesh, [&](const Vec3&) { return shift; });
  }
  motion.Add(ParameterKind::kCameraPosition, 0, shift);
  ExpectZero(scene, motion, FewSamples(GetParam()));
}

TEST_P(Invariance, C28CommonRotation) {
  const renderer::Scene scene = Everything();
  Motion motion(scene);
  const Vec3 turn{0.3, -0.2, 0.4};
  const Vec3 pivot{0.2, 0.1, -0.3};
  for (int mesh = 0; mesh < 3; ++mesh) {
    motion.Vertices(mesh, [&](const Vec3& p) { return Cross(turn, p - pivot); });
  }
  const Vec3 eye = scene.sensors[0].world_from_camera.translation;
  motion.Add(ParameterKind::kCameraPosition, 0, Cross(turn, eye - pivot))
      .Add(ParameterKind::kCameraRotation, 0, turn)
      .Add(ParameterKind::kLightRotation, 0, turn);
  ExpectZero(scene, motion, FewSamples(GetParam()));
}

TEST_P(Invariance, C28CommonScale) {
  const renderer::Scene scene = Everything();
  Motion motion(scene);
  const Vec3 pivot{0.2, 0.1, -0.3};
  for (int mesh = 0; mesh < 3; ++mesh) {
    motion.Vertices(mesh, [&](const Vec3& p) { return p - pivot; });
  }
  const Vec3 eye = scene.sensors[0].world_from_camera.translation;
  motion.Add(ParameterKind::kCameraPosition, 0, eye - pivot);
  ExpectZero(scene, motion, FewSamples(GetParam()), kZeroButOffset);
}

/// The one-pixel scene with another mesh in the place of an object: the derivative by an affine
/// motion of that object is the same.
class OtherMesh {
 public:
  OtherMesh(Object object, DerivativeForm form) : object_(object), options_(Options(form)) {
    scene_ = OnePixelScene().ToScene();
    reference_ = DerivativeOf(scene_);
  }
  void Expect(const std::string& name, const Mesh& mesh) const {
    renderer::Scene scene = scene_;
    scene.meshes[static_cast<std::size_t>(object_)].mesh = mesh;
    const TermReplicates found = DerivativeOf(scene);
    double scale = 0.0;
    for (const auto& term : reference_.terms) {
      scale = std::max(scale, std::abs(EstimateMean(term).mean));
    }
    for (std::size_t t = 0; t < kNumTerms; ++t) {
      ExpectEqual(name + "_" + std::to_string(t), found.terms[t], reference_.terms[t], scale);
    }
  }
  [[nodiscard]] const Mesh& mesh() const {
    return scene_.meshes[static_cast<std::size_t>(object_)].mesh;
  }

 private:
  [[nodiscard]] TermReplicates DerivativeOf(const renderer::Scene& scene) const {
    const renderer::Renderer renderer(scene);
    const Vec3 centre = OnePixelScene().Centroid(object_);
    const Motion motion = Motion(scene).Vertices(object_, [&](const Vec3& p) {
      const Vec3 q = p - centre;
      return Vec3{0.3, 0.2, -0.2} + Vec3{0.2 * q.x + 0.3 * q.y, -0.2 * q.x, 0.3 * q.x - 0.1 * q.y};
    });
    return DerivativeByTerm(renderer, scene.sensors[0], motion, options_, kReplicates);
  }

  Object object_;
  renderer::RenderOptions options_;
  renderer::Scene scene_;
  TermReplicates reference_;
};

TEST_P(Invariance, C34DiagonalOfAQuad) {
  for (const Object object : {Object::kFloor, Object::kLight}) {
    const OtherMesh other(object, GetParam());
    Mesh mesh = other.mesh();
    mesh.triangles = {{0, 1, 3}, {1, 2, 3}};
    other.Expect(object == Object::kFloor ? "floor" : "light", mesh);
  }
}

TEST_P(Invariance, C36Subdivision) {
  for (const Object object : {Object::kFloor, Object::kLight, Object::kOccluder}) {
    const OtherMesh other(object, GetParam());
    Mesh fine;
    for (const renderer::Triangle& t : other.mesh().triangles) {
      const auto p = [&](std::size_t i) {
        return other.mesh().positions[static_cast<std::size_t>(t[i])];
      };
      const Vec3 corners[6] = {
          p(0), p(1), p(2), (p(0) + p(1)) * 0.5, (p(1) + p(2)) * 0.5, (p(2) + p(0)) * 0.5};
      const auto first = static_cast<std::int32_t>(fine.positions.size());
      fine.positions.insert(fine.positions.end(), std::begin(corners), std::end(corners));
      for (const renderer::Triangle& part :
           {renderer::Triangle{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}) {
        fine.triangles.push_back({first + part[0], first + part[1], first + part[2]});
      }
    }
    renderer::WeldPositions(fine);
    other.Expect(OnePixelScene().ToScene().meshes[static_cast<std::size_t>(object)].name, fine);
  }
}

INSTANTIATE_TEST_SUITE_P(PathSpace64,
                         Invariance,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

TEST(InvarianceOfOccluders, C35WindingDoesNotMatterAndDuplicatesAreRefused) {
  renderer::Scene scene = OnePixelScene().ToScene();
  renderer::Material& material = scene.materials[Object::kOccluder];
  material.base_color = {};
  material.two_sided = true;
  const auto derivative = [](const renderer::Scene& s) {
    const renderer::Renderer renderer(s);
    return DerivativeByTerm(
        renderer,
        s.sensors[0],
        Motion(s).Add(ParameterKind::kObjectTranslation, Object::kOccluder, Vec3{0.7, 0.4, 0.3}),
        Options(DerivativeForm::kImage),
        kReplicates);
  };
  const TermReplicates reference = derivative(scene);
  Mesh& mesh = scene.meshes[Object::kOccluder].mesh;
  std::swap(mesh.triangles[0][1], mesh.triangles[0][2]);
  const TermReplicates reversed = derivative(scene);
  const double scale = std::abs(EstimateMean(reference.terms[2]).mean);
  for (std::size_t t = 0; t < kNumTerms; ++t) {
    ExpectEqual("reversed_" + std::to_string(t), reversed.terms[t], reference.terms[t], scale);
  }
  mesh.triangles.push_back(mesh.triangles[0]);
  EXPECT_THROW(renderer::Renderer{scene}, renderer::SceneError);
}

TEST(InvarianceOfOccluders, C37LightAndReceiverExchanged) {
  // Floor [-0.4, 0.4]^2 and ceiling [-0.2, 0.6] x [-0.3, 0.3] at z = 2, a black plate between: the
  // flux from one to the other is the same both ways, so is its derivative.
  const double height = 2.0;
  const auto flux = [&](bool from_ceiling) {
    FloorScene s;
    s.scene.meshes.clear();
    const int ceiling = 0;
    s.scene.meshes.push_back({"ceiling", Ceiling(-0.2, 0.6, -0.3, 0.3, height), 0, {}});
    s.scene.meshes.push_back({"floor", Plate(0.4, 0.4, 0.0), 0, {}});
    const int plate = s.Add("plate", Ceiling(-0.6, 0.05, -0.5, 0.5, 0.8));
    renderer::AreaEmitter light;
    light.mesh = from_ceiling ? ceiling : 1;
    s.scene.emitters = {{"light", renderer::LightFrame::kWorld, {}, light}};
    s.scene.meshes[static_cast<std::size_t>(light.mesh)].material = 1;
    // A parallel camera close to the receiver that sees all of it.
    const Vec3 centre = from_ceiling ? Vec3{0, 0, 0.02} : Vec3{0.2, 0, height - 0.02};
    const double size = 0.9;
    s.LookDown(-0.5 * size, 0.5 * size, -0.5 * size, 0.5 * size);
    s.scene.sensors[0].world_from_camera =
        renderer::LookAt(centre, centre + Vec3{0, 0, from_ceiling ? -1.0 : 1.0}, {0, 1, 0});
    const renderer::Renderer renderer(s.scene);
    return Irradiance(
        DerivativeByTerm(
            renderer,
            s.scene.sensors[0],
            Motion(s.scene).Add(ParameterKind::kObjectTranslation, plate, Vec3{1.0, 0.2, 0.3}),
            Options(DerivativeForm::kImage),
            kReplicates)
            .Total());
  };
  const std::vector<double> down = flux(true);
  ExpectEqual("dFlux", down, flux(false), std::abs(EstimateMean(down).mean));
}

}  // namespace
}  // namespace pathfit::tests::invariance_test
