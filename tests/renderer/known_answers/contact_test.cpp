#include "tests/renderer/known_answers/shadow_receiver.h"

// Things that touch while they move, with closed forms: what gets covered loses its light once, and
// segments into a contact, as short as can be, count.
namespace pathfit::tests::contact_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;

/// [x0, x1] x [y0, y1] x [z0, z1], outward.
Mesh Block(double x0, double x1, double y0, double y1, double z0, double z1) {
  Mesh mesh = Cube();
  renderer::ApplyTransform(
      {{{0.5 * (x1 - x0), 0, 0}, {0, 0.5 * (y1 - y0), 0}, {0, 0, 0.5 * (z1 - z0)}},
       {0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * (z0 + z1)}},
      mesh);
  return mesh;
}

/// The receiver z = 0 sees a shining slab y = kSlab, on which a black block lies. The block hides
/// from a point of the receiver what lies in the hull of its projection onto the slab.
class BlockOnSlab : public ShadowReceiver {
 protected:
  static constexpr double kSlab = -0.6, kTop = -0.5, kNear = 0.7, kFar = 1.2, kHalf = 0.4;

  BlockOnSlab() : slab_(AddSlab()) {
    block_ = floor_.Add("block", Block(-kHalf, kHalf, kSlab, kTop, kNear, kFar));
    floor_.LookDown(-kReach, kReach, -kReach, kReach);
  }
  /// Irradiance that a slab of radiance 1 loses per unit of the block's motion.
  static double Lost(const Vec3& v) {
    return Average(
        [&](double x, double y) {
          const double scale = (kSlab - y) / (kTop - y);  // projects the top onto the slab
          std::array<Vec3, 6> corners{Vec3{-kHalf - x, kSlab - y, kNear},
                                      Vec3{kHalf - x, kSlab - y, kNear}};
          std::array<Vec3, 6> velocities{v, v};
          std::size_t i = 2;
          for (const auto& [cx, cz] :
               {std::pair{kHalf, kNear}, {kHalf, kFar}, {-kHalf, kFar}, {-kHalf, kNear}}) {
            corners[i] = Vec3{cx - x, kTop - y, cz} * scale;
            velocities[i++] = v * scale;
          }
          return PolygonIrradianceDerivative(corners, velocities);
        },
        -kReach,
        kReach,
        -kReach,
        kReach);
  }

  static constexpr double kReach = 0.4;
  int slab_, block_ = 0;

 private:
  int AddSlab() {
    floor_ = FloorScene(kReach);
    Mesh slab;  // two strips that meet under the block's near border
    for (const double z : {0.4, kNear, 3.0}) {
      slab.positions.insert(slab.positions.end(), {Vec3{-1, kSlab, z}, Vec3{1, kSlab, z}});
    }
    slab.triangles = {{0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}};
    return floor_.Add("slab", slab);
  }
};

TEST_F(BlockOnSlab, CoversALight) {
  floor_.Shine(slab_);
  options_.spp_direct = 1 << 18;
  const renderer::Scene& scene = floor_.scene;
  for (const auto& [name, v] : {std::pair{"dE/dx", Vec3{1, 0, 0}}, {"dE/dz", Vec3{0, 0, 1}}}) {
    ExpectOnly(kDirect,
               ExpectDerivative(name,
                                Motion(scene).Add(ParameterKind::kObjectTranslation, block_, v),
                                {-Lost(v), std::abs(Lost({0, 0, 1}))}));
  }
}

/// The same slab, white under a sun whose shadow of the block lies within what the block hides.
TEST_F(BlockOnSlab, CoversALitSurface) {
  floor_.scene.meshes[static_cast<std::size_t>(slab_)].material = 0;
  const Vec3 to_light = Normalized(Vec3{0, 1, -0.1});
  renderer::DirectionalEmitter sun;
  sun.direction = -to_light;
  floor_.scene.emitters = {{"sun", renderer::LightFrame::kWorld, {}, sun}};
  options_.max_bounces = 2;
  const double radiance = to_light.y / std::numbers::pi;
  const renderer::Scene& scene = floor_.scene;
  for (const auto& [name, v] : {std::pair{"dE/dx", Vec3{1, 0, 0}}, {"dE/dz", Vec3{0, 0, 1}}}) {
    ExpectOnly(kIndirect,
               ExpectDerivative(name,
                                Motion(scene).Add(ParameterKind::kObjectTranslation, block_, v),
                                {-radiance * Lost(v), radiance * std::abs(Lost({0, 0, 1}))}));
  }
}

class Contact : public ShadowReceiver, public ::testing::WithParamInterface<DerivativeForm> {
 protected:
  Contact() { options_.form = GetParam(); }
};

/// The foot of a block on a shining floor, seen straight on: as it slides, each of its points sees
/// the floor from the foot on, but the floor's far end nearer. The floor reflects nothing, but
/// could (two bounces): its points close to the foot are contacts, too.
TEST_P(Contact, FrontSeesTheFloorAtItsFoot) {
  const double half = 0.8, top = 0.03, width = 0.2;
  floor_ = FloorScene(half);
  floor_.scene.materials[0].base_color = {0.0, 0.0, 0.0};
  floor_.scene.materials[1].base_color = {1.0, 1.0, 1.0};
  const int block = floor_.Add("block", Block(-0.6, 0.6, 0.0, 0.6, 0.0, 0.7));
  floor_.Shine(0);
  options_.max_bounces = 2;
  floor_.LookDown(-width, width, 0.0, top);
  floor_.scene.sensors[0].world_from_camera =
      renderer::LookAt({0, -2, 0.5 * top}, {0, 0, 0.5 * top}, {0, 0, 1});
  const double exact = Average(
      [&](double x, double z) {  // in the frame of the front: x, up, out
        const std::array<Vec3, 4> corners{Vec3{-half - x, -z, 0},
                                          Vec3{half - x, -z, 0},
                                          Vec3{half - x, -z, half},
                                          Vec3{-half - x, -z, half}};
        const Vec3 v{0, 0, 1};
        return PolygonIrradianceDerivative(corners, std::array<Vec3, 4>{Vec3{}, Vec3{}, v, v});
      },
      -width,
      width,
      0.0,
      top);
  // What is close and what is far cancel: each is the floor's light (half a hemisphere) over the
  // length on which it changes.
  const double parts = 0.5 * std::numbers::pi / top;
  const Motion slide =
      Motion(floor_.scene).Add(ParameterKind::kObjectTranslation, block, Vec3{0, 1, 0});
  ExpectOnly(kInterior, ExpectDerivative("dE/dy", slide, {exact, parts}));
}

INSTANTIATE_TEST_SUITE_P(BothForms,
                         Contact,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

}  // namespace
}  // namespace pathfit::tests::contact_test
