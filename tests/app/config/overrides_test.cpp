#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/config/schema.h"
#include "tests/app/config/config_text.h"

namespace pathfit::app::overrides_test {
namespace {

TEST(Overrides, ReachEveryKindOfPlace) {
  const ExperimentConfig config = LoadText(kFitConfig,
                                           {"seed=9",
                                            "render.max_bounces=3",
                                            "stages[0].spp=32",
                                            "stages.all.spp=64",
                                            "stages.light.stop.relative_cost=1e-3",
                                            "unknowns.mug.vertices.priors[0].laplacian.weight=0.5",
                                            "unknowns.mug.vertices.parametrisation.large_steps."
                                            "lambda=3",
                                            "unknowns.mug.colors.bounds[1]=0.9",
                                            "scene.materials.paint.base_color.constant=[0.1, 0.2, "
                                            "0.3]",
                                            "input.split.validation=[a.jpg, b.jpg]",
                                            "input.max_size_px=512",
                                            "gradcheck.params+=\"room.*\"",
                                            "output.directory=/tmp/out"});
  EXPECT_EQ(config.render.seed, 9U);
  EXPECT_EQ(config.render.max_bounces, 3) << "no such map in the file";
  EXPECT_EQ(config.fit.stages[0].samples.spp, 32);
  EXPECT_EQ(config.fit.stages[1].samples.spp, 64);
  EXPECT_DOUBLE_EQ(config.fit.stages[0].stop_relative_cost, 1e-3);
  EXPECT_DOUBLE_EQ(config.fit.unknowns[0].laplacian_weight, 0.5);
  EXPECT_DOUBLE_EQ(config.fit.unknowns[0].large_steps_lambda, 3.0);
  const YamlNode& bounds = *config.resolved.Find("unknowns")->entries[1].value.Find("bounds");
  EXPECT_EQ(bounds.items[0].text + " " + bounds.items[1].text, "0.02 0.9");
  EXPECT_EQ(config.materials[1].base_color, (Triple{0.1, 0.2, 0.3}));
  EXPECT_EQ(config.input->photos.validation_names, (std::vector<std::string>{"a.jpg", "b.jpg"}));
  EXPECT_EQ(config.input->photos.validation_every, 0);
  EXPECT_EQ(config.input->photos.max_size_px, 512);
  EXPECT_EQ(config.gradcheck.params, (std::vector<std::string>{"mug.*", "room.*"}));
  EXPECT_EQ(config.output.directory, "/tmp/out");
}

TEST(Overrides, AddWholeEntries) {
  const ExperimentConfig config =
      LoadText(kFitConfig,
               {"unknowns.room.intensity={}",
                "scene.materials.chalk={model: diffuse, base_color: {constant: [0.9, 0.9, 0.9]}}"});
  EXPECT_EQ(config.fit.unknowns.size(), LoadText(kFitConfig).fit.unknowns.size() + 1);
  EXPECT_EQ(config.fit.unknowns.back().name, "room.intensity");
  EXPECT_EQ(config.materials.back().name, "chalk");
}

TEST(Overrides, LaterOnesWin) {
  EXPECT_EQ(LoadText(kFitConfig, {"seed=1", "seed=2"}).render.seed, 2U);
  EXPECT_EQ(LoadText(kFitConfig, {"render={spp: 3}", "render.max_bounces=2"}).render.spp, 3);
}

TEST(Overrides, WhatVariesIsSpelledOnce) {
  const ConfigFile file(kFitConfig);
  const auto problems = [&](bool varies) {
    try {
      LoadExperimentConfig(
          file.path(),
          {{"--vary #1", "stages[1].spp=4", varies}, {"--vary #2", "stages.all.spp=8", true}});
    } catch (const ConfigError& error) {
      return ProblemsIn(error, file);
    }
    return std::vector<std::string>();
  };
  EXPECT_EQ(problems(true),
            std::vector<std::string>(
                {"--vary #2: stages.all.spp: is what --vary #1 varies: stages[1].spp=4"}));
  EXPECT_TRUE(problems(false).empty());
}

TEST(Overrides, UnknownPlacesAreNamedWithTheNearest) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"stages.all.max_round=5", "stages.all.max_round: no such key (did you mean 'max_rounds'?)"},
      {"stages.al.spp=5",
       "stages.al.spp: no item of 'stages' is called 'al' (did you mean 'all'?)"},
      {"stages[2].spp=5", "stages[2].spp: no item 2; 'stages' has 2"},
      {"stages[x].spp=5", "stages[x].spp: a list item is named by its number from 0, as in [2]"},
      {"stages[-1].spp=5", "stages[-1].spp: a list item is named by its number from 0, as in [2]"},
      {"stages[1=5", "stages[1: a list item is named by its number from 0, as in [2]"},
      {"stages[1]spp=5", "stages[1]spp: '.' or '[' is expected behind ']'"},
      {"seed.x=5", "seed.x: no such key; 'seed' holds a whole number from 0 to 9007199254740992"},
      {"solver[0]=5", "solver[0]: no such key; 'solver' is not a list"},
      {"unknowns.mug.vertex.hold=true",
       "unknowns.mug.vertex.hold: no OBJECT.PROPERTY is called 'mug.vertex' (did you mean "
       "'mug.vertices'?)"},
      {"scene.materials.glze.two_sided=false",
       "scene.materials.glze.two_sided: no MATERIAL is called 'glze' (did you mean 'glaze'?)"},
      {"output.report+=1", "output.report: true or false is needed, not a list"},
      {"name+=1", "name: += needs a list, this is 'mug'"},
      {"seed=9007199254740993",
       "seed: 9007199254740993 is out of range (allowed: a whole number from 0 to "
       "9007199254740992)"},
      {"seed", "the form is path.to.key=VALUE"},
      {"=5", "the form is path.to.key=VALUE"},
      {"seed=", "seed: no value after '='"},
      {"seed=[1", "seed: this '[' is never closed by ']'"},
      {".seed=1",
       ".seed: no such key (known: schema, name, seed, input, scene, render, unknowns, "
       "loss, gauge, stages, solver, output, gradcheck)"},
      {"stages..spp=1", "stages..spp: no item of 'stages' is called '' (known: light, all)"},
  };
  for (const auto& [assignment, expected] : cases) {
    EXPECT_EQ(ProblemOf(kFitConfig, {assignment}), "--set #1: " + expected) << assignment;
  }
}

TEST(Overrides, FlagsAreNamedAsThePlace) {
  const ConfigFile file(kFitConfig);
  try {
    LoadExperimentConfig(file.path(), {{"--threads", "solver.threads=5000"}});
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "--threads: error: solver.threads: 5000 is out of range (allowed: a whole number "
                 "from 1 to 1024, or auto)\n      solver.threads=5000\n"
                 "pathfit: config has 1 error; nothing was run (status 3)");
  }
}

}  // namespace
}  // namespace pathfit::app::overrides_test
