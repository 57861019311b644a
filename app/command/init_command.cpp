#include <cstdio>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/config/experiment_config.h"
#include "app/experiment/draft_config.h"
#include "app/output/fields.h"
#include "app/output/run_directory.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/gltf_reader.h"
#include "renderer/io/mesh_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

/// Of the folder that holds everything.
std::string NameOf(const FoundInput& input) {
  fs::path folder = input.options.images_dir;
  for (const char* usual : {"images", "image", "photos", "rgb", "input"}) {
    if (folder.filename() == usual) {
      folder = folder.parent_path();
      break;
    }
  }
  return SafeFileName(folder.filename().string());
}

Json Describe(const FoundInput& input, const fs::path& config, const std::string& name) {
  const auto& masks = input.options.masks;
  return {{"config", config.string()},
          {"name", name},
          {"photos", input.observations.views.size()},
          {"photos_without_camera", input.num_without_camera},
          {"images", input.options.images_dir.string()},
          {"cameras", input.options.cameras.string()},
          {"camera_format", input.camera_format},
          {"masks", input.num_masks},
          {"masks_inverted", masks.invert},
          {"background_change",
           input.background_change ? ToJson(*input.background_change) : Json(nullptr)},
          {"seen", input.observations.assumptions},
          {"guessed", Json::array({LightGuess(input)})}};
}

void Declare(OptionList& options, CommandLine& line) {
  options.Threads();
  options.Path("-o,--output", "FILE", "Config to write; else NAME.yaml here", line.output);
  options.Path("--masks", "DIR", "Folder of the masks, if it is not found", line.masks);
  options.Path("--mesh", "FILE", "Start mesh, in the frame of the cameras", line.mesh);
  options.Flag("--force", "Overwrites an existing file", line.force);
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
    {"background_change",
     "number or null",
     "Share by which the background differs from photo to photo; null without masks"},
    {"seen", "list", "What was found, in words"},
    {"guessed", "list", "What was guessed, in words"}};

ExitStatus Run(CommandContext& context) {
  const CommandLine& line = context.line;
  const renderer::ThreadLimit limit(NumThreads(line, 0));
  if (!line.mesh.empty()) {  // refuses what is none
    if (renderer::IsGltfPath(line.mesh)) {
      static_cast<void>(renderer::ReadGltf(line.mesh));
    } else {
      static_cast<void>(renderer::ReadMesh(line.mesh));
    }
  }
  const fs::path first = line.targets.empty() ? fs::path(".") : line.targets[0];
  // A camera file alone says where its photos are.
  const bool is_file = fs::is_regular_file(first);
  const FoundInput input = FindInput({.photos = is_file ? first.parent_path() : first,
                                      .cameras = line.targets.size() > 1 ? line.targets[1]
                                                 : is_file               ? first
                                                                         : fs::path(),
                                      .masks = line.masks});
  const std::string name = NameOf(input);
  const fs::path config =
      fs::absolute(line.output.empty() ? fs::path(name + ".yaml") : line.output);
  const std::string text =
      DraftConfig(input,
                  config.lexically_normal(),
                  name,
                  line.mesh.empty() ? fs::path() : fs::absolute(line.mesh).lexically_normal());
  if (fs::exists(config) && !line.force) {
    throw UsageError("init",
                     config.string() + " exists; -o names another file, --force overwrites");
  }
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
        "no masks were found: the background is fitted, too; masks of the object make its shape "
        "far surer");
  }
  context.log.Info("guess: " + LightGuess(input));
  context.log.Info(fmt::format("next: pathfit check {0}, then pathfit fit {0}", config.string()));
  if (line.json) {
    PrintResult(context, Describe(input, config, name));
  } else {
    fmt::print("{}\n", config.string());
  }
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kInitCommand = {"init",
                                     "Writes a config for photos and cameras that it finds",
                                     "[PHOTOS] [CAMERAS]",
                                     Declare,
                                     Run,
                                     kResult};

}  // namespace pathfit::app
