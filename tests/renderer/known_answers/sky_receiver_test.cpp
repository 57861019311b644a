#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/renderer/known_answers/known_answer.h"

// Path_space 6.3, C21, C22: the irradiance of a point of a white floor under a sky that turns. The
// texels' bilinear interpolation is part of the model.
namespace pathfit::tests::sky_receiver_test {
namespace {

using renderer::DerivativeForm;
using renderer::ParameterKind;

constexpr int kReplicates = 20;
constexpr double kPi = std::numbers::pi;

class SkyReceiver : public ::testing::TestWithParam<DerivativeForm> {
 protected:
  SkyReceiver() {
    options_.max_bounces = 1;
    options_.spp = 4096;
    options_.sppe = options_.spp_direct = 64.0;  // nothing to find
    options_.spp_pixel = 16384;
    options_.form = GetParam();
    floor_.LookAtOrigin();
  }
  void ExpectValue(const Known& known) const {
    const renderer::Renderer renderer(floor_.scene);
    const auto image = PrimalReplicates(renderer, floor_.scene.sensors[0], options_, kReplicates);
    ExpectKnown("E", Irradiance(Channel(image, 0)), known);
  }
  TermReplicates ExpectDerivative(const std::string& name,
                                  const Motion& motion,
                                  const Known& known) const {
    const renderer::Renderer renderer(floor_.scene);
    TermReplicates found =
        DerivativeByTerm(renderer, floor_.scene.sensors[0], motion, options_, kReplicates);
    ExpectKnown(name, Irradiance(found.Total()), known);
    return found;
  }
  void ExpectSkyTurn(const std::string& name, const Vec3& w, const Known& known) const {
    const Motion motion = Motion(floor_.scene).Add(ParameterKind::kLightRotation, 0, w);
    const TermReplicates found = ExpectDerivative(name, motion, known);
    for (std::size_t t = 1; t < kNumTerms; ++t) {  // all of it is interior
      for (const double value : found.terms[t]) EXPECT_EQ(value, 0.0) << "term " << t;
    }
  }
  /// About the origin, at which the sensor keeps looking.
  void ExpectFloorTurn(const std::string& name, const Vec3& w, const Known& known) const {
    const auto velocity = [w](const Vec3& p) { return Cross(w, p); };
    ExpectDerivative(name, Motion(floor_.scene).Vertices(0, velocity), known);
  }

  FloorScene floor_;
  renderer::RenderOptions options_;
};

TEST_P(SkyReceiver, C21LinearSky) {
  constexpr double kTexels = 3e-4;  // texels of 1.4 degrees flatten the function a little
  const Vec3 k{0.3, -0.2, 0.5};
  const C21Answer c21 = C21LinearSky(1.0, k);
  floor_.scene.emitters = {LinearEnvironment(1.0, k)};
  ExpectValue({c21.value, 0.0, kTexels});
  ExpectSkyTurn("dE/dt", {1, 0, 0}, {c21.d_turn, 0.0, kTexels});
  ExpectFloorTurn("dE/dt_floor", {-1, 0, 0}, {c21.d_turn, 0.0, kTexels});
  // About y by k_x, and about the normal by nothing.
  const double d_y = -2.0 * kPi / 3.0 * k.x;
  ExpectSkyTurn("dE/dt_y", {0, 1, 0}, {d_y, 0.0, kTexels});
  ExpectSkyTurn("dE/dt_z", {0, 0, 1}, {0.0, std::abs(d_y), kTexels});
}

/// The border of the bright half is a ramp of one texel: all of its derivative lies there.
TEST_P(SkyReceiver, C22HalfBrightSky) {
  constexpr double kTexels = 1e-3;  // the ramp's width, squared
  const double theta = 0.6;
  const C22Answer c22 = C22HalfBrightSky(theta);
  renderer::Emitter sky = LinearEnvironment(1.0, {});
  auto& environment = std::get<renderer::EnvironmentEmitter>(sky.light);
  for (std::size_t i = environment.texels.size() / 2; i < environment.texels.size(); ++i) {
    environment.texels[i] = {};
  }
  // The map's bright pole +y goes to the normal, turned by theta about -x.
  environment.frame_from_light = renderer::RotationAboutAxis({1, 0, 0}, 0.5 * kPi - theta);
  floor_.scene.emitters = {sky};
  ExpectValue({c22.value, 0.0, kTexels});
  ExpectFloorTurn("dE/dtheta_floor", {1, 0, 0}, {c22.d_theta, 0.0, kTexels});
  options_.spp = 32768;
  ExpectSkyTurn("dE/dtheta", {-1, 0, 0}, {c22.d_theta, 0.0, kTexels});
}

INSTANTIATE_TEST_SUITE_P(PathSpace63,
                         SkyReceiver,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

}  // namespace
}  // namespace pathfit::tests::sky_receiver_test
