#include "renderer/io/atomic_file.h"

#include <iterator>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::atomic_file_test {
namespace {

std::ptrdiff_t NumEntries(const std::filesystem::path& folder) {
  return std::distance(std::filesystem::directory_iterator(folder),
                       std::filesystem::directory_iterator());
}

TEST(AtomicFile, KeepsEveryByte) {
  const TemporaryFolder folder;
  const std::string bytes("a\0b\r\n\xff", 6);
  WriteFileAtomically(folder.Path() / "x.bin", bytes);
  EXPECT_EQ(ReadWholeFile(folder.Path() / "x.bin"), bytes);
  WriteFileAtomically(folder.Path() / "x.bin", "");
  EXPECT_EQ(ReadWholeFile(folder.Path() / "x.bin"), "");
  EXPECT_EQ(NumEntries(folder.Path()), 1);
}

TEST(AtomicFile, AFailedWriteKeepsTheOldFileAndLeavesNoOther) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Write("x.txt", "old");
  const auto fails = [](const std::filesystem::path& temporary) {
    EXPECT_EQ(temporary.extension(), ".txt");
    std::ofstream(temporary) << "half";
    throw std::runtime_error("stop");
  };
  EXPECT_THROW(WriteThroughTemporary(path, fails), std::runtime_error);
  EXPECT_EQ(ReadWholeFile(path), "old");
  EXPECT_EQ(NumEntries(folder.Path()), 1);
}

TEST(AtomicFile, RefusesMissingFilesAndFolders) {
  const TemporaryFolder folder;
  EXPECT_NE(IoErrorOf([&] { ReadWholeFile(folder.Path() / "none"); }).find("no such file"),
            std::string::npos);
  EXPECT_THROW(ReadWholeFile(folder.Path()), IoError);
  EXPECT_THROW(ReadWholeFile("/dev/zero"), IoError);
  EXPECT_THROW(WriteFileAtomically(folder.Path() / "no" / "x", "y"), IoError);
  EXPECT_THROW(WriteFileAtomically(folder.Path(), "y"), IoError);
  EXPECT_THROW(WriteFileAtomically("", "y"), IoError);
  EXPECT_EQ(NumEntries(folder.Path()), 0);
}

}  // namespace
}  // namespace pathfit::renderer::atomic_file_test
