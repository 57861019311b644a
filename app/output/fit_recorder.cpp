#include "app/output/fit_recorder.h"

#include <algorithm>
#include <functional>
#include <variant>
#include <vector>

#include "app/output/parameter_table.h"
#include "app/output/report.h"
#include "app/output/report_images.h"
#include "app/output/viewed_model.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/disk_full_error.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/image_filter.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using renderer::Image;

constexpr int kJpegQuality = 85;

void WriteJpeg(const fs::path& path, const Image& encoded) {
  const std::vector<unsigned char> bytes =
      renderer::EncodeJpeg(ReducedImage(encoded, kThumbnailPx), kJpegQuality);
  renderer::WriteFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

Image Subtracted(Image a, const Image& b) {
  PATHFIT_CHECK(a.data.size() == b.data.size());
  std::ranges::transform(a.data, b.data, a.data.begin(), std::minus<>());
  return a;
}

std::vector<std::string> ViewNames(const optim::ObservationSet& observations) {
  std::vector<std::string> names;
  for (const optim::View& view : observations.views) names.push_back(view.name);
  return names;
}

FitHistory LoadHistory(const RunDirectory& run, int step) {
  FitHistory history;
  if (fs::exists(run.History())) history = ReadHistory(run.History());
  TruncateHistory(step, history);
  return history;
}

const renderer::EnvironmentEmitter* FindEnvironment(const renderer::Scene& scene) {
  for (const renderer::Emitter& emitter : scene.emitters) {
    if (const auto* found = std::get_if<renderer::EnvironmentEmitter>(&emitter.light)) return found;
  }
  return nullptr;
}

}  // namespace

FitRecorder::FitRecorder(const RunDirectory& run,
                         const optim::ObservationSet& observations,
                         RunRecordFile& record,
                         Log& log,
                         Progress& progress,
                         RecorderOptions options,
                         int resume_step)
    : run_(run),
      observations_(observations),
      record_(record),
      log_(log),
      progress_(progress),
      options_(std::move(options)),
      history_(LoadHistory(run, resume_step)),
      view_folders_(ViewFolderNames(ViewNames(observations))),
      earlier_warnings_(record.record().warnings) {
  WriteRounds();
}

void FitRecorder::WriteRounds() const {
  WriteHistory(run_.History(), history_);
  renderer::WriteFileAtomically(run_.Metrics(), CsvTable(history_.rounds));
}

void FitRecorder::OnRound(const optim::RoundReport& report) {
  progress_.OnRound(report);
  log_.Write(LogLevel::kDebug, RoundWords(report));
  AddRound(report, history_);
  WriteRounds();
  record_.SetTimes(report.wall_s, report.peak_rss_mb);
}

void FitRecorder::OnScene(const std::string& stage,
                          const renderer::Scene& scene,
                          const StandardErrorsByName& standard_errors) {
  if (!options_.report) return;
  const Json model = ViewedModel(scene, observations_, standard_errors);
  if (stage == "start") WriteViewedModel(run_.StartModel(), model);
  WriteViewedModel(run_.Model(), model);
}

void FitRecorder::OnView(const std::string& stage,
                         std::size_t view,
                         const renderer::Film& film,
                         const optim::ViewLevel& observed) {
  const optim::View& original = observations_.views[view];
  const fs::path folder = run_.Images() / view_folders_[view];
  renderer::CreateFolders(folder);
  const auto thumbnail = [&](const char* kind) {
    return ThumbnailPath(run_, view_folders_[view], kind);
  };
  const Image fit = renderer::ColorImage(film);
  const Image fit_encoded = EncodedImage(fit);
  const Image difference = DifferenceImage(fit, observed.photo, observed.mask);

  // Encoding takes longer than all else here.
  std::vector<std::function<void()>> files;
  if (!fs::exists(thumbnail("photo"))) {
    files.emplace_back([&] {
      WriteJpeg(thumbnail("photo"),
                EncodedImage(ReducedImage(original.photo.Unpack(), kThumbnailPx)));
    });
  }
  if (stage == "start") {
    files.emplace_back([&] { WriteJpeg(thumbnail("start"), fit_encoded); });
  }
  files.emplace_back([&] { WriteJpeg(thumbnail("result"), fit_encoded); });
  files.emplace_back([&] { WriteJpeg(thumbnail("difference"), difference); });
  if (!observed.mask.Empty() && observations_.mask_meaning == optim::MaskMeaning::kSilhouette) {
    files.emplace_back([&] {
      WriteJpeg(thumbnail("silhouette"),
                SilhouetteImage(renderer::CoverageImage(film), observed.mask));
    });
  }
  const bool other_stage = !options_.only_pictures_of.empty() && stage != options_.only_pictures_of;
  const std::string prefix = SafeFileName(stage);
  if (original.validation && !other_stage) {
    files.emplace_back([&] { renderer::WritePng8(folder / (prefix + "_fit.png"), fit_encoded); });
    files.emplace_back(
        [&] { renderer::WritePng8(folder / (prefix + "_difference.png"), difference); });
    files.emplace_back([&] { renderer::WriteExr(folder / (prefix + "_fit.exr"), fit); });
    files.emplace_back([&] {
      renderer::WriteExr(folder / (prefix + "_difference.exr"), Subtracted(fit, observed.photo));
    });
  }
  renderer::ParallelFor(static_cast<std::int64_t>(files.size()),
                        [&](std::int64_t i) { files[static_cast<std::size_t>(i)](); });
}

void FitRecorder::OnStage(const optim::StageReport& report) {
  PATHFIT_CHECK(report.views.size() == observations_.views.size());
  AddStage(report, history_);
  WriteHistory(run_.History(), history_);
  UpdateRecord();
  progress_.OnStage(report);
  log_.Write(LogLevel::kDebug, StageWords(report));
  WritePage();
}

void FitRecorder::WritePage() {
  if (!options_.report) return;
  try {
    WriteReport(run_);
  } catch (const renderer::DiskFullError&) {
    throw;  // nothing else can be written either
  } catch (const renderer::IoError& error) {
    log_.Warn(std::string("no report is written: ") + error.what() +
              "; `pathfit report` writes it from what is recorded");
  }
}

void FitRecorder::OnMessage(const std::string& text) { log_.Info(text); }
void FitRecorder::OnWarning(const std::string& text) { log_.Warn(text); }
void FitRecorder::OnLimit(const std::string& limit) { log_.WarnOfLimit(limit); }

void FitRecorder::RecordScenes(const optim::FitSpec& spec,
                               const renderer::Scene& start,
                               const renderer::Scene& result,
                               const StandardErrorsByName& errors) {
  history_.parameters = SummarizeParameters(spec, start, result, errors);
  history_.gain_errors = GainErrors(result, errors);
  const renderer::EnvironmentEmitter* initial = FindEnvironment(start);
  const renderer::EnvironmentEmitter* final = FindEnvironment(result);
  if (initial != nullptr && final != nullptr) {
    history_.environment_exposure = EnvironmentExposure(*final);
    renderer::WritePng8(run_.Images() / "environment_initial.png",
                        EnvironmentPicture(*initial, history_.environment_exposure));
    renderer::WritePng8(run_.Images() / "environment_final.png",
                        EnvironmentPicture(*final, history_.environment_exposure));
  }
  WriteHistory(run_.History(), history_);
  OnScene("", result, errors);
}

void FitRecorder::UpdateRecord() {
  std::vector<optim::StageReport> stages;
  for (const StageEntry& entry : history_.stages) stages.push_back(entry.report);
  record_.SetStages(std::move(stages));
  std::vector<std::string> warnings = earlier_warnings_;
  for (const std::string& warning : log_.Warnings()) {
    if (std::ranges::find(warnings, warning) == warnings.end()) {
      warnings.push_back(warning);
    }
  }
  record_.SetWarnings(std::move(warnings));
}

void FitRecorder::Finish(RunStatus status, const std::string& reason, int exit_code) {
  progress_.Finish();
  UpdateRecord();
  record_.Finish(status, reason, exit_code);
  WritePage();
}

}  // namespace pathfit::app
