#include <gtest/gtest.h>

#include "renderer/derivative/film_sink.h"
#include "renderer/renderer.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::pixel_batch_test {
namespace {

Mesh Moved(Mesh mesh, double size, const Vec3& to) {
  ApplyTransform({{{size, 0, 0}, {0, size, 0}, {0, 0, size}}, to}, mesh);
  return mesh;
}

/// Ball and wall under all kinds of light, with balls of smooth and of rough glass, a mirror, a
/// shining plate, and two sheets at one place, of which rounding alone decides which is seen.
Scene AllKinds(bool environment) {
  Scene scene = tests::BallAndWall();
  const auto add = [&](const char* name, const Mesh& mesh, const Bsdf& bsdf, const Rgb& color) {
    Material material;
    material.name = name;
    material.bsdf = bsdf;
    material.base_color = color;
    material.two_sided = true;
    scene.materials.push_back(material);
    scene.meshes.push_back({name, mesh, static_cast<int>(scene.materials.size()) - 1, {}});
  };
  add("glass",
      Moved(MakeIcosphere(2, 0.5), 1.0, {1.2, 0.6, 0.6}),
      SmoothDielectricBsdf{},
      {1, 1, 1});
  add("frost",
      Moved(MakeIcosphere(2, 0.5), 1.0, {-1.2, 0.6, 0.6}),
      RoughDielectricBsdf{},
      {1, 1, 1});
  add("mirror", Moved(tests::Rectangle(), 0.4, {0.8, -0.9, 0.4}), MirrorBsdf{}, {1, 1, 1});
  add("sheet", Moved(tests::Rectangle(), 0.5, {-0.9, -0.7, 0.5}), LambertBsdf{}, {0.9, 0.1, 0.1});
  add("double", Moved(tests::Rectangle(), 0.5, {-0.9, -0.7, 0.5}), LambertBsdf{}, {0.1, 0.1, 0.9});
  add("plate", Moved(tests::Rectangle(), 0.3, {0.0, 1.2, 1.0}), LambertBsdf{}, {0.2, 0.2, 0.2});
  AreaEmitter area;
  area.intensity = {3, 2, 1};
  area.two_sided = true;
  area.mesh = static_cast<int>(scene.meshes.size()) - 1;
  scene.emitters.push_back({"plate", LightFrame::kWorld, {}, area});
  if (!environment) {
    std::erase_if(scene.emitters, [](const Emitter& emitter) {
      return std::holds_alternative<EnvironmentEmitter>(emitter.light);
    });
  }
  return scene;
}

/// Paths of an image are traced side by side, those of its derivative alone: each is what it is
/// alone, whatever its neighbours do.
TEST(PixelBatch, SameBitsAsOneAtATime) {
  for (const bool environment : {true, false}) {
    const Renderer renderer(AllKinds(environment));
    const Camera& camera = renderer.scene().sensors[0];
    ParameterLayout layout(renderer.scene());
    layout.Add(ParameterKind::kExposure, 0);
    for (const bool antithetic : {false, true}) {
      for (const int spp : {1, 7, 40}) {
        for (const int max_bounces : {1, 8}) {
          RenderOptions options;
          options.spp = spp;
          options.max_bounces = max_bounces;
          options.rr_depth = 2;
          options.antithetic = antithetic;
          options.terms = {DerivativeTerm::kInterior};
          FilmSink sink(layout, {1.0}, camera.width, camera.height);
          const Film alone = renderer.RenderDerivative(camera, 0, options, layout, sink);
          RenderStats stats;
          const Film batch = renderer.RenderPrimal(camera, options, {nullptr, nullptr, &stats});
          EXPECT_EQ(stats.non_finite_samples, 0);
          int different = 0;
          double sum = 0.0;
          for (std::size_t i = 0; i < alone.pixels.size(); ++i) {
            sum += alone.pixels[i].r;
            for (int c = 0; c < 4; ++c) {
              different += alone.pixels[i][c] == batch.pixels[i][c] ? 0 : 1;
            }
          }
          EXPECT_EQ(different, 0) << environment << antithetic << spp << max_bounces;
          EXPECT_GT(sum, 0.0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::pixel_batch_test
