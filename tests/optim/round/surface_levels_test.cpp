#include "optim/round/surface_levels.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <gtest/gtest.h>
#include <unistd.h>

#include "optim/checkpoint/checkpoint.h"
#include "optim/checkpoint/fit_state.h"
#include "optim/round/mesh_levels.h"
#include "optim/round/stage_plan.h"
#include "optim/round/texel_fill.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/scene/texture_surface.h"
#include "tests/optim/round/synthetic_fit.h"
#include "tests/support/sanitized.h"

namespace pathfit::surface_levels_test {
namespace {

using optim::TexelSight;
using optim::UnknownSpec;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using renderer::Vec3;

constexpr double kCarryPsnr = 45.0;  // dB: what is fitted lies 10 or more below

/// Of pixels that show the ball, peak 1.
double Psnr(const Scene& a, const Scene& b) {
  double squares = 0.0;
  double count = 0.0;
  const renderer::Renderer of_a(a), of_b(b);
  for (std::size_t v = 0; v < a.sensors.size(); ++v) {
    renderer::RenderOptions options;
    options.spp = 16;
    options.view = v;
    const auto first = renderer::ColorImage(of_a.RenderPrimal(a.sensors[v], options));
    const auto second = renderer::ColorImage(of_b.RenderPrimal(b.sensors[v], options));
    for (std::size_t i = 0; i < first.data.size(); ++i) {
      if (first.data[i] == 0.0F) continue;
      squares += std::pow(static_cast<double>(first.data[i] - second.data[i]), 2);
      count += 1.0;
    }
  }
  return -10.0 * std::log10(squares / count);
}

Rgb Paint(const Vec3& d) {
  return {0.5 + 0.3 * std::sin(4.0 * d.x), 0.5 + 0.3 * std::cos(3.0 * d.y + d.z), 0.4 + 0.2 * d.z};
}

class SurfaceLevelsTest : public testing::Test {
 protected:
  SurfaceLevelsTest() {
    scene_.textures = {{"paint_base_color"}};
    Mesh& ball = scene_.meshes[0].mesh;
    for (std::size_t i = 0; i < ball.positions.size(); ++i) {
      ball.colors[i] = Paint(std::as_const(ball).positions[i]);
    }
    observations_ = tests::Photograph(scene_, 1);
    unknowns_[0].name = "paint_base_color.texels";
    unknowns_[0].kind = ParameterKind::kTextureTexels;
    unknowns_[0].promotion = optim::Promotion{ParameterKind::kBaseColor, 0};
    unknowns_[1].name = "ball.colors";
    unknowns_[1].kind = ParameterKind::kVertexColors;
    unknowns_[1].promotion = unknowns_[0].promotion;
  }

  [[nodiscard]] optim::SceneLevel Promote(const Scene& scene,
                                          double scale,
                                          const std::vector<int>& free = {0}) const {
    return optim::PromoteSurfaces(
        scene, scene, unknowns_, free, optim::MakeFitViews(observations_, scale), 1.0 / scale);
  }
  /// Unknown 2.
  void FreeVertices() {
    UnknownSpec& vertices = unknowns_.emplace_back();
    vertices.name = "ball.vertices";
    vertices.mesh_detail = optim::MeshDetail::kLevels;
  }
  [[nodiscard]] Scene WithOneColour() const {
    Scene scene = scene_;
    scene.materials[0].vertex_colors = false;
    scene.meshes[0].mesh.colors.clear();
    scene.meshes[0].mesh.color_triangles.clear();
    return scene;
  }
  static const renderer::Texture& TextureOf(const Scene& scene) { return scene.textures[0]; }

  Scene scene_ = tests::BallScene(3, 6, 128);
  optim::ObservationSet observations_;
  std::vector<UnknownSpec> unknowns_{2};
};

TEST_F(SurfaceLevelsTest, VertexColoursBecomeATextureThatLooksTheSame) {
  const optim::SceneLevel level = Promote(scene_, 1.0);
  ASSERT_EQ(level.messages.size(), 1U);
  const Scene& made = level.scene;
  renderer::ValidateScene(made);
  EXPECT_EQ(made.materials[0].base_color_texture, 0);
  EXPECT_FALSE(made.materials[0].vertex_colors);
  EXPECT_TRUE(renderer::IsAtlas(made, 0));
  EXPECT_EQ(made.meshes[0].mesh.triangles, scene_.meshes[0].mesh.triangles)
      << "seams do not cut the surface, which stays free to move";
  EXPECT_GT(Psnr(scene_, made), kCarryPsnr);
  EXPECT_EQ(Promote(scene_, 1.0).scene.textures[0].texels, TextureOf(made).texels);
}

TEST_F(SurfaceLevelsTest, TexelsAreAsLargeAsPixels) {
  const Scene made = Promote(scene_, 1.0).scene;
  // A pixel at the ball's near side, of which there is one somewhere for most places.
  const double pixel = 3.2 / (1.45 * 128);
  double texels = 0.0;
  for (const TexelSight sight :
       optim::SightOfTexels(made, 0, optim::MakeFitViews(observations_, 1.0))) {
    texels += sight == TexelSight::kOutside ? 0.0 : 1.0;
  }
  EXPECT_NEAR(std::sqrt(12.57 / texels), pixel, 0.35 * pixel);
}

TEST_F(SurfaceLevelsTest, ConstantsBecomeTexturesExactly) {
  scene_.materials[0].vertex_colors = false;
  scene_.meshes[0].mesh.colors.clear();
  scene_.meshes[0].mesh.color_triangles.clear();
  scene_.materials[0].base_color = {0.3, 0.6, 0.2};
  const Scene made = Promote(scene_, 1.0).scene;
  EXPECT_EQ(made.materials[0].base_color_texture, 0);
  EXPECT_GT(TextureOf(made).width, 32);
  EXPECT_GT(Psnr(scene_, made), 140.0);
}

TEST_F(SurfaceLevelsTest, RoughnessBecomesAScalarTextureOnTheSameUvs) {
  scene_.materials[0].bsdf = renderer::MetallicRoughnessBsdf{0.35, 0.1};
  scene_.textures.push_back({"paint_roughness"});
  scene_.textures[1].scalar = true;
  unknowns_[1] = unknowns_[0];
  unknowns_[1].object = 1;
  unknowns_[1].promotion->property = ParameterKind::kRoughness;
  const Scene first = Promote(scene_, 1.0, {0}).scene;
  const Scene both = Promote(first, 1.0, {1}).scene;
  renderer::ValidateScene(both);
  EXPECT_EQ(both.meshes[0].mesh.uvs, first.meshes[0].mesh.uvs);
  EXPECT_EQ(both.materials[0].roughness_texture, 1);
  EXPECT_EQ(both.textures[0].texels, first.textures[0].texels);
  for (const Rgb& texel : both.textures[1].texels) EXPECT_NEAR(texel.r, 0.35, 1e-14);
  EXPECT_GT(Psnr(first, both), 140.0);
  // Together in one step: one atlas for both.
  const Scene at_once = Promote(scene_, 1.0, {0, 1}).scene;
  EXPECT_EQ(at_once.meshes[0].mesh.uvs, both.meshes[0].mesh.uvs);
  EXPECT_EQ(at_once.textures[1].width, at_once.textures[0].width);
}

TEST_F(SurfaceLevelsTest, ConstantsBecomeVertexColoursExactly) {
  scene_.materials[0].vertex_colors = false;
  scene_.meshes[0].mesh.colors.clear();
  scene_.meshes[0].mesh.color_triangles.clear();
  const Scene made = Promote(scene_, 1.0, {1}).scene;
  EXPECT_TRUE(made.materials[0].vertex_colors);
  EXPECT_GT(Psnr(scene_, made), 140.0);
}

TEST_F(SurfaceLevelsTest, TexturesGrowWithThePhotosAndNeverShrink) {
  const Scene small = Promote(scene_, 0.25).scene;
  const Scene large = Promote(small, 1.0).scene;
  EXPECT_EQ(TextureOf(large).width, 4 * TextureOf(small).width);
  EXPECT_EQ(TextureOf(large).height, 4 * TextureOf(small).height);
  EXPECT_EQ(large.meshes[0].mesh.uvs, small.meshes[0].mesh.uvs);
  EXPECT_GT(Psnr(small, large), kCarryPsnr);
  EXPECT_EQ(TextureOf(Promote(large, 0.25).scene).width, TextureOf(large).width);
  EXPECT_TRUE(Promote(large, 1.0).messages.empty()) << "nothing more to do";
}

TEST_F(SurfaceLevelsTest, TexturesFollowTheMeshThroughItsLevels) {
  const Scene before = Promote(scene_, 1.0).scene;
  FreeVertices();
  optim::FitSpec spec;
  spec.unknowns = unknowns_;
  spec.stages.resize(1);
  const optim::SceneLevel level =
      optim::SceneOfLevel(before, spec, {2}, optim::MakeFitViews(observations_, 0.5), 0.5);
  EXPECT_NE(level.scene.meshes[0].mesh.triangles, before.meshes[0].mesh.triangles);
  ASSERT_EQ(level.messages.size(), 2U);
  EXPECT_NE(level.messages[0].find("UVs are made anew"), std::string::npos) << level.messages[0];
  renderer::ValidateScene(level.scene);
  EXPECT_TRUE(renderer::IsAtlas(level.scene, 0));
  // The mesh itself is another one; its colours are the same.
  Scene plain = level.scene;
  plain.materials[0].base_color_texture = -1;
  plain.materials[0].vertex_colors = true;
  Mesh& mesh = plain.meshes[0].mesh;
  mesh.colors.clear();
  for (const Vec3& p : std::as_const(mesh.positions)) mesh.colors.push_back(Paint(p));
  mesh.color_triangles = mesh.triangles;
  EXPECT_GT(Psnr(plain, level.scene), 38.0) << "two different interpolations of the paint";
}

TEST_F(SurfaceLevelsTest, BetweenRoundsAMeshWithATextureKeepsItsTriangles) {
  FreeVertices();
  const optim::FitViews views = optim::MakeFitViews(observations_, 0.5);
  Scene plain = optim::RefineMeshes(scene_, unknowns_, {2}, views).scene;
  // Stretched to thrice its length, which edges do not bear.
  for (Vec3& p : plain.meshes[0].mesh.positions) p.y *= p.y > 0.0 ? 3.0 : 1.0;
  EXPECT_TRUE(optim::MendMeshes(plain, unknowns_, {2}, views).has_value());
  const Scene textured = Promote(plain, 0.5).scene;
  ASSERT_EQ(textured.materials[0].base_color_texture, 0);
  EXPECT_FALSE(optim::MendMeshes(textured, unknowns_, {2}, views).has_value());
}

TEST_F(SurfaceLevelsTest, BluntedMeshesHaveTheirTexturesMadeAgain) {
  FreeVertices();
  optim::FitSpec spec;
  spec.unknowns = unknowns_;
  spec.stages.resize(1);
  const optim::FitViews views = optim::MakeFitViews(observations_, 0.5);
  const auto blunt = [&](const Scene& scene) {
    return optim::BluntSceneOfLevel(scene, spec, {2}, views, 0.5);
  };
  Scene plain = optim::RefineMeshes(scene_, unknowns_, {2}, views).scene;
  EXPECT_FALSE(blunt(Promote(plain, 0.5).scene));
  tests::PullNeedles(plain.meshes[0].mesh);
  const auto made = blunt(Promote(plain, 0.5).scene);
  ASSERT_TRUE(made);
  renderer::ValidateScene(*made);
  EXPECT_TRUE(renderer::IsAtlas(*made, 0));
}

TEST_F(SurfaceLevelsTest, UvsOfTheirOwnAreKept) {
  scene_.meshes[0].mesh = renderer::MakeRectangle();
  scene_.materials[0].vertex_colors = false;
  const Scene made = Promote(scene_, 1.0).scene;
  EXPECT_EQ(made.meshes[0].mesh.uvs, scene_.meshes[0].mesh.uvs);
  EXPECT_EQ(made.materials[0].base_color_texture, 0);
  scene_.meshes[0].mesh = renderer::MakeCube();
  renderer::SetBoxUvs(scene_.meshes[0].mesh);
  const optim::SceneLevel cube = Promote(scene_, 1.0);
  EXPECT_TRUE(renderer::IsAtlas(cube.scene, 0)) << "those that overlap are not";
}

TEST_F(SurfaceLevelsTest, GivenTexturesKeepUvsThatOverlap) {
  scene_.meshes[0].mesh = renderer::MakeCube();
  renderer::SetBoxUvs(scene_.meshes[0].mesh);
  scene_.materials[0].vertex_colors = false;
  scene_.materials[0].bsdf = renderer::MetallicRoughnessBsdf{};
  scene_.textures.push_back({"worn"});
  scene_.materials[0].roughness_texture = 1;
  const optim::SceneLevel shared = Promote(scene_, 1.0);
  EXPECT_EQ(shared.scene.meshes[0].mesh.uvs, scene_.meshes[0].mesh.uvs);
  EXPECT_EQ(shared.scene.materials[0].base_color_texture, 0);
  EXPECT_FALSE(renderer::IsAtlas(shared.scene, 0));
  for (renderer::Vec2& uv : scene_.meshes[0].mesh.uvs.Edit()) uv = uv * 2.0;  // tiles
  const optim::SceneLevel level = Promote(scene_, 1.0);
  EXPECT_EQ(level.scene.meshes[0].mesh.uvs, scene_.meshes[0].mesh.uvs);
  EXPECT_EQ(level.scene.materials[0].base_color_texture, -1);
  ASSERT_EQ(level.messages.size(), 1U);
  EXPECT_NE(level.messages[0].find("other textures lie on"), std::string::npos);
}

TEST_F(SurfaceLevelsTest, WhatNoPhotoShowsStaysAndIsSaid) {
  for (Vec3& p : scene_.meshes[0].mesh.positions) p.y += 100.0;
  const optim::SceneLevel level = Promote(scene_, 1.0);
  EXPECT_TRUE(level.scene.materials[0].vertex_colors);
  ASSERT_EQ(level.messages.size(), 1U);
  EXPECT_NE(level.messages[0].find("no fitted photo"), std::string::npos);
}

TEST_F(SurfaceLevelsTest, UnseenTexelsAreFilledAndMarked) {
  // One camera above: below the rim nothing is seen.
  observations_.views[0].camera = tests::CameraAt({0, 4, 0.01}, {0, 0, 0}, 1.45 * 128, 128, 128);
  scene_.sensors[0] = observations_.views[0].camera;
  for (std::size_t v = 1; v < observations_.views.size(); ++v) {
    observations_.views[v].validation = true;
  }
  for (optim::View& view : observations_.views) view.mask = {};
  observations_.mask_meaning = optim::MaskMeaning::kNone;
  const optim::FitViews views = optim::MakeFitViews(observations_, 1.0);
  Scene made = Promote(scene_, 1.0).scene;
  const std::vector<TexelSight> sight = optim::SightOfTexels(made, 0, views);
  const auto seen = std::ranges::count(sight, TexelSight::kSeen);
  const auto unseen = std::ranges::count(sight, TexelSight::kUnseen);
  EXPECT_GT(seen, unseen / 8);
  EXPECT_GT(unseen, seen / 8);
  std::vector<Rgb>& texels = made.textures[0].texels.Edit();
  for (std::size_t i = 0; i < texels.size(); ++i) {
    texels[i] = sight[i] == TexelSight::kSeen ? Rgb{0.2, 0.4, 0.6} : Rgb{9.0, 9.0, 9.0};
  }
  const std::vector<std::string> messages = optim::FillUnseenTexels(unknowns_, views, made);
  for (const Rgb& texel : std::as_const(made).textures[0].texels) {
    EXPECT_NEAR(texel.r, 0.2, 1e-6) << "all of the picture continues what is seen";
    EXPECT_NEAR(texel.b, 0.6, 1e-6);
  }
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_NE(messages[0].find(std::to_string(unseen) + " of " + std::to_string(seen + unseen)),
            std::string::npos)
      << messages[0];
}

TEST_F(SurfaceLevelsTest, OnlyAStageThatMakesATextureOfAConstantBeginsSmallForIt) {
  optim::FitSpec spec;
  spec.unknowns = unknowns_;
  spec.stages.resize(3);
  spec.stages[1].free = {0};
  spec.stages[2].free = {0};
  const Scene start = WithOneColour();
  EXPECT_FALSE(MakesTexture(start, spec, 0));
  EXPECT_TRUE(MakesTexture(start, spec, 1));
  EXPECT_FALSE(MakesTexture(start, spec, 2)) << "it is there by then";
  EXPECT_FALSE(MakesTexture(Promote(scene_, 1.0).scene, spec, 1)) << "it was given";
  EXPECT_FALSE(MakesTexture(scene_, spec, 1)) << "vertices know more than small photos";
  spec.stages[0].free = {1};
  EXPECT_FALSE(MakesTexture(start, spec, 1)) << "so do those of an earlier stage";
  EXPECT_FALSE(MakesTexture(start, spec, 0)) << "vertices stay as many as they are";
  spec.stages[0].free = {};
  spec.unknowns[0].hold = true;
  EXPECT_FALSE(MakesTexture(start, spec, 1));
}

TEST_F(SurfaceLevelsTest, AStandingTextureGrowsWithThePhotosAndKeepsItsSamples) {
  observations_ = tests::Photograph(scene_, 32);
  optim::FitSpec spec;
  spec.unknowns = unknowns_;
  spec.unknowns[0].total_variation_weight = 1e-3;
  spec.stages.resize(1);
  spec.stages[0].name = "texture";
  spec.stages[0].free = {0};
  spec.stages[0].image_scale = 0.5;
  spec.stages[0].max_rounds = 12;
  const Scene start = WithOneColour();
  tests::RecordingObserver observer;
  const optim::FitResult result = optim::RunFit(start, observations_, spec, observer, {});
  ASSERT_FALSE(observer.rounds.empty());
  EXPECT_EQ(observer.rounds.front().image_scale, 0.25);
  EXPECT_EQ(observer.rounds.back().image_scale, 0.5);
  for (std::size_t i = 1; i < observer.rounds.size(); ++i) {
    const optim::RoundReport& last = observer.rounds[i - 1];
    const optim::RoundReport& next = observer.rounds[i];
    // Four times the pixels have half the samples each.
    EXPECT_GE(next.samples.spp * next.image_scale, 0.9 * last.samples.spp * last.image_scale) << i;
  }
  EXPECT_GT(Psnr(scene_, result.scene), 30.0);
}

TEST_F(SurfaceLevelsTest, AFitGoesFromConstantToVerticesToTextureAndContinuesToTheSameBits) {
  const Scene start = WithOneColour();
  UnknownSpec& constant = unknowns_.emplace_back();
  constant.name = "paint.base_color";
  constant.kind = ParameterKind::kBaseColor;
  for (UnknownSpec& unknown : unknowns_) {
    unknown.lower = 0.01;
    unknown.upper = 0.99;
  }
  unknowns_[0].total_variation_weight = 1e-3;
  optim::FitSpec spec;
  spec.unknowns = unknowns_;
  spec.stages.resize(3);
  const char* const names[] = {"one colour", "vertices", "texture"};
  const int free[] = {2, 1, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    spec.stages[i].name = names[i];
    spec.stages[i].free = {free[i]};
    spec.stages[i].max_rounds = 2;
    spec.stages[i].image_scale = i == 2 ? 0.5 : 0.25;
    spec.stages[i].samples.spp = 12;
  }
  observations_ = tests::Photograph(scene_, 32);
  tests::RecordingObserver straight;
  const optim::FitResult result = optim::RunFit(start, observations_, spec, straight, {});
  ASSERT_EQ(straight.stages.size(), 4U);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_LT(straight.stages[i].cost_after, straight.stages[i].cost_before) << names[i - 1];
  }
  EXPECT_EQ(result.scene.materials[0].base_color_texture, 0);
  EXPECT_GT(Psnr(scene_, result.scene), 30.0);

  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() /
      (std::string("pathfit_") + info->name() + std::to_string(getpid()));
  for (const int after : {3, 5}) {  // rounds: of vertices, of the texture
    if (tests::kSanitized && after == 3) continue;
    tests::RecordingObserver first, second;
    first.cancel_after = after;
    optim::FitControls controls;
    controls.cancel = &first.cancel;
    controls.checkpoint_folder = folder;
    optim::RunFit(start, observations_, spec, first, controls);
    controls.cancel = nullptr;
    controls.resume = optim::ReadNewestCheckpoint(folder, {start, spec.unknowns}).state;
    ASSERT_TRUE(controls.resume.has_value());
    const optim::FitResult resumed = optim::RunFit(start, observations_, spec, second, controls);
    EXPECT_EQ(resumed.scene.textures[0].texels, result.scene.textures[0].texels);
    EXPECT_EQ(resumed.scene.meshes[0].mesh.uvs, result.scene.meshes[0].mesh.uvs);
    EXPECT_TRUE(optim::SameShapes(resumed.scene, result.scene));
    std::filesystem::remove_all(folder);
  }
}

}  // namespace
}  // namespace pathfit::surface_levels_test
