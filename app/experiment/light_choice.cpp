#include "app/experiment/light_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "app/experiment/draft_config.h"
#include "app/experiment/experiment.h"
#include "app/experiment/start_check.h"
#include "optim/round/decimate.h"
#include "optim/round/fit.h"
#include "renderer/core/error.h"
#include "renderer/math/median.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using renderer::ParameterKind;

// Measured, light that goes with the camera against one that stands still, in dB: a flash 2.3, a
// turntable 1.5; a room in which the camera moved 0.4, renderings of one 0.1.
constexpr double kClearlyBetter = 0.8;
constexpr double kSlightlyBetter = 0.5;
constexpr double kDoubtful = 18.0;    // dB, of the best
constexpr double kOverexposed = 0.9;  // of the object, clipped: such a photo tells nothing of light
constexpr std::size_t kTrialPhotos = 24;
constexpr double kTrialPixels = 600.0;                            // of the object in a photo
constexpr double kLeastTrialSide = 64.0, kMostTrialSide = 256.0;  // of a photo, the longer one
constexpr int kTrialErosion = 1;  // the start's outline is not yet that of the masks
constexpr int kTrialRounds = 20;
constexpr int kTrialSpp = 8;
constexpr int kTrialTriangles = 2000;

/// Whether nearly all of the object is at least as bright as photos tell.
bool IsOverexposed(const optim::View& view) {
  if (view.clipped.Empty()) return false;
  const renderer::Image mask = view.mask.Unpack();
  const renderer::Image clipped = view.clipped.Unpack();
  double of_object = 0.0;
  double of_clipped = 0.0;
  for (std::size_t p = 0; p < mask.data.size(); ++p) {
    of_object += static_cast<double>(mask.data[p]);
    of_clipped += static_cast<double>(mask.data[p] * clipped.data[p]);
  }
  return of_clipped > kOverexposed * of_object;
}

/// Of the photos that are fitted and have a mask, evenly chosen, but for overexposed ones. Throws
/// ObservationError where all of them are.
std::vector<const optim::View*> ChooseViews(const optim::ObservationSet& all) {
  std::vector<const optim::View*> fit;
  for (const optim::View& view : all.views) {
    if (!view.validation && !view.mask.Empty()) fit.push_back(&view);
  }
  std::vector<const optim::View*> chosen;
  const std::size_t count = std::min(kTrialPhotos, fit.size());
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(fit[i * fit.size() / count]);
  std::erase_if(chosen, [](const optim::View* view) { return IsOverexposed(*view); });
  if (chosen.empty() && count > 0) {
    throw optim::ObservationError({"the object is clipped in the photos"});
  }
  return chosen;
}

/// Longer side of photos in which the object has as many pixels as its trial needs.
double TrialSide(const std::vector<const optim::View*>& views) {
  std::vector<double> sides;
  for (const optim::View* view : views) {
    const renderer::Image mask = view->mask.Unpack();
    const double object = std::accumulate(mask.data.begin(), mask.data.end(), 0.0);
    const double side = std::max(mask.width, mask.height);
    sides.push_back(side * std::sqrt(kTrialPixels / std::max(1.0, object)));
  }
  return std::clamp(renderer::Median(sides), kLeastTrialSide, kMostTrialSide);
}

/// As small as its trial needs it, once for all of them.
optim::View Reduced(const optim::View& view, const optim::ObservationSet& of, double trial_side) {
  const double side = std::max(view.camera.width, view.camera.height);
  const optim::ViewLevel level =
      optim::PackedLevel(view, of, std::min(1.0, trial_side / side)).Unpack();
  optim::View small = view;
  small.camera = level.camera;
  small.file_width = small.file_height = 0;
  small.photo = level.photo;
  small.mask = level.mask;
  small.straight_alpha = false;  // it is before black already
  if (!view.clipped.Empty()) small.clipped = level.clipped;
  return small;
}

/// With some of its photos alone, at least one.
FoundInput Reduced(const FoundInput& input, const std::vector<const optim::View*>& views) {
  FoundInput small = input;
  optim::ObservationSet& photos = small.observations;
  photos.views.clear();
  photos.black_background = true;
  const double side = TrialSide(views);
  for (const optim::View* view : views) photos.views.push_back(Reduced(*view, photos, side));
  photos.mask_erode_px = kTrialErosion;
  return small;
}

/// Meshes of a person may be finer than small photos show.
void Coarsen(std::vector<renderer::SceneMesh>& meshes) {
  for (renderer::SceneMesh& instance : meshes) {
    if (instance.mesh.triangles.size() <= kTrialTriangles) continue;
    try {
      instance.mesh = optim::Decimate(instance.mesh, kTrialTriangles);
      renderer::SetUniformVertexColors({0.5, 0.5, 0.5}, instance.mesh);
    } catch (const renderer::SceneError&) {  // parts that only touch: it takes longer
    }
  }
}

/// Fits drafts with different lights to a few small photos.
class LightTrial {
 public:
  /// `small`: of such photos.
  LightTrial(const FoundInput& small, const fs::path& mesh, const fs::path& config)
      : input_(small), mesh_(mesh), path_(config) {}

  /// PSNR of the photos as the draft with this light explains them, dB.
  double Explained(DraftLight light) {
    const std::string text = DraftConfig(input_, {light, ""}, path_, "draft", mesh_);
    const ExperimentConfig config =
        ReadExperimentConfig(ParseYaml(text, path_.string()), path_, {});
    Experiment experiment = BuildExperiment(config, input_.observations);
    if (start_.empty()) {
      static_cast<void>(CheckStart(config, experiment));  // is there anything to explain?
      start_ = experiment.scene.meshes;
      Coarsen(start_);
    }
    experiment.scene.meshes = start_;
    optim::FitSpec& fit = experiment.fit;
    optim::StageSpec lights = fit.stages.front();  // and exposures
    lights.max_rounds = kTrialRounds;
    lights.max_spp = kTrialSpp;
    optim::StageSpec all = lights;
    all.name = "all";
    for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
      if (fit.unknowns[i].kind == ParameterKind::kVertexColors) {
        all.free.push_back(static_cast<int>(i));
      }
    }
    fit.stages = {lights, all};
    optim::SilentObserver observer;
    return optim::RunFit(experiment.scene, experiment.observations, fit, observer, {})
        .stages.back()
        .psnr_linear_fit;
  }

 private:
  const FoundInput& input_;
  const fs::path& mesh_;
  const fs::path& path_;
  std::vector<renderer::SceneMesh> start_;  // of the first draft
};

}  // namespace

const char* WordOf(DraftLight light) {
  static constexpr std::array kWords = {"world", "camera", "flash"};
  return kWords[static_cast<std::size_t>(light)];
}

LightChoice LightAsSaid(DraftLight light) {
  return {light,
          light == DraftLight::kWorld    ? "as was said, the light stands still around the object"
          : light == DraftLight::kCamera ? "as was said, the light goes with the camera"
                                         : "as was said, a flash on the camera"};
}

std::optional<LightChoice> LightBySigns(const FoundInput& input) {
  const auto& observations = input.observations;
  if (observations.num_with_flash == static_cast<int>(observations.views.size())) {
    return LightChoice{input.layout ? DraftLight::kFlash : DraftLight::kCamera,
                       "a flash fired in all photos (EXIF): taken to be on the camera"};
  }
  if (input.background && input.background->ShowsThatItIsStill()) {
    return LightChoice{DraftLight::kCamera,
                       fmt::format("the background stays as it is (to {:.0f} %) while the view "
                                   "changes: the object turned, and the light goes with the camera",
                                   100.0 * input.background->change)};
  }
  return std::nullopt;
}

std::optional<LightChoice> LightByTrial(const FoundInput& input,
                                        const fs::path& mesh,
                                        const fs::path& config,
                                        std::string& problem) {
  if (input.options.masks.meaning != optim::MaskMeaning::kSilhouette) return std::nullopt;
  try {
    const std::vector<const optim::View*> views = ChooseViews(input.observations);
    if (views.empty()) return std::nullopt;
    const FoundInput small = Reduced(input, views);
    LightTrial trial(small, mesh, config);
    const double still = trial.Explained(DraftLight::kWorld);
    std::string compared =
        fmt::format("{} of {} small photos are explained to {:.1f} dB by light that stands still",
                    views.size(),
                    input.observations.views.size(),
                    still);
    // Light from all around that goes with the camera is that of a turntable, before which the
    // background stays.
    const bool may_be_turned = !input.background || input.background->IsStill();
    const bool may_be_flash =
        input.layout && !(input.background && input.background->ShowsThatItIsStill());
    const double turned = may_be_turned ? trial.Explained(DraftLight::kCamera) : still;
    if (!std::isfinite(still) || !std::isfinite(turned)) return std::nullopt;
    LightChoice choice{
        DraftLight::kWorld,
        fmt::format(": taken to stand still, as one that goes along must be {} dB better",
                    kClearlyBetter)};
    if (may_be_turned) {
      compared += fmt::format(", to {:.1f} dB by light that goes with the camera", turned);
      if (turned < still + kClearlyBetter) {
        choice.reason = compared + choice.reason;
        return choice;
      }
      choice = {DraftLight::kCamera, ": taken to go with it"};
    }
    double flash = still;
    if (may_be_flash) {
      flash = trial.Explained(DraftLight::kFlash);
      compared += fmt::format(", to {:.1f} dB by a flash on it", flash);
      const double least = may_be_turned ? turned + kSlightlyBetter : still + kClearlyBetter;
      if (flash > least) {
        if (!std::isfinite(flash)) return std::nullopt;
        choice = {DraftLight::kFlash, ": taken for one"};
      }
    }
    choice.reason = compared + choice.reason;
    const double best = std::max({still, turned, flash});
    if (best < kDoubtful) {
      choice.reason +=
          ", though none explains them well (clipped or dark photos, masks or cameras that are "
          "off)";
    }
    return choice;
  } catch (const std::runtime_error& error) {
    problem = error.what();
    return std::nullopt;
  }
}

LightChoice UsualLight(const FoundInput& input) {
  if (!input.background) {
    return {DraftLight::kWorld,
            "nothing tells whether the light goes with the camera; taken to stand still around the "
            "object (init --light camera or flash says otherwise)"};
  }
  if (input.background->IsStill()) {
    return {DraftLight::kCamera,
            fmt::format("the background stays as it is (to {:.0f} %), though little is in it: the "
                        "object is taken to have turned, and the light to go with the camera (init "
                        "--light world or flash says otherwise)",
                        100.0 * input.background->change)};
  }
  return {DraftLight::kWorld,
          fmt::format("the background changes from photo to photo (by {:.0f} %): the camera went "
                      "round the object, taken to be in light that stood still (with a flash on "
                      "the camera: init --light flash)",
                      100.0 * input.background->change)};
}

}  // namespace pathfit::app
