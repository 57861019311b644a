#include "app/output/run_directory.h"

#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "app/output/log.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::run_directory_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::system_clock;

const system_clock::time_point kTime{std::chrono::seconds(1795318200)};

TEST(RunDirectory, IsNamedByUtcTimeAndNeverTakenTwice) {
  const TemporaryFolder folder("run_directory");
  const fs::path pattern = folder.path() / "runs/{name}/{timestamp}";
  const RunDirectory first = CreateRunDirectory(pattern, "axe demo", kTime);
  EXPECT_EQ(first.root(), folder.path() / "runs/axe_demo/2026-11-22_033000");
  const RunDirectory second = CreateRunDirectory(pattern, "axe demo", kTime);
  EXPECT_EQ(second.root().filename(), "2026-11-22_033000-2");
  EXPECT_TRUE(fs::is_directory(second.Checkpoints()));
  EXPECT_TRUE(fs::is_directory(second.Images()));
  EXPECT_TRUE(fs::is_directory(second.Result()));
  EXPECT_EQ(fs::read_symlink(folder.path() / "runs/axe_demo/latest"), "2026-11-22_033000-2");
}

TEST(RunDirectory, FoldersThatAreCalledLikeAPlaceholderStay) {
  const TemporaryFolder folder("run_placeholder");
  fs::create_directories(folder.path() / "{name}");
  const RunDirectory run = CreateRunDirectory(folder.path() / "{name}/runs/{name}", "a", kTime);
  EXPECT_EQ(run.root(), folder.path() / "{name}/runs/a");
}

TEST(RunDirectory, OpensARunOrTheLatestOfAFolder) {
  const TemporaryFolder folder("run_open");
  const RunDirectory run = CreateRunDirectory(folder.path() / "{timestamp}", "a", kTime);
  EXPECT_THROW(OpenRunDirectory(run.root()), renderer::IoError);
  renderer::WriteFileAtomically(run.Record(), "{}");
  EXPECT_EQ(OpenRunDirectory(run.root()).root(), run.root());
  EXPECT_TRUE(fs::equivalent(OpenRunDirectory(folder.path()).root(), run.root()));
  EXPECT_THROW(OpenRunDirectory(folder.path() / "none"), renderer::IoError);
}

TEST(RunDirectory, RefusesWhatItCannotCreate) {
  const TemporaryFolder folder("run_refuse");
  renderer::WriteFileAtomically(folder.path() / "file", "");
  EXPECT_THROW(CreateRunDirectory(folder.path() / "file/{timestamp}", "a", kTime),
               renderer::IoError);
  fs::create_directories(folder.path() / "runs/latest");
  EXPECT_THROW(CreateRunDirectory(folder.path() / "runs/{timestamp}", "a", kTime),
               renderer::IoError);
  const auto in_runs = fs::directory_iterator(folder.path() / "runs");
  EXPECT_EQ(std::distance(begin(in_runs), end(in_runs)), 1) << "no run that never began";
}

TEST(RunDirectory, FileNamesAreSafe) {
  EXPECT_EQ(SafeFileName("../a b"), "_.._a_b");
  EXPECT_EQ(SafeFileName(""), "_");
  EXPECT_EQ(SafeFileName("IMG_0012.jpg"), "IMG_0012.jpg");
  EXPECT_EQ(SafeFileName(std::string(500, 'a')).size(), 100U);
}

TEST(RunDirectory, ViewFoldersAreDifferent) {
  EXPECT_EQ(ViewFolderNames({"a/IMG_1.jpg", "IMG_2.jpg"}),
            (std::vector<std::string>{"IMG_1", "IMG_2"}));
  const std::vector<std::string> folders =
      ViewFolderNames({"a/1.jpg", "b/1.jpg", "a_1.jpg", "a/1.png", "..", "", "a_1.jpg"});
  EXPECT_EQ(std::set<std::string>(folders.begin(), folders.end()).size(), folders.size());
  for (const std::string& name : folders) {
    EXPECT_EQ(name.find('/'), std::string::npos);
    EXPECT_NE(name.front(), '.');
  }
}

TEST(UtcTime, IsWrittenAsIso8601) { EXPECT_EQ(UtcIso(kTime), "2026-11-22T03:30:00Z"); }

}  // namespace
}  // namespace pathfit::app::run_directory_test
