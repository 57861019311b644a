#include "renderer/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/support/recording_sink.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::renderer_test {
namespace {

class RendererOfAllParameters : public ::testing::Test {
 protected:
  RendererOfAllParameters() : renderer_(tests::BallAndWall()), layout_(AllOf(renderer_.scene())) {
    options_.spp = 6;
    options_.sppe = 3.0;
    options_.max_bounces = 3;
    options_.rr_depth = 2;
    options_.seed = 17;
  }
  static ParameterLayout AllOf(const Scene& scene) {
    ParameterLayout layout(scene);
    layout.Add(ParameterKind::kVertexPositions, 0);
    layout.Add(ParameterKind::kVertexPositions, 1);
    layout.Add(ParameterKind::kVertexColors, 0);
    layout.Add(ParameterKind::kBaseColor, 1);
    layout.Add(ParameterKind::kRoughness, 1);
    layout.Add(ParameterKind::kMetallic, 1);
    for (int light = 0; light < 3; ++light) layout.Add(ParameterKind::kLightIntensity, light);
    layout.Add(ParameterKind::kEnvironmentTexels, 0);
    layout.Add(ParameterKind::kExposure, 0);
    return layout;
  }
  [[nodiscard]] const Camera& Sensor() const { return renderer_.scene().sensors[0]; }

  struct Result {
    Film primal, film;
    std::vector<std::vector<ParameterDerivative>> entries;
    RenderStats stats;
  };
  [[nodiscard]] Result Render(int num_threads) const {
    const ThreadLimit limit(num_threads);
    const auto pixels = static_cast<std::size_t>(Sensor().width * Sensor().height);
    tests::RecordingSink sink(pixels);
    Result result;
    result.primal = renderer_.RenderPrimal(Sensor(), options_);
    result.film =
        renderer_.RenderDerivative(Sensor(), 0, options_, layout_, sink, {.stats = &result.stats});
    result.entries = std::move(sink.pixels);
    return result;
  }

  Renderer renderer_;
  ParameterLayout layout_;
  RenderOptions options_;
};

void ExpectSameBits(const std::vector<std::vector<ParameterDerivative>>& a,
                    const std::vector<std::vector<ParameterDerivative>>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t pixel = 0; pixel < a.size(); ++pixel) {
    ASSERT_EQ(a[pixel].size(), b[pixel].size()) << pixel;
    for (std::size_t i = 0; i < a[pixel].size(); ++i) {
      ASSERT_EQ(a[pixel][i].block, b[pixel][i].block) << pixel;
      ASSERT_EQ(a[pixel][i].d, b[pixel][i].d) << pixel;
    }
  }
}

TEST_F(RendererOfAllParameters, SameBitsForAnyNumberOfThreads) {
  const Result one = Render(1);
  for (const int threads : {2, 8}) {
    const Result many = Render(threads);
    EXPECT_EQ(one.primal.pixels, many.primal.pixels) << threads;
    EXPECT_EQ(one.film.pixels, many.film.pixels) << threads;
    ExpectSameBits(one.entries, many.entries);
    EXPECT_EQ(one.stats.edge_samples, many.stats.edge_samples);
    EXPECT_EQ(one.stats.edge_samples_hidden, many.stats.edge_samples_hidden);
  }
}

TEST_F(RendererOfAllParameters, DerivativeRendersThePrimalsBits) {
  const Result result = Render(2);
  EXPECT_EQ(result.primal.pixels, result.film.pixels);
  options_.terms.Set(DerivativeTerm::kInterior, false);
  tests::RecordingSink sink(result.primal.pixels.size());
  EXPECT_EQ(renderer_.RenderDerivative(Sensor(), 0, options_, layout_, sink).pixels,
            result.primal.pixels);
}

/// Paths that no parameter touches are cut short.
TEST(Renderer, DerivativeWithoutImageHasTheSameBits) {
  const Scene scene = tests::BallAndWall();
  const Renderer renderer(scene);
  const Camera& camera = scene.sensors[0];
  const auto pixels = static_cast<std::size_t>(camera.width * camera.height);
  const auto check = [&](ParameterKind kind, int object) {
    ParameterLayout layout(scene);
    layout.Add(kind, object);
    for (const DerivativeForm form : {DerivativeForm::kImage, DerivativeForm::kMaterial}) {
      RenderOptions options;
      options.spp = 6;
      options.max_bounces = 3;
      options.rr_depth = 2;
      options.form = form;
      tests::RecordingSink with(pixels);
      renderer.RenderDerivative(camera, 0, options, layout, with);
      options.with_image = false;
      tests::RecordingSink without(pixels);
      EXPECT_TRUE(renderer.RenderDerivative(camera, 0, options, layout, without).pixels.empty());
      ExpectSameBits(with.pixels, without.pixels);
    }
  };
  for (const int mesh : {0, 1}) {
    check(ParameterKind::kVertexPositions, mesh);
    check(ParameterKind::kObjectTranslation, mesh);
  }
  check(ParameterKind::kVertexColors, 0);
  check(ParameterKind::kRoughness, 1);
  check(ParameterKind::kLightIntensity, 0);
  check(ParameterKind::kEnvironmentTexels, 0);
  check(ParameterKind::kCameraPosition, 0);
  check(ParameterKind::kExposure, 0);
  check(ParameterKind::kWhiteBalance, 0);
  check(ParameterKind::kVignetting, 0);
}

TEST(Renderer, ExposureDoesNotScaleTheDerivativeOfCoverage) {
  Scene scene = tests::BallAndWall();
  scene.meshes.pop_back();
  scene.sensors = {tests::CameraAt({0.2, 0.3, 4.0}, {0, 0, 0}, 28.0, 16, 16)};
  scene.environment_visible = false;
  const Renderer renderer(scene);
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectTranslation, 0);
  Camera camera = scene.sensors[0];
  camera.filter = {PixelFilter::Shape::kTent, 1.0};
  for (const DerivativeForm form : {DerivativeForm::kImage, DerivativeForm::kMaterial}) {
    RenderOptions options;
    options.spp = 4;
    options.sppe = 4.0;
    options.form = form;
    const auto coverage = [&](double gain) {
      camera.gain = gain;
      const auto pixels = static_cast<std::size_t>(camera.width * camera.height);
      tests::RecordingSink sink(pixels);
      renderer.RenderDerivative(camera, 0, options, layout, sink);
      std::vector<double> sums(3 * pixels);
      for (std::size_t p = 0; p < pixels; ++p) {
        for (const ParameterDerivative& entry : sink.pixels[p]) {
          for (std::size_t i = 0; i < 3; ++i) sums[3 * p + i] += entry.d[i].a;
        }
      }
      return sums;
    };
    const std::vector<double> once = coverage(1.0), exposed = coverage(4.0);
    EXPECT_GT(*std::ranges::max_element(once), 0.0);
    for (std::size_t i = 0; i < once.size(); ++i) EXPECT_NEAR(exposed[i], once[i], 1e-12);
  }
}

/// Of the same samples: all terms by their pixels, and by how the lens itself darkens them.
TEST(Renderer, VignettingScalesPixelsAndTheirDerivatives) {
  const Scene scene = tests::BallAndWall();
  const Renderer renderer(scene);
  const std::vector<ParameterKind> kinds = {ParameterKind::kVertexPositions,
                                            ParameterKind::kExposure,
                                            ParameterKind::kWhiteBalance,
                                            ParameterKind::kFocal,
                                            ParameterKind::kPrincipalPoint,
                                            ParameterKind::kVignetting};
  ParameterLayout layout(scene);
  for (const ParameterKind kind : kinds) layout.Add(kind, 0);
  // Half the sensor's size: derivatives are by the sensor's pixels.
  const Camera& full = scene.sensors[0];
  Camera plain = ScaledCamera(full, full.width / 2, full.height / 2);
  plain.gain = 1.7;
  plain.red = 1.3;
  Camera dark = plain;
  dark.vignetting = {-0.4, 0.15, -0.1};
  RenderOptions options;
  options.spp = 4;
  options.sppe = 4.0;
  const auto width = static_cast<std::size_t>(plain.width);
  const std::size_t pixels = width * static_cast<std::size_t>(plain.height);
  const auto sums = [&](const Camera& camera, Film& film) {
    tests::RecordingSink sink(pixels);
    film = renderer.RenderDerivative(camera, 0, options, layout, sink);
    std::vector<std::array<Rgba, 3>> sum(pixels * static_cast<std::size_t>(layout.NumBlocks()));
    for (std::size_t p = 0; p < pixels; ++p) {
      for (const ParameterDerivative& entry : sink.pixels[p]) {
        for (std::size_t i = 0; i < 3; ++i) {
          sum[p * static_cast<std::size_t>(layout.NumBlocks()) +
              static_cast<std::size_t>(entry.block)][i] += entry.d[i];
        }
      }
    }
    return sum;
  };
  Film film, dark_film;
  const auto plain_sum = sums(plain, film);
  const auto dark_sum = sums(dark, dark_film);
  EXPECT_EQ(renderer.RenderPrimal(dark, options).pixels, dark_film.pixels);
  // By the sensor's numbers, of one pixel.
  const auto by_lens = [&](ParameterKind kind, int x, int y) {
    std::array<double, 3> d{};
    Scene moved = scene;
    ParameterLayout one(scene);
    one.Add(kind, 0);
    for (std::size_t i = 0; i < static_cast<std::size_t>(one.NumScalars()); ++i) {
      const auto at = [&](double step) {
        moved.sensors[0].vignetting = dark.vignetting;
        std::vector<double> values = one.Gather(scene);
        if (kind == ParameterKind::kVignetting) {
          values = {dark.vignetting.v1, dark.vignetting.v2, dark.vignetting.v3};
        }
        values[i] += step;
        one.Scatter(values, moved);
        const Camera camera = ScaledCamera(moved.sensors[0], plain.width, plain.height);
        return camera.vignetting.At(camera.VignettingRadius2(x, y));
      };
      constexpr double kStep = 1e-5;
      d[i] = (at(kStep) - at(-kStep)) / (2.0 * kStep);
      moved.sensors[0] = scene.sensors[0];
    }
    return d;
  };
  double largest = 0.0;
  for (std::size_t p = 0; p < pixels; ++p) {
    const int x = static_cast<int>(p % width), y = static_cast<int>(p / width);
    const double falloff = dark.vignetting.At(dark.VignettingRadius2(x, y));
    const Rgba& color = film.pixels[p];
    EXPECT_NEAR(dark_film.pixels[p].r, color.r * falloff, 1e-12);
    EXPECT_EQ(dark_film.pixels[p].a, color.a);
    for (const ParameterGroup& group : layout.groups()) {
      const std::array<double, 3> own = group.kind == ParameterKind::kVertexPositions ||
                                                group.kind == ParameterKind::kExposure ||
                                                group.kind == ParameterKind::kWhiteBalance
                                            ? std::array<double, 3>{}
                                            : by_lens(group.kind, x, y);
      for (std::int32_t b = group.first_block; b < group.first_block + group.num_blocks; ++b) {
        const std::size_t at =
            p * static_cast<std::size_t>(layout.NumBlocks()) + static_cast<std::size_t>(b);
        for (std::size_t i = 0; i < 3; ++i) {
          const Rgba before = group.kind == ParameterKind::kVignetting ? Rgba{} : plain_sum[at][i];
          const Rgba& after = dark_sum[at][i];
          largest = std::max(largest, std::abs(own[i] * color.g));
          EXPECT_NEAR(after.r, before.r * falloff + own[i] * color.r, 1e-8) << group.name << i;
          EXPECT_NEAR(after.g, before.g * falloff + own[i] * color.g, 1e-8) << group.name << i;
          EXPECT_NEAR(after.b, before.b * falloff + own[i] * color.b, 1e-8) << group.name << i;
          EXPECT_EQ(after.a, before.a) << group.name << i;
        }
      }
    }
  }
  EXPECT_GT(largest, 0.1);
}

TEST_F(RendererOfAllParameters, TermsAddUp) {
  const Result all = Render(2);
  Result sum;
  sum.entries.resize(all.entries.size());
  for (const auto& [name, term] : kDerivativeTerms) {
    options_.terms = {term};
    const Result one = Render(2);
    std::int64_t count = 0;
    for (std::size_t i = 0; i < sum.entries.size(); ++i) {
      sum.entries[i].insert(sum.entries[i].end(), one.entries[i].begin(), one.entries[i].end());
      count += static_cast<std::int64_t>(one.entries[i].size());
    }
    // No line touches the ball and meets two surfaces; image form has no pixel boundary.
    const bool none = term == DerivativeTerm::kIndirect || term == DerivativeTerm::kPixel;
    EXPECT_EQ(count > 100, !none) << name;
  }
  ExpectSameBits(all.entries, sum.entries);
}

TEST_F(RendererOfAllParameters, NothingIsNanAndCoverageIsAShare) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    options_.seed = seed;
    const Result result = Render(2);
    EXPECT_EQ(result.stats.non_finite_samples, 0);
    for (const Rgba& p : result.film.pixels) {
      EXPECT_TRUE(IsFinite(p.Color()));
      EXPECT_GE(p.a, 0.0);
      EXPECT_LE(p.a, 1.0);
    }
    for (const auto& pixel : result.entries) {
      for (const ParameterDerivative& entry : pixel) {
        for (const Rgba& d : entry.d) EXPECT_TRUE(IsFinite(d.Color()) && std::isfinite(d.a));
      }
    }
  }
}

TEST_F(RendererOfAllParameters, SeedsAndViewsGiveOtherNumbers) {
  const Film first = renderer_.RenderPrimal(Sensor(), options_);
  options_.seed += 1;
  EXPECT_NE(renderer_.RenderPrimal(Sensor(), options_).pixels, first.pixels);
  options_.seed -= 1;
  options_.view = 1;
  EXPECT_NE(renderer_.RenderPrimal(Sensor(), options_).pixels, first.pixels);
  options_.view = 0;
  EXPECT_EQ(renderer_.RenderPrimal(Sensor(), options_).pixels, first.pixels);
}

TEST_F(RendererOfAllParameters, SettingParametersEqualsANewRenderer) {
  std::vector<double> values = layout_.Gather(renderer_.scene());
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] *= 1.0 + 0.01 * std::sin(static_cast<double>(i));
  Scene scene = tests::BallAndWall();
  layout_.Scatter(values, scene);
  renderer_.SetParameters(layout_, values);
  EXPECT_EQ(layout_.Gather(renderer_.scene()), values);
  const Renderer fresh(scene);
  EXPECT_EQ(renderer_.RenderPrimal(Sensor(), options_).pixels,
            fresh.RenderPrimal(scene.sensors[0], options_).pixels);
}

TEST_F(RendererOfAllParameters, ValuesThatAreNotValidChangeNothing) {
  const std::vector<double> before = layout_.Gather(renderer_.scene());
  const Film film = renderer_.RenderPrimal(Sensor(), options_);
  for (std::size_t i = 0; i < before.size(); ++i) {
    std::vector<double> values = before;
    for (double& value : values) value *= 1.01;
    values[i] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(renderer_.SetCheckedParameters(layout_, values), SceneError) << i;
  }
  EXPECT_EQ(layout_.Gather(renderer_.scene()), before);
  EXPECT_EQ(renderer_.RenderPrimal(Sensor(), options_).pixels, film.pixels);
}

TEST_F(RendererOfAllParameters, GainScalesColorNotCoverage) {
  Camera bright = Sensor();
  bright.gain = 2.0;
  const Film a = renderer_.RenderPrimal(Sensor(), options_);
  const Film b = renderer_.RenderPrimal(bright, options_);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    EXPECT_EQ(b.pixels[i], Rgba(a.pixels[i].Color() * 2.0, a.pixels[i].a));
  }
}

TEST_F(RendererOfAllParameters, CancellationReachesTheCaller) {
  const CancelFlag cancel(true);
  const RenderServices services{.cancel = &cancel};
  tests::RecordingSink sink(static_cast<std::size_t>(Sensor().width * Sensor().height));
  EXPECT_THROW((void)renderer_.RenderPrimal(Sensor(), options_, services), Cancelled);
  EXPECT_THROW(renderer_.RenderDerivative(Sensor(), 0, options_, layout_, sink, services),
               Cancelled);
}

TEST(Renderer, RefusesAnInvalidScene) {
  Scene scene = tests::BallAndWall();
  scene.meshes[0].material = 5;
  EXPECT_THROW(Renderer{scene}, SceneError);
}

TEST(Renderer, EmptySceneShowsTheSkyOrNothing) {
  Scene scene;
  const Camera camera = tests::CameraAt({0, 0, 2}, {0, 0, 0}, 4.0, 4, 4);
  EXPECT_EQ(Renderer(scene).RenderPrimal(camera, {}).pixels[5], Rgba());
  scene.emitters = {tests::ConstantEnvironment({1, 2, 3})};
  EXPECT_EQ(Renderer(scene).RenderPrimal(camera, {}).pixels[5], Rgba(1, 2, 3, 0));
}

TEST(Renderer, BoundsDoNotChangeTheImage) {
  // Under a hidden sky pixels without a mesh are skipped; a crop of the same view has other bounds,
  // equal numbers aside.
  Scene scene = tests::BallAndWall();
  scene.meshes.pop_back();
  const Film shown = Renderer(scene).RenderPrimal(scene.sensors[0], {});
  scene.environment_visible = false;
  const Film hidden = Renderer(scene).RenderPrimal(scene.sensors[0], {});
  for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
    EXPECT_EQ(shown.pixels[i].a, hidden.pixels[i].a);
    if (shown.pixels[i].a == 1.0) {
      EXPECT_EQ(shown.pixels[i], hidden.pixels[i]);
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::renderer_test
