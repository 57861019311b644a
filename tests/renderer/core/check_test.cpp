#include "renderer/core/check.h"

#include <gtest/gtest.h>

#include "renderer/core/parallel.h"

namespace pathfit::renderer::check_test {
namespace {

template <class Body>
std::string MessageOf(const Body& body) {
  try {
    body();
  } catch (const InternalError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Check, PassesWhenTheConditionHolds) {
  EXPECT_NO_THROW(PATHFIT_CHECK(1 + 1 == 2));
  EXPECT_NO_THROW(PATHFIT_CHECK_EQ(1 + 1, 2));
}

TEST(Check, ThrowsNamingFileLineConditionAndOperands) {
  const int two = 2;
  EXPECT_NE(MessageOf([&] { PATHFIT_CHECK(two > 3); }).find("check failed: two > 3"),
            std::string::npos);
  const std::string text = MessageOf([&] { PATHFIT_CHECK_EQ(two, 1 + 2); });
  EXPECT_NE(text.find("check_test.cpp:"), std::string::npos) << text;
  EXPECT_NE(text.find("two == 1 + 2 (2 against 3)"), std::string::npos) << text;
}

TEST(Check, CrossesParallelLoops) {
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    const auto nested = [] {
      ParallelFor(16, [](std::int64_t i) {
        ParallelFor(16, [i](std::int64_t j) { PATHFIT_CHECK(i * j < 200); });
      });
    };
    EXPECT_THROW(nested(), InternalError);
  }
}

}  // namespace
}  // namespace pathfit::renderer::check_test
