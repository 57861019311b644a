#include <algorithm>
#include <array>
#include <cstdio>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/config/near_path.h"
#include "app/config/nearest_name.h"
#include "app/output/export_cameras.h"
#include "optim/observation/camera_import.h"
#include "optim/observation/photo_file.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app::convert_command {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;

/// Every format that is read, as a type of an option.
std::string FromWords() { return TypeOfWords(optim::CameraFormatWords(), '|', std::identity()); }

struct Cameras {
  std::vector<renderer::Camera> cameras;
  /// Of the photos: seen from the folder that holds them all, and from the folder of OUT.
  std::vector<std::string> names, paths;
};

/// The deepest folder above all of them; empty if there is none.
fs::path CommonFolder(const std::vector<fs::path>& files) {
  fs::path common = files.empty() ? fs::path() : files.front().parent_path();
  for (const fs::path& file : files) {
    while (!common.empty() && *file.lexically_relative(common).begin() == "..") {
      common = common == common.root_path() ? fs::path() : common.parent_path();
    }
  }
  return common;
}

/// Photos that are there get a path to them; the others stay called as they are.
Cameras Complete(const optim::ImportedCameras& imported,
                 const fs::path& photos,
                 const fs::path& folder) {
  Cameras result;
  std::vector<fs::path> found;
  for (const optim::ImportedCamera& camera : imported.cameras) {
    const optim::FileSearch photo = optim::FindPhoto(camera.image, imported, photos);
    int width = camera.camera.width;
    int height = camera.camera.height;
    if (width == 0) {  // only the photo knows
      if (!photo.found) {
        throw IoError(camera.place + ": says no size (w, h), and the photo " + camera.image +
                      " is not there to tell (tried: " + optim::TriedNames(photo) +
                      "); --images DIR names its folder");
      }
      const renderer::Image image = optim::ReadPhotoFile(*photo.found, {}).photo;
      width = image.width;
      height = image.height;
    }
    result.cameras.push_back(optim::CompleteCamera(camera, width, height));
    result.names.push_back(fs::path(camera.image).lexically_normal().generic_string());
    if (photo.found) found.push_back(fs::absolute(*photo.found).lexically_normal());
    result.paths.push_back(
        photo.found ? NearPath(fs::absolute(*photo.found), folder).generic_string() : camera.image);
  }
  if (found.size() < result.names.size()) return result;
  const fs::path common = CommonFolder(found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    result.names[i] = found[i].lexically_relative(common).generic_string();
  }
  return result;
}

struct Options {
  std::string from = "auto";
  std::string to;  ///< empty: by the name of the output
  fs::path images, calibration;
  bool force = false;
};

void Declare(OptionList& options, Options& own) {
  options.Word("--from", FromWords(), "Format of IN", own.from);
  options.Word(
      "--to",
      "transforms|colmap|list",
      "Format of OUT; else transforms for a .json file, list for a .yaml file, colmap for a folder",
      own.to);
  options.Path("--images", "DIR", "Folder of the photos, if IN does not lead there", own.images);
  options.Path("--calibration",
               "FILE",
               "OpenCV calibration of the camera, in place of what IN says of it",
               own.calibration);
  options.Flag("--force", "Overwrites existing files", own.force);
}

constexpr ResultKey kResult[] = {{"from", "text", "Format that was read"},
                                 {"to", "text", "Format that was written"},
                                 {"cameras", "whole", "Number of posed photos"},
                                 {"files", "list", "Paths that were written"}};

using TextFile = std::pair<fs::path, std::string>;

/// `file`: what they are called if the format has one, empty for the usual name in the folder.
std::vector<TextFile> FilesOf(const Cameras& cameras,
                              const std::string& format,
                              const fs::path& file,
                              const fs::path& folder,
                              double metres_per_unit) {
  const auto or_usual = [&](const char* name) { return file.empty() ? folder / name : file; };
  if (format == "transforms") {
    return {{or_usual("transforms.json"),
             TransformsJson(cameras.cameras, cameras.paths, metres_per_unit)}};
  }
  if (format == "list") {
    return {{or_usual("cameras.yaml"),
             CameraListYaml(cameras.cameras, cameras.paths, metres_per_unit)}};
  }
  const ColmapText text = ColmapModel(cameras.cameras, cameras.names);
  return {{folder / "cameras.txt", text.cameras},
          {folder / "images.txt", text.images},
          {folder / "points3D.txt", text.points}};
}

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  const fs::path out = fs::absolute(line.targets[2]).lexically_normal();
  const bool is_yaml = out.extension() == ".yaml" || out.extension() == ".yml";
  const std::string to = !own.to.empty()              ? own.to
                         : out.extension() == ".json" ? "transforms"
                         : is_yaml                    ? "list"
                                                      : "colmap";
  if (own.to.empty() && to == "colmap" && out.has_extension() && !fs::is_directory(out)) {
    throw UsageError("convert",
                     out.string() +
                         ": the ending says no format that is written; --to names one, and COLMAP "
                         "models are folders");
  }
  const bool is_file =
      (to == "transforms" && out.extension() == ".json") || (to == "list" && is_yaml);
  const fs::path folder = is_file ? out.parent_path() : out;
  if (!is_file && fs::exists(out) && !fs::is_directory(out)) {
    throw UsageError("convert", out.string() + " is a file, but " + to + " needs a folder");
  }
  optim::ImportedCameras imported = optim::ImportCameras(line.targets[1], own.from, own.images);
  if (!own.calibration.empty()) optim::UseCalibration(own.calibration, imported);
  for (const std::string& note : imported.notes) context.log.Info(note);
  const Cameras cameras =
      Complete(imported, own.images.empty() ? fs::path() : fs::absolute(own.images), folder);
  if (std::ranges::any_of(imported.cameras, [](const auto& c) { return !c.mask.empty(); })) {
    context.log.Warn("the masks that the file names are not written; copy them beside the photos");
  }
  if (to == "colmap" && imported.metres_per_unit > 0.0) {
    context.log.Warn(fmt::format("COLMAP models have no unit; that 1 unit is {} m is not written",
                                 imported.metres_per_unit));
  }
  const std::string lost = to == "colmap" ? LostInColmap(cameras.cameras) : "";
  if (!lost.empty()) context.log.Warn(lost);
  const std::vector<TextFile> files =
      FilesOf(cameras, to, is_file ? out : fs::path(), folder, imported.metres_per_unit);
  for (const auto& [path, text] : files) {
    if (fs::exists(path) && !own.force) {
      throw UsageError("convert", path.string() + " exists; --force overwrites it");
    }
  }
  renderer::CreateFolders(folder);
  Json written = Json::array();
  for (const auto& [path, text] : files) {
    renderer::WriteFileAtomically(path, text);
    written.push_back(path.string());
    if (!line.json) fmt::print("{}\n", path.string());
  }
  context.log.Info(fmt::format("{} cameras of {}", cameras.cameras.size(), imported.format));
  if (line.json) {
    PrintResult(context,
                {{"from", imported.format},
                 {"to", to},
                 {"cameras", cameras.cameras.size()},
                 {"files", std::move(written)}});
  }
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kConvertCommand = {"convert",
                                        "Writes the cameras of a file or folder in another format",
                                        "cameras IN OUT",
                                        Prepare<Options, Declare, Run>,
                                        kResult};

}  // namespace pathfit::app::convert_command
