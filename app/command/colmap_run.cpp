#include "app/command/colmap_run.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <set>

#include <fmt/format.h>

#include "app/command/child_process.h"
#include "optim/observation/camera_import.h"
#include "optim/observation/exif_exposure.h"
#include "optim/observation/photo_file.h"
#include "renderer/core/clock.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/raw_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;
using Words = std::vector<std::string>;

constexpr std::size_t kMostForAllPairs = 200;

/// The pictures in a folder, or in one of its folders of a usual name.
std::vector<fs::path> FindPictures(const fs::path& top) {
  for (const fs::path& folder : {top, top / "images", top / "photos", top / "rgb", top / "input"}) {
    std::vector<fs::path> pictures = optim::WithoutRawTwins(optim::PicturesIn(folder));
    const auto raw = std::ranges::find_if(pictures, renderer::HasRawExtension);
    if (raw != pictures.end()) {
      throw IoError(raw->string() +
                    ": COLMAP reads RAW photos in its own way, turned or cut; put JPEGs of all of "
                    "them, of full size and not turned, into a folder and let the cameras be found "
                    "on these; with the folder of the RAW photos as input.images these are found "
                    "by the same names then");
    }
    if (!pictures.empty()) return pictures;
  }
  throw IoError(top.string() + ": holds no pictures (nor images, photos, rgb or input in it)");
}

class ColmapRunner {
 public:
  ColmapRunner(const ColmapInput& input, const StopSignals& signals, CommandContext& context)
      : input_(input), signals_(signals), context_(context), log_(input.workspace / "colmap.log") {}

  ColmapResult Run() {
    const std::optional<fs::path> program = FindProgram("colmap");
    if (!program) {
      throw IoError(
          "--sfm colmap needs the program colmap, which is not on PATH (Debian: apt install "
          "colmap); or give a camera file of another program");
    }
    program_ = *program;
    pictures_ = FindPictures(input_.photos);
    const fs::path folder = pictures_.front().parent_path();
    if (std::ssize(pictures_) < kFewestPhotosOfColmap) {
      throw IoError(
          fmt::format("{}: holds {} pictures; cameras are found from at least {} that "
                      "overlap",
                      folder.string(),
                      pictures_.size(),
                      kFewestPhotosOfColmap));
    }
    renderer::CreateFolders(input_.workspace / "sparse");
    FindGpuOptions();
    context_.log.Info(fmt::format("COLMAP finds the cameras of {} photos; what it says is in {}",
                                  pictures_.size(),
                                  log_.string()));
    const std::string database = (input_.workspace / "database.db").string();
    Step("feature_extractor", Features(database, folder));
    const bool all_pairs = pictures_.size() <= kMostForAllPairs;
    Step(all_pairs ? "exhaustive_matcher" : "sequential_matcher",
         Threads({"--database_path", database, "--" + matching_ + ".use_gpu", "0"}, matching_));
    Words mapper = {"--database_path",
                    database,
                    "--image_path",
                    folder.string(),
                    "--output_path",
                    (input_.workspace / "sparse").string()};
    if (!input_.calibration.empty()) {
      mapper.insert(
          mapper.end(),
          {"--Mapper.ba_refine_focal_length", "0", "--Mapper.ba_refine_extra_params", "0"});
    }
    // Its status is 1 without a model, which is said better below.
    Step("mapper", Threads(mapper, "Mapper"), true);
    if (signals_.Received()) return {folder, {}};
    return {folder, LargestModel()};
  }

 private:
  /// COLMAP 3.13 and later call these options otherwise.
  void FindGpuOptions() {
    const fs::path help = input_.workspace / "colmap_help.txt";
    RunChild({program_, {"colmap", "feature_extractor", "-h"}, help, true}, signals_);
    const bool is_new = fs::exists(help) && renderer::ReadWholeFile(help).find(
                                                "FeatureExtraction.use_gpu") != std::string::npos;
    fs::remove(help);
    extraction_ = is_new ? "FeatureExtraction" : "SiftExtraction";
    matching_ = is_new ? "FeatureMatching" : "SiftMatching";
  }

  [[nodiscard]] Words Threads(Words words, const std::string& group) const {
    if (context_.line.threads && *context_.line.threads > 0) {
      words.insert(words.end(),
                   {"--" + group + ".num_threads", std::to_string(*context_.line.threads)});
    }
    return words;
  }

  [[nodiscard]] Words Features(const std::string& database, const fs::path& folder) {
    Words words = {"--database_path",
                   database,
                   "--image_path",
                   folder.string(),
                   "--" + extraction_ + ".use_gpu",
                   "0"};
    const bool is_one = TookOneCamera();
    if (is_one || !input_.calibration.empty()) {
      words.insert(words.end(), {"--ImageReader.single_camera", "1"});
    }
    if (!input_.calibration.empty()) {
      const renderer::Camera c = optim::ReadOpencvIntrinsics(input_.calibration);
      const renderer::LensDistortion& d = c.distortion;
      words.insert(words.end(),
                   {"--ImageReader.camera_model",
                    "FULL_OPENCV",
                    "--ImageReader.camera_params",
                    fmt::format("{},{},{},{},{},{},{},{},{},0,0,0",
                                c.fx,
                                c.fy,
                                c.cx,
                                c.cy,
                                d.k1,
                                d.k2,
                                d.p1,
                                d.p2,
                                d.k3)});
    }
    if (!input_.masks.empty()) {
      words.insert(words.end(), {"--ImageReader.mask_path", LinkMasks().string()});
    }
    return Threads(words, extraction_);
  }

  [[nodiscard]] bool TookOneCamera() const {
    std::vector<std::string> kinds(pictures_.size());
    renderer::ParallelFor(std::ssize(pictures_), [&](std::int64_t i) {
      const auto index = static_cast<std::size_t>(i);
      const renderer::DecodedImage photo = renderer::ReadImageFile(pictures_[index], false);
      kinds[index] = fmt::format("{} x {} pixels", photo.image.width, photo.image.height);
      const std::string lens = optim::ParseExifLens(photo.exif);
      if (!lens.empty()) kinds[index] += ", " + lens;
    });
    const std::set<std::string> different(kinds.begin(), kinds.end());
    if (different.size() == 1) {
      context_.log.Info("one camera took all photos, as they agree: " + *different.begin());
      return true;
    }
    context_.log.Info(
        fmt::format("each photo has a camera of its own: there are {} kinds, such as "
                    "{} and {}",
                    different.size(),
                    *different.begin(),
                    *different.rbegin()));
    return false;
  }

  /// By the names COLMAP wants: a.jpg.png for a.jpg.
  [[nodiscard]] fs::path LinkMasks() const {
    fs::path folder = input_.workspace / "masks";
    renderer::CreateFolders(folder);
    optim::ObservationOptions options;
    options.masks.folder = fs::absolute(input_.masks);
    std::size_t count = 0;
    for (const fs::path& picture : pictures_) {
      const std::string name = picture.filename().string();
      const optim::FileSearch mask = optim::FindMask(
          {.image = name, .mask = {}, .camera = {}, .place = {}}, picture, {}, options);
      if (!mask.found) continue;
      const fs::path link = folder / (name + ".png");
      fs::remove(link);
      fs::create_symlink(*mask.found, link);
      ++count;
    }
    if (count == 0) {
      throw IoError(input_.masks.string() +
                    ": holds no mask of a photo (for a.jpg: a.jpg.png, a.png or a.mask.png)");
    }
    context_.log.Info(fmt::format("features are looked for inside the masks of {} photos", count));
    return folder;
  }

  void Step(const std::string& name, Words options, bool may_fail = false) {
    if (signals_.Received()) return;
    const auto start = renderer::Clock::now();
    options.insert(options.begin(), {"colmap", name});
    {
      std::ofstream log(log_, std::ios::app);
      log << "\n$";
      for (const std::string& word : options) log << ' ' << word;
      log << std::endl;  // before the program's own words
      if (!log) throw IoError(log_.string() + ": cannot be written");
    }
    const std::optional<int> status = RunChild({program_, options, log_, true}, signals_);
    if (signals_.Received()) return;
    if (!status || (*status != 0 && !may_fail)) {
      throw IoError(fmt::format("colmap {} {}; the end of {} says:\n{}",
                                name,
                                status ? fmt::format("failed (status {})", *status)
                                       : "was ended by a signal (too little memory?)",
                                log_.string(),
                                EndOf(renderer::ReadWholeFile(log_))));
    }
    context_.log.Info(fmt::format("colmap {}: {:.0f} s", name, renderer::SecondsSince(start)));
  }

  /// Of the folders sparse/0, sparse/1 ...
  [[nodiscard]] fs::path LargestModel() const {
    fs::path largest;
    std::size_t most = 0;
    std::string found;
    for (int i = 0;; ++i) {
      const fs::path model = input_.workspace / "sparse" / std::to_string(i);
      if (!optim::HasCameras(model)) break;
      const std::size_t count = optim::ImportCameras(model, "colmap").cameras.size();
      found += fmt::format("{}{} ({} photos)", found.empty() ? "" : ", ", model.string(), count);
      if (count > most) {
        most = count;
        largest = model;
      }
    }
    if (largest.empty()) {
      throw IoError(fmt::format(
          "COLMAP found no cameras: {} photos that overlap too little, show too little texture, or "
          "(on a turntable) a background that stands still, for which --masks DIR helps. Its words "
          "are in {}",
          pictures_.size(),
          log_.string()));
    }
    if (most < pictures_.size()) {
      context_.log.Warn(fmt::format(
          "COLMAP found the cameras of {} of {} photos: {}", most, pictures_.size(), found));
    }
    if (found.find("), ") != std::string::npos) {
      context_.log.Warn(
          "COLMAP found several models that do not hang together, and the largest is "
          "used: " +
          found);
    }
    return largest;
  }

  const ColmapInput& input_;
  const StopSignals& signals_;
  CommandContext& context_;
  fs::path log_, program_;
  std::string extraction_, matching_;
  std::vector<fs::path> pictures_;
};

}  // namespace

ColmapResult RunColmap(const ColmapInput& input,
                       const StopSignals& signals,
                       CommandContext& context) {
  return ColmapRunner(input, signals, context).Run();
}

}  // namespace pathfit::app
