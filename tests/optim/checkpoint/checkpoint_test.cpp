#include "optim/checkpoint/checkpoint.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "optim/checkpoint/npy.h"
#include "renderer/core/error.h"

namespace pathfit {
namespace {

namespace fs = std::filesystem;

class CheckpointTest : public testing::Test {
 protected:
  CheckpointTest() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("pathfit_checkpoint_" + std::to_string(getpid()) + "_" + info->name());
    fs::remove_all(folder_);
  }
  ~CheckpointTest() override { fs::remove_all(folder_); }
  CheckpointTest(const CheckpointTest&) = delete;
  CheckpointTest& operator=(const CheckpointTest&) = delete;

  static optim::FitState State(int sequence) {
    optim::FitState state;
    state.fingerprint = "views \"3\"\n\\";
    state.sequence = sequence;
    state.step = 17;
    state.stage = 1;
    state.round = 4;
    state.wall_s = 1.0 / 3.0;
    state.radius_factor = 0.1;
    state.damping = std::nextafter(1e-3, 1.0);
    state.rejected_in_row = 2;
    state.costs = {0.3, 0.2, 0.1};
    state.current = {1.0 / 3.0, -0.0, 5e-324, 1e300};
    state.stage_start = {1.0, 2.0, 3.0, 4.0};
    state.average = {{0.1}, {}, 12.0, 1.0 / 7.0, 8};
    return state;
  }

  fs::path folder_;
};

TEST_F(CheckpointTest, ReturnsEveryBit) {
  const optim::FitState state = State(3);
  optim::WriteCheckpoint(folder_, state);
  const optim::FitState read = optim::ReadNewestCheckpoint(folder_).value();
  EXPECT_EQ(read.fingerprint, state.fingerprint);
  EXPECT_EQ(read.sequence, 3);
  EXPECT_EQ(read.step, 17);
  EXPECT_EQ(read.stage, 1);
  EXPECT_EQ(read.round, 4);
  EXPECT_EQ(read.wall_s, state.wall_s);
  EXPECT_EQ(read.radius_factor, state.radius_factor);
  EXPECT_EQ(read.damping, state.damping);
  EXPECT_EQ(read.rejected_in_row, 2);
  EXPECT_EQ(read.costs, state.costs);
  EXPECT_EQ(read.current, state.current);
  EXPECT_TRUE(std::signbit(read.current[1]));
  EXPECT_EQ(read.stage_start, state.stage_start);
  EXPECT_EQ(read.average.older_sum, state.average.older_sum);
  EXPECT_EQ(read.average.newer_sum, state.average.newer_sum);
  EXPECT_EQ(read.average.older_weight, state.average.older_weight);
  EXPECT_EQ(read.average.newer_weight, state.average.newer_weight);
  EXPECT_EQ(read.average.newer_start, 8);
}

TEST_F(CheckpointTest, KeepsTheTwoNewestAndReadsTheNewestThatIsWhole) {
  for (int sequence = 1; sequence <= 12; ++sequence) {
    optim::WriteCheckpoint(folder_, State(sequence));
  }
  const auto count = std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  EXPECT_EQ(count, 2);
  EXPECT_EQ(optim::ReadNewestCheckpoint(folder_)->sequence, 12);
  fs::resize_file(folder_ / "state_000012" / "current.npy", 130);
  EXPECT_EQ(optim::ReadNewestCheckpoint(folder_)->sequence, 11);
  std::ofstream(folder_ / "state_000011" / "state.json") << "{";
  EXPECT_THROW(optim::ReadNewestCheckpoint(folder_), renderer::IoError);
}

TEST_F(CheckpointTest, IsEmptyWithoutStatesAndRefusesOtherVersions) {
  EXPECT_FALSE(optim::ReadNewestCheckpoint(folder_).has_value());
  optim::WriteCheckpoint(folder_, State(1));
  std::ofstream(folder_ / "state_000001" / "state.json") << "{\"version\": 99}";
  try {
    optim::ReadNewestCheckpoint(folder_);
    FAIL() << "not refused";
  } catch (const renderer::IoError& error) {
    EXPECT_NE(std::string(error.what()).find("version 99"), std::string::npos);
  }
}

TEST_F(CheckpointTest, SaysWhereItCannotWrite) {
  std::ofstream(folder_) << "a file where the folder should be";
  EXPECT_THROW(optim::WriteCheckpoint(folder_, State(1)), renderer::IoError);
}

}  // namespace
}  // namespace pathfit
