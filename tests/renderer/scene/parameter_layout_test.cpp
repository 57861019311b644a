#include "renderer/scene/parameter_layout.h"

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::parameter_layout_test {
namespace {

ParameterLayout AllOf(const Scene& scene) {
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kVertexPositions, 0);
  layout.Add(ParameterKind::kVertexColors, 0);
  layout.Add(ParameterKind::kBaseColor, 1);
  layout.Add(ParameterKind::kRoughness, 1);
  layout.Add(ParameterKind::kMetallic, 1);
  layout.Add(ParameterKind::kLightIntensity, 2);
  layout.Add(ParameterKind::kEnvironmentTexels, 0);
  layout.Add(ParameterKind::kExposure, 0);
  return layout;
}

TEST(ParameterLayout, NumbersBlocksAndScalarsThroughAllGroups) {
  const Scene scene = tests::BallAndWall();
  const ParameterLayout layout = AllOf(scene);
  const auto vertices = static_cast<std::int32_t>(scene.meshes[0].mesh.positions.size());
  EXPECT_EQ(layout.NumBlocks(), 2 * vertices + 1 + 1 + 1 + 1 + 32 + 1);
  EXPECT_EQ(layout.NumScalars(), 6 * vertices + 3 + 1 + 1 + 3 + 96 + 1);
  EXPECT_EQ(layout.FirstBlock(ParameterKind::kVertexColors, 0), vertices);
  EXPECT_EQ(layout.FirstBlock(ParameterKind::kVertexColors, 1), -1);
  EXPECT_EQ(layout.FirstBlock(ParameterKind::kLightIntensity, 0), -1);
  std::int64_t scalar = 0;
  for (std::int32_t block = 0; block < layout.NumBlocks(); ++block) {
    EXPECT_EQ(layout.FirstScalarOfBlock(block), scalar);
    scalar += layout.GroupOfBlock(block).block_size;
  }
  EXPECT_EQ(scalar, layout.NumScalars());
}

TEST(ParameterLayout, NamesScalarsForMessages) {
  const Scene scene = tests::BallAndWall();
  const ParameterLayout layout = AllOf(scene);
  EXPECT_EQ(layout.ScalarName(17, 1), "ball.vertices[17].y");
  EXPECT_EQ(layout.ScalarName(layout.FirstBlock(ParameterKind::kVertexColors, 0) + 3, 2),
            "ball.colors[3].b");
  EXPECT_EQ(layout.ScalarName(layout.FirstBlock(ParameterKind::kRoughness, 1), 0),
            "gloss.roughness");
  EXPECT_EQ(layout.ScalarName(layout.FirstBlock(ParameterKind::kLightIntensity, 2), 0),
            "sun.intensity.r");
  EXPECT_EQ(layout.ScalarName(layout.FirstBlock(ParameterKind::kEnvironmentTexels, 0) + 8, 0),
            "sky.texels[8].r");
  EXPECT_EQ(layout.ScalarName(layout.FirstBlock(ParameterKind::kExposure, 0), 0),
            "camera.exposure");
}

TEST(ParameterLayout, GatherUndoesScatter) {
  Scene scene = tests::BallAndWall();
  const ParameterLayout layout = AllOf(scene);
  std::vector<double> values;
  for (std::int64_t i = 0; i < layout.NumScalars(); ++i)
    values.push_back(0.01 * static_cast<double>(i) + 0.5);
  layout.Scatter(values, scene);
  EXPECT_EQ(layout.Gather(scene), values);
  EXPECT_EQ(scene.meshes[0].mesh.positions[1].z, values[5]);
  EXPECT_EQ(scene.sensors[0].gain, values.back());
}

TEST(ParameterLayout, PicturesByOneLensHaveItsNumbers) {
  Scene scene = tests::BallAndWall();
  scene.sensors.resize(4, scene.sensors[0]);
  for (std::size_t i = 0; i < 4; ++i) scene.sensors[i].name = "photo_" + std::to_string(i);
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kFocal, 0, {2, 3});
  layout.Add(ParameterKind::kFocal, 1);
  layout.Add(ParameterKind::kVignetting, 2, {0, 1, 3});
  ASSERT_EQ(layout.groups().size(), 3U);
  EXPECT_EQ(layout.NumScalars(), 2 + 2 + 3);
  for (const int sensor : {0, 2, 3}) {
    EXPECT_EQ(layout.FirstBlock(ParameterKind::kFocal, sensor), 0) << sensor;
  }
  EXPECT_EQ(layout.FirstBlock(ParameterKind::kFocal, 1), 1);
  EXPECT_EQ(layout.FirstBlock(ParameterKind::kVignetting, 3), 2);
  EXPECT_EQ(layout.ScalarName(0, 1), "photo_0.focal.y");
  EXPECT_EQ(layout.ScalarName(2, 0), "camera.vignetting.1") << "of all sensors";
  const std::vector<double> values = {50.0, 51.0, 60.0, 61.0, -0.1, -0.2, -0.3};
  layout.Scatter(values, scene);
  EXPECT_EQ(layout.Gather(scene), values);
  EXPECT_EQ(scene.sensors[3].fy, 51.0);
  EXPECT_EQ(scene.sensors[1].fy, 61.0);
  EXPECT_EQ(scene.sensors[1].vignetting.v3, -0.3);
  EXPECT_THROW(layout.Add(ParameterKind::kFocal, 3), SceneError) << "shared already";
  EXPECT_THROW(layout.Add(ParameterKind::kPrincipalPoint, 0, {4}), SceneError);
}

TEST(ParameterLayout, RefusesWhatIsNotThereOrListedTwice) {
  const Scene scene = tests::BallAndWall();
  ParameterLayout layout(scene);
  EXPECT_THROW(layout.Add(ParameterKind::kVertexPositions, 2), SceneError);
  EXPECT_THROW(layout.Add(ParameterKind::kVertexPositions, -1), SceneError);
  EXPECT_THROW(layout.Add(ParameterKind::kVertexColors, 1), SceneError)
      << "the wall has no colours";
  EXPECT_THROW(layout.Add(ParameterKind::kRoughness, 0), SceneError) << "Lambert has no roughness";
  EXPECT_THROW(layout.Add(ParameterKind::kEnvironmentTexels, 1), SceneError)
      << "a lamp has no texels";
  layout.Add(ParameterKind::kRoughness, 1);
  EXPECT_THROW(layout.Add(ParameterKind::kRoughness, 1), SceneError);
  EXPECT_EQ(layout.NumScalars(), 1) << "refused groups leave nothing behind";
}

TEST(ParameterLayout, EverySensorIsOneGroup) {
  Scene scene = tests::BallAndWall();
  scene.sensors.push_back(scene.sensors[0]);
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kFocal, -1);
  ASSERT_EQ(layout.groups().size(), 2U);
  EXPECT_EQ(layout.groups()[1].object, 1);
}

TEST(ParameterLayout, OfScalarTexturesOneNumberIsAllChannels) {
  Scene scene = tests::BallAndWall();
  Texture& texture = scene.textures.emplace_back();
  texture.name = "worn";
  texture.width = 2;
  texture.texels = {Rgb::Constant(0.25), Rgb::Constant(0.5)};
  texture.scalar = true;
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kTextureTexels, 0);
  EXPECT_EQ(layout.Gather(scene), (std::vector<double>{0.25, 0.5}));
  EXPECT_EQ(layout.ScalarName(1, 0), "worn.texels[1]");
  layout.Scatter({0.75, 1.0}, scene);
  EXPECT_EQ(scene.textures[0].texels[0], Rgb::Constant(0.75));
  EXPECT_EQ(scene.textures[0].texels[1], Rgb::Constant(1.0));
}

TEST(ParameterLayout, GathersIntoTheMemoryThatItIsGiven) {
  const Scene scene = tests::BallAndWall();
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kVertexPositions, 0);
  layout.Add(ParameterKind::kObjectScale, 0);
  const std::vector<double> expected = layout.Gather(scene);
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, 2 * expected.size()}) {
    std::vector<double> values(size, 3.0);
    layout.Gather(scene, values);
    EXPECT_EQ(values, expected);
    const double* memory = values.data();
    layout.Gather(scene, values);
    EXPECT_EQ(values, expected);
    EXPECT_EQ(values.data(), memory);
  }
}

TEST(ParameterLayout, WritingOneListLeavesTheOthersShared) {
  const Scene scene = tests::BallAndWall();
  Scene moved = scene;
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kVertexPositions, 0);
  std::vector<double> values = layout.Gather(scene);
  values[0] += 1.0;
  layout.Scatter(values, moved);
  EXPECT_EQ(layout.Gather(scene)[0], values[0] - 1.0);
  const auto lists = [](const Scene& s) {
    const Mesh& ball = s.meshes[0].mesh;
    const auto& sky = std::get<EnvironmentEmitter>(s.emitters[0].light);
    return std::vector<const void*>{ball.colors.data(),
                                    ball.triangles.data(),
                                    s.meshes[1].mesh.positions.data(),
                                    sky.texels.data(),
                                    ball.positions.data()};
  };
  std::vector<const void*> before = lists(scene), after = lists(moved);
  EXPECT_NE(after.back(), before.back());
  before.pop_back();
  after.pop_back();
  EXPECT_EQ(after, before);
}

TEST(ParameterTraits, EveryKindHasAName) {
  for (int k = 0; k < static_cast<int>(ParameterKind::kCount); ++k) {
    const auto kind = static_cast<ParameterKind>(k);
    const ParameterTraits& traits = TraitsOf(kind);
    EXPECT_EQ(traits.kind, kind);
    EXPECT_STRNE(traits.property, "");
    EXPECT_LE(traits.NumComponents(), 3);
  }
}

TEST(ParameterTraits, RowsOfAKindStandTogetherAndAgree) {
  const ParameterTraits* before = nullptr;
  for (const ParameterTraits& row : AllParameterTraits()) {
    if (before != nullptr) {
      EXPECT_LE(before->kind, row.kind);
    }
    const ParameterTraits& first = TraitsOf(row.kind);
    EXPECT_STREQ(first.property, row.property);
    EXPECT_EQ(first.list, row.list);
    EXPECT_EQ(first.moves, row.moves);
    EXPECT_LE(row.smallest, row.lower) << row.property;
    EXPECT_GE(row.largest, row.upper) << row.property;
    before = &row;
  }
}

TEST(ParameterTraits, EveryObjectFitsOneRow) {
  Scene scene = tests::BallAndWall();
  scene.materials.push_back({"gold", RoughConductorBsdf{}});
  scene.materials.push_back({"glass", SmoothDielectricBsdf{}});
  scene.textures.resize(2);
  scene.textures[1].scalar = true;
  scene.emitters.push_back({"spot", LightFrame::kWorld, {}, SpotEmitter{}});
  scene.emitters.push_back({"beamer", LightFrame::kWorld, {}, ProjectorEmitter{}});
  scene.emitters.push_back({"panel", LightFrame::kWorld, {}, AreaEmitter{0}});
  for (int k = 0; k < static_cast<int>(ParameterKind::kCount); ++k) {
    const auto kind = static_cast<ParameterKind>(k);
    const auto names = ObjectNames(scene, TraitsOf(kind).list);
    for (int object = 0; object < static_cast<int>(names.size()); ++object) {
      int fitting = 0;
      for (const ParameterTraits& row : AllParameterTraits()) {
        fitting += row.kind == kind && row.is_for(scene, object) ? 1 : 0;
      }
      EXPECT_EQ(fitting, 1) << TraitsOf(kind).property << " of "
                            << names[static_cast<std::size_t>(object)];
      const ParameterTraits& row = TraitsOf(kind, scene, object);
      const auto blocks = row.read(scene, object);
      EXPECT_TRUE(blocks.num_blocks == 0 || blocks.block_size == row.NumComponents())
          << row.property << " of " << names[static_cast<std::size_t>(object)];
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::parameter_layout_test
