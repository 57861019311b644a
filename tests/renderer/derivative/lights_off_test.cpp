#include <cmath>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/renderer.h"
#include "tests/support/recording_sink.h"
#include "tests/support/test_scenes.h"

// Camera::lights_off: what known answers say of lights that are off.
namespace pathfit::renderer::lights_off_test {
namespace {

constexpr int kSky = 0, kLamp = 1, kSun = 2, kPanel = 3;

Scene BallUnderFourLights() {
  Scene scene = tests::BallAndWall();
  Mesh panel = tests::Rectangle();
  ApplyTransform({{{0.4, 0, 0}, {0, 0, 0.4}, {0, -0.4, 0}}, {-0.8, 1.8, 1.0}}, panel);
  scene.materials.push_back({"black", LambertBsdf{}, {0, 0, 0}});
  scene.meshes.push_back({"panel", panel, 2, {}});
  scene.emitters.push_back({"panel",
                            LightFrame::kWorld,
                            {},
                            AreaEmitter{.mesh = 2, .intensity = {5, 6, 7}, .two_sided = true}});
  return scene;
}

Film Lit(const Renderer& renderer, const std::vector<int>& off, int bounces, int spp) {
  Camera camera = renderer.scene().sensors[0];
  camera.lights_off = off;
  RenderOptions options;
  options.spp = spp;
  options.max_bounces = bounces;
  return renderer.RenderPrimal(camera, options);
}

double MeanOf(const Film& film) {
  double sum = 0.0;
  for (const Rgba& p : film.pixels) sum += p.r + p.g + p.b;
  return sum / (3.0 * static_cast<double>(film.pixels.size()));
}

/// Points and suns are met by every path, so that equal samples give equal sums.
TEST(LightsOff, PicturesOfLampsAddUp) {
  const Renderer renderer(BallUnderFourLights());
  const Film both = Lit(renderer, {kSky, kPanel}, 2, 8);
  const Film lamp = Lit(renderer, {kSky, kSun, kPanel}, 2, 8);
  const Film sun = Lit(renderer, {kSky, kLamp, kPanel}, 2, 8);
  for (std::size_t i = 0; i < both.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(both.pixels[i][c], lamp.pixels[i][c] + sun.pixels[i][c], 1e-9);
    }
  }
}

TEST(LightsOff, PicturesOfAllLightsAddUpInTheMean) {
  const Renderer renderer(BallUnderFourLights());
  constexpr int kSamples = 256;
  double sum = 0.0;
  for (const int on : {kSky, kLamp, kSun, kPanel}) {
    std::vector<int> off;
    for (const int i : {kSky, kLamp, kSun, kPanel}) {
      if (i != on) off.push_back(i);
    }
    sum += MeanOf(Lit(renderer, off, 2, kSamples));
  }
  const double all = MeanOf(Lit(renderer, {}, 2, kSamples));
  EXPECT_NEAR(sum / all, 1.0, 2e-3);
  EXPECT_EQ(MeanOf(Lit(renderer, {kSky, kLamp, kSun, kPanel}, 2, kSamples)), 0.0);
}

TEST(LightsOff, DerivativesByThemAreExactlyZero) {
  Scene scene = BallUnderFourLights();
  const Renderer renderer(scene);
  for (const auto& [kind, light] : {std::pair{ParameterKind::kLightIntensity, kPanel},
                                    {ParameterKind::kLightIntensity, kLamp},
                                    {ParameterKind::kLightPosition, kLamp},
                                    {ParameterKind::kLightRotation, kSun},
                                    {ParameterKind::kEnvironmentTexels, kSky},
                                    {ParameterKind::kLightRotation, kSky}}) {
    ParameterLayout layout(scene);
    layout.Add(kind, light);
    for (const bool is_off : {false, true}) {
      Camera camera = scene.sensors[0];
      if (is_off) camera.lights_off = {light};
      RenderOptions options;
      options.spp = 4;
      options.sppe = options.spp_direct = options.spp_indirect = 4.0;
      options.max_bounces = 2;
      tests::RecordingSink sink(static_cast<std::size_t>(camera.width * camera.height));
      renderer.RenderDerivative(camera, 0, options, layout, sink);
      std::size_t entries = 0;
      for (const auto& pixel : sink.pixels) entries += pixel.size();
      EXPECT_EQ(entries == 0, is_off) << light;
    }
  }
}

TEST(LightsOff, MustExistInAscendingOrder) {
  for (const std::vector<int>& off : {std::vector<int>{4}, {-1}, {1, 0}, {2, 2}}) {
    Scene scene = BallUnderFourLights();
    scene.sensors[0].lights_off = off;
    EXPECT_THROW(ValidateScene(scene), SceneError);
  }
}

}  // namespace
}  // namespace pathfit::renderer::lights_off_test
