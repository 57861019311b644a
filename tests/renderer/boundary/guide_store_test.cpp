#include <gtest/gtest.h>

#include "renderer/boundary/primary_guide.h"
#include "tests/support/probe.h"

namespace pathfit::renderer::guide_store_test {
namespace {

/// A plate between a small area light and a floor; the plate moves.
Scene Shadow() {
  Scene scene;
  Mesh floor = tests::Plate(2.0, 2.0, 0.0);
  Mesh plate = tests::Plate(0.3, 0.3, 1.0);
  Mesh lamp = tests::Plate(0.2, 0.2, -2.0);
  ApplyTransform({{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, {0.1, 0, 0}},
                 lamp);  // at z = 2, facing down
  scene.meshes = {{"plate", plate, 0}, {"floor", floor, 0}, {"lamp", lamp, 0}};
  scene.materials = {{"paint", LambertBsdf{}, {0.7, 0.6, 0.5}}};
  AreaEmitter light;
  light.mesh = 2;
  light.intensity = Rgb::Constant(20.0);
  scene.emitters = {{"light", LightFrame::kWorld, {}, light}};
  scene.sensors = {tests::CameraAt({0.0, -3.0, 1.0}, {0, 0, 0}, 20.0, 16, 16)};
  return scene;
}

struct Moments {
  double mean = 0.0, variance_of_mean = 0.0, image_variance = 0.0;
};

/// Sum of the direct boundary over the image, by passes of different seeds.
Moments Passes(const Scene& scene,
               RenderOptions options,
               int count,
               const RenderServices& services = {}) {
  const Renderer renderer(scene);
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectTranslation, 0);
  std::vector<double> sums;
  for (int i = 0; i < count; ++i) {
    options.seed = 100 + static_cast<std::uint64_t>(i);
    FilmSink sink(layout, {1.0, 0.3, 0.2}, 16, 16);
    renderer.RenderDerivative(scene.sensors[0], 0, options, layout, sink, services);
    sums.push_back(tests::SumOfPixels(sink.film()).g);
  }
  Moments m;
  for (const double s : sums) m.mean += s / count;
  for (const double s : sums) m.image_variance += (s - m.mean) * (s - m.mean) / (count - 1);
  m.variance_of_mean = m.image_variance / count;
  return m;
}

RenderOptions DirectOnly() {
  RenderOptions options;
  options.terms = {DerivativeTerm::kDirect};
  options.spp = 1;
  options.spp_direct = 64.0;
  return options;
}

TEST(GuideStore, KeptGuidesHaveTheSameMean) {
  const Scene scene = Shadow();
  RenderOptions options = DirectOnly();
  const Moments fresh = Passes(scene, options, 48);
  options.guide = GuideKind::kNone;
  const Moments unguided = Passes(scene, options, 48);
  options.guide = GuideKind::kAdaptive;
  GuideStore store;
  const Moments kept = Passes(scene, options, 48, {.guides = &store});
  ASSERT_NE(fresh.mean, 0.0);
  for (const Moments& other : {fresh, unguided}) {
    const double z =
        (kept.mean - other.mean) / std::sqrt(kept.variance_of_mean + other.variance_of_mean);
    EXPECT_LT(std::abs(z), 4.0) << kept.mean << " against " << other.mean;
  }
  EXPECT_LT(std::sqrt(kept.variance_of_mean), 0.01 * std::abs(kept.mean));
}

TEST(GuideStore, KeepsTheGuidesOfEachViewUntilCleared) {
  const Scene scene = Shadow();
  const Renderer renderer(scene);
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectTranslation, 0);
  GuideStore store;
  RenderOptions options = DirectOnly();
  const auto run = [&] {
    FilmSink sink(layout, {1.0, 0.3, 0.2}, 16, 16);
    renderer.RenderDerivative(scene.sensors[0], 0, options, layout, sink, {.guides = &store});
    return sink.film().pixels;
  };
  const auto learned = run();
  EXPECT_EQ(store.guides().of.size(), 1U);
  options.seed = 1;
  const auto kept = run();
  EXPECT_EQ(store.guides().of.size(), 1U);
  options.view = 1;
  run();
  EXPECT_EQ(store.guides().of.size(), 2U) << "another view";
  store.Clear();
  EXPECT_TRUE(store.guides().of.empty());
  options.view = 0;
  EXPECT_NE(run(), kept) << "pilots are paid for anew";
  options.seed = 0;
  store.Clear();
  EXPECT_EQ(run(), learned);
}

}  // namespace
}  // namespace pathfit::renderer::guide_store_test
