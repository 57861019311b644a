#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "app/config/schema.h"
#include "tests/app/config/config_text.h"

namespace pathfit::app {
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
}  // namespace pathfit::app
