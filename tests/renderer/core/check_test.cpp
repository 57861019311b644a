#include "renderer/core/check.h"

#include <gtest/gtest.h>

namespace pathfit::renderer {
namespace {

TEST(Check, PassesWhenTheConditionHolds) { PATHFIT_CHECK(1 + 1 == 2); }

TEST(CheckDeathTest, AbortsNamingTheConditionAndTheFile) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const int two = 2;
  EXPECT_DEATH(PATHFIT_CHECK(two == 3), "check_test.cpp:.*check failed: two == 3");
}

}  // namespace
}  // namespace pathfit::renderer
