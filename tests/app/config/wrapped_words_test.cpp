#include "app/config/wrapped_words.h"

#include <gtest/gtest.h>

namespace pathfit::app::wrapped_words_test {
namespace {

TEST(WrappedWords, FillsLinesAndLeavesLongWordsWhole) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(WrappedWords("one two  three", 7), (Lines{"one two", "three"}));
  EXPECT_EQ(WrappedWords("one two", 6), (Lines{"one", "two"}));
  EXPECT_EQ(WrappedWords("incomparable a", 5), (Lines{"incomparable", "a"}));
  EXPECT_EQ(WrappedWords(" \n", 5), Lines{});
}

}  // namespace
}  // namespace pathfit::app::wrapped_words_test
