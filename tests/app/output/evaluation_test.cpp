#include "app/output/evaluation.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "app/output/report.h"
#include "renderer/geometry/mesh_primitives.h"
#include "tests/app/output/html_check.h"
#include "tests/optim/round/synthetic_fit.h"

namespace pathfit::app::evaluation_test {
namespace {

using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;

constexpr int kViews = 4;

/// A coloured ball with a lamp, in photos by four cameras, of which the last is held out.
Scene Truth() {
  Scene scene = tests::BallScene(3, kViews, 32);
  scene.materials[0].vertex_colors = false;
  scene.materials[0].base_color = {0.6, 0.3, 0.2};
  scene.emitters.push_back({"lamp",
                            renderer::LightFrame::kWorld,
                            {},
                            renderer::PointEmitter{{2.0, 3.0, 1.0}, {8.0, 7.0, 6.0}}});
  return scene;
}

Experiment RunOf(const Scene& truth, const Scene& found) {
  Experiment run;
  run.scene = found;
  run.observations = tests::Photograph(truth, 256);
  const auto free = [&](const char* name, ParameterKind kind, int object) {
    run.fit.unknowns.emplace_back();
    run.fit.unknowns.back().name = name;
    run.fit.unknowns.back().kind = kind;
    run.fit.unknowns.back().object = object;
  };
  free("ball.translation", ParameterKind::kObjectTranslation, 0);
  free("paint.base_color", ParameterKind::kBaseColor, 0);
  free("lamp.intensity", ParameterKind::kLightIntensity, 1);
  return run;
}

EvaluationOptions Quick() {
  EvaluationOptions options;
  options.spp = 256;
  options.points = 4000;
  return options;
}

template <class Row>
const Row& Named(const std::vector<Row>& rows, std::string Row::*member, const std::string& name) {
  for (const Row& row : rows) {
    if (row.*member == name) return row;
  }
  throw std::logic_error("no row " + name);
}

TEST(Evaluation, TheTruthIsFoundToBeTrue) {
  const Scene truth = Truth();
  const Evaluation e = Evaluate(RunOf(truth, truth), &truth, Quick());
  ASSERT_EQ(e.views.size(), 4U);
  EXPECT_TRUE(e.views[3].validation);
  for (const EvaluatedView& view : e.views) {
    EXPECT_GT(view.psnr_srgb, 40.0);
    EXPECT_GT(view.ssim, 0.96);
    EXPECT_GT(view.iou, 0.99);
  }
  ASSERT_EQ(e.relit.size(), 4U);
  for (const EvaluatedView& view : e.relit) EXPECT_GT(view.psnr_srgb, 60.0);
  for (const char* name : {"all", "seen"}) {
    const auto& surface = Named(e.surfaces, &EvaluatedSurface::surface, name);
    EXPECT_NEAR(surface.mean_percent, 0.0, 1e-9);
    EXPECT_LT(surface.to_truth_angle_deg, 0.5);  // beside an edge either triangle is the nearest
  }
  for (const EvaluatedAppearance& row : e.appearance) EXPECT_NEAR(row.rms, 0.0, 1e-9);
  for (const EvaluatedParameter& row : e.parameters) EXPECT_EQ(row.rms_error, 0.0);
  ASSERT_EQ(e.lights.size(), 2U);
  EXPECT_NEAR(e.lights[0].radiance_percent, 0.0, 1e-9);
  EXPECT_EQ(e.lights[1].ratio_g, 1.0);
  for (const EvaluatedCamera& row : e.cameras) {
    EXPECT_EQ(row.position_m, 0.0);
    EXPECT_NEAR(row.rotation_deg, 0.0, 1e-9);
  }
  EXPECT_TRUE(e.notes.empty());
}

TEST(Evaluation, ErrorsAreWhatWasPutIn) {
  const Scene truth = Truth();
  Scene found = truth;
  found.meshes[0].pose.translation = {0.05, 0.0, 0.0};
  found.materials[0].base_color = {0.3, 0.15, 0.1};
  auto& lamp = std::get<renderer::PointEmitter>(found.emitters[1].light);
  lamp.intensity *= 2.0;
  lamp.position.z += 0.5;
  auto& sky = std::get<renderer::EnvironmentEmitter>(found.emitters[0].light);
  sky.intensity *= 2.0;
  found.sensors[1].gain = 2.0;
  found.sensors[1].world_from_camera.translation.y += 0.1;
  found.sensors[2].rotation = {0.0, 0.0, 0.02};
  Experiment run = RunOf(truth, found);
  const Evaluation e = Evaluate(run, &truth, Quick());

  const auto& all = Named(e.surfaces, &EvaluatedSurface::surface, "all");
  EXPECT_NEAR(all.to_truth_mean, 0.025, 0.002);  // 0.05 |cos| over the ball
  EXPECT_NEAR(all.from_truth_most, 0.05, 0.003);
  const auto& colour = Named(e.appearance, &EvaluatedAppearance::surface, "all");
  EXPECT_NEAR(colour.rms_percent, 50.0, 1e-6);
  EXPECT_NEAR(colour.scaled_percent, 0.0, 1e-4);
  EXPECT_NEAR(Named(e.parameters, &EvaluatedParameter::name, "ball.translation").rms_error,
              0.05 / std::sqrt(3.0),
              1e-12);
  EXPECT_NEAR(
      Named(e.parameters, &EvaluatedParameter::name, "lamp.intensity").largest_error, 8.0, 1e-12);
  const auto& of_lamp = Named(e.lights, &EvaluatedLight::light, "lamp");
  EXPECT_NEAR(of_lamp.position_m, 0.5, 1e-12);
  EXPECT_NEAR(of_lamp.ratio_b, 2.0, 1e-12);
  const auto& of_sky = Named(e.lights, &EvaluatedLight::type, "environment");
  EXPECT_NEAR(of_sky.radiance_percent, 100.0, 1e-6);
  EXPECT_NEAR(of_sky.scaled_percent, 0.0, 1e-4);
  EXPECT_NEAR(of_sky.ratio_r, 2.0, 1e-9);
  EXPECT_NEAR(e.cameras[1].exposure_ev, 1.0, 1e-12);
  EXPECT_NEAR(e.cameras[1].position_m, 0.1, 1e-12);
  EXPECT_NEAR(e.cameras[2].rotation_deg, 0.02 * 180.0 / 3.14159265358979, 1e-9);

  // Of a scene in millimetres.
  run.observations.metres_per_unit = 0.001;
  const Evaluation small = Evaluate(run, &truth, Quick());
  EXPECT_NEAR(small.surfaces[0].to_truth_mean, 0.001 * e.surfaces[0].to_truth_mean, 1e-12);
  EXPECT_EQ(small.surfaces[0].mean_percent, e.surfaces[0].mean_percent);
  EXPECT_NEAR(small.lights[1].position_m, 0.001 * e.lights[1].position_m, 1e-12);
  EXPECT_NEAR(small.cameras[1].position_m, 1e-4, 1e-12);
}

/// A map of few texels cannot be the truth's; the best it can be has no error.
TEST(Evaluation, CoarseMapsAreComparedWithTheMeansOfTheTruth) {
  Scene truth = Truth();
  auto& sky = std::get<renderer::EnvironmentEmitter>(truth.emitters[0].light);
  constexpr int kWidth = 16, kHeight = 8;
  sky.width = kWidth;
  sky.height = kHeight;
  std::vector<Rgb> fine(kWidth * kHeight), coarse(kWidth * kHeight / 4);
  std::vector<double> weights(coarse.size());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double value = 1.0 + (x * 7 + y * 3) % 5;
      fine[static_cast<std::size_t>(y * kWidth + x)] = {value, 2.0 * value, 1.0};
      const auto to = static_cast<std::size_t>(y / 2 * (kWidth / 2) + x / 2);
      const double weight = std::sin(3.14159265358979 * (y + 0.5) / kHeight);
      coarse[to] += Rgb{value, 2.0 * value, 1.0} * weight;
      weights[to] += weight;
    }
  }
  for (std::size_t i = 0; i < coarse.size(); ++i) coarse[i] = coarse[i] / weights[i];
  sky.texels = fine;
  Scene found = truth;
  auto& small = std::get<renderer::EnvironmentEmitter>(found.emitters[0].light);
  small.width = kWidth / 2;
  small.height = kHeight / 2;
  small.texels = coarse;
  const auto light = [&](const Scene& scene) {
    return Evaluate(RunOf(truth, scene), &truth, Quick()).lights[0];
  };
  EXPECT_GT(light(found).scaled_percent, 10.0);
  EXPECT_NEAR(light(found).texels_percent, 0.0, 1e-4);
  EXPECT_NEAR(light(truth).texels_percent, 0.0, 1e-9);
  small.intensity *= 2.0;
  EXPECT_NEAR(light(found).texels_percent, 100.0, 1e-4);
  EXPECT_NEAR(light(found).texels_scaled_percent, 0.0, 1e-3);
}

/// Half as bright and twice as lit looks alike, and not under another light; a factor mends that.
TEST(Evaluation, ColoursAndLightsShareAFactor) {
  const Scene truth = Truth();
  Scene found = truth;
  found.materials[0].base_color = {0.3, 0.15, 0.1};
  for (renderer::Emitter& light : found.emitters) LightIntensity(light) *= 2.0;
  const Evaluation e = Evaluate(RunOf(truth, found), &truth, Quick());
  for (const EvaluatedView& view : e.views) EXPECT_GT(view.psnr_srgb, 40.0);
  for (const EvaluatedView& view : e.relit) {
    EXPECT_LT(view.psnr_srgb, 20.0);
    EXPECT_GT(view.psnr_scaled, 60.0);
  }
}

TEST(Evaluation, ErrorsInAFewPlacesAreToldFromErrorsEverywhere) {
  Scene truth = Truth();
  renderer::Material& paint = truth.materials[0];
  paint.bsdf = renderer::MetallicRoughnessBsdf{};
  paint.vertex_colors = true;
  truth.meshes[0].mesh.colors.assign(truth.meshes[0].mesh.positions.size(), {0.6, 0.3, 0.2});
  Scene found = truth;
  for (std::size_t i = 0; i < 20; ++i) found.meshes[0].mesh.colors[i] = {0.1, 0.1, 0.1};
  const Evaluation few = Evaluate(RunOf(truth, found), &truth, Quick());
  const EvaluatedAppearance& spots = Named(few.appearance, &EvaluatedAppearance::surface, "all");
  EXPECT_GT(spots.rms, 0.01);
  EXPECT_NEAR(spots.median, 0.0, 1e-9);

  for (renderer::Rgb& color : found.meshes[0].mesh.colors) color = {0.5, 0.2, 0.1};
  const Evaluation all = Evaluate(RunOf(truth, found), &truth, Quick());
  const EvaluatedAppearance& cast = Named(all.appearance, &EvaluatedAppearance::surface, "all");
  EXPECT_NEAR(cast.median, 0.1, 1e-6);

  const EvaluatedAppearance& metal =
      Named(all.appearance, &EvaluatedAppearance::property, "metallic");
  EXPECT_EQ(metal.rms, 0.0);
  EXPECT_TRUE(std::isnan(metal.rms_percent));  // there is no metal to have a share of
  EXPECT_EQ(EvaluationText(all).find("nan"), std::string::npos);
}

TEST(Evaluation, ObjectsThatShineByAPictureAreNoLamps) {
  Scene truth = Truth();
  truth.meshes[0].mesh = renderer::MakeRectangle();
  truth.textures.emplace_back();
  truth.textures[0].name = "glow";
  truth.textures[0].width = truth.textures[0].height = 2;
  truth.textures[0].texels = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.3, 0.2, 0.1}};
  renderer::AreaEmitter glow{0, {1.0, 1.0, 1.0}, 0};
  truth.emitters.push_back({"glow", renderer::LightFrame::kWorld, {}, glow});
  const Evaluation object = Evaluate(RunOf(truth, truth), &truth, Quick());
  EXPECT_FALSE(object.surfaces.empty());
  EXPECT_FALSE(object.appearance.empty());
  glow.texture = -1;
  truth.emitters.back().light = glow;
  const Evaluation lamp = Evaluate(RunOf(truth, truth), &truth, Quick());
  EXPECT_TRUE(lamp.surfaces.empty());
  EXPECT_TRUE(std::ranges::any_of(lamp.notes, [](const std::string& note) {
    return note.find("lamps that shine alike") != std::string::npos;
  }));
}

TEST(Evaluation, WhatDoesNotCompareIsSaid) {
  const Scene truth = Truth();
  Scene other = truth;
  other.meshes[0].mesh = renderer::MakeIcosphere(2, 1.0);
  other.emitters.pop_back();
  other.sensors.clear();
  const Evaluation e = Evaluate(RunOf(truth, truth), &other, Quick());
  EXPECT_TRUE(e.cameras.empty());
  ASSERT_EQ(e.notes.size(), 3U);
  EXPECT_EQ(e.notes[0],
            "ball.translation: moves another mesh than the truth's: compared as "
            "surfaces only");
  EXPECT_EQ(e.notes[1], "lamp.intensity: the truth has no such number");
  EXPECT_EQ(e.notes[2], "light 'lamp': the truth has none to compare it with");
  EXPECT_EQ(Evaluate(RunOf(truth, truth), nullptr, Quick()).notes.size(), 1U);
}

TEST(Evaluation, JsonTextAndPageHoldTheFigures) {
  const Scene truth = Truth();
  Evaluation e = Evaluate(RunOf(truth, truth), &truth, Quick());
  e.notes.emplace_back("</script><b>");
  Json json = {{"run", "a"}, {"truth", "b"}};
  json.update(EvaluationJson(e));
  EXPECT_EQ(json.at("schema"), "pathfit-eval-1");
  EXPECT_EQ(json.at("held_out").at("views"), 1);
  EXPECT_EQ(json.at("fitted").at("views"), 3);
  EXPECT_EQ(json.at("views").size(), 4U);
  EXPECT_TRUE(json.at("views")[0].at("psnr_scaled_db").is_null());
  EXPECT_TRUE(json.at("relit").at("psnr_scaled_db").is_number());
  EXPECT_EQ(json.at("surfaces")[1].at("surface"), "seen");
  EXPECT_TRUE(json.at("lights")[1].at("direction_deg").is_null());
  EXPECT_EQ(HtmlFault(ReportPage(EvaluationPage(e, json))), "");
  const std::string text = EvaluationText(e);
  EXPECT_EQ(text.rfind("Held out: PSNR ", 0), 0U) << text;
  EXPECT_NE(text.find("of 3 views"), std::string::npos) << text;
}

}  // namespace
}  // namespace pathfit::app::evaluation_test
