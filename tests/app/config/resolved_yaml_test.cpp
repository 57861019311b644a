#include "app/config/resolved_yaml.h"

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/app/config/config_text.h"

namespace pathfit::app::resolved_yaml_test {
namespace {

std::string WithoutComments(const std::string& yaml) {
  std::string bare;
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);) {
    bare += line.substr(0, line.find("  # ")) + "\n";
  }
  return bare;
}

// What is read back from the resolved copy, in another folder, is the same config.
void ExpectRoundTrip(const std::string& text, const std::vector<std::string>& sets = {}) {
  const ExperimentConfig first = LoadText(text, sets);
  const ExperimentConfig second = LoadText(ResolvedText(first));
  EXPECT_EQ(WithoutComments(ResolvedText(first)), WithoutComments(ResolvedText(second)));
  EXPECT_EQ(ResolvedText(second).find("# default"), std::string::npos)
      << "every value is written in the copy";
  EXPECT_EQ(first.name, second.name);
  EXPECT_EQ(first.output.directory, second.output.directory);
  ASSERT_EQ(first.fit.unknowns.size(), second.fit.unknowns.size());
  for (std::size_t i = 0; i < first.fit.unknowns.size(); ++i) {
    EXPECT_EQ(first.fit.unknowns[i].name, second.fit.unknowns[i].name);
  }
  EXPECT_TRUE(SameValues(first.resolved, second.resolved));
  ASSERT_EQ(first.fit.stages.size(), second.fit.stages.size());
  for (std::size_t i = 0; i < first.fit.stages.size(); ++i) {
    EXPECT_EQ(first.fit.stages[i].free, second.fit.stages[i].free);
  }
}

TEST(ResolvedYaml, TheInnerAngleOfASpotKeepsItsBits) {
  for (const char* outer : {"35", "10", "33.3", "59", "71.7"}) {
    const ExperimentConfig first =
        LoadText(kSceneConfig,
                 {std::string("scene.lights.sky={type: spot, position_m: [0, 3, 0], target_m: "
                              "[0, 0, 0], outer_deg: ") +
                  outer + "}"});
    const ExperimentConfig second = LoadText(ResolvedText(first));
    EXPECT_EQ(first.lights.back().inner_angle, second.lights.back().inner_angle) << outer;
    EXPECT_EQ(first.lights.back().outer_angle, second.lights.back().outer_angle) << outer;
  }
}

TEST(ResolvedYaml, ReadsBackAsTheSameConfig) {
  ExpectRoundTrip(kFitConfig, {"stages.all.spp=32", "unknowns.mug.colors.bounds[0]=0.1"});
  ExpectRoundTrip(kSceneConfig);
  ExpectRoundTrip(kRichConfig);
  ExpectRoundTrip(R"(schema: 1
scene:
  geometry:
    leaf:
      mesh:
        vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [2, 2, 1e-3]]
        triangles: [[0, 1, 2]]
      material: "1"
    other: {file: "a \"b\" \\c.ply", material: "1"}
  materials: {"1": {model: "diffuse", base_color: {constant: [.5, +0.5, 5e-1]}}}
  sensors:
    a: {size_px: [8, 9], focal_px: 9, pose: {look_at: {origin_m: [0, 0, 1], target_m: [0, 0, 0]}}}
gradcheck: {params: ["*", "# no comment", " spaced ", "é: x"]}
)");
}

TEST(ResolvedYaml, SaysWhereEveryValueCameFrom) {
  const std::string yaml = ResolvedText(LoadText(
      kFitConfig, {"stages.all.spp=32", "render.spp=3", "unknowns.mug.colors.bounds[0]=0.1"}));
  for (const char* line : {"\nseed: 7  # test.yaml:3\n",
                           "\n    spp: 32  # --set #1\n",
                           "\n  spp: 3  # --set #2\n",
                           "\n    bounds: [0.1, 0.95]  # test.yaml:26, --set #3\n",
                           "\n  max_bounces: 1  # default\n"}) {
    EXPECT_NE(yaml.find(line), std::string::npos) << line << yaml;
  }
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(": ");
    const bool has_value =
        colon < line.find('#') && colon + 2 < line.size() && line[colon + 2] != ' ';
    if (has_value) {
      EXPECT_NE(line.find("  # "), std::string::npos) << line;
    }
  }
}

TEST(ResolvedYaml, HoldsEveryDefault) {
  const std::string yaml = ResolvedText(LoadText(kSceneConfig));
  for (const char* line : {"\nname: \"test\"  # default\n",
                           "\nseed: 0  # default\n",
                           "\n      principal_point_px: [32, 16]  # default\n",
                           "\n      fov_axis: smaller  # default\n",
                           "\n  linear_solver: auto  # default\n"}) {
    EXPECT_NE(yaml.find(line), std::string::npos) << line << yaml;
  }
}

}  // namespace
}  // namespace pathfit::app::resolved_yaml_test
