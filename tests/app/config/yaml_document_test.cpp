#include "app/config/yaml_document.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pathfit::app::yaml_document_test {
namespace {

// First line of the message, or "accepted". Problems that do not stop reading count too.
std::string Refusal(const std::string& text) {
  try {
    const YamlDocument document = ParseYaml(text, "a.yaml");
    if (document.problems.empty()) return "accepted";
    throw ConfigError(document.source, document.problems);
  } catch (const ConfigError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("nothing was run (status 3)"), std::string::npos);
    return message.substr(0, message.find('\n'));
  }
}

TEST(YamlDocument, KeepsKindsQuotesAndPlaces) {
  const YamlDocument document = ParseYaml("a: 1\nb:\n  c: \"1\"\n  d: [x, 'y']\n", "a.yaml");
  ASSERT_TRUE(document.root.IsMap());
  const YamlNode& a = *document.root.Find("a");
  EXPECT_EQ(a.text, "1");
  EXPECT_FALSE(a.quoted);
  EXPECT_EQ(a.place.line, 1);
  EXPECT_EQ(a.place.column, 4);
  const YamlNode& b = *document.root.Find("b");
  EXPECT_EQ(document.root.entries[1].key_place.line, 2);
  EXPECT_EQ(document.root.entries[1].key_place.column, 1);
  EXPECT_TRUE(b.Find("c")->quoted);
  const YamlNode& d = *b.Find("d");
  ASSERT_TRUE(d.IsList());
  EXPECT_FALSE(d.items[0].quoted);
  EXPECT_TRUE(d.items[1].quoted);
  EXPECT_EQ(d.items[1].place.line, 4);
  EXPECT_EQ(d.items[1].place.column, 10);
  EXPECT_EQ(b.Find("missing"), nullptr);
}

TEST(YamlDocument, ReadsAliasesAndIgnoresAByteOrderMark) {
  const YamlDocument document = ParseYaml(
      "\xEF\xBB\xBF"
      "a: &x {b: 1}\nc: *x\n",
      "a.yaml");
  EXPECT_TRUE(document.problems.empty());
  EXPECT_TRUE(SameValues(*document.root.Find("a"), *document.root.Find("c")));
}

TEST(YamlDocument, AMissingValueIsPlacedAtItsKey) {
  const YamlDocument document = ParseYaml("a:\nb: 1\n", "a.yaml");
  EXPECT_EQ(document.root.Find("a")->kind, YamlNode::Kind::kNull);
  EXPECT_EQ(document.root.Find("a")->place.line, 1);
}

TEST(YamlDocument, MistakesAreNamedWithTheirPlace) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"a: 1\nb: 2\na: 3\n", "a.yaml:3:1: error: key 'a' is given twice (first at 1:1)"},
      {"a: &x {b: 1}\nc: {<<: *x}\n",
       "a.yaml:2:5: error: merge keys (<<) are not supported; write the keys out, or alias one "
       "value"},
      {"a:\n\tb: 1\n", "a.yaml:2:1: error: a tab is used for indentation; use spaces"},
      {"a: b: c\n",
       "a.yaml:1:5: error: ':' is not expected here; check the indentation, or quote the text"},
      {"a: [1, 2\n", "a.yaml:1:4: error: this '[' is never closed by ']'"},
      {"a: {b: 1\n", "a.yaml:1:4: error: this '{' is never closed by '}'"},
      {"a: {b: 1 c: 2}\n",
       "a.yaml:1:11: error: ',' or '}' is needed before this (is a comma missing?)"},
      {"a: {b: [1, 2] c: 2}\n",
       "a.yaml:1:15: error: ',' or '}' is needed before this (is a comma missing?)"},
      {"a: [{b: 1} {b: 2}]\n",
       "a.yaml:1:12: error: ',' or ']' is needed before this (is a comma missing?)"},
      {"a: [1]]\n", "a.yaml:1:7: error: this closing bracket has no opening one"},
      {"a: \"foo\n", "a.yaml:1:4: error: this quote is never closed"},
      {"a: 'it''s\n", "a.yaml:1:4: error: this quote is never closed"},
      {"a: \"foo\\\"\nb: 1\n", "a.yaml:1:4: error: this quote is never closed"},
      {"a: *x\n", "a.yaml:1:4: error: this alias (*) names no anchor (&) written before it"},
      {"a: &x [*x]\n", "a.yaml:1:8: error: this alias (*) stands inside the value it names"},
      {"a: @x\n", "a.yaml:1:4: error: this character cannot start a value; quote the text"},
      {"a: !!str 1\n", "a.yaml:1:4: error: tags ('!…') are not supported; remove it"},
      {"? [a]\n: b\n", "a.yaml:1:3: error: a key must be text, not a list"},
      {"---\na: 1\n---\nb: 1\n",
       "a.yaml:3:1: error: a second document starts here; a config is one document whose keys "
       "start in the same column"},
      {"", "a.yaml: error: the config is empty"},
      {"# only a comment\n", "a.yaml: error: the config is empty"},
      {"a: 1\nb: \xff\n", "a.yaml:2:4: error: this is not UTF-8 text (byte 255)"},
      {std::string("a: \0b\n", 6), "a.yaml:1:4: error: this is not UTF-8 text (byte 0)"},
      {"a: \xC0\x80\n", "a.yaml:1:4: error: this is not UTF-8 text (byte 192)"},
      {"a: \xED\xA0\x80\n", "a.yaml:1:4: error: this is not UTF-8 text (byte 237)"},
  };
  for (const auto& [text, expected] : cases) EXPECT_EQ(Refusal(text), expected) << text;
}

TEST(YamlDocument, RefusesDeepNestingAndAliasBombs) {
  EXPECT_NE(Refusal("a: " + std::string(100, '[') + std::string(100, ']')).find("64 levels deep"),
            std::string::npos);
  EXPECT_NE(Refusal(std::string(200000, '[')).find("a.yaml:1:"), std::string::npos);
  EXPECT_NE(Refusal(std::string(5000, '{')).find("a.yaml:1:"), std::string::npos);
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string alias = "*a" + std::to_string(i - 1);
    const std::string name = "a" + std::to_string(i);
    bomb += name + ": &" + name + " [" + alias + ", " + alias + ", " + alias + "]\n";
  }
  EXPECT_NE(Refusal(bomb).find("more than 100000 values"), std::string::npos);
  std::string tower = "a0: &a0 x\n";
  for (int i = 1; i < 200; ++i) {
    const std::string name = "a" + std::to_string(i);
    tower += name + ": &" + name + " [*a" + std::to_string(i - 1) + "]\n";
  }
  EXPECT_NE(Refusal(tower).find("64 levels deep"), std::string::npos);
}

TEST(YamlDocument, ShowsTheLineWithACaretBelow) {
  try {
    ParseYaml("é: 1\nüüü: a: b\n", "a.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_EQ(std::string(error.what()),
              "a.yaml:2:10: error: ':' is not expected here; check the indentation, or quote the "
              "text\n    2 | üüü: a: b\n      |       ^\n"
              "pathfit: config has 1 error; nothing was run (status 3)");
  }
}

TEST(YamlDocument, MissingFilesAndFoldersAreRefused) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / "pathfit_yaml_document_test";
  std::filesystem::create_directories(folder);
  EXPECT_THROW(LoadYamlFile(folder / "missing.yaml"), ConfigError);
  EXPECT_THROW(LoadYamlFile(folder), ConfigError);
  std::ofstream(folder / "good.yaml") << "a: 1\r\nb: 2\r\n";
  EXPECT_EQ(LoadYamlFile(folder / "good.yaml").root.Find("b")->text, "2");
  std::filesystem::remove_all(folder);
}

TEST(YamlDocument, OverrideValuesAreScalarsOrFlowCollections) {
  const Place place{Place::Source::kOverride, 1, 0, 0};
  std::vector<Problem> problems;
  EXPECT_EQ(ParseOverrideValue("16", place, "a", problems).text, "16");
  const YamlNode list = ParseOverrideValue("[a, {b: 'c'}]", place, "a", problems);
  ASSERT_EQ(list.items.size(), 2U);
  EXPECT_EQ(list.items[1].Find("b")->place, place);
  EXPECT_TRUE(problems.empty());
  ParseOverrideValue("", place, "a", problems);
  ParseOverrideValue("[1, 2", place, "a", problems);
  ParseOverrideValue("{a: 1, a: 2}", place, "a", problems);
  ASSERT_EQ(problems.size(), 3U);
  EXPECT_EQ(problems[0].text, "no value after '='");
  EXPECT_EQ(problems[1].text, "this '[' is never closed by ']'");
  for (const Problem& problem : problems) EXPECT_EQ(problem.place, place);
}

TEST(ConfigError, SortsCountsAndCutsAfterTwenty) {
  const ConfigSource source{"a.yaml", {}, {{"--set #1", "x=1"}}};
  std::vector<Problem> problems = {{{Place::Source::kOverride, 0, 0, 0}, "x", "bad"}};
  for (int line = 25; line >= 1; --line) {
    problems.push_back({{Place::Source::kFile, 0, line, 1}, "k", "wrong"});
  }
  const ConfigError error(source, problems);
  const std::string text = error.what();
  EXPECT_EQ(text.find("a.yaml:1:1: error: k: wrong\na.yaml:2:1: "), 0U);
  EXPECT_NE(text.find("a.yaml:20:1: error: k: wrong\n... and 6 more\n"
                      "pathfit: config has 26 errors; nothing was run (status 3)"),
            std::string::npos);
  EXPECT_EQ(FormatProblems(source, {problems[0]}), "--set #1: error: x: bad\n      x=1\n");
}

}  // namespace
}  // namespace pathfit::app::yaml_document_test
