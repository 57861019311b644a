#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "optim/round/fit.h"
#include "renderer/geometry/mesh_primitives.h"
#include "tests/optim/round/free_fit.h"
#include "tests/optim/round/synthetic_fit.h"

// What surfaces and pictures are made of, found again from other starts. The tolerances are two to
// three times what was measured, and several times below the error of the start.
namespace pathfit::fit_surfaces_test {
namespace {

using optim::UnknownSpec;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using renderer::Vec3;

constexpr int kSize = 48;

class FitSurfacesTest : public tests::FreeFit {
 protected:
  Scene Fit(const Scene& start, const Scene& truth, int num_rounds) {
    spec_.stages = {Stage(num_rounds, 8, 32)};
    spec_.seed = 3;
    return optim::RunFit(start, tests::Photograph(truth, 256), spec_, observer_, {}).scene;
  }

  tests::RecordingObserver observer_;
};

renderer::Texture Picture(int width, int height) {
  renderer::Texture texture;
  texture.name = "picture";
  texture.width = width;
  texture.height = height;
  texture.wrap = renderer::TextureWrap::kClamp;
  texture.texels.clear();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      texture.texels.push_back({0.5 + 0.3 * std::sin(1.3 * x + y),
                                0.4 + 0.3 * std::cos(0.9 * y - x),
                                (x + y) % 3 * 0.3 + 0.1});
    }
  }
  return texture;
}

Scene PlaneScene(int num_views) {
  Scene scene;
  scene.meshes = {{"plane", renderer::MakeRectangle(), 0}};
  scene.materials = {{"paint", renderer::LambertBsdf{}, {0.6, 0.6, 0.6}}};
  scene.textures = {Picture(8, 6)};
  for (int i = 0; i < num_views; ++i) {
    scene.sensors.push_back(
        tests::CameraAt({0.8 * i - 0.8, -0.6, 3.2}, {0, 0, 0}, 1.3 * kSize, kSize, kSize));
    scene.sensors.back().name = "view" + std::to_string(i);
  }
  return scene;
}

double Rms(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      sum += (a[i][c] - b[i][c]) * (a[i][c] - b[i][c]) / (3.0 * static_cast<double>(a.size()));
    }
  }
  return std::sqrt(sum);
}

TEST_F(FitSurfacesTest, TexelsOfAPlane) {
  Scene truth = PlaneScene(3);
  truth.materials[0].base_color_texture = 0;
  truth.emitters = {tests::ConstantEnvironment({1, 1, 1})};
  Scene start = truth;
  for (Rgb& texel : start.textures[0].texels) texel = {0.5, 0.5, 0.5};
  UnknownSpec& texels = Free(ParameterKind::kTextureTexels, 0);
  texels.lower = 0.01;
  texels.upper = 0.99;
  texels.smooth_weight = 1e-5;
  const double before = Rms(start.textures[0].texels, truth.textures[0].texels);
  const Scene result = Fit(start, truth, 6);
  EXPECT_GT(before, 0.2);
  EXPECT_LT(Rms(result.textures[0].texels, truth.textures[0].texels), 0.006);
}

TEST_F(FitSurfacesTest, TexelsThroughAProjector) {
  Scene truth = PlaneScene(3);
  renderer::ProjectorEmitter projector;
  projector.position = {0.2, 0.1, 3.0};
  projector.intensity = {4, 4, 4};
  projector.texture = 0;
  truth.emitters = {{"beamer", renderer::LightFrame::kWorld, {}, projector}};
  Scene start = truth;
  for (Rgb& texel : start.textures[0].texels) texel = {0.5, 0.5, 0.5};
  UnknownSpec& texels = Free(ParameterKind::kTextureTexels, 0);
  texels.parameterization = optim::Parameterization::kLog;
  texels.smooth_weight = 1e-5;
  const Scene result = Fit(start, truth, 6);
  EXPECT_LT(Rms(result.textures[0].texels, truth.textures[0].texels), 0.02);
}

TEST_F(FitSurfacesTest, RoughnessAndIndexOfAMetal) {
  Scene truth = tests::BallScene(3, 4, kSize);
  truth.materials = {
      {"metal", renderer::RoughConductorBsdf{0.4, {0.3, 0.9, 1.1}, {2.9, 2.4, 2.1}}, {1, 1, 1}}};
  truth.emitters = {{"lamp",
                     renderer::LightFrame::kWorld,
                     {},
                     renderer::PointEmitter{{2.0, 3.0, 3.0}, {20, 20, 20}}}};
  Scene start = truth;
  auto& metal = std::get<renderer::RoughConductorBsdf>(start.materials[0].bsdf);
  metal.roughness = 0.6;
  metal.eta = {0.5, 0.5, 0.5};
  UnknownSpec& roughness = Free(ParameterKind::kRoughness, 0);
  roughness.lower = 0.1;
  roughness.upper = 1.0;
  UnknownSpec& eta = Free(ParameterKind::kEta, 0);
  eta.parameterization = optim::Parameterization::kLog;
  eta.lower = 0.02;
  eta.upper = 2.0;  // (1 + k^2) / eta would reflect alike
  const Scene result = Fit(start, truth, 16);
  const auto& found = std::get<renderer::RoughConductorBsdf>(result.materials[0].bsdf);
  EXPECT_NEAR(found.roughness, 0.4, 0.02) << "from 0.6";
  EXPECT_NEAR(found.eta.r, 0.3, 0.05) << "from 0.5";
  EXPECT_NEAR(found.eta.g, 0.9, 0.05) << "from 0.5";
  EXPECT_NEAR(found.eta.b, 1.1, 0.05) << "from 0.5";
}

TEST_F(FitSurfacesTest, MetalThatStartsAsPaint) {
  Scene truth = tests::BallScene(3, 5, kSize);
  std::vector<Rgb> colors;
  for (const Vec3& p : truth.meshes[0].mesh.positions) {
    colors.push_back({0.4 + 0.3 * std::sin(5.0 * p.x), 0.4 + 0.3 * std::cos(4.0 * p.y), 0.3});
  }
  truth.meshes[0].mesh.colors = colors;
  truth.materials[0].bsdf = renderer::MetallicRoughnessBsdf{0.4, 1.0};
  truth.emitters.push_back({"lamp",
                            renderer::LightFrame::kWorld,
                            {},
                            renderer::PointEmitter{{2.0, 3.0, 3.0}, {20, 20, 20}}});
  Scene start = truth;
  renderer::SetUniformVertexColors({0.5, 0.5, 0.5}, start.meshes[0].mesh);
  start.materials[0].bsdf = renderer::MetallicRoughnessBsdf{0.4, 0.1};
  for (const ParameterKind kind :
       {ParameterKind::kVertexColors, ParameterKind::kRoughness, ParameterKind::kMetallic}) {
    UnknownSpec& unknown = Free(kind, 0);
    unknown.lower = kind == ParameterKind::kMetallic ? 0.0 : 0.03;
    unknown.upper = 1.0;
  }
  const auto found = [&] {
    return std::get<renderer::MetallicRoughnessBsdf>(Fit(start, truth, 16).materials[0].bsdf);
  };
  const renderer::MetallicRoughnessBsdf metal = found();
  EXPECT_GT(metal.metallic, 0.85) << "from 0.1";
  EXPECT_NEAR(metal.roughness, 0.4, 0.02);
  const auto tells = [](const std::string& text) {
    return text.find("starts at 1 than at 0.1") != std::string::npos;
  };
  EXPECT_TRUE(std::ranges::any_of(observer_.messages, tells));
  // One that is said to be believed is where the fit begins.
  spec_.unknowns.back().gaussian = optim::GaussianPriorSpec{{}, 100.0};
  EXPECT_LT(found().metallic, metal.metallic - 0.05);
}

}  // namespace
}  // namespace pathfit::fit_surfaces_test
