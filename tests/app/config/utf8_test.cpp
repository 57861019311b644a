#include "app/config/utf8.h"

#include <gtest/gtest.h>

namespace pathfit::app::utf8_test {
namespace {

TEST(Utf8, CountsCharactersNotBytes) {
  EXPECT_EQ(NumCharacters(""), 0U);
  EXPECT_EQ(NumCharacters("abc"), 3U);
  EXPECT_EQ(NumCharacters("é█…"), 3U);
  EXPECT_TRUE(IsContinuationByte('\x80'));
  EXPECT_TRUE(IsContinuationByte('\xbf'));
  EXPECT_FALSE(IsContinuationByte('\xc3'));
  EXPECT_FALSE(IsContinuationByte('a'));
}

TEST(Utf8, CutsBetweenCharacters) {
  EXPECT_EQ(FirstBytes("aé", 3), "aé");
  EXPECT_EQ(FirstBytes("aé…", 2), "a");
  EXPECT_EQ(FirstBytes("aé…", 5), "aé");
  EXPECT_EQ(FirstBytes("…", 0), "");
  EXPECT_EQ(LastBytes("…éa", 6), "…éa");
  EXPECT_EQ(LastBytes("…éa", 5), "éa");
  EXPECT_EQ(LastBytes("…éa", 2), "a");
}

TEST(Utf8, FindsTheFirstByteThatIsNoText) {
  EXPECT_FALSE(FirstBadByte("é█…\t\n"));
  EXPECT_EQ(FirstBadByte("ab\x01"), 2U);
  EXPECT_EQ(FirstBadByte("a\xc3"), 1U) << "cut";
  EXPECT_EQ(FirstBadByte("a\xc3("), 1U) << "no continuation";
  EXPECT_EQ(FirstBadByte("\xc0\x80"), 0U) << "overlong";
  EXPECT_EQ(FirstBadByte("\xed\xa0\x80"), 0U) << "surrogate";
}

}  // namespace
}  // namespace pathfit::app::utf8_test
