#include <cstdio>

#include <fmt/format.h>

#include "app/command/colmap_run.h"
#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/video_frames.h"
#include "app/config/experiment_config.h"
#include "app/experiment/draft_config.h"
#include "app/experiment/folder_search.h"
#include "app/experiment/lamp_draft.h"
#include "app/experiment/lamp_input.h"
#include "app/experiment/light_choice.h"
#include "app/output/fields.h"
#include "app/output/run_directory.h"
#include "app/output/terminal.h"
#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"
#include "renderer/core/parallel.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_file.h"
#include "renderer/io/ply_file.h"

namespace pathfit::app::init_command {
namespace {

namespace fs = std::filesystem;

bool IsVideo(const fs::path& path) { return HasVideoExtension(path) && !fs::is_directory(path); }

/// Of the folder that holds everything, or the video.
std::string NameOf(fs::path folder) {
  if (IsVideo(folder)) return SafeFileName(folder.stem().string());
  for (const char* usual : {"images", "image", "photos", "rgb", "input"}) {
    if (folder.filename() == usual) {
      folder = folder.parent_path();
      break;
    }
  }
  return SafeFileName(folder.filename().string());
}

Json Describe(const FoundInput& input,
              const LightChoice& light,
              DraftSurface surface,
              const fs::path& config,
              const std::string& name) {
  const auto& masks = input.options.masks;
  return {
      {"config", config.string()},
      {"name", name},
      {"photos", input.observations.views.size()},
      {"photos_without_camera", input.num_without_camera},
      {"images", input.options.images_dir.string()},
      {"cameras", input.options.cameras.string()},
      {"camera_format", input.camera_format},
      {"masks", input.num_masks},
      {"masks_inverted", masks.invert},
      {"mask_agreement", input.mask_agreement ? ToJson(*input.mask_agreement) : Json(nullptr)},
      {"start_of_points", input.start_of_points},
      {"background_change", input.background ? ToJson(input.background->change) : Json(nullptr)},
      {"light", WordOf(light.light)},
      {"surface", WordOf(surface)},
      {"seen", input.observations.assumptions},
      {"guessed", Json::array({light.reason})}};
}

constexpr int kMostFrames = 5000;

struct Options {
  fs::path output, masks, mesh, calibration, lamps, ball;
  std::string sfm;      ///< program that finds the cameras; empty: none
  std::string light;    ///< word of a DraftLight; empty: found
  std::string surface;  ///< "matt", "shiny", "metal"; empty: matt
  int frames = 60;
  bool whole = false;
  bool force = false;
};

/// The config to write.
fs::path ConfigOf(const Options& own, const std::string& name) {
  return fs::absolute(own.output.empty() ? fs::path(name + ".yaml") : own.output)
      .lexically_normal();
}

void Declare(OptionList& options, Options& own) {
  options.Threads();
  options.Path("-o,--output", "FILE", "Config to write; else NAME.yaml here", own.output);
  options.Word(
      "--sfm", "colmap", "Finds the cameras with this program, which must be installed", own.sfm);
  options.Whole("--frames",
                "Of a video in place of the photos: so many of its frames are taken by ffmpeg, "
                "which must be installed, and their cameras found by COLMAP; 60 unless given",
                kFewestPhotosOfColmap,
                kMostFrames,
                own.frames);
  options.Check([&options, &own] {
    const bool is_video = !options.line().targets.empty() && IsVideo(options.line().target);
    if (is_video) own.sfm = "colmap";
    if (!is_video && options.Given("--frames")) {
      options.Fail("--frames are those of a video, which is not given");
    }
  });
  options.Path("--masks",
               "DIR|FILE",
               "Folder of the masks, or one mask of all photos, if it is not found",
               own.masks);
  options.Path("--calibration",
               "FILE",
               "OpenCV calibration of the camera, in place of what the camera file says of it",
               own.calibration);
  options.Word("--light",
               "world|camera|flash",
               "Whether it stood still around the object, went with the camera from all around "
               "(turntable), or is a flash on it; else a few small photos are tried with each",
               own.light);
  options.Word("--surface",
               "matt|shiny|metal",
               "Whether the object has highlights: then its roughness is an unknown, and the light "
               "finer; those of a metal have its colour. Matt unless given",
               own.surface);
  options.Path("--lamps",
               "FILE",
               "One camera stood still, each photo has a far lamp of its own: their directions, "
               "x right, y up, z to the camera (LP file, or rows \"x y z [strength]\")",
               own.lamps);
  options.Path("--ball",
               "DIR|FILE",
               "In place of --lamps, the same by the highlights of a shiny ball: the folder of its "
               "photos under the same lamps with a mask, or its mask in the photos themselves",
               own.ball);
  options.Path("--mesh", "FILE", "Start mesh, in the frame of the cameras", own.mesh);
  options.Flag("--whole-photos",
               "Makes no masks, and no start from sparse points, where there are no masks: the "
               "background is fitted, too",
               own.whole);
  options.Flag("--force", "Overwrites an existing file", own.force);
}

constexpr ResultKey kResult[] = {
    {"config", "text", "The config that was written"},
    {"name", "text", "Of runs"},
    {"photos", "whole", "Number of photos with a camera"},
    {"photos_without_camera", "whole", ""},
    {"images", "text", "Folder of the photos"},
    {"cameras", "text", "Camera file or folder"},
    {"camera_format", "text", ""},
    {"masks", "whole", "Number of photos with a mask"},
    {"masks_inverted", "boolean", "White along the border, so taken as the background"},
    {"mask_agreement",
     "number or null",
     "Share by which masks that were made overlap with the body they agree on; null: none were"},
    {"start_of_points",
     "boolean",
     "Whether the start is what the sparse points of the cameras lie on, and masks are where it is "
     "seen"},
    {"background_change",
     "number or null",
     "Share by which the background differs from photo to photo; null without masks"},
    {"light",
     "text",
     "Of the draft: world (stands still), camera (goes with it), flash, or lamps (one per photo)"},
    {"surface", "text", "Of the draft: matt, shiny or metal"},
    {"seen", "list", "What was found, in words"},
    {"guessed", "list", "What was guessed, in words"}};

void RefuseToOverwrite(const fs::path& path, const Options& own) {
  if (!fs::exists(path) || own.force) return;
  throw UsageError("init", path.string() + " exists; -o names another file, --force overwrites");
}

/// What to do with the config that was written, and the result.
void SayNext(const CommandContext& context, const fs::path& config, const Json& result) {
  context.log.Info(fmt::format("next: pathfit check {0}, then pathfit fit {0}", config.string()));
  if (context.line.json) {
    PrintResult(context, result);
  } else {
    fmt::print("{}\n", config.string());
  }
}

/// What init makes beside the config: "axe_masks" of axe.yaml.
fs::path BesideConfig(const fs::path& config, const char* what) {
  return config.parent_path() / (config.stem().string() + "_" + what);
}

/// Where COLMAP found cameras, for the photos in `photos` or the frames of that video; its
/// workspace is beside the config. Model empty: a signal came.
ColmapResult FindCamerasByColmap(const fs::path& photos,
                                 const fs::path& config,
                                 const StopSignals& signals,
                                 const Options& own,
                                 CommandContext& context) {
  const bool is_video = IsVideo(photos);
  if (context.line.targets.size() > 1 || (fs::is_regular_file(photos) && !is_video)) {
    throw UsageError("init", "--sfm finds the cameras; give the folder of the photos alone");
  }
  const fs::path workspace = BesideConfig(config, "colmap");
  const fs::path frames = BesideConfig(config, "frames");
  for (const fs::path& path : {config, workspace}) RefuseToOverwrite(path, own);
  if (is_video) {
    RefuseToOverwrite(frames, own);
    if (!TakeFrames({photos, frames, own.frames}, signals, context)) return {};
  }
  fs::remove_all(workspace / "sparse");
  fs::remove(workspace / "database.db");
  return RunColmap(
      {is_video ? frames : photos, own.masks, own.calibration, workspace}, signals, context);
}

/// For photos without masks, in a folder beside the config.
void TryToMakeMasks(const fs::path& config,
                    const Options& own,
                    CommandContext& context,
                    FoundInput& input) {
  const fs::path folder = BesideConfig(config, "masks");
  RefuseToOverwrite(folder, own);
  context.log.Info("no masks were found: the object is told from its background by colour");
  if (MakeMasks(folder, input)) {
    context.log.Warn(fmt::format(
        "masks were made from colours and what all photos say together (they overlap by {:.0f} %): "
        "{}. Look at them (check draws their outlines) and correct them with any paint program; "
        "init --whole-photos makes none",
        100.0 * *input.mask_agreement,
        folder.string()));
  }
}

/// For photos whose colours tell no object: the start mesh, if sparse points tell one; else empty.
fs::path TryToStartFromPoints(const fs::path& config,
                              const Options& own,
                              CommandContext& context,
                              FoundInput& input) {
  if (input.points.empty()) return {};
  const fs::path mesh = BesideConfig(config, "start.ply");
  const fs::path folder = BesideConfig(config, "region");
  for (const fs::path& path : {mesh, folder}) RefuseToOverwrite(path, own);
  try {
    if (!MakeStart(mesh, folder, input)) return {};
  } catch (const renderer::IoError& error) {
    context.log.Warn(std::string("the sparse points of the cameras are of no use: ") +
                     error.what());
    return {};
  }
  context.log.Warn(fmt::format(
      "colours do not tell the object from its background, so the start is what the sparse points "
      "of the cameras lie on: {}; only where it is seen photos count: {}. Masks of the object tell "
      "its outline, too; init --whole-photos makes neither",
      mesh.string(),
      folder.string()));
  return mesh;
}

/// Of a person at a terminal; else, and without an answer, empty.
std::optional<LightChoice> AskForLight(const CommandContext& context, const FoundInput& input) {
  if (context.line.json || !IsAtTerminal()) return std::nullopt;
  const std::string answer = renderer::LowerCase(Ask(fmt::format(
      "Did the light stand still around the object [w], {}go with the camera, as where the object "
      "turned before both [c]{}? [Enter: photos do not say] ",
      input.layout ? "" : "or ",
      input.layout ? ", or is it a flash on the camera [f]" : "")));
  for (const DraftLight light : kDraftLights) {
    const bool is_possible = input.layout || light != DraftLight::kFlash;
    if (is_possible && answer.starts_with(WordOf(light)[0])) return LightAsSaid(light);
  }
  return std::nullopt;
}

/// By what a person or the photos say, or a trial.
LightChoice ChooseLight(const CommandContext& context,
                        const Options& own,
                        const FoundInput& input,
                        const fs::path& mesh,
                        const fs::path& config) {
  for (const DraftLight light : kDraftLights) {
    if (own.light == WordOf(light)) return LightAsSaid(light);
  }
  if (const auto choice = LightBySigns(input)) return *choice;
  if (input.options.masks.meaning == optim::MaskMeaning::kSilhouette) {
    context.log.Info("small photos tell whether the light stood still or went with the camera");
  }
  std::string problem;
  if (const auto choice = LightByTrial(input, mesh, config, problem)) return *choice;
  if (!problem.empty()) context.log.Warn("small photos cannot be fitted: " + problem);
  if (const auto choice = AskForLight(context, input)) return *choice;
  return UsualLight(input);
}

Json Describe(const FoundLamps& found,
              const LampDraftFiles& files,
              DraftSurface surface,
              const std::string& name) {
  return {{"config", files.config.string()},
          {"name", name},
          {"photos", found.lamps.size()},
          {"photos_without_camera", 0},
          {"images", found.options.images_dir.string()},
          {"cameras", ""},
          {"camera_format", ""},
          {"masks", found.lamps.size()},
          {"masks_inverted", false},
          {"mask_agreement", nullptr},
          {"start_of_points", false},
          {"background_change", nullptr},
          {"light", "lamps"},
          {"surface", WordOf(surface)},
          {"seen", found.observations.assumptions},
          {"guessed", found.guesses}};
}

/// What says how several cameras or one light are found means nothing where each photo has a lamp.
void RefuseBesideLamps(const CommandContext& context, const Options& own) {
  const auto refuse = [](bool given, const char* option) {
    if (given) {
      throw UsageError(
          "init",
          std::string(option) +
              " does not go with --lamps or --ball: one camera stood still, and each photo has "
              "a lamp of its own");
    }
  };
  refuse(!own.sfm.empty(), "--sfm");
  refuse(!own.light.empty(), "--light");
  refuse(!own.calibration.empty(), "--calibration");
  refuse(own.whole, "--whole-photos");
  refuse(context.line.targets.size() > 1, "a file of cameras");
  if (!own.lamps.empty() && !own.ball.empty()) {
    throw UsageError("init", "--lamps and --ball say the same in two ways; give one");
  }
}

/// Photos by one camera, each under a lamp of its own.
ExitStatus RunWithLamps(CommandContext& context, const Options& own, LampPlaces places) {
  const std::string name = NameOf(AbsolutePath(places.photos));
  LampDraftFiles files;
  files.config = ConfigOf(own, name);
  const std::string base = (files.config.parent_path() / files.config.stem()).string();
  files.mesh =
      own.mesh.empty() ? fs::path(base + "_start.ply") : fs::absolute(own.mesh).lexically_normal();
  // One that was made before may have been corrected since.
  files.mask = base + "_mask.png";
  if (places.mask.empty() && fs::exists(files.mask)) {
    places.mask = files.mask;
    context.log.Info("the mask is " + files.mask.string() + ", which is there");
  }
  RefuseToOverwrite(files.config, own);
  if (own.mesh.empty()) RefuseToOverwrite(files.mesh, own);
  const FoundLamps found = FindLamps(places);
  if (!found.mask_made) files.mask = found.options.masks.folder;
  const std::string draft = DraftLampConfig(found, files, name, SurfaceOf(own.surface));
  if (own.mesh.empty()) renderer::WritePly(files.mesh, LampStart(found));
  if (found.mask_made) {
    renderer::WritePng8(files.mask, found.mask);
    context.log.Warn(
        fmt::format("a mask was made from brightness: {}. Look at it and correct it with any paint "
                    "program",
                    files.mask.string()));
  }
  renderer::WriteFileAtomically(files.config, draft);
  static_cast<void>(LoadExperimentConfig(files.config, {}));
  for (const std::string& seen : found.observations.assumptions) context.log.Info(seen);
  for (const std::string& guess : found.guesses) context.log.Info("guess: " + guess);
  SayNext(context, files.config, Describe(found, files, SurfaceOf(own.surface), name));
  return ExitStatus::kFinished;
}

/// The file of lamps that is given, or lies beside photos without cameras, unless something says
/// that they have some; else empty.
fs::path LampFile(const CommandContext& context, const Options& own, const fs::path& photos) {
  const bool may_be_found = own.sfm.empty() && own.ball.empty() && own.light.empty() &&
                            own.calibration.empty() && !own.whole &&
                            context.line.targets.size() < 2 && !fs::is_regular_file(photos);
  if (!own.lamps.empty() || !may_be_found) return own.lamps;
  const fs::path found = FindLampFile(photos);
  if (found.empty() || HasCamerasNear({.photos = photos})) return {};
  context.log.Info("each photo has a lamp of its own, of " + found.string() +
                   ", as there are no cameras");
  return found;
}

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  const renderer::ThreadLimit limit(NumThreads(line, 0));
  if (!own.mesh.empty()) {  // refuses what is none
    static_cast<void>(renderer::ReadMesh(own.mesh));
  }
  const fs::path first = line.targets.empty() ? fs::path(".") : line.targets[0];
  if (const fs::path lamps = LampFile(context, own, first); !lamps.empty() || !own.ball.empty()) {
    RefuseBesideLamps(context, own);
    return RunWithLamps(
        context, own, {.photos = first, .lamps = lamps, .ball = own.ball, .mask = own.masks});
  }
  // A camera file alone says where its photos are.
  const bool is_file = fs::is_regular_file(first);
  InputPlaces places{.photos = is_file ? first.parent_path() : first,
                     .cameras = line.targets.size() > 1 ? line.targets[1]
                                : is_file               ? first
                                                        : fs::path(),
                     .masks = own.masks,
                     .calibration = own.calibration};
  std::string name;
  if (!own.sfm.empty()) {
    const fs::path photos = AbsolutePath(first);
    name = NameOf(photos);
    const StopSignals signals;
    const ColmapResult found =
        FindCamerasByColmap(photos, ConfigOf(own, name), signals, own, context);
    if (found.model.empty()) return signals.Received().value_or(ExitStatus::kInterrupted);
    places.photos = found.photos;
    places.cameras = found.model;
  }
  FoundInput input = FindInput(places);
  if (own.light == WordOf(DraftLight::kFlash) && !input.layout) {
    throw UsageError(
        "init",
        "--light flash needs to know how far the object is, but the cameras look at no "
        "common point; take --light camera");
  }
  if (name.empty()) name = NameOf(input.options.images_dir);
  const fs::path config = ConfigOf(own, name);
  RefuseToOverwrite(config, own);
  const bool makes_masks = own.mesh.empty() && !own.whole;
  if (input.num_masks == 0 && makes_masks) {
    TryToMakeMasks(config, own, context, input);
  } else if (input.mask_agreement) {
    context.log.Warn("masks are those that an earlier init made from colours: " +
                     input.options.masks.folder.string() +
                     ". Look at them (check draws their outlines); without its made_masks.txt "
                     "they count as yours, and without the folder they are made anew");
  }
  fs::path mesh = own.mesh.empty() ? fs::path() : fs::absolute(own.mesh).lexically_normal();
  if (input.num_masks == 0 && makes_masks) {
    mesh = TryToStartFromPoints(config, own, context, input);
  }
  const LightChoice light = ChooseLight(context, own, input, mesh, config);
  const DraftSurface surface = SurfaceOf(own.surface);
  const std::string text = DraftConfig(input, light, config, name, mesh, surface);
  renderer::WriteFileAtomically(config, text);
  static_cast<void>(LoadExperimentConfig(config, {}));  // a draft that is refused is a mistake here

  for (const std::string& seen : input.observations.assumptions) context.log.Info(seen);
  if (input.num_without_camera > 0) {
    context.log.Warn(fmt::format("{} pictures in {} have no camera and are not used",
                                 input.num_without_camera,
                                 input.options.images_dir.string()));
  }
  if (input.num_masks == 0) {
    context.log.Warn(
        makes_masks
            ? "no masks were found, and neither colours nor sparse points tell the object from its "
              "background: that is fitted, too; masks of the object make its shape far surer"
            : "no masks: the background is fitted, too; masks of the object make its shape "
              "far surer");
  }
  context.log.Info("light: " + light.reason);
  SayNext(context, config, Describe(input, light, surface, config, name));
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kInitCommand = {"init",
                                     "Writes a config for photos, or a video, and cameras that it "
                                     "finds",
                                     "[PHOTOS] [CAMERAS]",
                                     Prepare<Options, Declare, Run>,
                                     kResult};

}  // namespace pathfit::app::init_command
