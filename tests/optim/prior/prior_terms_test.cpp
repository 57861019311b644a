#include "optim/prior/prior_terms.h"

#include <cmath>

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/geometry/texel_places.h"
#include "renderer/geometry/uv_atlas.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/test_scenes.h"

namespace pathfit::prior_terms_test {
namespace {

using optim::ParameterSet;
using optim::PriorTerm;
using optim::UnknownSpec;
using renderer::ParameterKind;

class PriorTermsTest : public testing::Test {
 protected:
  UnknownSpec& Add(ParameterKind kind, int object) {
    unknowns_.emplace_back();
    unknowns_.back().kind = kind;
    unknowns_.back().object = object;
    active_.push_back(static_cast<int>(active_.size()));
    return unknowns_.back();
  }

  [[nodiscard]] ParameterSet Set() const { return {scene_, unknowns_, active_, {0}, exposure_}; }

  [[nodiscard]] std::vector<PriorTerm> Terms(const ParameterSet& set) const {
    return optim::BuildPriorTerms(run_start_, scene_, unknowns_, set, exposure_, kNumChannels);
  }

  [[nodiscard]] double Cost(const ParameterSet& set) const {
    return PriorCost(Terms(set), set, set.ThetaFromValues(set.layout().Gather(scene_))) /
           kNumChannels;
  }

  static constexpr double kNumChannels = 1000.0;
  renderer::Scene run_start_ = tests::BallAndWall();
  renderer::Scene scene_ = run_start_;
  std::vector<UnknownSpec> unknowns_;
  std::vector<int> active_;
  optim::ExposureModel exposure_{{1.0}, 0.3, 3.0};
};

// d residual / d theta of every term against central differences.
void CheckJacobians(const std::vector<PriorTerm>& terms,
                    const ParameterSet& set,
                    std::vector<double> theta) {
  ASSERT_FALSE(terms.empty());
  const std::vector<double> gradient = optim::PriorGradient(terms, set, theta);
  for (std::size_t i = 0; i < theta.size(); i += 1 + theta.size() / 40) {
    constexpr double kStep = 1e-5;
    std::vector<double> above = theta, below = theta;
    above[i] += kStep;
    below[i] -= kStep;
    const double difference =
        (PriorCost(terms, set, above) - PriorCost(terms, set, below)) / (2.0 * kStep);
    EXPECT_NEAR(gradient[i], difference, 1e-5 * (1.0 + std::abs(difference)));
  }
  for (const PriorTerm& term : terms) {
    std::vector<const double*> blocks;
    const auto size = static_cast<std::size_t>(set.BlockSize(term.blocks[0]));
    const std::size_t rows = term.NumGroups() * size;
    std::vector<std::vector<double>> storage(term.blocks.size(), std::vector<double>(rows * size));
    std::vector<double*> jacobians;
    for (std::size_t k = 0; k < term.blocks.size(); ++k) {
      blocks.push_back(theta.data() + set.BlockOffset(term.blocks[k]));
      jacobians.push_back(storage[k].data());
    }
    std::vector<double> residual(rows), above(rows), below(rows);
    EvalPrior(term, set, blocks.data(), residual.data(), jacobians.data());
    for (std::size_t k = 0; k < term.blocks.size(); ++k) {
      for (std::size_t c = 0; c < size; ++c) {
        double& x = theta[set.BlockOffset(term.blocks[k]) + c];
        const double before = x;
        constexpr double kStep = 1e-5;
        x = before + kStep;
        EvalPrior(term, set, blocks.data(), above.data(), nullptr);
        x = before - kStep;
        EvalPrior(term, set, blocks.data(), below.data(), nullptr);
        x = before;
        for (std::size_t row = 0; row < rows; ++row) {
          const double difference = (above[row] - below[row]) / (2.0 * kStep);
          EXPECT_NEAR(storage[k][row * size + c], difference, 1e-6 * (1.0 + std::abs(difference)));
        }
      }
    }
  }
}

TEST_F(PriorTermsTest, JacobiansAgreeWithDifferences) {
  Add(ParameterKind::kVertexPositions, 0).laplacian_weight = 0.1;
  Add(ParameterKind::kVertexColors, 0).smooth_weight = 0.2;
  UnknownSpec& texels = Add(ParameterKind::kEnvironmentTexels, 0);
  texels.smooth_weight = 0.3;
  texels.neutral_weight = 0.4;
  texels.parameterization = optim::Parameterization::kLog;
  Add(ParameterKind::kRoughness, 1).gaussian = optim::GaussianPriorSpec{{0.4}, 0.1};
  UnknownSpec& lamp = Add(ParameterKind::kLightIntensity, 1);
  lamp.gaussian = optim::GaussianPriorSpec{{1.0, 2.0, 3.0}, 0.5};
  lamp.parameterization = optim::Parameterization::kLog;
  Add(ParameterKind::kExposure, -1);
  const ParameterSet set = Set();
  const std::vector<double> values = set.layout().Gather(scene_);
  CheckJacobians(Terms(set), set, set.ThetaFromValues(values));
}

// Where a light is known, exposures are believed to be alike, and what they have in common is as
// open as their bounds; where all are free, each is near its start.
TEST_F(PriorTermsTest, ExposuresUnderAKnownLightHaveAnOpenMean) {
  constexpr int kViews = 7;
  scene_.sensors.resize(kViews, scene_.sensors[0]);
  exposure_.start_gains.clear();
  std::vector<int> views;
  double mean = 0.0;
  std::vector<double> shifts;  // EV
  for (int v = 0; v < kViews; ++v) {
    views.push_back(v);
    exposure_.start_gains.push_back(std::exp2(0.1 * v));
    shifts.push_back(-1.2 + 0.2 * std::sin(3.0 * v));
    mean += shifts.back() / kViews;
    scene_.sensors[static_cast<std::size_t>(v)].gain = std::exp2(0.1 * v + shifts.back());
  }
  double each = 0.0, apart = 0.0;
  for (const double shift : shifts) {
    each += std::pow(shift / 0.3, 2);
    apart += std::pow((shift - mean) / 0.3, 2);
  }
  const double unit = 0.5 * std::pow(optim::kGaussianResidual, 2) / kNumChannels;
  Add(ParameterKind::kExposure, -1);
  const auto cost = [&] { return Cost({scene_, unknowns_, active_, views, exposure_}); };
  EXPECT_NEAR(cost(), unit * (apart + std::pow(mean / 3.0, 2)), 1e-9 * unit * each);
  for (int e = 0; e < static_cast<int>(scene_.emitters.size()); ++e) {
    EXPECT_LT(cost(), unit * each);
    Add(ParameterKind::kLightIntensity, e);
  }
  EXPECT_NEAR(cost(), unit * each, 1e-9 * unit * each);
}

TEST_F(PriorTermsTest, ProximalTermsVanishAtTheRoundsStartAndWeighRoughnessMore) {
  Add(ParameterKind::kVertexPositions, 0).large_steps_lambda = 10.0;
  const ParameterSet set = Set();
  std::vector<double> values = set.layout().Gather(scene_);
  const auto terms = optim::BuildProximalTerms(scene_, unknowns_, set, values, 2.0);
  CheckJacobians(terms, set, values);
  EXPECT_NEAR(PriorCost(terms, set, values), 0.0, 1e-18);
  std::vector<double> shifted = values;
  for (double& x : shifted) {
    x += 0.1;
  }
  const double smooth = PriorCost(terms, set, shifted);
  // A translation has no Laplacian: mu / 2 * |shift|^2.
  EXPECT_NEAR(smooth, 0.5 * 2.0 * 0.01 * static_cast<double>(values.size()), 1e-9);
  values[0] += 0.1;
  EXPECT_GT(PriorCost(terms, set, values), 20.0 * smooth / static_cast<double>(values.size()));
}

TEST_F(PriorTermsTest, NeutralIsZeroForGreyAndOneHalfOfTheMeanSquareOtherwise) {
  UnknownSpec& texels = Add(ParameterKind::kEnvironmentTexels, 0);
  texels.neutral_weight = 0.5;
  texels.parameterization = optim::Parameterization::kLog;
  auto& sky = std::get<renderer::EnvironmentEmitter>(scene_.emitters[0].light);
  for (renderer::Rgb& texel : sky.texels) {
    texel = {2.0, 2.0, 2.0};
  }
  const ParameterSet set = Set();
  EXPECT_NEAR(Cost(set), 0.0, 1e-15);
  for (renderer::Rgb& texel : sky.texels) {
    texel = {3.0, 2.0, 1.0};
  }
  EXPECT_NEAR(Cost(set), 0.5 * 0.5 * 2.0, 1e-12);
}

TEST_F(PriorTermsTest, BinaryIsZeroAtZeroAndOneAndTheSquaredDistanceNearThem) {
  Add(ParameterKind::kMetallic, 1).binary_weight = 0.5;
  const ParameterSet set = Set();
  const auto cost_at = [&](double metallic) {
    std::get<renderer::MetallicRoughnessBsdf>(scene_.materials[1].bsdf).metallic = metallic;
    return Cost(set);
  };
  EXPECT_NEAR(cost_at(0.0), 0.0, 1e-15);
  EXPECT_NEAR(cost_at(1.0), 0.0, 1e-15);
  EXPECT_NEAR(cost_at(0.5), 0.5 * 0.5 / 16.0, 1e-12);
  EXPECT_NEAR(cost_at(0.01), 0.25 * 1e-4, 1e-6);
  EXPECT_NEAR(cost_at(0.3), cost_at(0.7), 1e-12);
  CheckJacobians(Terms(set), set, {0.3});
}

TEST_F(PriorTermsTest, BinaryOfTexelsIsTheirMean) {
  renderer::Texture texture{"metal", 3, 2, std::vector<renderer::Rgb>(6, {0.5, 0.5, 0.5})};
  texture.scalar = true;
  texture.texels[0] = {1.0, 1.0, 1.0};
  scene_.textures = run_start_.textures = {texture};
  scene_.materials[1].metallic_texture = run_start_.materials[1].metallic_texture = 0;
  Add(ParameterKind::kTextureTexels, 0).binary_weight = 2.0;
  const ParameterSet set = Set();
  EXPECT_NEAR(Cost(set), 5.0 / 6.0 / 16.0, 1e-12);
  CheckJacobians(Terms(set), set, {0.1, 0.2, 0.4, 0.5, 0.7, 1.0});
}

TEST_F(PriorTermsTest, TexelSmoothnessWrapsAroundAndIgnoresConstants) {
  Add(ParameterKind::kEnvironmentTexels, 0).smooth_weight = 1.0;
  auto& sky = std::get<renderer::EnvironmentEmitter>(scene_.emitters[0].light);
  for (renderer::Rgb& texel : sky.texels) {
    texel = {2.0, 1.0, 0.5};
  }
  const ParameterSet set = Set();
  EXPECT_NEAR(Cost(set), 0.0, 1e-15);
  // A texel of the first column has the same number of neighbours as one in the middle.
  sky.texels[8].r += 1.0;
  const double at_seam = Cost(set);
  sky.texels[8].r -= 1.0;
  sky.texels[11].r += 1.0;
  EXPECT_NEAR(Cost(set), at_seam, 1e-12);
  EXPECT_GT(at_seam, 0.0);
}

TEST_F(PriorTermsTest, LogSmoothnessIsABeliefAboutFactorsBetweenNeighbours) {
  auto& unknown = Add(ParameterKind::kEnvironmentTexels, 0);
  unknown.log_smooth_weight = 4.0;
  unknown.parameterization = optim::Parameterization::kLog;
  auto& sky = std::get<renderer::EnvironmentEmitter>(scene_.emitters[0].light);
  for (renderer::Rgb& texel : sky.texels) texel = {2.0, 1.0, 0.5};
  EXPECT_NEAR(Cost(Set()), 0.0, 1e-15);
  // One channel of a texel with three neighbours, in the first row: half a factor of e each.
  sky.texels[1].g *= std::exp(0.5);
  EXPECT_NEAR(Cost(Set()) * kNumChannels, 3.0 * 0.5 * std::pow(optim::kGaussianResidual, 2), 1e-12);
  // Whatever the brightness.
  for (renderer::Rgb& texel : sky.texels) texel = texel * 1000.0;
  EXPECT_NEAR(Cost(Set()) * kNumChannels, 3.0 * 0.5 * std::pow(optim::kGaussianResidual, 2), 1e-12);
  for (const PriorTerm& term : Terms(Set())) EXPECT_EQ(term.belief, optim::kGaussianResidual);
}

TEST_F(PriorTermsTest, LogSmoothnessIsWeighedByWhatTheSceneLeavesUnexplained) {
  auto& unknown = Add(ParameterKind::kEnvironmentTexels, 0);
  unknown.log_smooth_weight = 4.0;
  unknown.parameterization = optim::Parameterization::kLog;
  std::get<renderer::EnvironmentEmitter>(scene_.emitters[0].light).texels[1].g *= std::exp(0.5);
  const ParameterSet set = Set();
  const std::vector<double> theta = set.ThetaFromValues(set.layout().Gather(scene_));
  constexpr double kFactor = 5.0;
  const std::vector<PriorTerm> weak = Terms(set);
  const std::vector<PriorTerm> strong = optim::BuildPriorTerms(run_start_,
                                                               scene_,
                                                               unknowns_,
                                                               set,
                                                               exposure_,
                                                               kNumChannels,
                                                               kFactor * optim::kGaussianResidual);
  EXPECT_NEAR(PriorCost(strong, set, theta), kFactor * kFactor * PriorCost(weak, set, theta), 1e-9);
  // It is believed as much: the gradient's deviation over the curvature stays.
  const auto error = [&](const std::vector<PriorTerm>& terms) {
    return std::sqrt(optim::BeliefCovariance(terms, set, theta)[0]) /
           optim::PriorHessian(terms, set, theta)[0];
  };
  EXPECT_NEAR(error(strong), error(weak), 1e-9 * error(weak));
}

TEST_F(PriorTermsTest, TextureSmoothnessWrapsAroundWhereTheTextureRepeats) {
  renderer::Texture texture{"oak", 4, 3, std::vector<renderer::Rgb>(12, {0.5, 0.5, 0.5})};
  scene_.textures = {texture};
  Add(ParameterKind::kTextureTexels, 0).smooth_weight = 1.0;
  auto cost_of = [&](renderer::TextureWrap wrap, std::size_t texel) {
    scene_.textures = {texture};
    scene_.textures[0].wrap = wrap;
    scene_.textures[0].texels[texel].g += 1.0;
    return Cost(Set());
  };
  // w/2 * mean over pairs: 2 * 12 pairs with wrap, 17 without; 4 neighbours or 2 in a corner.
  EXPECT_NEAR(cost_of(renderer::TextureWrap::kRepeat, 0), 0.5 * 4.0 / 24.0, 1e-12);
  EXPECT_NEAR(cost_of(renderer::TextureWrap::kRepeat, 5), 0.5 * 4.0 / 24.0, 1e-12);
  EXPECT_NEAR(cost_of(renderer::TextureWrap::kClamp, 0), 0.5 * 2.0 / 17.0, 1e-12);
  EXPECT_NEAR(cost_of(renderer::TextureWrap::kClamp, 5), 0.5 * 4.0 / 17.0, 1e-12);
}

TEST_F(PriorTermsTest, TotalVariationIsTheSizeOfTheSlope) {
  scene_.textures = {{"oak", 4, 3, std::vector<renderer::Rgb>(12, {0.5, 0.5, 0.5})}};
  scene_.textures[0].wrap = renderer::TextureWrap::kClamp;
  Add(ParameterKind::kTextureTexels, 0).total_variation_weight = 0.7;
  EXPECT_EQ(Cost(Set()), 0.0);
  constexpr double kEdge = optim::kTotalVariationEdge;
  const auto size_of = [](double square) { return std::sqrt(square + kEdge * kEdge) - kEdge; };
  scene_.textures[0].texels[5].g += 0.3;  // inside: its own slope, its left and upper neighbour's
  EXPECT_NEAR(Cost(Set()), 0.7 / 12.0 * (size_of(2 * 0.09) + 2.0 * size_of(0.09)), 1e-14);
  scene_.textures[0].texels[5].g -= 0.3;
  scene_.textures[0].texels[11].r += 0.3;  // the last corner: seen by two neighbours
  EXPECT_NEAR(Cost(Set()), 0.7 / 12.0 * 2.0 * size_of(0.09), 1e-14);
  scene_.textures[0].wrap = renderer::TextureWrap::kRepeat;
  EXPECT_NEAR(Cost(Set()), 0.7 / 12.0 * (size_of(2 * 0.09) + 2.0 * size_of(0.09)), 1e-14);
}

/// A cube of side 2 on an atlas, as mesh 0 and material 0, with a texture of the colours of `paint`
/// at the places that its texels show.
template <class Paint>
void PaintCube(const Paint& paint, double density, renderer::Scene& scene) {
  renderer::Mesh cube = tests::Cube();
  renderer::Mesh* const meshes[] = {&cube};
  const std::vector<double> densities[] = {std::vector<double>(cube.triangles.size(), density)};
  const renderer::UvAtlas atlas = renderer::MakeUvAtlas(meshes, densities);
  scene.meshes[0].mesh = cube;
  scene.materials[0].vertex_colors = false;
  scene.materials[0].base_color_texture = 0;
  scene.textures = {{"cube", atlas.width, atlas.height}};
  scene.textures[0].wrap = renderer::TextureWrap::kClamp;
  const renderer::Mesh* const placed[] = {&scene.meshes[0].mesh};
  std::vector<renderer::Rgb> texels;
  for (const renderer::TexelPlace& place :
       renderer::PlaceTexels(placed, atlas.width, atlas.height)) {
    renderer::Vec3 x;
    for (std::size_t k = 0; place.mesh >= 0 && k < 3; ++k) {
      const auto f = static_cast<std::size_t>(place.triangle);
      x += std::as_const(cube)
               .positions[static_cast<std::size_t>(std::as_const(cube).triangles[f][k])] *
           place.weights[k];
    }
    texels.push_back(place.mesh < 0 ? renderer::Rgb{77.0, 0.0, -5.0} : paint(x));
  }
  scene.textures[0].texels = std::move(texels);
}

TEST_F(PriorTermsTest, TotalVariationOfAnAtlasIsThatOfTheSurface) {
  Add(ParameterKind::kTextureTexels, 0).total_variation_weight = 0.7;
  constexpr double kDensity = 40.0;  // texels per metre
  PaintCube([](const renderer::Vec3&) { return renderer::Rgb{0.3, 0.5, 0.7}; }, kDensity, scene_);
  EXPECT_NEAR(Cost(Set()), 0.0, 1e-12) << "seams and what lies beside the charts cost nothing";
  PaintCube(
      [](const renderer::Vec3& x) {
        return renderer::Rgb{0.5 + 4.0 * x.x, 0.0, 0.0};
      },
      kDensity,
      scene_);
  // Four of six sides have the slope 4 along x, all of them meet without a jump.
  constexpr double kEdge = optim::kTotalVariationEdge;
  const double slope = std::hypot(4.0 / kDensity, kEdge) - kEdge;
  EXPECT_NEAR(Cost(Set()), 0.7 * 4.0 / 6.0 * slope, 0.05 * slope) << "rims of charts count, too";
  // Twice as large, and as many texels: the slope halves, the texels' side doubles.
  const double cost = Cost(Set());
  for (renderer::Vec3& p : scene_.meshes[0].mesh.positions) p *= 2.0;
  EXPECT_NEAR(Cost(Set()), cost, 1e-9);
  scene_.meshes[0].pose.scale = 3.0;
  EXPECT_NEAR(Cost(Set()), cost, 1e-9);
}

TEST_F(PriorTermsTest, JumpsAcrossSeamsCostAsSlopes) {
  Add(ParameterKind::kTextureTexels, 0).total_variation_weight = 1.0;
  constexpr double kDensity = 40.0;
  // The top has another colour: a jump of 0.5 along 8 metres of seams.
  PaintCube(
      [](const renderer::Vec3& x) {
        return renderer::Rgb{x.y > 1.0 - 1e-9 ? 0.75 : 0.25, 0.5, 0.5};
      },
      kDensity,
      scene_);
  // Rims of the sides that end at the top are painted like it: the jump is inside them.
  constexpr double kEdge = optim::kTotalVariationEdge;
  const double jump = std::hypot(0.5, kEdge) - kEdge;
  EXPECT_NEAR(Cost(Set()), jump * 8.0 / kDensity / 24.0, 0.35 * jump * 8.0 / kDensity / 24.0);
  UnknownSpec& unknown = unknowns_.back();
  unknown.total_variation_weight = 0.0;
  unknown.smooth_weight = 1.0;
  EXPECT_GT(Cost(Set()), 0.0);
  scene_.textures[0].texels.Edit().assign(scene_.textures[0].texels.size(), {0.1, 0.2, 0.3});
  EXPECT_NEAR(Cost(Set()), 0.0, 1e-12);
}

TEST_F(PriorTermsTest, AnAtlasDerivativesAgreeWithDifferences) {
  Add(ParameterKind::kTextureTexels, 0).total_variation_weight = 0.7;
  PaintCube(
      [](const renderer::Vec3& x) {
        return renderer::Rgb{0.5 + 0.1 * x.x, 0.5 + 0.2 * x.y * x.z, 0.5};
      },
      3.0,
      scene_);
  const ParameterSet set = Set();
  CheckJacobians(Terms(set), set, set.ThetaFromValues(set.layout().Gather(scene_)));
}

TEST_F(PriorTermsTest, TotalVariationOfAnEnvironmentWrapsAroundInLongitudeOnly) {
  Add(ParameterKind::kEnvironmentTexels, 0).total_variation_weight = 1.0;
  auto& sky = std::get<renderer::EnvironmentEmitter>(scene_.emitters[0].light);
  for (renderer::Rgb& texel : sky.texels) texel = {2.0, 1.0, 0.5};
  const auto cost_of = [&](std::size_t texel) {
    sky.texels[texel].r += 1.0;
    const double cost = Cost(Set());
    sky.texels[texel].r -= 1.0;
    return cost;
  };
  EXPECT_NEAR(cost_of(8), cost_of(11), 1e-12);
  EXPECT_NEAR(cost_of(0), cost_of(3), 1e-12);
  EXPECT_LT(cost_of(0), cost_of(8));
}

TEST_F(PriorTermsTest, TotalVariationsDerivativesAgreeWithDifferences) {
  scene_.textures = {{"oak", 4, 3, std::vector<renderer::Rgb>(12, {0.5, 0.5, 0.5})}};
  for (std::size_t i = 0; i < 12; ++i) {
    const double x = 0.4 + 0.3 * std::sin(2.0 * static_cast<double>(i));
    scene_.textures[0].texels[i] = {x, 0.5 * x, 0.9 - x};
  }
  Add(ParameterKind::kTextureTexels, 0).total_variation_weight = 0.7;
  UnknownSpec& texels = Add(ParameterKind::kEnvironmentTexels, 0);
  texels.total_variation_weight = 0.3;
  texels.parameterization = optim::Parameterization::kLog;
  const ParameterSet set = Set();
  CheckJacobians(Terms(set), set, set.ThetaFromValues(set.layout().Gather(scene_)));
  for (const PriorTerm& term : Terms(set)) {
    const auto loss = MakePriorLossFunction(term);
    for (const double s : {0.0, 0.1, 3.0}) {
      const double square = s * term.edge * term.edge;
      const double h = 1e-4 * term.edge * term.edge;
      double rho[3], above[3], below[3];
      loss->Evaluate(square, rho);
      loss->Evaluate(square + h, above);
      loss->Evaluate(std::max(0.0, square - h), below);
      const double step = square > h ? 2.0 * h : h;
      EXPECT_NEAR((above[0] - below[0]) / step, rho[1], 1e-4);
      EXPECT_NEAR((above[1] - below[1]) / step, rho[2], 1e-3 * std::abs(rho[2]));
    }
  }
}

/// A grey step of 0.2 to 0.8 with noise, denoised by one prior.
struct Denoised {
  double noise = 0.0;  ///< rms along the step, where nothing should vary
  double step = 0.0;   ///< mean difference across the step
};

TEST_F(PriorTermsTest, TotalVariationSparesAnEdgeWhereSmoothBlursIt) {
  constexpr int kSize = 24;
  renderer::Texture texture{"wall", kSize, kSize, {}};
  texture.wrap = renderer::TextureWrap::kClamp;
  renderer::CounterRng rng(3);
  for (int i = 0; i < kSize * kSize; ++i) {
    const double step = i % kSize < kSize / 2 ? 0.2 : 0.8;
    texture.texels.push_back(renderer::Rgb::Constant(step + 0.2 * (rng.Next() - 0.5)));
  }
  scene_.textures = {texture};
  Add(ParameterKind::kTextureTexels, 0);
  const auto denoise = [&](double smooth, double total_variation) {
    unknowns_[0].smooth_weight = smooth;
    unknowns_[0].total_variation_weight = total_variation;
    const ParameterSet set = Set();
    const std::vector<PriorTerm> terms = Terms(set);
    std::vector<double> theta = set.layout().Gather(scene_);
    // What photos would say of each texel, with the solver's unit of cost.
    std::vector<PriorTerm> data;
    const double scale = std::sqrt(kNumChannels / (kSize * kSize));
    for (std::int32_t i = 0; i < kSize * kSize; ++i) {
      const double value = scale * theta[3 * static_cast<std::size_t>(i)];
      data.push_back({{i}, {scale}, {value, value, value}});
    }
    ceres::Problem problem;
    for (const auto* list : {&terms, static_cast<const std::vector<PriorTerm>*>(&data)}) {
      for (const PriorTerm& term : *list) {
        std::vector<double*> blocks;
        for (const std::int32_t block : term.blocks) {
          blocks.push_back(theta.data() + set.BlockOffset(block));
        }
        problem.AddResidualBlock(MakePriorCostFunction(term, set).release(),
                                 MakePriorLossFunction(term).release(),
                                 blocks);
      }
    }
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    EXPECT_TRUE(summary.IsSolutionUsable()) << summary.message;
    EXPECT_LE(PriorCost(terms, set, theta) + PriorCost(data, set, theta), summary.initial_cost);
    EXPECT_NEAR(PriorCost(terms, set, theta) + PriorCost(data, set, theta),
                summary.final_cost,
                1e-9 * summary.initial_cost);
    Denoised result;
    const auto value = [&](int x, int y) {
      return theta[3 * static_cast<std::size_t>(y * kSize + x)];
    };
    double variance = 0.0;
    for (int x = 0; x < kSize; ++x) {
      double mean = 0.0;
      for (int y = 0; y < kSize; ++y) mean += value(x, y) / kSize;
      for (int y = 0; y < kSize; ++y) {
        variance += std::pow(value(x, y) - mean, 2) / (kSize * (kSize - 1));
      }
    }
    for (int y = 0; y < kSize; ++y) {
      result.step += (value(kSize / 2, y) - value(kSize / 2 - 1, y)) / kSize;
    }
    result.noise = std::sqrt(variance);
    return result;
  };
  const double noise = denoise(0.0, 0.0).noise;
  EXPECT_NEAR(noise, 0.2 / std::sqrt(12.0), 0.004);
  const Denoised tv = denoise(0.0, 0.15);
  EXPECT_LT(tv.noise, 0.35 * noise);
  double low = 0.0, high = 100.0;  // the weight of `smooth` that leaves as much noise
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (low + high);
    (denoise(middle, 0.0).noise > tv.noise ? low : high) = middle;
  }
  const Denoised smooth = denoise(high, 0.0);
  EXPECT_NEAR(smooth.noise, tv.noise, 1e-4);
  RecordProperty("steps", std::to_string(tv.step) + " " + std::to_string(smooth.step));
  EXPECT_GT(tv.step, 0.5);
  EXPECT_LT(smooth.step, 0.6 * tv.step);
}

TEST_F(PriorTermsTest, GaussianWithoutMeanIsAroundTheStartOfTheRun) {
  Add(ParameterKind::kCameraPosition, 0).gaussian = optim::GaussianPriorSpec{{}, 0.1};
  const ParameterSet set = Set();
  EXPECT_EQ(Cost(set), 0.0);
  scene_.sensors[0].world_from_camera.translation.y += 0.1;
  EXPECT_NEAR(Cost(set) * kNumChannels, 0.5 * std::pow(optim::kGaussianResidual, 2), 1e-12);
}

TEST_F(PriorTermsTest, ABeliefAloneIsAsUncertainAsItSays) {
  Add(ParameterKind::kRoughness, 1).gaussian = optim::GaussianPriorSpec{{0.35}, 0.1};
  const ParameterSet set = Set();
  const std::vector<PriorTerm> terms = Terms(set);
  const std::vector<double> theta = set.ThetaFromValues(set.layout().Gather(scene_));
  const double curvature = optim::PriorHessian(terms, set, theta)[0];
  const double variance = optim::BeliefCovariance(terms, set, theta)[0];
  EXPECT_NEAR(std::sqrt(variance) / curvature, 0.1, 1e-9);
}

TEST_F(PriorTermsTest, GaussianOfOneSigmaCostsTheStatedResidual) {
  Add(ParameterKind::kRoughness, 1).gaussian =
      optim::GaussianPriorSpec{{0.35}, 0.1};  // the scene has 0.45
  EXPECT_NEAR(Cost(Set()) * kNumChannels, 0.5 * std::pow(optim::kGaussianResidual, 2), 1e-12);
  unknowns_[0].gaussian->mean = {0.1, 0.2};
  EXPECT_THROW(static_cast<void>(Terms(Set())), renderer::SceneError);
}

}  // namespace
}  // namespace pathfit::prior_terms_test
