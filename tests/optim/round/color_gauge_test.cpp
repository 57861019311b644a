#include "optim/round/color_gauge.h"

#include <cmath>

#include <gtest/gtest.h>

#include "optim/round/fit.h"
#include "renderer/renderer.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/optim/round/free_fit.h"
#include "tests/optim/round/synthetic_fit.h"

namespace pathfit::color_gauge_test {
namespace {

using optim::ColorGauge;
using optim::GaugeSource;
using renderer::ParameterKind;
using renderer::Rgb;

void ExpectNear(const Rgb& a, const Rgb& b, double tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "channel " << c;
}

class ColorGaugeTest : public tests::FreeFit {
 protected:
  ColorGaugeTest() {
    spec_.estimators.max_bounces = 1;
    spec_.gauge.rule = ColorGauge::Rule::kAuto;
    optim::UnknownSpec& colors = Free(ParameterKind::kVertexColors, 0);
    colors.lower = 0.01;
    colors.upper = 0.99;
    Free(ParameterKind::kEnvironmentTexels, 0).parameterization = optim::Parameterization::kLog;
    for (Rgb& color : moved_.meshes[0].mesh.colors) color = {0.2, 0.3, 0.4};
  }

  [[nodiscard]] optim::ParameterSet Set() const {
    std::vector<int> free(spec_.unknowns.size());
    for (std::size_t i = 0; i < free.size(); ++i) free[i] = static_cast<int>(i);
    return {start_, spec_.unknowns, free, {0}, exposure_};
  }

  renderer::Scene start_ = tests::BallScene(1, 2, 24);
  renderer::Scene moved_ = start_;
  optim::ExposureModel exposure_{{1.0, 1.0}, {}};
};

TEST_F(ColorGaugeTest, MeanColorIsThatOfTheSurface) {
  ExpectNear(optim::MeanBaseColor(moved_, -1), {0.2, 0.3, 0.4}, 1e-12);
  ExpectNear(optim::MeanBaseColor(moved_, 0), {0.2, 0.3, 0.4}, 1e-12);
  // A quad with one colour on a quarter of its texture.
  renderer::Scene quad;
  quad.meshes = {{"quad", tests::Rectangle(), 0}};
  renderer::Mesh& mesh = quad.meshes[0].mesh;
  mesh.uvs.clear();
  for (const renderer::Vec3& p : mesh.positions) {
    mesh.uvs.push_back({p.x > 0.0 ? 1.0 : 0.0, p.y > 0.0 || p.z > 0.0 ? 1.0 : 0.0});
  }
  mesh.uv_triangles = mesh.triangles;
  quad.textures = {{"picture", 2, 2, std::vector<Rgb>(4, Rgb{0.0, 0.0, 0.0})}};
  quad.textures[0].texels[0] = {0.8, 0.4, 0.2};
  quad.textures[0].wrap = renderer::TextureWrap::kClamp;
  quad.materials = {{"paint", renderer::LambertBsdf{}, {}, false, 0}};
  ExpectNear(optim::MeanBaseColor(quad, -1), {0.2, 0.1, 0.05}, 1e-3);
}

TEST_F(ColorGaugeTest, KeepsTheMeanOfTheStartAndThePictures) {
  // The same factor for all channels: directions of the sky are chosen by its brightness.
  for (Rgb& color : moved_.meshes[0].mesh.colors) color = {0.3, 0.3, 0.3};
  renderer::Scene fixed = moved_;
  FixColorGauge(Set(), spec_, start_, fixed);
  ExpectNear(optim::MeanBaseColor(fixed, -1), {0.6, 0.6, 0.6}, 1e-9);
  renderer::RenderOptions options;
  options.max_bounces = 1;
  const auto before = renderer::Renderer(moved_).RenderPrimal(moved_.sensors[0], options);
  const auto after = renderer::Renderer(fixed).RenderPrimal(fixed.sensors[0], options);
  for (std::size_t p = 0; p < before.pixels.size(); ++p) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(before.pixels[p][c], after.pixels[p][c], 1e-9 * (1.0 + before.pixels[p][c]));
    }
  }
}

TEST_F(ColorGaugeTest, TakesTheValueOfACard) {
  spec_.gauge = {ColorGauge::Rule::kMeanColor, {0.18}, "paint"};
  renderer::Scene fixed = moved_;
  FixColorGauge(Set(), spec_, start_, fixed);
  ExpectNear(optim::MeanBaseColor(fixed, -1), {0.18, 0.18, 0.18}, 1e-9);
}

TEST_F(ColorGaugeTest, OtherColorsMoveByMoreWhereSomeMeetTheirBounds) {
  spec_.gauge = {ColorGauge::Rule::kMeanColor, {0.18}, "paint"};
  auto& colors = moved_.meshes[0].mesh.colors;
  const std::size_t half = colors.size() / 2;
  for (std::size_t i = 0; i < half; ++i) colors[i] = {0.01, 0.012, 0.95};
  renderer::Scene fixed = moved_;
  FixColorGauge(Set(), spec_, start_, fixed);
  ExpectNear(optim::MeanBaseColor(fixed, -1), {0.18, 0.18, 0.18}, 2e-5);
  const auto texel = [](const renderer::Scene& scene) {
    return std::get<renderer::EnvironmentEmitter>(scene.emitters[0].light).texels[5];
  };
  for (int c = 0; c < 3; ++c) {
    double least = 1.0;
    for (const Rgb& color : fixed.meshes[0].mesh.colors) least = std::min(least, color[c]);
    EXPECT_GE(least, 0.01 - 1e-12) << "channel " << c;
    EXPECT_NEAR(fixed.meshes[0].mesh.colors[half][c] * texel(fixed)[c],
                colors[half][c] * texel(moved_)[c],
                1e-6)
        << "channel " << c;
  }
}

TEST_F(ColorGaugeTest, AMeanThatNoColorsReachChangesNothing) {
  spec_.gauge = {ColorGauge::Rule::kMeanColor, {0.995}, "paint"};
  renderer::Scene fixed = moved_;
  FixColorGauge(Set(), spec_, start_, fixed);
  EXPECT_EQ(optim::MeanBaseColor(fixed, -1).r, optim::MeanBaseColor(moved_, -1).r);
}

TEST_F(ColorGaugeTest, WhatIsKnownOrSeenDecides) {
  EXPECT_EQ(SourceOfGauge(Set(), spec_, start_)->source, GaugeSource::kMeanColor);
  spec_.gauge.rule = ColorGauge::Rule::kPhotos;
  EXPECT_EQ(SourceOfGauge(Set(), spec_, start_)->source, GaugeSource::kNothing);
  spec_.gauge.rule = ColorGauge::Rule::kAuto;
  spec_.estimators.max_bounces = 3;
  EXPECT_EQ(SourceOfGauge(Set(), spec_, start_)->source, GaugeSource::kPhotos);
  spec_.estimators.max_bounces = 1;
  renderer::Scene glossy = start_;
  glossy.materials[0].bsdf = renderer::MetallicRoughnessBsdf{};
  EXPECT_EQ(SourceOfGauge(Set(), spec_, glossy)->source, GaugeSource::kPhotos);
  spec_.gauge.rule = ColorGauge::Rule::kMeanColor;
  EXPECT_EQ(SourceOfGauge(Set(), spec_, glossy)->source, GaugeSource::kMeanColor);

  const optim::ParameterSet colors(start_, spec_.unknowns, {0}, {0}, exposure_);
  EXPECT_FALSE(SourceOfGauge(colors, spec_, start_));
  start_.emitters.push_back({"sun",
                             renderer::LightFrame::kWorld,
                             {},
                             renderer::DirectionalEmitter{{0, -1, 0}, {1, 1, 1}}});
  const auto known = SourceOfGauge(Set(), spec_, start_);
  EXPECT_EQ(known->source, GaugeSource::kKnownLight);
  EXPECT_EQ(known->known, "sun");
  spec_.unknowns.emplace_back().kind = ParameterKind::kExposure;
  spec_.unknowns.back().object = -1;
  const auto exposed = SourceOfGauge(Set(), spec_, start_);
  EXPECT_EQ(exposed->source, GaugeSource::kNothing);
  EXPECT_TRUE(exposed->is_of_exposures);
  EXPECT_EQ(SourceOfGauge(Set(), spec_, glossy)->source, GaugeSource::kMeanColor);  // free lights
  glossy.emitters = start_.emitters;
  EXPECT_EQ(SourceOfGauge(Set(), spec_, glossy)->source, GaugeSource::kPhotos);
  renderer::Scene same = start_;
  FixColorGauge(Set(), spec_, start_, same);
  EXPECT_EQ(same.meshes[0].mesh.colors[0].r, start_.meshes[0].mesh.colors[0].r);
}

// Photos show the products of two colours with an unknown light; the rule says the rest.
TEST_F(ColorGaugeTest, ErrorsAreThoseOnTheRule) {
  spec_.unknowns.clear();
  renderer::SceneMesh second = start_.meshes[0];
  start_.meshes[0].pose.translation = {-0.7, 0.0, 0.0};
  second.name = "second";
  second.material = 1;
  second.pose.translation = {0.7, 0.0, 0.0};
  for (renderer::SceneMesh* ball : {&start_.meshes[0], &second}) ball->pose.scale = 0.5;
  start_.meshes.push_back(second);
  start_.materials = {{"paint", renderer::LambertBsdf{}, {0.4, 0.4, 0.4}},
                      {"chalk", renderer::LambertBsdf{}, {0.4, 0.4, 0.4}}};
  start_.emitters = {{"sun",
                      renderer::LightFrame::kWorld,
                      {},
                      renderer::DirectionalEmitter{{0.0, -0.6, -0.8}, {2.0, 2.0, 2.0}}}};
  renderer::Scene truth = start_;
  truth.materials[0].base_color = {0.2, 0.3, 0.4};
  truth.materials[1].base_color = {0.4, 0.3, 0.2};
  std::get<renderer::DirectionalEmitter>(truth.emitters[0].light).irradiance = {3.0, 3.0, 3.0};
  for (const int material : {0, 1}) {
    optim::UnknownSpec& color = Free(ParameterKind::kBaseColor, material);
    color.lower = 0.01;
    color.upper = 0.99;
  }
  optim::UnknownSpec& light = Free(ParameterKind::kLightIntensity, 0);
  light.parameterization = optim::Parameterization::kLog;
  light.lower = 1e-3;
  optim::ObservationSet photos = tests::Photograph(truth, 64);
  renderer::CounterRng noise(7);
  tests::EditPhotos(
      [&](renderer::Image& photo) {
        for (float& value : photo.data) {
          value += 0.02F * static_cast<float>(noise.Next() - 0.5);
        }
      },
      photos);
  spec_.stages = {Stage(30, 16, 64)};
  const auto fit = [&](const ColorGauge& gauge) {
    spec_.gauge = gauge;
    tests::RecordingObserver observer;
    return optim::RunFit(start_, photos, spec_, observer, {});
  };
  const optim::FitResult by_rule = fit({ColorGauge::Rule::kMeanColor, {0.3}, ""});
  for (const int c : {0, 1, 2}) {
    const auto scalar = static_cast<std::size_t>(c);
    const double found = by_rule.scene.materials[0].base_color[c];
    const double error = by_rule.standard_errors.at("paint.base_color")[scalar];
    EXPECT_LT(error, 3e-3);
    EXPECT_LT(std::abs(found - truth.materials[0].base_color[c]), 4.0 * error);
    // The mean does not move: of surfaces of one size, what one colour gains the other loses.
    EXPECT_NEAR(error, by_rule.standard_errors.at("chalk.base_color")[scalar], 1e-3 * error);
    EXPECT_LT(by_rule.standard_errors.at("sun.intensity")[scalar], 0.03);
  }
  const optim::FitResult without = fit({ColorGauge::Rule::kPhotos, {}, ""});
  EXPECT_GT(without.standard_errors.at("paint.base_color")[0], 0.1);
}

// A photo tells a metal with a dark colour from paint by little; the prior decides.
TEST_F(ColorGaugeTest, BinaryPriorDecidesHalfDeterminedMetallic) {
  spec_.unknowns.clear();
  const auto material = [](double metallic) {
    return renderer::MetallicRoughnessBsdf{0.9, metallic, 1.0};
  };
  start_.materials[0] = {"paint", material(0.0), {0.3, 0.3, 0.3}};
  renderer::Scene truth = start_;
  std::get<renderer::MetallicRoughnessBsdf>(start_.materials[0].bsdf).metallic = 0.35;
  Free(ParameterKind::kBaseColor, 0);
  Free(ParameterKind::kMetallic, 0);
  spec_.unknowns[0].lower = 0.01;
  spec_.unknowns[0].upper = 0.99;
  spec_.unknowns[1].lower = 0.0;
  spec_.unknowns[1].upper = 1.0;
  // The light is believed to be a little too bright: no metallic between 0 and 1 fits best.
  truth.emitters = start_.emitters = {tests::GradientEnvironment(8, 4)};
  for (Rgb& texel : std::get<renderer::EnvironmentEmitter>(start_.emitters[0].light).texels) {
    texel = texel * 1.15;
  }
  const optim::ObservationSet photos = tests::Photograph(truth, 16);
  const auto fitted = [&](double weight) {
    spec_.unknowns[1].binary_weight = weight;
    spec_.stages = {Stage(12, 8, 16)};
    tests::RecordingObserver observer;
    const auto scene = optim::RunFit(start_, photos, spec_, observer, {}).scene;
    return std::get<renderer::MetallicRoughnessBsdf>(scene.materials[0].bsdf).metallic;
  };
  const double without = fitted(0.0);
  const double with = fitted(0.1);
  RecordProperty("without", std::to_string(without));
  EXPECT_GT(without, 0.05);
  EXPECT_LT(std::min(with, 1.0 - with), 0.02) << "without the prior: " << without;
}

}  // namespace
}  // namespace pathfit::color_gauge_test
