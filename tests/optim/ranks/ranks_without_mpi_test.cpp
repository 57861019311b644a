// optim/ranks/ranks.cpp as it is built without MPI.
#include <cstdlib>

#include <gtest/gtest.h>

#include "optim/ranks/division.h"
#include "optim/ranks/ranks.h"
#include "renderer/core/error.h"

namespace pathfit::optim::ranks_without_mpi_test {
namespace {

TEST(RanksWithoutMpi, IsOneProcess) {
  int argc = 0;
  char** argv = nullptr;
  Ranks ranks(argc, argv);
  EXPECT_TRUE(ranks.IsAlone());
  EXPECT_TRUE(ranks.IsFirst());
  Division division(&ranks, nullptr);
  int sum = 0;
  division.ForEach<int>(
      Division::Kind::kTrial,
      4,
      [](std::size_t i, const auto& give) { give(static_cast<int>(i)); },
      [&](std::size_t, int part) { sum += part; });
  EXPECT_EQ(sum, 6);
  EXPECT_EQ(ranks.End(75), 75);
}

TEST(RanksWithoutMpi, RefusesToBeOneOfSeveral) {
  int argc = 0;
  char** argv = nullptr;
  setenv("OMPI_COMM_WORLD_SIZE", "2", 1);
  EXPECT_THROW(Ranks(argc, argv), renderer::IoError);
  unsetenv("OMPI_COMM_WORLD_SIZE");
}

}  // namespace
}  // namespace pathfit::optim::ranks_without_mpi_test
