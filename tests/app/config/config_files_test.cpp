#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>

#include "app/config/schema.h"
#include "app/config/schema_builders.h"
#include "tests/app/config/config_text.h"
#include "tests/app/config/schema_markdown.h"

namespace pathfit::app::config_files_test {
namespace {

namespace fs = std::filesystem;

const fs::path kConfigs = fs::path(PATHFIT_SOURCE_DIR) / "configs";

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(ConfigFiles, AllOfThisRepositoryLoad) {
  const fs::path tests = fs::path(PATHFIT_SOURCE_DIR) / "tests";
  for (const fs::path& folder : {kConfigs, tests / "scenes", tests / "bench"}) {
    int count = 0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() != ".yaml") continue;
      ++count;
      try {
        const ExperimentConfig config = LoadExperimentConfig(entry.path(), {});
        EXPECT_EQ(config.name, entry.path().stem()) << "runs are found by the file's name";
      } catch (const ConfigError& error) {
        ADD_FAILURE() << error.what();
      }
    }
    EXPECT_GE(count, 2) << folder;
  }
}

// PATHFIT_UPDATE_DOCS=1 rewrites the page.
TEST(ConfigFiles, TheReferencePageIsUpToDate) {
  const fs::path path = kConfigs / "README.md";
  if (std::getenv("PATHFIT_UPDATE_DOCS") != nullptr) {
    std::ofstream(path, std::ios::binary) << SchemaMarkdown();
  }
  EXPECT_TRUE(ReadText(path) == SchemaMarkdown())
      << path << " is out of date; run this test with PATHFIT_UPDATE_DOCS=1";
}

TEST(ConfigFiles, TheListOfAllSettingsHoldsTheDefaults) {
  const std::string text = SchemaYaml();
  for (const SchemaNode& child : ConfigSchema().children) {
    const bool open = text.find("\n" + child.key + ":") != std::string::npos;
    EXPECT_TRUE(open || text.find("\n# " + child.key + ":") != std::string::npos) << child.key;
  }
  EXPECT_NE(text.find("  # Samples per pixel of `pathfit render`."), std::string::npos);
  EXPECT_NE(text.find("#           # Radius."), std::string::npos) << "also of what is optional";
  // With a scene it is the same as the scene alone.
  const std::string scene =
      "scene: {geometry: {ball: {primitive: {sphere: {}}, material: grey}}, materials: {grey: "
      "{model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}}, "
      "sensors: {eye: {size_px: [8, 8], fov_deg: 40, pose: {look_at: {origin_m: [0, 0, 4], "
      "target_m: [0, 0, 0]}}}}}\n";
  const ConfigFile file(text + scene);
  const ExperimentConfig all = LoadExperimentConfig(file.path(), {});
  file.Write("schema: 1\n" + scene);
  const ExperimentConfig alone = LoadExperimentConfig(file.path(), {});
  EXPECT_TRUE(SameValues(all.resolved, alone.resolved)) << ResolvedText(all) << ResolvedText(alone);
}

TEST(ConfigFiles, TheTableOfKindsNamesEveryLightThatShines) {
  std::string named;
  std::istringstream lines(SchemaMarkdown());
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| `LIGHT.intensity`", 0) == 0) named += line.substr(0, line.find(" | ", 2));
  }
  const SchemaNode& light = ConfigSchema().Child("scene")->Child("lights")->children.front();
  for (const std::string& type : light.Child("type")->words) {
    EXPECT_NE(named.find(" " + type), std::string::npos) << type << " in " << named;
  }
}

// That every line has a member is a matter of compiling; that it is a member of the right struct is
// checked when the schema is made.
TEST(ConfigFiles, LinesAreBoundToTheStructOfTheirMap) {
  EXPECT_NO_THROW(CheckBindings(ConfigSchema(), typeid(ExperimentConfig)));
  EXPECT_THROW(CheckBindings(ConfigSchema(), typeid(OutputConfig)), std::logic_error);
  const SchemaNode stray = Map("output", {Key("sigma", &GradcheckConfig::sigma)}) | Always();
  EXPECT_THROW(CheckBindings(stray, typeid(OutputConfig)), std::logic_error);
  EXPECT_NO_THROW(CheckBindings(stray, typeid(GradcheckConfig)));
  const SchemaNode unread = Map("output", {TextNode("title")});
  EXPECT_THROW(CheckBindings(unread, typeid(OutputConfig)), std::logic_error);
}

// What depends on another key is looked up in the schema without asking whether it is there.
TEST(ConfigFiles, LinesSpeakOfKeysAndValuesThatExist) {
  EXPECT_NO_THROW(CheckReferences(ConfigSchema()));
  const auto refusal = [](const Trait& trait) -> std::string {
    SchemaNode key = TextNode("angle");
    trait(key);
    SchemaNode kind = TextNode("kind");
    kind.words = {"spot", "point"};
    try {
      CheckReferences(Map("", {Map("light", {kind, key})}));
    } catch (const std::logic_error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal(When("kind", {"spot"})), "accepted");
  EXPECT_EQ(refusal(Needs("kind")), "accepted");
  EXPECT_EQ(refusal(UselessWith("light.kind", {"point"})), "accepted");
  EXPECT_EQ(refusal(When("sort", {"spot"})),
            "schema: 'angle' depends on 'sort', which its map does not have");
  EXPECT_EQ(refusal(When("kind", {"spit"})),
            "schema: 'angle' depends on 'spit', which is no value of 'kind'");
  EXPECT_EQ(refusal(RequiredFor({"spot"})),
            "schema: 'angle' depends on 'spot', which is no value of ''");
  EXPECT_EQ(refusal(OneOfFor("group", {"point"}) | When("kind", {"spot"})), "accepted");
  EXPECT_EQ(refusal(Needs("width")), "schema: 'angle' needs 'width', which its map does not have");
  EXPECT_EQ(refusal(UselessWith("lamp.kind", {"point"})),
            "schema: 'angle' has no use with lamp.kind: point, which is no value of the config");
  EXPECT_EQ(refusal(UselessWith("light.kind", {"pint"})),
            "schema: 'angle' has no use with light.kind: pint, which is no value of the config");
}

TEST(ConfigFiles, EveryKeyIsDocumented) {
  std::vector<const SchemaNode*> nodes = {&ConfigSchema()};
  while (!nodes.empty()) {
    const SchemaNode* node = nodes.back();
    nodes.pop_back();
    for (const SchemaNode& child : node->children) {
      const bool named = node->type == SchemaNode::Type::kMap;
      EXPECT_TRUE(!named || !child.doc.empty()) << child.key;
      nodes.push_back(&child);
    }
  }
}

}  // namespace
}  // namespace pathfit::app::config_files_test
