#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "optim/round/fit.h"
#include "tests/optim/round/free_fit.h"
#include "tests/optim/round/synthetic_fit.h"

// Scenes rendered by this renderer and recovered from other starts, within seconds. The tolerances
// are two to three times what was measured, and several times below the error of the start.
namespace pathfit::fit_recovers_test {
namespace {

using optim::FitResult;
using optim::UnknownSpec;
using renderer::ParameterKind;

constexpr int kNumViews = 7;  // the last is held out
constexpr int kSize = 64;

class FitRecoversTest : public tests::FreeFit {
 protected:
  FitResult Fit(int num_rounds) {
    spec_.stages = CoarseAndFine(Stage(num_rounds, 8, 32));
    spec_.seed = 3;
    return optim::RunFit(start_, tests::Photograph(truth_, 256), spec_, observer_, {});
  }

  static renderer::SharedVector<renderer::Rgb>& Texels(renderer::Scene& scene) {
    return std::get<renderer::EnvironmentEmitter>(scene.emitters[0].light).texels;
  }

  static double Rms(const std::vector<renderer::Rgb>& a, const std::vector<renderer::Rgb>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        sum += (a[i][c] - b[i][c]) * (a[i][c] - b[i][c]) / (3.0 * static_cast<double>(a.size()));
      }
    }
    return std::sqrt(sum);
  }

  renderer::Scene start_ = tests::BallScene(2, kNumViews, kSize);
  renderer::Scene truth_ = start_;
  tests::RecordingObserver observer_;
};

TEST_F(FitRecoversTest, ShapeFromShadingAndSilhouettes) {
  tests::Bump(truth_);
  UnknownSpec& vertices = Free(ParameterKind::kVertexPositions, 0);
  vertices.laplacian_weight = 1e-3;
  vertices.large_steps_lambda = 10.0;
  const double before = tests::BumpError(start_);
  const FitResult result = Fit(10);
  EXPECT_GT(before, 0.05);
  EXPECT_LT(tests::BumpError(result.scene), 0.005);  // radius 1; a pixel is 0.045
  EXPECT_GT(result.stages.back().iou_val, 0.985);
  EXPECT_GT(result.stages.back().psnr_linear_val, result.stages.front().psnr_linear_val + 8.0);
}

TEST_F(FitRecoversTest, ColorsOfTheVertices) {
  renderer::Mesh& mesh = truth_.meshes[0].mesh;
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    const renderer::Vec3& p = mesh.positions[i];
    mesh.colors[i] = {
        0.5 + 0.3 * std::sin(4 * p.x), 0.5 + 0.3 * std::cos(3 * p.y), 0.4 + 0.2 * p.z};
  }
  UnknownSpec& colors = Free(ParameterKind::kVertexColors, 0);
  colors.lower = 0.01;
  colors.upper = 0.99;
  colors.smooth_weight = 1e-4;
  const double before = Rms(start_.meshes[0].mesh.colors, mesh.colors);
  const FitResult result = Fit(6);
  EXPECT_GT(before, 0.2);
  EXPECT_LT(Rms(result.scene.meshes[0].mesh.colors, mesh.colors), 0.008);
}

TEST_F(FitRecoversTest, EnvironmentFromAMatteBall) {
  std::fill(Texels(start_).begin(), Texels(start_).end(), renderer::Rgb{1.0, 1.0, 1.0});
  UnknownSpec& texels = Free(ParameterKind::kEnvironmentTexels, 0);
  texels.parameterization = optim::Parameterization::kLog;
  texels.smooth_weight = 1e-4;  // a matte ball sees only the low frequencies
  const double before = Rms(Texels(start_), Texels(truth_));
  FitResult result = Fit(8);
  EXPECT_GT(before, 0.39);
  EXPECT_LT(Rms(Texels(result.scene), Texels(truth_)), 0.13);
  EXPECT_GT(result.stages.back().psnr_linear_val, 30.0);
}

// Lamps a thousand times as bright as the sky. Where the lobe has become narrower than they are,
// the derivative by the roughness is all noise, and nothing leads back from there.
TEST_F(FitRecoversTest, RoughnessOfAMetalBallUnderBrightLamps) {
  auto& light = std::get<renderer::EnvironmentEmitter>(truth_.emitters[0].light);
  light.width = 32;
  light.height = 16;
  light.texels.Edit().assign(32 * 16, {0.5, 0.5, 0.5});
  for (const std::size_t lamp : {32U * 4 + 5, 32U * 6 + 15, 32U * 3 + 25}) {
    for (const std::size_t texel : {lamp, lamp + 1, lamp + 32, lamp + 33}) {
      light.texels.Edit()[texel] = {500.0, 480.0, 450.0};
    }
  }
  renderer::Mesh& ball = truth_.meshes[0].mesh;
  ball.normals = ball.positions;
  ball.normal_triangles = ball.triangles;
  renderer::Material& material = truth_.materials[0];
  material.vertex_colors = false;
  material.base_color = {0.9, 0.7, 0.3};
  material.bsdf = renderer::MetallicRoughnessBsdf{0.2, 1.0};
  start_ = truth_;
  start_.materials[0].base_color = {0.5, 0.5, 0.5};
  start_.materials[0].bsdf = renderer::MetallicRoughnessBsdf{0.7, 0.5};
  for (const ParameterKind kind :
       {ParameterKind::kBaseColor, ParameterKind::kRoughness, ParameterKind::kMetallic}) {
    UnknownSpec& unknown = Free(kind, 0);
    unknown.lower = kind == ParameterKind::kMetallic ? 0.0 : 0.03;
    unknown.upper = kind == ParameterKind::kBaseColor ? 0.99 : 1.0;
  }
  const optim::ObservationSet photos = tests::Photograph(truth_, 256);
  for (const std::uint64_t seed : {2U, 3U}) {  // three of six seeds ended there
    spec_.seed = seed;
    spec_.stages = {Stage(60, 8, 64)};
    const FitResult result = optim::RunFit(start_, photos, spec_, observer_, {});
    const auto& found = std::get<renderer::MetallicRoughnessBsdf>(result.scene.materials[0].bsdf);
    EXPECT_NEAR(found.roughness, 0.2, 0.01) << "seed " << seed;
    EXPECT_NEAR(found.metallic, 1.0, 0.05) << "seed " << seed;
  }
}

// Texels that hardly anything tells: the whole step to the minimum of the model leads too far.
TEST_F(FitRecoversTest, LightThatPhotosHardlyTellEndsNoWorseThanItsRounds) {
  std::fill(Texels(start_).begin(), Texels(start_).end(), renderer::Rgb{0.3, 0.3, 0.3});
  UnknownSpec& texels = Free(ParameterKind::kEnvironmentTexels, 0);
  texels.parameterization = optim::Parameterization::kLog;
  texels.log_smooth_weight = 1.0;
  spec_.stages = {Stage(20, 8, 64)};
  optim::ObservationSet photos = tests::Photograph(truth_, 256);
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0F, 0.01F);
  const auto edit = [&](renderer::Image& photo) {
    for (float& x : photo.data) x = std::max(0.0F, x + noise(random));
  };
  tests::EditPhotos(edit, photos);
  const FitResult result = optim::RunFit(start_, photos, spec_, observer_, {});
  EXPECT_LT(result.stages.back().cost_after, 1.5 * observer_.rounds.back().cost_total);
}

TEST_F(FitRecoversTest, LightDespiteWhatStandsBeforeTheObject) {
  const auto& light = [](renderer::Scene& scene) -> renderer::EnvironmentEmitter& {
    return std::get<renderer::EnvironmentEmitter>(scene.emitters[0].light);
  };
  light(start_).intensity = {0.5, 0.5, 0.5};
  Free(ParameterKind::kLightIntensity, 0).parameterization = optim::Parameterization::kLog;
  spec_.stages = {Stage(8, 8, 32)};
  optim::ObservationSet photos = tests::Photograph(truth_, 256);
  const auto edit = [](renderer::Image& photo) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = kSize / 2; x < kSize / 2 + 5; ++x) {
        for (int c = 0; c < 3; ++c) photo.At(x, y, c) = 3.0F;  // a white stick
      }
    }
  };
  tests::EditPhotos(edit, photos);
  const auto error = [&](double huber) {
    spec_.loss.robust_huber = huber;
    renderer::Scene fitted = optim::RunFit(start_, photos, spec_, observer_, {}).scene;
    return std::abs(light(fitted).intensity.g - 1.0);
  };
  EXPECT_GT(error(0.0), 0.3);
  EXPECT_LT(error(0.03), 0.05);
}

TEST_F(FitRecoversTest, ExposuresUpToTheFactorSharedWithTheLight) {
  for (int i = 0; i < kNumViews; ++i) {
    truth_.sensors[static_cast<std::size_t>(i)].gain = std::exp2(0.3 * std::sin(5.0 * i));
  }
  Free(ParameterKind::kExposure, -1);
  Free(ParameterKind::kLightIntensity, 0).parameterization = optim::Parameterization::kLog;
  const FitResult result = Fit(6);
  double mean_ev = 0.0, mean_error = 0.0, square = 0.0;
  for (int i = 0; i < kNumViews; ++i) {
    const auto v = static_cast<std::size_t>(i);
    const double error = std::log2(result.scene.sensors[v].gain / truth_.sensors[v].gain);
    mean_error += error / kNumViews;
    square += error * error / kNumViews;
    if (i + 1 < kNumViews) {
      mean_ev += std::log2(result.scene.sensors[v].gain) / (kNumViews - 1);
    }
  }
  EXPECT_LT(std::sqrt(square - mean_error * mean_error), 0.01);  // EV, the held-out view included
  EXPECT_NEAR(mean_ev, 0.0, 1e-9);                               // the gauge
  EXPECT_EQ(std::ranges::count_if(result.standard_errors,
                                  [](const auto& of_group) {
                                    const auto& [name, errors] = of_group;
                                    return name.ends_with(".exposure") && errors.size() == 1 &&
                                           errors[0] > 1e-5 && errors[0] < 0.3;
                                  }),
            kNumViews - 1);
}

/// What all photos have in common, also where they are held out.
TEST_F(FitRecoversTest, TheLensOfAllPhotos) {
  for (renderer::Camera& sensor : truth_.sensors) {
    sensor.fx *= 1.03;
    sensor.fy *= 1.03;
    sensor.vignetting = {-0.35, 0.1, 0.0};
  }
  const renderer::Camera& right = truth_.sensors[0];
  for (const ParameterKind kind : {ParameterKind::kFocal, ParameterKind::kVignetting}) {
    Free(kind, -1).sharing.assign(kNumViews, 0);
  }
  const FitResult result = Fit(12);
  EXPECT_EQ(result.standard_errors.count("camera.focal"), 1U);
  for (const renderer::Camera& sensor : result.scene.sensors) {  // the held-out one, too
    EXPECT_NEAR(sensor.fx, right.fx, 2e-3 * right.fx);
    EXPECT_NEAR(sensor.fy, right.fy, 2e-3 * right.fy);
    const double corner = sensor.VignettingRadius2(0, 0);
    for (const double r2 : {0.1, 0.3, 0.3 * corner}) {
      EXPECT_NEAR(sensor.vignetting.At(r2), right.vignetting.At(r2), 5e-3);
    }
    EXPECT_EQ(sensor.vignetting, result.scene.sensors[0].vignetting);
  }
}

TEST_F(FitRecoversTest, WhiteBalancesUpToTheFactorsSharedWithTheLight) {
  for (int i = 0; i < kNumViews; ++i) {
    renderer::Camera& sensor = truth_.sensors[static_cast<std::size_t>(i)];
    sensor.red = std::exp2(0.2 * std::sin(5.0 * i));
    sensor.blue = std::exp2(0.2 * std::cos(4.0 * i));
  }
  Free(ParameterKind::kExposure, -1);
  Free(ParameterKind::kWhiteBalance, -1);
  Free(ParameterKind::kLightIntensity, 0).parameterization = optim::Parameterization::kLog;
  const FitResult result = Fit(6);
  const auto scatter_ev = [&](double renderer::Camera::*factor) {
    double sum = 0.0, square = 0.0;
    for (std::size_t v = 0; v < kNumViews; ++v) {  // the held-out view included
      const double error = std::log2(result.scene.sensors[v].*factor / truth_.sensors[v].*factor);
      sum += error / kNumViews;
      square += error * error / kNumViews;
    }
    return std::sqrt(square - sum * sum);
  };
  EXPECT_LT(scatter_ev(&renderer::Camera::gain), 0.01);
  EXPECT_LT(scatter_ev(&renderer::Camera::red), 0.01);
  EXPECT_LT(scatter_ev(&renderer::Camera::blue), 0.01);
}

}  // namespace
}  // namespace pathfit::fit_recovers_test
