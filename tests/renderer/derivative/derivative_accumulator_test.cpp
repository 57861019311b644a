#include "renderer/derivative/derivative_accumulator.h"

#include <map>

#include <gtest/gtest.h>

#include "renderer/sampler/counter_rng.h"

namespace pathfit::renderer::derivative_accumulator_test {
namespace {

TEST(DerivativeAccumulator, SumsByBlockInOrderOfFirstAppearance) {
  DerivativeAccumulator sum;
  sum.Entry(5)[0] += Rgba(1, 0, 0, 0);
  sum.Entry(2)[1] += Rgba(0, 1, 0, 0);
  sum.Entry(5)[0] += Rgba(2, 0, 0, 1);
  ASSERT_EQ(sum.Entries().size(), 2U);
  EXPECT_EQ(sum.Entries()[0].block, 5);
  EXPECT_EQ(sum.Entries()[0].d[0], Rgba(3, 0, 0, 1));
  EXPECT_EQ(sum.Entries()[1].block, 2);
  EXPECT_EQ(sum.Entries()[1].d[1], Rgba(0, 1, 0, 0));
}

TEST(DerivativeAccumulator, AgreesWithAMapThroughGrowthAndReuse) {
  DerivativeAccumulator sum;
  CounterRng rng(1);
  for (const int count : {10, 5000, 3, 20000, 0, 700}) {
    sum.Clear();
    EXPECT_TRUE(sum.Entries().empty());
    std::map<std::int32_t, double> expected;
    for (int i = 0; i < count; ++i) {
      // Clustered keys with a common stride provoke collisions.
      const auto block = static_cast<std::int32_t>(rng.Next() * 3000.0) * 4096;
      const double value = rng.Next();
      sum.Entry(block)[2].g += value;
      expected[block] += value;
    }
    ASSERT_EQ(sum.Entries().size(), expected.size());
    for (const ParameterDerivative& entry : sum.Entries()) {
      EXPECT_EQ(entry.d[2].g, expected.at(entry.block)) << "same order of summation, same bits";
      EXPECT_EQ(entry.d[0], Rgba());
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::derivative_accumulator_test
