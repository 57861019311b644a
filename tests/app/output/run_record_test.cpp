#include "app/output/run_record.h"

#include <cmath>
#include <limits>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>

#include "app/output/file_lock.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::run_record_test {
namespace {

namespace fs = std::filesystem;

RunRecord SomeRecord(const fs::path& folder) {
  renderer::WriteFileAtomically(folder / "photo.jpg", "abc");
  RunRecord record = MakeRunRecord({"pathfit", "fit", "axe.yaml"});
  record.name = "axe";
  record.program_version = "0.1.0";
  record.libraries = {{"Embree", "3.13.5"}, {"Ceres", "2.1.0"}};
  record.threads = 2;
  record.seed = 0xfedcba9876543210U;
  record.inputs = HashInputs({folder / "photo.jpg"});
  record.assumptions = {"masks: black = object absent"};
  return record;
}

TEST(RunRecord, SaysWhatAndWhereAndIsReadBack) {
  const TemporaryFolder folder("record");
  const fs::path path = folder.path() / "run.json";
  RunRecordFile file(path, SomeRecord(folder.path()));
  const auto json = nlohmann::json::parse(renderer::ReadWholeFile(path));
  EXPECT_EQ(json.at("status"), "running");
  EXPECT_TRUE(json.at("exit_code").is_null());
  EXPECT_EQ(json.at("sessions").at(0).at("argv").at(1), "fit");
  EXPECT_EQ(json.at("sessions").at(0).at("pid"), getpid());
  EXPECT_EQ(json.at("inputs").at(0).at("sha256"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(json.at("inputs").at(0).at("bytes"), 3);
  EXPECT_EQ(json.at("libraries").at("Embree"), "3.13.5");
  EXPECT_EQ(json.at("seed"), 0xfedcba9876543210U);
  EXPECT_FALSE(json.at("host").at("cpu").get<std::string>().empty());

  optim::StageReport stage;
  stage.stage = "light";
  stage.psnr_srgb_fit = 20.0;
  stage.psnr_srgb_val = std::numeric_limits<double>::quiet_NaN();
  file.SetStages({stage});
  file.SetWarnings({"a mask is black"});
  file.SetTimes(12.0, 300.0);
  file.Finish(RunStatus::kFinished, "all stages done", 0);
  const RunRecord read = ReadRunRecord(path);
  EXPECT_EQ(read.status, RunStatus::kFinished);
  EXPECT_EQ(read.exit_code, 0);
  EXPECT_EQ(read.seed, 0xfedcba9876543210U);
  EXPECT_EQ(read.stages.at(0).stage, "light");
  EXPECT_EQ(read.stages.at(0).psnr_srgb_fit, 20.0);
  EXPECT_TRUE(std::isnan(read.stages.at(0).psnr_srgb_val)) << "no view was held out";
  EXPECT_EQ(read.warnings, std::vector<std::string>{"a mask is black"});
  EXPECT_EQ(read.peak_rss_mb, 300.0);
  EXPECT_EQ(read.sessions.at(0).outcome, "finished");
  EXPECT_FALSE(read.ended_utc.empty());
}

TEST(RunRecord, AnExceptionDoesNotLeaveItRunning) {
  const TemporaryFolder folder("record_failed");
  const fs::path path = folder.path() / "run.json";
  const auto our_mistake = [&] {
    const RunRecordFile file(path, SomeRecord(folder.path()));
    PATHFIT_CHECK(file.record().sessions.empty());
  };
  EXPECT_THROW(our_mistake(), renderer::InternalError);
  const RunRecord read = ReadRunRecord(path);
  EXPECT_EQ(read.status, RunStatus::kFailed);
  EXPECT_EQ(read.exit_code, 1);
}

TEST(RunRecord, NamesInputsThatHaveChanged) {
  const TemporaryFolder folder("record_inputs");
  const RunRecord record = SomeRecord(folder.path());
  EXPECT_TRUE(ChangedInputs(record).empty());
  renderer::WriteFileAtomically(folder.path() / "photo.jpg", "abd");
  EXPECT_EQ(ChangedInputs(record).size(), 1U);
  fs::remove(folder.path() / "photo.jpg");
  EXPECT_EQ(ChangedInputs(record).size(), 1U);
}

TEST(RunRecord, ResumeOverridesAKilledRun) {
  const TemporaryFolder folder("record_resume");
  const fs::path path = folder.path() / "run.json";
  RunRecord killed = SomeRecord(folder.path());
  constexpr int kNoSuchProcess = 0x3ffffff0;
  killed.sessions.back().pid = kNoSuchProcess;
  WriteRunRecord(path, killed);
  EXPECT_EQ(EffectiveStatus(ReadRunRecord(path), folder.path()), "killed");

  RunRecordFile file(path, {"pathfit", "resume", "run"}, 17);
  EXPECT_EQ(EffectiveStatus(ReadRunRecord(path), folder.path()), "killed") << "nothing holds it";
  const FileLock lock(folder.path(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, LOCK_EX | LOCK_NB);
  EXPECT_EQ(EffectiveStatus(ReadRunRecord(path), folder.path()), "running");
  RunRecord elsewhere = ReadRunRecord(path);
  elsewhere.host.name = "another";
  EXPECT_EQ(EffectiveStatus(elsewhere, folder.path()), "running");
  ASSERT_EQ(file.record().sessions.size(), 2U);
  EXPECT_EQ(file.record().sessions[1].from_step, 17);
  EXPECT_EQ(file.record().sessions[0].pid, kNoSuchProcess);
  file.Finish(RunStatus::kStopped, "interrupted", 130);
  EXPECT_EQ(ReadRunRecord(path).exit_code, 130);
}

TEST(RunRecord, RefusesDamagedFilesAndMissingInputs) {
  const TemporaryFolder folder("record_bad");
  const fs::path path = folder.path() / "run.json";
  WriteRunRecord(path, SomeRecord(folder.path()));
  const std::string good = renderer::ReadWholeFile(path);
  for (const std::string& text : {std::string(),
                                  std::string("{}"),
                                  good.substr(0, good.size() / 2),
                                  std::string("{\"version\": 2}")}) {
    renderer::WriteFileAtomically(path, text);
    EXPECT_THROW(ReadRunRecord(path), renderer::IoError);
  }
  EXPECT_THROW(HashInputs({folder.path() / "none.jpg"}), renderer::IoError);
}

}  // namespace
}  // namespace pathfit::app::run_record_test
