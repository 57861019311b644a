#include "renderer/core/process_memory.h"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::process_memory_test {
namespace {

class ControlGroupTest : public testing::Test {
 protected:
  void WriteLimit(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = folder_.Path() / "cgroup" / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text << "\n";
  }
  [[nodiscard]] double LimitOf(const std::string& groups) const {
    return ControlGroupLimit(folder_.Write("groups", groups), folder_.Path() / "cgroup");
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(ControlGroupTest, TheLeastOfAGroupAndThoseItIsInHolds) {
  WriteLimit("job/memory.max", "3000000000");
  WriteLimit("job/step/memory.max", "max");
  EXPECT_EQ(LimitOf("0::/job/step\n"), 3e9);
  WriteLimit("job/step/memory.max", "2000000000");
  EXPECT_EQ(LimitOf("0::/job/step\n"), 2e9);
  WriteLimit("memory.max", "1000000000");
  EXPECT_EQ(LimitOf("0::/elsewhere/outside\n"), 1e9) << "a container's own root";
}

TEST_F(ControlGroupTest, TheFirstVersionIsReadToo) {
  WriteLimit("memory/a:b/memory.limit_in_bytes", "4000000000");
  EXPECT_EQ(LimitOf("5:cpu,cpuacct:/\n4:memory:/a:b\n0::/\n"), 4e9);
  EXPECT_EQ(LimitOf("4:hugetlb,memory:/a:b\n"), 4e9);
}

TEST_F(ControlGroupTest, WhatIsNotThereIsNoLimit) {
  for (const char* groups : {"", "0::/\n", "memory\n", "4:memory\n", "::\n", "4:cpu:/a\n"}) {
    EXPECT_TRUE(std::isinf(LimitOf(groups))) << groups;
  }
}

TEST(ProcessMemory, TheLimitHoldsTheProcess) {
  const double resident = ProcessMemory("VmRSS:");
  EXPECT_GT(resident, 1e6);
  EXPECT_GT(MemoryLimit(), resident);
}

}  // namespace
}  // namespace pathfit::renderer::process_memory_test
