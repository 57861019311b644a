#include "app/experiment/light_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/experiment/draft_config.h"
#include "app/experiment/experiment.h"
#include "optim/round/decimate.h"
#include "optim/round/fit.h"
#include "renderer/core/error.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using renderer::ParameterKind;

// Measured, light that goes with the camera against one that stands still, in dB: a flash 2.9, a
// turntable 2.2; a room in which the camera moved 0.3, renderings of one 0.0.
constexpr double kClearlyBetter = 1.0;
constexpr double kHardlyWorse = 0.5;
constexpr std::size_t kTrialPhotos = 24;
constexpr double kTrialSide = 64.0;  // pixels, the longer one
constexpr int kTrialErosion = 1;     // the start's outline is not yet that of the masks
constexpr int kTrialRounds = 20;
constexpr int kTrialSpp = 8;
constexpr int kTrialResolution = 32;  // of the hull, as fine as those photos
constexpr int kTrialTriangles = 2000;

/// As small as its trial needs it, once for all of them.
optim::View Reduced(const optim::View& view, const optim::ObservationSet& of) {
  const double side = std::max(view.camera.width, view.camera.height);
  const optim::ViewLevel level =
      optim::PackedLevel(view, of, std::min(1.0, kTrialSide / side)).Unpack();
  optim::View small = view;
  small.camera = level.camera;
  small.file_width = small.file_height = 0;
  small.photo = level.photo;
  if (!view.mask.Empty()) small.mask = level.mask;
  if (!view.clipped.Empty()) small.clipped = level.clipped;
  return small;
}

/// Of the photos that are fitted, evenly chosen.
optim::ObservationSet ForTrial(const optim::ObservationSet& all) {
  std::vector<const optim::View*> fitted;
  for (const optim::View& view : all.views) {
    if (!view.validation) fitted.push_back(&view);
  }
  optim::ObservationSet some = all;
  some.views.clear();
  some.black_background = all.mask_meaning == optim::MaskMeaning::kSilhouette;
  const std::size_t count = std::min(kTrialPhotos, fitted.size());
  for (std::size_t i = 0; i < count; ++i) {
    some.views.push_back(Reduced(*fitted[i * fitted.size() / count], some));
  }
  some.mask_erode_px = kTrialErosion;
  return some;
}

/// Meshes of a person may be finer than small photos show.
void Coarsen(renderer::Scene& scene) {
  for (renderer::SceneMesh& instance : scene.meshes) {
    if (instance.mesh.triangles.size() <= kTrialTriangles) continue;
    instance.mesh = optim::Decimate(instance.mesh, kTrialTriangles);
    renderer::SetUniformVertexColors({0.5, 0.5, 0.5}, instance.mesh);
  }
}

/// Keeps the figure that a trial is for.
class PsnrObserver final : public optim::FitObserver {
 public:
  void OnRound(const optim::RoundReport& /*report*/) override {}
  void OnView(const std::string& /*stage*/,
              std::size_t /*view*/,
              const renderer::Film& /*image*/,
              const optim::ViewLevel& /*observed*/) override {}
  void OnStage(const optim::StageReport& report) override { psnr_ = report.psnr_linear_fit; }
  void OnMessage(const std::string& /*text*/) override {}
  void OnWarning(const std::string& /*text*/) override {}
  [[nodiscard]] double psnr() const { return psnr_; }

 private:
  double psnr_ = 0.0;
};

/// PSNR of the photos as the draft with this light explains them, dB.
double Explained(const FoundInput& input, DraftLight light, const fs::path& mesh) {
  const fs::path path = fs::current_path() / "draft.yaml";  // is not written
  const std::string text = DraftConfig(input, {light, ""}, path, "draft", mesh);
  std::vector<ConfigOverride> overrides;
  if (mesh.empty()) {
    overrides.push_back(
        {"trial",
         fmt::format("scene.geometry.object.visual_hull.resolution={}", kTrialResolution)});
  }
  Experiment experiment = BuildExperiment(
      ReadExperimentConfig(ParseYaml(text, path.string()), path, overrides), input.observations);
  Coarsen(experiment.scene);
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
  PsnrObserver observer;
  optim::RunFit(experiment.scene, experiment.observations, fit, observer, {});
  return observer.psnr();
}

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

std::optional<LightChoice> LightByTrial(const FoundInput& input, const fs::path& mesh) {
  if (mesh.empty() && input.options.masks.meaning != optim::MaskMeaning::kSilhouette) {
    return std::nullopt;
  }
  FoundInput small = input;
  small.observations = ForTrial(input.observations);
  try {
    const double still = Explained(small, DraftLight::kWorld, mesh);
    const double moves = Explained(small, DraftLight::kCamera, mesh);
    const std::string compared = fmt::format(
        "{} of {} small photos are explained to {:.1f} dB by light that stands still, to {:.1f} dB "
        "by light that goes with the camera",
        small.observations.views.size(),
        input.observations.views.size(),
        still,
        moves);
    if (!std::isfinite(still) || !std::isfinite(moves)) return std::nullopt;
    if (moves < still + kClearlyBetter) {
      return LightChoice{DraftLight::kWorld, compared + ": taken to stand still"};
    }
    if (input.layout && !(input.background && input.background->IsStill())) {
      const double flash = Explained(small, DraftLight::kFlash, mesh);
      if (flash > moves - kHardlyWorse) {
        return LightChoice{
            DraftLight::kFlash,
            compared + fmt::format(" and to {:.1f} dB by a flash; the camera moved: taken for a "
                                   "flash on it",
                                   flash)};
      }
    }
    return LightChoice{DraftLight::kCamera, compared + ": taken to go with it"};
  } catch (const renderer::SceneError&) {
    return std::nullopt;  // check says what is wrong
  } catch (const renderer::NumericalError&) {
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
