#include "renderer/io/text_scanner.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pathfit::renderer::text_scanner_test {
namespace {

TEST(TextScanner, ParsesWholeRealsOnly) {
  EXPECT_EQ(ParseReal("1.5"), 1.5);
  EXPECT_EQ(ParseReal("+1.5e2"), 150.0);
  EXPECT_EQ(ParseReal("-.5"), -0.5);
  EXPECT_EQ(ParseReal("5."), 5.0);
  EXPECT_EQ(ParseReal("1e-400"), 0.0);
  EXPECT_NEAR(ParseReal("3e-320").value_or(1.0), 3e-320, 1e-322);
  for (const char* token : {"", "+", "-", "1,5", "1.5x", "nan", "-inf", "1e400", "0x10", "+-1"}) {
    EXPECT_FALSE(ParseReal(token)) << token;
  }
}

TEST(TextScanner, ParsesWholeIntegersOnly) {
  EXPECT_EQ(ParseInteger("-12"), -12);
  EXPECT_EQ(ParseInteger("+7"), 7);
  for (const char* token : {"", "1.0", "1x", "99999999999999999999", "--1"}) {
    EXPECT_FALSE(ParseInteger(token)) << token;
  }
}

TEST(TextScanner, CutsTokensAndLines) {
  std::string_view text = " a\tbc ";
  EXPECT_EQ(NextToken(text), "a");
  EXPECT_EQ(NextToken(text), "bc");
  EXPECT_EQ(NextToken(text), "");
  LineReader reader("one\r\ntwo\n\nfour\rfive");
  std::vector<std::string> lines;
  for (std::string_view line; reader.Next(line);) lines.emplace_back(line);
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two", "", "four", "five"}));
  EXPECT_EQ(reader.LineNumber(), 5);
}

}  // namespace
}  // namespace pathfit::renderer::text_scanner_test
