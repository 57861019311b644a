#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/app/config/config_text.h"

namespace pathfit::app::config_fuzz_test {
namespace {

// Accepted, or refused with a complete message: anything but another exception or a crash.
void ExpectAnswer(const ConfigFile& file,
                  const std::string& text,
                  const std::vector<std::string>& sets = {}) {
  file.Write(text);
  try {
    const ExperimentConfig config = LoadExperimentConfig(file.path(), Sets(sets));
    EXPECT_FALSE(ResolvedText(config).empty());
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("nothing was run (status 3)"), std::string::npos);
  } catch (const std::exception& error) {
    ADD_FAILURE() << error.what() << "\n" << text;
  }
}

class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::size_t Below(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_);
  }

  // A few edits of characters, words or lines.
  std::string Mutate(std::string text) {
    const std::size_t count = 1 + Below(4);
    for (std::size_t i = 0; i < count && !text.empty(); ++i) Edit(text);
    return text;
  }

 private:
  void Edit(std::string& text) {
    const std::size_t at = Below(text.size());
    switch (Below(6)) {
      case 0:
        text[at] = static_cast<char>(Below(256));
        break;
      case 1:
        text.erase(at, 1 + Below(20));
        break;
      case 2:
        text.insert(at, kWords.at(Below(kWords.size())));
        break;
      case 3:
        text.resize(at);
        break;
      case 4:
        text.insert(at, text.substr(Below(text.size()), 1 + Below(60)));
        break;
      default: {
        // The value behind a colon.
        const std::size_t colon = text.find(": ", at);
        if (colon == std::string::npos) break;
        const std::size_t end = text.find_first_of(",}]\n", colon);
        if (end == std::string::npos) break;
        text.replace(colon + 2, end - colon - 2, kWords.at(Below(kWords.size())));
      }
    }
  }

  const std::vector<std::string> kWords = {
      "{}",          "[]",          "null",       "~",
      "[[1, 2], 3]", "{a: {b: c}}", "1e999",      "-1",
      "0",           ".inf",        "yes",        "\"1\"",
      "- a",         "\n",          "\t",         ": ",
      "&a ",         "*a",          "!!x",        "#",
      "'",           "\"",          "]",          "}",
      "012",         "all",         "${X",        "~/x",
      "é",           "<<: *a",      "exposure",   "mug.vertices",
      "mesh",        "vertex",      "2147483648", "99999999999999999999",
      "0.5"};
  std::mt19937 random_;
};

TEST(ConfigFuzz, DamagedConfigsAreAnswered) {
  constexpr int kRounds = 1000;
  Mutator mutator(1);
  const ConfigFile file("");
  for (int i = 0; i < kRounds; ++i) {
    ExpectAnswer(file, mutator.Mutate(kFitConfig));
    ExpectAnswer(file, mutator.Mutate(kSceneConfig));
    ExpectAnswer(file, mutator.Mutate(kRichConfig));
  }
}

TEST(ConfigFuzz, EveryTruncationIsAnswered) {
  const ConfigFile file("");
  const std::string text = kSceneConfig;
  for (std::size_t length = 0; length < text.size(); ++length) {
    ExpectAnswer(file, text.substr(0, length));
  }
}

TEST(ConfigFuzz, DamagedOverridesAreAnswered) {
  constexpr int kRounds = 200;
  Mutator mutator(2);
  const ConfigFile file("");
  for (int i = 0; i < kRounds; ++i) {
    ExpectAnswer(file,
                 kFitConfig,
                 {mutator.Mutate("unknowns.mug.vertices.priors[0].laplacian.weight=0.5"),
                  mutator.Mutate("stages.light.free=[room.texels, exposure]"),
                  mutator.Mutate("scene.materials.glaze={model: diffuse, base_color: {}}")});
  }
}

}  // namespace
}  // namespace pathfit::app::config_fuzz_test
