#include <gtest/gtest.h>

#include "renderer/io/raw_file.h"
#include "tests/renderer/io/temporary_folder.h"

// Of a build without LibRaw.
namespace pathfit::renderer::raw_file_without_libraw_test {
namespace {

TEST(RawFileWithoutLibRaw, IsRefusedByNameWithWhatToInstall) {
  EXPECT_EQ(LibRawVersion(), "");
  EXPECT_TRUE(HasRawExtension("a.dng"));
  const std::string error = IoErrorOf([] { ReadRawFile("photos/a.dng", {}); });
  EXPECT_NE(error.find("photos/a.dng: is a RAW photo"), std::string::npos) << error;
  EXPECT_NE(error.find("libraw-dev"), std::string::npos) << error;
}

}  // namespace
}  // namespace pathfit::renderer::raw_file_without_libraw_test
