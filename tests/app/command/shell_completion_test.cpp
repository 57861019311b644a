#include "app/command/shell_completion.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "app/command/command_reference.h"
#include "app/command/result.h"

namespace pathfit::app::shell_completion_test {
namespace {

namespace fs = std::filesystem;

/// The completions of the last word, as bash finds them.
class Bash : public ::testing::Test {
 protected:
  Bash() {
    if (std::system("bash -c true") != 0) return;
    std::ofstream(script_) << BashCompletion(DescribeProgram());
    has_bash_ = true;
  }
  ~Bash() override { fs::remove(script_); }

  std::string Complete(const std::string& words, const std::string& between = "\" \"") {
    const std::string command =
        "bash -c 'source " + script_.string() + "; COMP_WORDS=(" + words +
        "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _pathfit; IFS=" + between +
        "; echo \"${COMPREPLY[*]}\"' 2>&1";
    FILE* pipe = popen(command.c_str(), "r");
    std::string out;
    std::array<char, 4096> buffer{};
    while (pipe != nullptr && std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
      out += buffer.data();
    }
    if (pipe != nullptr) pclose(pipe);
    return out.substr(0, out.find_last_not_of('\n') + 1);
  }

  fs::path script_ =
      fs::temp_directory_path() / ("pathfit_completion_" + std::to_string(getpid()) + ".bash");
  bool has_bash_ = false;
};

TEST_F(Bash, CompletesCommandsOptionsAndTheirWords) {
  if (!has_bash_) GTEST_SKIP() << "there is no bash";
  EXPECT_EQ(Complete("pathfit re"), "resume render report");
  EXPECT_EQ(Complete("pathfit --threads 2 fi"), "fit");
  EXPECT_EQ(Complete("pathfit fit --st"), "--stop-after");
  EXPECT_EQ(Complete("pathfit fit a.yaml --color \"\""), "auto always never");
  EXPECT_EQ(Complete("pathfit fit --color = n"), "never") << "--color=n";
  EXPECT_EQ(Complete("pathfit export RUN --to glb,o"), "glb,obj");
  EXPECT_EQ(Complete("pathfit config s"), "show schema");
  EXPECT_EQ(Complete("pathfit convert \"\""), "cameras");
  EXPECT_EQ(Complete("pathfit help sy"), "synth");
  EXPECT_EQ(Complete("pathfit fit --set solver.th"), "solver.threads=");
  EXPECT_EQ(Complete("pathfit fit --stop-after \"\""), "") << "a name of the user's";
  const std::string script = script_.string();
  EXPECT_EQ(Complete("pathfit check " + script.substr(0, script.size() - 3)), script);
}

TEST_F(Bash, CompletesNamesWithSpaces) {
  if (!has_bash_) GTEST_SKIP() << "there is no bash";
  const fs::path folder = script_.string() + ".d";
  fs::create_directories(folder / "my photos");
  std::ofstream(folder / "my photos" / "a b.yaml") << "";
  const std::string start = "\"" + folder.string() + "/my";
  const auto complete = [&](const std::string& words) { return Complete(words, "\"|\""); };
  EXPECT_EQ(complete("pathfit init " + start + "\""), folder.string() + "/my photos");
  EXPECT_EQ(complete("pathfit check " + start + "\\\\ photos/a\""),
            folder.string() + "/my photos/a b.yaml")
      << "as it is typed";
  fs::remove_all(folder);
}

TEST(Completion, EveryCommandAndOptionIsInEveryScript) {
  const DeclaredProgram program = DescribeProgram();
  const std::string scripts[] = {BashCompletion(program), ZshCompletion(program)};
  const std::string fish = FishCompletion(program);
  const std::string page = ManPage(program, "1.2");
  for (const DeclaredCommand& command : program.commands) {
    for (const std::string& script : scripts) {
      EXPECT_NE(script.find("\n    " + command.name + ") echo '"), std::string::npos);
    }
    EXPECT_NE(fish.find(" -a " + command.name + " -d "), std::string::npos) << command.name;
    EXPECT_NE(page.find(".SS pathfit " + command.name), std::string::npos) << command.name;
    for (const DeclaredOption& option : command.options) {
      const std::string& name = option.names.back();
      for (const std::string& script : scripts) {
        EXPECT_NE(script.find(name), std::string::npos) << name;
      }
      if (name.starts_with("--")) {
        EXPECT_NE(fish.find(" -l " + name.substr(2)), std::string::npos) << name;
      }
      EXPECT_FALSE(option.doc.empty()) << command.name << " " << name;
    }
  }
}

TEST(ManPage, HasNoWarnings) {
  if (std::system("man --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no man";
  const fs::path page =
      fs::temp_directory_path() / ("pathfit_man_" + std::to_string(getpid()) + ".1");
  std::ofstream(page) << ManPage(DescribeProgram(), "1.2");
  const std::string warnings = page.string() + ".txt";
  const std::string command = "LC_ALL=C.UTF-8 MANROFFSEQ= MANWIDTH=80 man --warnings -l " +
                              page.string() + " 2>" + warnings + " >/dev/null";
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::ifstream file(warnings);
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), "");
  fs::remove(page);
  fs::remove(warnings);
}

// PATHFIT_UPDATE_DOCS=1 rewrites the page.
TEST(CommandReference, ThePageIsUpToDate) {
  const fs::path path = fs::path(PATHFIT_SOURCE_DIR) / "app" / "command" / "README.md";
  const std::string expected = CommandMarkdown(DescribeProgram());
  if (std::getenv("PATHFIT_UPDATE_DOCS") != nullptr) {
    std::ofstream(path, std::ios::binary) << expected;
  }
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_TRUE(text.str() == expected)
      << path << " is out of date; run this test with PATHFIT_UPDATE_DOCS=1";
}

TEST(Result, MustHaveTheDeclaredKeysAndTypes) {
  constexpr ResultKey kKeys[] = {
      {"name", "text", ""}, {"value", "number or null", ""}, {"more", "list or absent", ""}};
  const Command command = {"test", "", nullptr, nullptr, kKeys};
  EXPECT_NO_THROW(RequireDeclared(command, {{"name", "a"}, {"value", 1.5}}));
  EXPECT_NO_THROW(RequireDeclared(
      command, {{"schema", "s"}, {"name", "a"}, {"value", nullptr}, {"more", Json::array()}}));
  EXPECT_THROW(RequireDeclared(command, {{"name", "a"}}), std::logic_error);
  EXPECT_THROW(RequireDeclared(command, {{"name", 1}, {"value", 1}}), std::logic_error);
  EXPECT_THROW(RequireDeclared(command, {{"name", "a"}, {"value", "b"}}), std::logic_error);
  EXPECT_THROW(RequireDeclared(command, {{"name", "a"}, {"value", 1}, {"x", 1}}), std::logic_error);
  for (const Command* known : AllCommands()) {
    for (const ResultKey& key : known->result) {
      const std::string type = key.type;
      const std::string first = type.substr(0, type.find(' '));
      EXPECT_NE(std::string(" text number whole boolean list map ").find(" " + first + " "),
                std::string::npos)
          << known->name << " " << key.key;
    }
  }
}

}  // namespace
}  // namespace pathfit::app::shell_completion_test
