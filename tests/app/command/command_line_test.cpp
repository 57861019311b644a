#include "app/command/command_line.h"

#include <cstdlib>
#include <filesystem>
#include <map>

#include <gtest/gtest.h>

#include "optim/ranks/ranks.h"

namespace pathfit::app::command_line_test {
namespace {

CommandLine Parse(std::vector<std::string> words,
                  const std::map<std::string, std::string>& environment = {},
                  const Commands& commands = AllCommands()) {
  words.insert(words.begin(), "pathfit");
  const auto value = [&environment](const std::string& name) {
    const auto found = environment.find(name);
    return found == environment.end() ? std::string() : found->second;
  };
  return ParseCommandLine(words, value, commands);
}

// First line of the message, or "accepted".
std::string Refusal(const std::vector<std::string>& words,
                    const std::map<std::string, std::string>& environment = {}) {
  try {
    Parse(words, environment);
  } catch (const UsageError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("(status 2)"), std::string::npos);
    return text.substr(0, text.find('\n'));
  }
  return "accepted";
}

TEST(CommandLine, FlagsMayStandAnywhere) {
  const CommandLine line =
      Parse({"-v",      "--threads",    "2",          "fit",          "--set",  "a.b=[1, 2]",
             "c.yaml",  "--set",        "d=e",        "-o",           "out",    "--time-limit",
             "1h30m",   "--max-memory", "12GiB",      "--stop-after", "light",  "--json",
             "--color", "never",        "--progress", "plain",        "--seed", "5"});
  EXPECT_STREQ(line.command->name, "fit");
  EXPECT_EQ(line.target, "c.yaml");
  ASSERT_EQ(line.overrides.size(), 6U);
  EXPECT_EQ(line.overrides[0].assignment, "a.b=[1, 2]");
  EXPECT_EQ(line.overrides[1].assignment, "d=e");
  EXPECT_EQ(line.overrides[2].assignment, "solver.threads=2") << "before the command";
  EXPECT_EQ(line.overrides[3].assignment, "seed=5");
  EXPECT_EQ(line.overrides[4].assignment, "solver.max_memory=12GiB");
  EXPECT_EQ(line.overrides[5].label, "-o");
  EXPECT_EQ(line.log_level, LogLevel::kDebug);
  EXPECT_EQ(line.threads, 2);
  EXPECT_EQ(line.color, ColorMode::kNever);
  EXPECT_EQ(line.progress, ProgressMode::kPlain);
  EXPECT_TRUE(line.json);
}

TEST(CommandLine, SomeCommandsTakeSeveralWordsOrNone) {
  EXPECT_TRUE(Parse({"init"}).targets.empty());
  const CommandLine one = Parse({"init", "photos", "--force"});
  ASSERT_EQ(one.targets.size(), 1U);
  EXPECT_EQ(one.target, "photos");
  const CommandLine two = Parse({"init", "--masks", "m", "photos", "-o", "a.yaml", "cameras.json"});
  ASSERT_EQ(two.targets.size(), 2U);
  EXPECT_EQ(two.targets[1], "cameras.json");
  EXPECT_EQ(Refusal({"init", "a", "b", "c"}), "pathfit init: unexpected argument 'c'");
  EXPECT_EQ(Refusal({"check", "a", "b"}), "pathfit check: unexpected argument 'b'");
  EXPECT_EQ(Refusal({"check", ""}), "pathfit check: CONFIG is missing");
}

TEST(CommandLine, OverridesComeInOrderOfPrecedence) {
  const CommandLine line =
      Parse({"gradcheck", "c.yaml", "--params",  "a.*", "--params",     "it's", "--spp",  "64",
             "--step",    "1e-3",   "--sigma",   "4.5", "--replicates", "9",    "--seed", "3",
             "--set",     "seed=1", "--threads", "8"});
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"--set #1", "seed=1"},
      {"--seed", "seed=3"},
      {"--threads", "solver.threads=8"},
      {"--spp", "gradcheck.spp=64"},
      {"--replicates", "gradcheck.replicates=9"},
      {"--step", "gradcheck.step=1e-3"},
      {"--sigma", "gradcheck.sigma=4.5"},
      {"--params", "gradcheck.params=['a.*', 'it''s']"},
  };
  const std::vector<ConfigOverride> overrides = line.overrides;
  ASSERT_EQ(overrides.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(overrides[i].label, expected[i].first);
    EXPECT_EQ(overrides[i].assignment, expected[i].second);
  }
}

TEST(CommandLine, OneSetTakesOneWord) {
  EXPECT_EQ(Refusal({"fit", "c.yaml", "--set", "a=1", "b=2"}),
            "pathfit fit: unexpected argument 'b=2'");
}

TEST(CommandLine, OverridesOfADerivative) {
  const CommandLine line = Parse({"render",
                                  "runs/a",
                                  "--views",
                                  "0,3,IMG_1.JPG",
                                  "--derivative",
                                  "axe.vertices[3].x",
                                  "--derivative",
                                  "exposure",
                                  "--terms",
                                  "primary,pixel",
                                  "--form",
                                  "material",
                                  "--spp",
                                  "4"});
  ASSERT_EQ(line.overrides.size(), 3U);
  EXPECT_EQ(line.overrides[0].assignment, "render.spp=4");
  EXPECT_EQ(line.overrides[1].assignment, "render.terms=[primary,pixel]");
  EXPECT_EQ(line.overrides[2].assignment, "render.form='material'");
}

/// A command of the test: its values, and what it was run with.
struct Brew {
  bool strong = false;
  std::string bean = "arabica", milk = "none";
  std::filesystem::path cup;
  std::vector<std::string> guests, extras;
  double grams = 18.0, seconds = 0.0;
  int shots = 2;
};
Brew brewed;

void DeclareBrew(OptionList& options, Brew& own) {
  options.Flag("--strong", "", own.strong);
  options.Text("--bean", "NAME", "", own.bean);
  options.Word("--milk", "none|oat|cow", "", own.milk);
  options.Path("-o,--cup", "PATH", "", own.cup);
  options.Texts("--guest", "NAME", "", own.guests);
  options.List("--extras", "LIST", "", own.extras);
  options.Number("--grams", "", 5.0, 30.0, own.grams);
  options.Duration("--for", "", own.seconds);
  options.Whole("--shots", "", 1, 4, own.shots);
  options.Check([&options, &own] {
    if (own.shots > 2 && !own.strong) options.Fail("--shots above 2 needs --strong");
    if (options.line().targets.size() > 1) own.guests.push_back(options.line().targets[1]);
  });
}

ExitStatus RunBrew(CommandContext& /*context*/, const Brew& own) {
  brewed = own;
  return ExitStatus::kStopped;
}

constexpr Command kBrew = {"brew", "", "POT [GUEST]", Prepare<Brew, DeclareBrew, RunBrew>};

ExitStatus RunOf(const CommandLine& line) {
  Terminal terminal({.write = [](std::string_view) {}, .columns = [] { return 80; }});
  Log log(terminal, LogLevel::kOff);
  optim::Ranks alone;
  CommandContext context{line, terminal, log, alone};
  return line.run(context);
}

TEST(CommandLine, ACommandOwnsItsValues) {
  const CommandLine line = Parse({"brew",          "pot",     "me",      "--strong", "--bean",
                                  "a b",           "--milk",  "oat",     "-o",       "c.png",
                                  "--guest",       "front",   "--guest", "top,left", "--extras",
                                  "0,3,IMG_1.JPG", "--grams", "7.5",     "--for",    "1h30m",
                                  "--shots",       "4"},
                                 {},
                                 {&kBrew});
  const CommandLine other = Parse({"brew", "pot"}, {}, {&kBrew});
  EXPECT_STREQ(line.command->name, "brew");
  EXPECT_EQ(RunOf(line), ExitStatus::kStopped);
  EXPECT_TRUE(brewed.strong);
  EXPECT_EQ(brewed.bean, "a b");
  EXPECT_EQ(brewed.milk, "oat");
  EXPECT_EQ(brewed.cup, "c.png");
  EXPECT_EQ(brewed.guests, (std::vector<std::string>{"front", "top,left", "me"}));
  EXPECT_EQ(brewed.extras, (std::vector<std::string>{"0", "3", "IMG_1.JPG"}));
  EXPECT_DOUBLE_EQ(brewed.grams, 7.5);
  EXPECT_DOUBLE_EQ(brewed.seconds, 5400.0);
  EXPECT_EQ(brewed.shots, 4);
  RunOf(other);
  EXPECT_FALSE(brewed.strong) << "the values of one line are not those of another";
  EXPECT_EQ(brewed.shots, 2);
  EXPECT_THROW(Parse({"brew", "pot", "--shots", "3"}, {}, {&kBrew}), UsageError);
  EXPECT_THROW(Parse({"fit", "c.yaml"}, {}, {&kBrew}), UsageError);
}

TEST(CommandLine, EveryCommandCanBeRun) {
  for (const Command* command : AllCommands()) EXPECT_NE(command->prepare, nullptr);
  EXPECT_FALSE(Parse({"help"}).run);
  EXPECT_TRUE(Parse({"--version"}).run);
  EXPECT_TRUE(Parse({"init"}).run);
  EXPECT_TRUE(Parse({"completion", "zsh"}).run);
}

TEST(CommandLine, TheRunDirectoryOfAFitIsRelativeToTheWorkingDirectory) {
  const std::vector<ConfigOverride> overrides =
      Parse({"fit", "c.yaml", "-o", "it's here"}).overrides;
  ASSERT_EQ(overrides.size(), 1U);
  EXPECT_EQ(overrides[0].label, "-o");
  const std::string folder = std::filesystem::current_path().string();
  EXPECT_EQ(overrides[0].assignment, "output.directory='" + folder + "/it''s here'");
  EXPECT_TRUE(Parse({"render", "c.yaml", "-o", "out"}).overrides.empty());
  // Shells replace ~ only at the beginning of a word.
  ASSERT_NE(std::getenv("HOME"), nullptr);
  EXPECT_EQ(Parse({"fit", "c.yaml", "--output=~/out"}).overrides[0].assignment,
            "output.directory='" + std::string(std::getenv("HOME")) + "/out'");
}

TEST(CommandLine, HelpAndVersionSucceed) {
  EXPECT_NE(Parse({"--help"}).help_text.find("gradcheck"), std::string::npos);
  EXPECT_NE(Parse({"fit", "-h"}).help_text.find("--time-limit"), std::string::npos);
  EXPECT_NE(Parse({"help", "render"}).help_text.find("--derivative"), std::string::npos);
  EXPECT_EQ(Parse({"help"}).command, nullptr);
  EXPECT_STREQ(Parse({"--version"}).command->name, "version");
  EXPECT_STREQ(Parse({"version", "--json"}).command->name, "version");
}

TEST(CommandLine, WhatSomeCommandsUseStandsBeforeThemToo) {
  EXPECT_EQ(Parse({"--threads", "3", "eval", "run"}).threads, 3);
  EXPECT_EQ(Parse({"--threads", "3", "info"}).threads, 3);
  EXPECT_EQ(Parse({"--seed", "3", "synth", "c.yaml"}).overrides.at(0).assignment, "seed=3");
  const CommandLine line = Parse({"resume", "run", "--max-memory", "2GiB", "--threads", "2"});
  ASSERT_EQ(line.overrides.size(), 2U);
  EXPECT_EQ(line.overrides[0].assignment, "solver.threads=2");
  EXPECT_EQ(line.overrides[1].assignment, "solver.max_memory=2GiB");
}

TEST(CommandLine, AnotherProcessSaysAsMuch) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(MessageOptions(Parse({"info"})),
            (Words{"--log-level=info", "--color=auto", "--progress=auto"}));
  EXPECT_EQ(MessageOptions(Parse({"info", "-vv", "--progress=json", "--color", "never"})),
            (Words{"--log-level=trace", "--color=never", "--progress=json"}));
  EXPECT_EQ(MessageOptions(Parse({"info", "-q"})),
            (Words{"--log-level=error", "--color=auto", "--progress=none"}));
}

TEST(CommandLine, EnvironmentGivesDefaultsOnly) {
  const std::map<std::string, std::string> environment = {
      {"PATHFIT_THREADS", "3"}, {"SLURM_CPUS_PER_TASK", "9"}, {"PATHFIT_LOG_LEVEL", "warn"}};
  const CommandLine line = Parse({"check", "c.yaml"}, environment);
  EXPECT_EQ(line.default_threads, 3);
  EXPECT_FALSE(line.threads);
  EXPECT_EQ(line.log_level, LogLevel::kWarn);
  EXPECT_EQ(Parse({"check", "c.yaml", "-q"}, environment).log_level, LogLevel::kError);
  EXPECT_EQ(Parse({"check", "c.yaml", "--log-level", "info", "-vv"}, environment).log_level,
            LogLevel::kInfo);
  EXPECT_FALSE(Parse({"check", "c.yaml"}, {{"SLURM_CPUS_PER_TASK", "9"}}).default_threads)
      << "the renderer knows it, by the rule for all that bounds threads";
}

TEST(CommandLine, MistakesAreNamed) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{},
       "pathfit: a command is needed: init, check, fit, resume, render, list, export, report, "
       "serve, "
       "compare, "
       "eval, sweep, synth, convert, gradcheck, config, completion, info, version, help"},
      {{"fti", "c.yaml"}, "pathfit: unknown command 'fti' (did you mean 'fit'?)"},
      {{"fit", "c.yaml", "-o", ""},
       "pathfit fit: --output: '' is not a path: a path is needed, not empty text"},
      {{"help", "rendr"}, "pathfit: unknown command 'rendr' (did you mean 'render'?)"},
      {{"fit"}, "pathfit fit: CONFIG is missing"},
      {{"resume"}, "pathfit resume: RUN is missing"},
      {{"fit", "c.yaml", "--treads", "4"},
       "pathfit fit: unknown option '--treads' (did you mean '--threads'?)"},
      {{"--treads", "4", "fit", "c.yaml"},
       "pathfit: unknown option '--treads' (did you mean '--threads'?)"},
      {{"check", "c.yaml", "--time-limit=2h"},
       "pathfit check: unknown option '--time-limit' (it belongs to 'pathfit fit')"},
      {{"fit", "c.yaml", "-x"}, "pathfit fit: unknown option '-x'"},
      {{"fit", "c.yaml", "d.yaml"}, "pathfit fit: unexpected argument 'd.yaml'"},
      {{"fit", "c.yaml", "--threads"}, "pathfit fit: option --threads needs a value"},
      {{"fit", "c.yaml", "--threads", "0"},
       "pathfit fit: --threads: '0' is not a whole number of at least 1"},
      {{"fit", "c.yaml", "--threads", "4x"},
       "pathfit fit: --threads: '4x' is not a whole number of at least 1"},
      {{"fit", "c.yaml", "--seed", "-1"},
       "pathfit fit: --seed: '-1' is not a whole number of at least 0"},
      {{"fit", "c.yaml", "--set", "novalue"}, "pathfit fit: --set #1: 'novalue' is not KEY=VALUE"},
      {{"fit", "c.yaml", "--time-limit", "2"},
       "pathfit fit: --time-limit: '2' is not a time like 2h, 90m, 1h30m or 45s"},
      {{"fit", "c.yaml", "-q", "-v"}, "pathfit fit: -q and -v exclude each other"},
      {{"fit", "c.yaml", "--color", "red"},
       "pathfit fit: --color: 'red' is not one of: auto, always, never"},
      {{"fit", "c.yaml", "--progress", "fancy"},
       "pathfit fit: --progress: 'fancy' is not one of: auto, bar, plain, json, none"},
      {{"fit", "c.yaml", "--log-level", "loud"},
       "pathfit fit: --log-level: 'loud' is not one of: trace, debug, info, warn, error"},
      {{"render", "c.yaml", "--views", "1,,2"},
       "pathfit render: --views: '1,,2' has an empty part"},
      {{"render", "c.yaml", "--views", "orbit:24.5"},
       "pathfit render: --views: 'orbit:24.5' is not understood; write orbit:24 for 24 cameras on "
       "a circle, alone"},
      {{"render", "c.yaml", "--views", "orbit:4", "--derivative", "a"},
       "pathfit render: --views orbit: excludes --cameras and --derivative"},
      {{"render", "c.yaml", "--env", "a.exr", "--derivative", "a"},
       "pathfit render: --env and --derivative exclude each other"},
      {{"export", "run"},
       "pathfit export: --to is missing; give one of: glb, obj, ply, colmap, transforms, blender"},
      {{"export", "run", "--to", "glb,fbx"},
       "pathfit export: --to: 'fbx' is not one of: glb, obj, ply, colmap, transforms, blender"},
      {{"compare", "run"}, "pathfit compare: at least two runs are needed"},
      {{"render", "c.yaml", "--views", "1", "--sensor", "front"},
       "pathfit render: --views and --sensor exclude each other"},
      {{"render", "c.yaml", "--form", "image"}, "pathfit render: --form needs --derivative"},
      {{"render", "c.yaml", "--derivative", "a.b", "--terms", ""},
       "pathfit render: --terms: '' has an empty part"},
      {{"render", "c.yaml", "--terms", "primary"}, "pathfit render: --terms needs --derivative"},
      {{"gradcheck", "c.yaml", "--step", "0"},
       "pathfit gradcheck: --step: '0' is not a number above 0"},
      {{"gradcheck", "c.yaml", "--sigma", "nan"},
       "pathfit gradcheck: --sigma: 'nan' is not a number above 0"},
      {{"synth", "c.yaml", "--noise", "-1"},
       "pathfit synth: --noise: '-1' is not a number from 0 to 10"},
      {{"synth", "c.yaml", "--quality", "9.5", "--format", "jpg"},
       "pathfit synth: --quality: '9.5' is not a whole number from 1 to 100"},
      {{"synth", "c.yaml", "--quality", "9"}, "pathfit synth: --quality needs --format jpg"},
      {{"synth", "c.yaml", "--format", "gif"},
       "pathfit synth: --format: 'gif' is not one of: exr, png, jpg"},
      {{"export", "run", "--to", "trnasforms"},
       "pathfit export: --to: 'trnasforms' is not one of: glb, obj, ply, colmap, transforms, "
       "blender (did you mean 'transforms'?)"},
      {{"config", "shwo", "a.yaml"}, "pathfit config: 'shwo' is not known (did you mean 'show'?)"},
      {{"config"}, "pathfit config: show|default|schema is missing"},
      {{"config", "show"}, "pathfit config: show: CONFIG is missing"},
      {{"config", "schema", "a.yaml"}, "pathfit config: schema takes no CONFIG; only show does"},
      {{"config", "default", "--set", "a=1"}, "pathfit config: --set needs show"},
      {{"completion", "csh"}, "pathfit completion: 'csh' is not known (did you mean 'zsh'?)"},
      {{"convert", "meshes", "a", "b"}, "pathfit convert: 'meshes' is not known (known: cameras)"},
      {{"convert", "cameras", "a"}, "pathfit convert: OUT is missing"},
      {{"sweep", "a.yaml"}, "pathfit sweep: nothing varies; give --vary KEY=A,B or --seeds N"},
      {{"sweep", "a.yaml", "--vary", "seed"}, "pathfit sweep: --vary: 'seed' is not KEY=A,B,C"},
      {{"sweep", "a.yaml", "--vary", "seed=1,,2"},
       "pathfit sweep: --vary: 'seed=1,,2' has an empty value"},
      {{"sweep", "a.yaml", "--vary", "seed=1,1"}, "pathfit sweep: --vary: 'seed=1,1' has 1 twice"},
      {{"sweep", "a.yaml", "--vary", "seed=1", "--vary", "seed=2"},
       "pathfit sweep: --vary: seed is given twice"},
      {{"sweep", "a.yaml", "--vary", "output.directory=a,b"},
       "pathfit sweep: --vary: each run has its folder below that of -o"},
      {{"sweep", "a.yaml", "--vary", "seed=1", "--seeds", "3"},
       "pathfit sweep: --seeds and --vary seed= exclude each other"},
      {{"sweep", "a.yaml", "--seeds", "0"},
       "pathfit sweep: --seeds: '0' is not a whole number from 1 to 10000"},
      {{"report", "run", "--max-size-mb", "0"},
       "pathfit report: --max-size-mb: '0' is not a number from 0.1 to 1000"},
      {{"eval", "run", "--env", "a.hdr"}, "pathfit eval: --env needs --truth"},
      {{"report", "run", "--threads", "2"}, "pathfit report: --threads has no use"},
      {{"--threads=2", "compare", "a", "b"}, "pathfit compare: --threads has no use"},
      {{"--seed", "4", "init"}, "pathfit init: --seed has no use"},
      {{"check", "c.yaml", "--seed=4"}, "pathfit check: --seed has no use"},
      {{"resume", "run", "--seed", "4"}, "pathfit resume: --seed has no use"},
      {{"render", "c.yaml", "--max-memory", "1GiB"},
       "pathfit render: unknown option '--max-memory' (it belongs to 'pathfit check')"},
      {{"gradcheck", "c.yaml", "--max-memory", "1GiB"},
       "pathfit gradcheck: unknown option '--max-memory' (it belongs to 'pathfit check')"},
      {{"fit", "\xff"}, "pathfit: an argument is not UTF-8 text"},
  };
  for (const auto& [words, expected] : cases) EXPECT_EQ(Refusal(words), expected);
  EXPECT_EQ(Refusal({"fit", "c.yaml"}, {{"PATHFIT_THREADS", "many"}}),
            "pathfit fit: PATHFIT_THREADS: 'many' is not a whole number of at least 1");
  EXPECT_NE(Refusal({"fit", "c.yaml", "--max-memory", "12"}).find("--max-memory: "),
            std::string::npos);
}

TEST(CommandLine, AFolderMayBeCalledLikeACommand) {
  EXPECT_EQ(Parse({"resume", "render"}).target, "render");
}

}  // namespace
}  // namespace pathfit::app::command_line_test
