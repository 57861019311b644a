#include "renderer/core/parallel.h"

#include <cstdlib>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace pathfit::renderer::parallel_test {
namespace {

TEST(ParallelFor, RunsEveryIndexOnce) {
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    std::vector<int> visits(1000, 0);
    ParallelFor(1000, [&](std::int64_t i) { ++visits[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(visits, std::vector<int>(1000, 1)) << threads << " threads";
  }
}

TEST(ParallelFor, DoesNothingForAnEmptyRange) {
  ParallelFor(0, [](std::int64_t) { FAIL() << "no index to visit"; });
}

TEST(ParallelFor, PassesAnExceptionOfABodyOn) {
  const auto body = [](std::int64_t i) {
    if (i == 37) {
      throw std::runtime_error("body 37");
    }
  };
  EXPECT_THROW(ParallelFor(100, body), std::runtime_error);
}

TEST(ParallelFor, NestsWithoutDeadlock) {
  const ThreadLimit limit(2);
  std::vector<int> sums(20, 0);
  ParallelFor(20, [&](std::int64_t i) {
    std::vector<int> inner(50, 0);
    ParallelFor(50, [&](std::int64_t j) { inner[static_cast<std::size_t>(j)] = 1; });
    for (const int x : inner) sums[static_cast<std::size_t>(i)] += x;
  });
  EXPECT_EQ(sums, std::vector<int>(20, 50));
}

TEST(DefaultNumThreads, IsAtLeastOneAndRespectsTheSchedulersShare) {
  const int all = DefaultNumThreads();
  EXPECT_GE(all, 1);
  setenv("SLURM_CPUS_PER_TASK", "1", 1);
  EXPECT_EQ(DefaultNumThreads(), 1);
  setenv("SLURM_CPUS_PER_TASK", "nonsense", 1);
  EXPECT_EQ(DefaultNumThreads(), all);
  unsetenv("SLURM_CPUS_PER_TASK");
}

}  // namespace
}  // namespace pathfit::renderer::parallel_test
