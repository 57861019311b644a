// Scenes of the Mitsuba 3 test suite (tests/scenes/mitsuba_*.yaml) against the images it stores for
// them (data/references/mitsuba): the image, its derivative by one number, and the derivative of a
// loss that weighs pixels unevenly.
#include <cmath>
#include <filesystem>
#include <numbers>
#include <ostream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "app/experiment/direction.h"
#include "app/experiment/experiment.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/io/exr_file.h"
#include "renderer/renderer.h"

namespace pathfit::app::mitsuba_reference_test {
namespace {

using renderer::Film;
using renderer::Image;

constexpr double kMaxRelativeError = 0.05;
constexpr double kMinCorrelation = 0.99;
constexpr double kMaxLossError = 0.02;

std::filesystem::path Source() { return PATHFIT_SOURCE_DIR; }

/// What is rendered: samples per pixel are as many as the limits need.
struct Reference {
  const char* name;
  std::vector<const char*> parameters;  ///< moved together
  int spp = 64;
  double sppe = 1.0;
  double spp_direct = 0.0;
  double per_unit = 1.0;  ///< the reference's unit in ours
  int block = 1;  ///< means of squares of so many pixels a side are compared: more than one where
                  ///< the reference's own noise is above the limits
};

struct Rendered {
  Film image, derivative;
};

Rendered Render(const Reference& reference) {
  const ExperimentConfig config = LoadExperimentConfig(
      Source() / ("tests/scenes/mitsuba_" + std::string(reference.name) + ".yaml"), {});
  const Experiment experiment = BuildExperiment(config);
  const renderer::Scene& scene = experiment.scene;
  renderer::ParameterLayout layout(scene);
  std::vector<double> direction;
  for (const char* parameter : reference.parameters) {
    const Direction by = ParseDirection(scene, parameter);
    for (const auto& group : by.layout.groups()) layout.Add(group.kind, group.object);
    for (const double value : by.values) direction.push_back(value * reference.per_unit);
  }
  renderer::RenderOptions options = config.render;
  options.spp = reference.spp;
  options.sppe = reference.sppe;
  options.spp_direct = reference.spp_direct;
  const renderer::Camera& camera = scene.sensors.front();
  renderer::FilmSink sink(layout, direction, camera.width, camera.height);
  Rendered rendered;
  rendered.image = renderer::Renderer(scene).RenderDerivative(camera, 0, options, layout, sink);
  rendered.derivative = sink.film();
  return rendered;
}

/// dLoss / dPixel of a fixed smooth loss, different for every channel and on the two sides of the
/// image, so that things that move across it do not cancel. x, y: 0..1 over the image.
double LossWeight(double x, double y, int channel) {
  return 1.0 + std::sin(std::numbers::pi * (x - 0.5)) +
         0.5 * std::cos(2.0 * std::numbers::pi * (1.3 * y - 0.4 * x) + 2.0 * channel);
}

/// Sums over the values of two pictures.
class Comparison {
 public:
  void Add(double a, double b, double weight) {
    n_ += 1.0;
    a_ += a;
    b_ += b;
    aa_ += a * a;
    bb_ += b * b;
    ab_ += a * b;
    loss_a_ += weight * a;
    loss_b_ += weight * b;
  }
  /// |a - b| / |b|, L2.
  [[nodiscard]] double RelativeError() const { return std::sqrt((aa_ - 2.0 * ab_ + bb_) / bb_); }
  [[nodiscard]] double Correlation() const {
    return (ab_ - a_ * b_ / n_) / std::sqrt((aa_ - a_ * a_ / n_) * (bb_ - b_ * b_ / n_));
  }
  /// Of the weighted sum, relative.
  [[nodiscard]] double LossError() const { return std::abs(loss_a_ - loss_b_) / std::abs(loss_b_); }

 private:
  double n_ = 0.0, a_ = 0.0, b_ = 0.0, aa_ = 0.0, bb_ = 0.0, ab_ = 0.0;
  double loss_a_ = 0.0, loss_b_ = 0.0;
};

Comparison Compare(const Film& ours, const Image& reference, int block) {
  EXPECT_EQ(ours.width, reference.width);
  EXPECT_EQ(ours.height, reference.height);
  EXPECT_EQ(reference.channels, 3);
  Comparison comparison;
  for (int y0 = 0; y0 < ours.height; y0 += block) {
    for (int x0 = 0; x0 < ours.width; x0 += block) {
      for (int c = 0; c < 3; ++c) {
        double a = 0.0, b = 0.0;
        for (int i = 0; i < block * block; ++i) {
          const auto pixel =
              static_cast<std::size_t>((y0 + i / block) * ours.width + x0 + i % block);
          a += ours.pixels[pixel][c];
          b += reference.data[3 * pixel + static_cast<std::size_t>(c)];
        }
        const double half = 0.5 * block;
        comparison.Add(a, b, LossWeight((x0 + half) / ours.width, (y0 + half) / ours.height, c));
      }
    }
  }
  return comparison;
}

void PrintTo(const Reference& reference, std::ostream* out) { *out << reference.name; }

class MitsubaReference : public testing::TestWithParam<Reference> {};

TEST_P(MitsubaReference, ImageAndDerivativeAgree) {
  const Reference& reference = GetParam();
  const Rendered rendered = Render(reference);
  for (const auto& [what, film, suffix] :
       {std::tuple{"image", &rendered.image, "_primal.exr"},
        std::tuple{"derivative", &rendered.derivative, "_fwd.exr"}}) {
    const Image stored = renderer::ReadExr(Source() / "data/references/mitsuba" /
                                           (std::string(reference.name) + suffix));
    const Comparison agreement = Compare(*film, stored, reference.block);
    std::printf("%-38s %-10s relative L2 %.4f correlation %.5f loss %.4f\n",
                reference.name,
                what,
                agreement.RelativeError(),
                agreement.Correlation(),
                agreement.LossError());
    EXPECT_LE(agreement.RelativeError(), kMaxRelativeError) << what;
    EXPECT_GE(agreement.Correlation(), kMinCorrelation) << what;
    EXPECT_LE(agreement.LossError(), kMaxLossError) << what;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Golden,
    MitsubaReference,
    testing::Values(
        Reference{"diffuse_albedo", {"wall.base_color"}, 128},
        Reference{"area_light_radiance", {"light.intensity"}, 128},
        Reference{"point_light_intensity", {"lamp.intensity"}, 128},
        // The reference holds 0.977576 where the background's derivative is exactly one.
        Reference{"constant_emitter_radiance", {"sky.intensity"}, 128},
        // The reference is a difference of float32 images over 1e-3 degrees: its second differences
        // show noise of 8 % in every pixel.
        Reference{"rotate_shading_normals_plane",
                  {"plane.normals.x"},
                  512,
                  1.0,
                  0.0,
                  std::numbers::pi / 180.0,
                  4},
        Reference{"translate_textured_plane", {"plane.translation.x"}, 1024},
        Reference{"translate_plane_under_projector", {"plane.translation.z"}, 256},
        Reference{"translate_diffuse_rectangle_constant", {"plane.translation.x"}, 128, 512},
        Reference{"translate_disk_emitter_on_gray", {"disk.translation.x"}, 128, 512},
        Reference{"scale_sphere_emitter_on_black", {"ball.scale"}, 128, 1024},
        Reference{"translate_shadow_receiver_area_light", {"wall.translation.x"}, 512, 16384, 64},
        Reference{"translate_self_shadowing_right_angle",
                  {"wall.translation.z", "floor.translation.z"},
                  512,
                  128,
                  128}),
    [](const auto& reference) { return std::string(reference.param.name); });

}  // namespace
}  // namespace pathfit::app::mitsuba_reference_test
