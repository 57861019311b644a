// Known answers (renderer/THEORY.md) as YAML scenes: every file of tests/scenes named here is read,
// built and rendered as `pathfit render` does.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/experiment/direction.h"
#include "app/experiment/experiment.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/renderer.h"

namespace pathfit::app::closed_form_scenes_test {
namespace {

constexpr int kReplicates = 32;
constexpr double kMaxSigmas = 4.0;
constexpr double kMaxRelativeError = 0.01;

struct KnownAnswer {
  const char* scene;
  const char* derivative;  ///< empty: the image itself
  double value;            ///< sum over all pixels, green channel
};

double SumOfGreen(const renderer::Film& film) {
  double sum = 0.0;
  for (const renderer::Rgba& p : film.pixels) {
    sum += p.g;
  }
  return sum;
}

class ClosedFormScene : public testing::TestWithParam<KnownAnswer> {};

TEST_P(ClosedFormScene, AgreesWithTheKnownAnswer) {
  const KnownAnswer& known = GetParam();
  const std::string path =
      std::string(PATHFIT_SOURCE_DIR) + "/tests/scenes/" + known.scene + ".yaml";
  const ExperimentConfig config = LoadExperimentConfig(path, {});
  const Experiment experiment = BuildExperiment(config);
  const renderer::Renderer renderer(experiment.scene);
  const auto& camera = experiment.scene.sensors.front();
  renderer::RenderOptions options;
  options.spp = config.render.spp;
  options.sppe = config.render.sppe;
  options.max_bounces = config.render.max_bounces;

  std::vector<double> values;
  for (int r = 0; r < kReplicates; ++r) {
    options.seed = static_cast<std::uint64_t>(r);
    if (known.derivative[0] == '\0') {
      values.push_back(SumOfGreen(renderer.RenderPrimal(camera, options)));
      continue;
    }
    const Direction direction = ParseDirection(experiment.scene, known.derivative);
    renderer::FilmSink sink(direction.layout, direction.values, camera.width, camera.height);
    renderer.RenderDerivative(camera, 0, options, direction.layout, sink);
    values.push_back(SumOfGreen(sink.film()));
  }
  double mean = 0.0;
  for (const double v : values) mean += v / kReplicates;
  double variance = 0.0;
  for (const double v : values) variance += (v - mean) * (v - mean) / (kReplicates - 1);
  const double sigma = std::sqrt(variance / kReplicates);
  RecordProperty("mean", std::to_string(mean));
  EXPECT_LE(sigma, kMaxRelativeError * std::abs(known.value))
      << "the test is too noisy to prove anything";
  EXPECT_LE(std::abs(mean - known.value), kMaxSigmas * sigma + 1e-8 * std::abs(known.value))
      << "mean " << mean << ", known " << known.value << ", sigma " << sigma;
}

constexpr double kRoughness = 0.5477225575051661;  // alpha = 0.3

INSTANTIATE_TEST_SUITE_P(
    KnownAnswers,
    ClosedFormScene,
    testing::Values(
        KnownAnswer{"half_plane_edge", "", 1.0 - 0.66},
        KnownAnswer{"half_plane_edge", "plane.vertices.x", -2.0},
        KnownAnswer{"half_plane_edge", "plane.vertices.z", -0.08},
        KnownAnswer{"tilted_quad", "", 1.0 - 0.1536266284006},
        KnownAnswer{"tilted_quad", "quad.vertices.z", -0.1024954382619},
        KnownAnswer{"half_plane_over_background", "", 0.66 * 0.3 + 0.34 * 1.1},
        KnownAnswer{"half_plane_over_background", "plane.vertices.x", -1.6},
        KnownAnswer{"convex_cube", "cube.vertices.scale", -0.4608},
        KnownAnswer{"ggx_normal_incidence", "", 0.8773584157886},
        KnownAnswer{"ggx_normal_incidence", "metal.roughness", -0.8261023256234 * 2.0 * kRoughness},
        KnownAnswer{"ggx_45_degrees", "", 0.8453962137678},
        KnownAnswer{"ggx_45_degrees", "metal.roughness", -0.8300498981922 * 2.0 * kRoughness},
        KnownAnswer{"lamp_at_camera", "", 0.1257044424265},
        KnownAnswer{"lamp_at_camera", "plane.vertices.z", 0.1257044424265}),
    [](const auto& param) {
      std::string name = std::string(param.param.scene) + "_" + param.param.derivative;
      for (char& c : name) {
        c = c == '.' ? '_' : c;
      }
      return name;
    });

}  // namespace
}  // namespace pathfit::app::closed_form_scenes_test
