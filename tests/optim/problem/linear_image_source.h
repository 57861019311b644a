#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "optim/problem/fit_views.h"
#include "optim/problem/image_source.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/test_scenes.h"

namespace pathfit::tests {

/// Images that are linear in the parameters with noise in value and derivative:
/// pixel channel = sum_i basis_i (x_i + noise of the pixel and sample set) over the blocks near the
/// pixel. Every pixel depends on `reach` neighbouring blocks, wrapping around.
class LinearImageSource : public optim::ImageSource {
 public:
  LinearImageSource(int width, int height, int num_blocks, int reach, double noise)
      : width_(width), height_(height), num_blocks_(num_blocks), reach_(reach), noise_(noise) {}

  void SetValues(const std::vector<double>& values) override { values_ = values; }

  [[nodiscard]] renderer::Film RenderPrimal(int view,
                                            const optim::SampleSet& samples) const override {
    renderer::Film film(width_, height_);
    for (std::size_t p = 0; p < film.pixels.size(); ++p) {
      renderer::Rgba sum{0, 0, 0, 1};
      for (const renderer::ParameterDerivative& d : Derivatives(view, p, samples)) {
        for (std::size_t c = 0; c < 3; ++c) {
          renderer::Rgba term = d.d[c];
          term *= values_[3 * static_cast<std::size_t>(d.block) + c];
          sum += term;
        }
      }
      film.pixels[p] = sum;
    }
    if (broken_pixel >= 0) {
      film.pixels[static_cast<std::size_t>(broken_pixel)].g =
          std::numeric_limits<double>::quiet_NaN();
    }
    return film;
  }

  renderer::Film RenderDerivative(int view,
                                  const optim::SampleSet& samples,
                                  renderer::DerivativeSink& sink) const override {
    const renderer::Film film = RenderPrimal(view, samples);
    for (std::size_t p = 0; p < film.pixels.size(); ++p) {
      std::vector<renderer::ParameterDerivative> derivatives = Derivatives(view, p, samples);
      if (static_cast<int>(p) == broken_derivative) {
        derivatives[0].d[1].b = std::numeric_limits<double>::infinity();
      }
      sink.Add(static_cast<std::int64_t>(p), derivatives);
    }
    return film;
  }

  int broken_pixel = -1, broken_derivative = -1;

 private:
  [[nodiscard]] std::vector<renderer::ParameterDerivative> Derivatives(
      int view, std::size_t pixel, const optim::SampleSet& samples) const {
    std::vector<renderer::ParameterDerivative> derivatives;
    // Pixels of a 4 x 2 patch have the same support, as those of a triangle.
    const std::size_t x = pixel % static_cast<std::size_t>(width_) / 4;
    const std::size_t y = pixel / static_cast<std::size_t>(width_) / 2;
    const auto first = static_cast<int>((x + 7 * y + 3 * static_cast<std::size_t>(view)) %
                                        static_cast<std::size_t>(num_blocks_));
    // One factor per pixel and sample set: value and derivative share their noise, as in a
    // renderer.
    renderer::CounterRng noise(
        samples.seed, renderer::RandomDomain{1}, static_cast<std::uint64_t>(view), pixel, 0);
    const double factor = 1.0 + noise_ * std::sqrt(12.0) * (noise.Next() - 0.5);
    renderer::CounterRng basis(
        9, renderer::RandomDomain{2}, static_cast<std::uint64_t>(view), pixel, 0);
    for (int k = 0; k < reach_; ++k) {
      renderer::ParameterDerivative d;
      d.block = (first + k) % num_blocks_;
      for (std::size_t c = 0; c < 3; ++c) {
        d.d[c] = renderer::Rgba(basis.Next(), basis.Next() - 0.3, basis.Next() - 0.5, 0.0);
        d.d[c] *= factor;
      }
      derivatives.push_back(d);
    }
    return derivatives;
  }

  int width_, height_, num_blocks_, reach_;
  double noise_;
  std::vector<double> values_;
};

/// A linear problem of `num_blocks` vertices (a ball's) with photos taken, without noise, at
/// `truth`.
struct LinearFit {
  renderer::Scene scene;
  std::vector<optim::UnknownSpec> unknowns;
  optim::FitViews views;
  std::vector<double> truth;
};

inline constexpr int kNumBlocks = 42;  ///< of MakeLinearFit: an icosphere's vertices

inline LinearFit MakeLinearFit(int width, int height, int num_views, int reach) {
  LinearFit fit;
  renderer::SceneMesh ball{"ball", renderer::MakeIcosphere(1, 1.0), 0};
  fit.scene.meshes = {ball};
  fit.scene.materials = {{"paint", renderer::LambertBsdf{}}};
  fit.unknowns.resize(1);
  fit.unknowns[0].name = "ball.vertices";
  const auto num_blocks = static_cast<int>(ball.mesh.positions.size());
  LinearImageSource source(width, height, num_blocks, reach, 0.0);
  for (int i = 0; i < 3 * num_blocks; ++i) {
    fit.truth.push_back(1.0 + 0.5 * std::sin(static_cast<double>(i)));
  }
  source.SetValues(fit.truth);
  for (int v = 0; v < num_views; ++v) {
    optim::ViewLevel level;
    level.photo = renderer::ColorImage(source.RenderPrimal(v, {}));
    level.color_weight = renderer::Image(width, height, 1);
    level.color_weight.data.assign(level.color_weight.data.size(), 1.0F);
    level.camera = CameraAt({0, 0, 4}, {0, 0, 0}, 50.0, width, height);
    fit.views.levels.emplace_back(level);
    fit.views.names.push_back("photo" + std::to_string(v));
    fit.views.fitted.push_back(v);
    fit.views.num_channels += 3.0 * width * height;
  }
  return fit;
}

}  // namespace pathfit::tests
