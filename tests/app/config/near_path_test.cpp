#include "app/config/near_path.h"

#include <gtest/gtest.h>

namespace pathfit::app {
namespace {

TEST(NearPath, IsRelativeUnlessOnlyTheRootIsAboveBoth) {
  EXPECT_EQ(NearPath("/a/b/photos/x.jpg", "/a/b"), "photos/x.jpg");
  EXPECT_EQ(NearPath("/a/b/photos/x.jpg", "/a/runs/one"), "../../b/photos/x.jpg");
  EXPECT_EQ(NearPath("/a/b/../c/x.jpg", "/a/b/"), "../c/x.jpg");
  EXPECT_EQ(NearPath("/c/x.jpg", "/a/b"), "/c/x.jpg");
  EXPECT_EQ(NearPath("/c/x.jpg", "/a/b/"), "/c/x.jpg");
  EXPECT_EQ(NearPath("/x.jpg", "/a"), "/x.jpg");
}

}  // namespace
}  // namespace pathfit::app
