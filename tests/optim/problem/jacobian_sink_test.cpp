#include "optim/problem/jacobian_sink.h"

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/sampler/counter_rng.h"

namespace pathfit::jacobian_sink_test {
namespace {

using optim::JacobianSink;
using renderer::CounterRng;

TEST(JacobianSinkTest, MergesBlocksInTheOrderOfCalls) {
  JacobianSink sink(2, 1);
  renderer::ParameterDerivative a{7, {}}, b{3, {}}, zero{1, {}};
  a.d[0] = {1.0, 2.0, 3.0, 4.0};
  b.d[2] = {0.5, 0.0, 0.0, 0.0};
  for (int i = 0; i < 100; ++i) {
    sink.Add(1, std::vector<renderer::ParameterDerivative>{a, zero, b});
  }
  sink.Finish();
  EXPECT_TRUE(sink.Pixel(0).empty());
  ASSERT_EQ(sink.Pixel(1).size(), 2U);
  auto entry = sink.Pixel(1).begin();
  EXPECT_EQ(entry.block(), 3);
  EXPECT_EQ((*entry).d[8], 50.0F);
  ++entry;
  EXPECT_EQ(entry.block(), 7);
  EXPECT_EQ((*entry).d[3], 400.0F);
}

TEST(JacobianSinkTest, PixelsOfALineAreKeptApart) {
  constexpr int kWidth = 3, kHeight = 2;
  JacobianSink sink(kWidth, kHeight);
  optim::TermSink terms(kWidth, kHeight);
  std::array<std::map<std::int32_t, float>, kWidth * kHeight> expected;
  CounterRng rng(4);
  for (const auto term : {renderer::DerivativeTerm::kInterior, renderer::DerivativeTerm::kDirect}) {
    terms.BeginTerm(term, 1);
    // Many times what is held before it is merged.
    for (int i = 0; i < 500; ++i) {
      const auto pixel = static_cast<std::size_t>(5.0 * rng.Next());  // none of the last one
      std::vector<renderer::ParameterDerivative> added;
      for (int k = 0; k < 3; ++k) {
        renderer::ParameterDerivative& d = added.emplace_back();
        d.block = static_cast<std::int32_t>(4.0 * rng.Next());
        d.d[1].g = 1.0 + k;  // sums are exact
        expected[pixel][d.block] += static_cast<float>(d.d[1].g);
      }
      sink.Add(static_cast<std::int64_t>(pixel), added);
      terms.Add(static_cast<std::int64_t>(pixel), added);
    }
  }
  sink.Finish();
  terms.Finish();
  JacobianSink joined(kWidth, kHeight);
  terms.MoveTo(joined);
  for (const auto& part : terms.parts()) {
    EXPECT_TRUE(!part || part->sink.Pixel(0).empty());
  }
  for (std::size_t pixel = 0; pixel < expected.size(); ++pixel) {
    for (const JacobianSink* made : {&sink, &joined}) {
      ASSERT_EQ(made->Pixel(pixel).size(), expected[pixel].size());
      auto entry = made->Pixel(pixel).begin();
      for (const auto& [block, sum] : expected[pixel]) {
        EXPECT_EQ(entry.block(), block);
        EXPECT_EQ((*entry).d[5], sum);
        ++entry;
      }
    }
  }
}

}  // namespace
}  // namespace pathfit::jacobian_sink_test
