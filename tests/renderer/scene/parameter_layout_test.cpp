#include "renderer/scene/parameter_layout.h"

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer {
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

}  // namespace
}  // namespace pathfit::renderer
