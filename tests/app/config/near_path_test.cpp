#include "app/config/near_path.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

namespace pathfit::app::near_path_test {
namespace {

namespace fs = std::filesystem;

TEST(NearPath, IsRelativeUnlessOnlyTheRootIsAboveBoth) {
  EXPECT_EQ(NearPath("/a/b/photos/x.jpg", "/a/b"), "photos/x.jpg");
  EXPECT_EQ(NearPath("/a/b/photos/x.jpg", "/a/runs/one"), "../../b/photos/x.jpg");
  // A folder that is named from here, as that of a run that is resumed.
  const fs::path here = fs::current_path();
  EXPECT_EQ(NearPath(here / "photos/x.jpg", "runs/one"), "../../photos/x.jpg");
  EXPECT_EQ(NearPath("/a/b/../c/x.jpg", "/a/b/"), "../c/x.jpg");
  EXPECT_EQ(NearPath("/c/x.jpg", "/a/b"), "/c/x.jpg");
  EXPECT_EQ(NearPath("/c/x.jpg", "/a/b/"), "/c/x.jpg");
  EXPECT_EQ(NearPath("/x.jpg", "/a"), "/x.jpg");
}

TEST(NearPath, ThroughALinkIsSeenFromWhereTheFolderIs) {
  const fs::path top =
      fs::temp_directory_path() / ("pathfit_near_" + std::to_string(getpid())) / "a";
  fs::create_directories(top / "runs/one/export");
  fs::create_directories(top / "photos");
  fs::create_directories(top / "b/c/d");
  std::ofstream(top / "photos/p.jpg") << "photo";
  fs::create_directory_symlink(top / "runs/one", top / "b/c/d/run");
  const fs::path folder = top / "b/c/d/run/export";
  const fs::path near = NearPath(top / "photos/p.jpg", folder);
  EXPECT_TRUE(near.is_relative()) << near;
  EXPECT_TRUE(fs::exists(folder / near)) << near;
  // A linked folder of photos keeps its place beside the config.
  fs::create_directory_symlink(top / "photos", top / "runs/photos");
  EXPECT_EQ(NearPath(top / "runs/photos/p.jpg", top / "runs"), fs::path("photos/p.jpg"));
  fs::remove_all(top.parent_path());
}

}  // namespace
}  // namespace pathfit::app::near_path_test
