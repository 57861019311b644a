#include "app/config/scalar.h"

#include <limits>

#include <gtest/gtest.h>

namespace pathfit::app::scalar_test {
namespace {

YamlNode Plain(const std::string& text) {
  YamlNode node;
  node.kind = YamlNode::Kind::kScalar;
  node.text = text;
  return node;
}

TEST(Scalar, NumbersKeepTheirValue) {
  const std::vector<std::pair<std::string, double>> cases = {{"0", 0.0},
                                                             {"-0.5", -0.5},
                                                             {"+2", 2.0},
                                                             {".5", 0.5},
                                                             {"5.", 5.0},
                                                             {"1e-3", 1e-3},
                                                             {"1.5E+2", 150.0},
                                                             {"0.1", 0.1}};
  for (const auto& [text, value] : cases) {
    EXPECT_EQ(ParseNumber(Plain(text), false).value, value) << text;
  }
  EXPECT_EQ(ParseNumber(Plain("-.inf"), true).value, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(ParseNumber(Plain(".INF"), true).value, std::numeric_limits<double>::infinity());
}

TEST(Scalar, WhatIsNoNumberIsRefused) {
  for (const char* text : {"",
                           ".",
                           "-",
                           "e5",
                           "1e",
                           "1e+",
                           "1 2",
                           "1_000",
                           "0x1",
                           "abc",
                           "--1",
                           "1.2.3",
                           "00",
                           "-01"}) {
    const Parsed<double> parsed = ParseNumber(Plain(text), true);
    EXPECT_FALSE(parsed.value) << text;
    EXPECT_FALSE(parsed.problem.empty()) << text;
  }
  EXPECT_EQ(ParseNumber(Plain("00"), true).problem, "'00' has a leading zero; write 0");
  EXPECT_EQ(ParseNumber(Plain("-000.50"), true).problem,
            "'-000.50' has a leading zero; write -0.50");
  EXPECT_EQ(ParseNumber(Plain("infinity"), true).problem, "'infinity' is not a number; write .inf");
}

TEST(Scalar, IntegersAreExact) {
  EXPECT_EQ(ParseInteger(Plain("9007199254740993")).value, 9007199254740993);
  EXPECT_EQ(ParseInteger(Plain("+7")).value, 7);
  EXPECT_EQ(ParseInteger(Plain("-7")).value, -7);
  EXPECT_FALSE(ParseInteger(Plain("1e3")).value);
  EXPECT_FALSE(ParseInteger(Plain("7.0")).value);
}

TEST(Scalar, BytesNeedAUnit) {
  EXPECT_EQ(ParseBytes(Plain("16 GiB")).value, 16.0 * 1073741824.0);
  EXPECT_EQ(ParseBytes(Plain("12GiB")).value, 12.0 * 1073741824.0);
  EXPECT_EQ(ParseBytes(Plain("1.5 GB")).value, 1.5e9);
  EXPECT_EQ(ParseBytes(Plain("512 B")).value, 512.0);
  for (const char* text : {"16", "GiB", "16 gib", "-1 GiB", "0 GiB", "1e9 B", "16 GiB x"}) {
    EXPECT_FALSE(ParseBytes(Plain(text)).value) << text;
  }
}

TEST(Scalar, DurationsNeedUnitsInOrder) {
  EXPECT_EQ(ParseDuration("2h"), 7200.0);
  EXPECT_EQ(ParseDuration("1h30m"), 5400.0);
  EXPECT_EQ(ParseDuration("1.5h"), 5400.0);
  EXPECT_EQ(ParseDuration("45s"), 45.0);
  for (const char* text : {"", "2", "h", "30m1h", "1h1h", "0s", "-1h", "1d", "2 h"}) {
    EXPECT_EQ(ParseDuration(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace pathfit::app::scalar_test
