#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/run_scene.h"
#include "app/config/near_path.h"
#include "app/config/nearest_name.h"
#include "app/output/coarse_asset.h"
#include "app/output/export_blender.h"
#include "app/output/export_cameras.h"
#include "app/output/fields.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app::export_command {
namespace {

namespace fs = std::filesystem;
using Files = std::vector<fs::path>;

/// Names of the photos, where they are, seen from a folder, and their cameras.
struct Photos {
  std::vector<std::string> names, paths;
  std::vector<renderer::Camera> cameras;
};
Photos PhotosOf(const RunScene& loaded, const fs::path& folder) {
  const std::vector<ExportedView> views = ExportedViews(loaded.experiment, loaded.config);
  Photos photos;
  photos.cameras = CamerasOfPhotos(loaded.experiment.scene, views);
  for (const ExportedView& view : views) {
    photos.names.push_back(view.name);
    photos.paths.push_back(NearPath(view.image_path, folder).generic_string());
  }
  return photos;
}

template <MeshFormat kFormat>
Files WriteMeshesAs(const fs::path& folder, const RunScene& loaded, Log& /*log*/) {
  const renderer::Scene& scene = loaded.experiment.scene;
  const double metres_per_unit = loaded.experiment.observations.metres_per_unit;
  Files written = WriteMeshes(folder, scene, kFormat, metres_per_unit);
  if (kFormat == MeshFormat::kGlb && !scene.meshes.empty()) {
    written.push_back(WriteSceneGlb(folder, scene, metres_per_unit));
  }
  return written;
}

Files WriteColmap(const fs::path& folder, const RunScene& loaded, Log& log) {
  const Photos photos = PhotosOf(loaded, folder);
  if (const std::string lost = LostInColmap(photos.cameras); !lost.empty()) log.Warn(lost);
  const ColmapText text = ColmapModel(photos.cameras, photos.names);
  const std::array<std::pair<const char*, const std::string*>, 3> files = {
      {{"cameras.txt", &text.cameras},
       {"images.txt", &text.images},
       {"points3D.txt", &text.points}}};
  Files written;
  for (const auto& [name, content] : files) {
    written.push_back(folder / name);
    renderer::WriteFileAtomically(written.back(), *content);
  }
  return written;
}

Files WriteTransforms(const fs::path& folder, const RunScene& loaded, Log& /*log*/) {
  const fs::path path = folder / "transforms.json";
  const Photos photos = PhotosOf(loaded, folder);
  renderer::WriteFileAtomically(
      path,
      TransformsJson(photos.cameras, photos.paths, loaded.experiment.observations.metres_per_unit));
  return {path};
}

Files WriteBlender(const fs::path& folder, const RunScene& loaded, Log& log) {
  const renderer::Scene& scene = loaded.experiment.scene;
  Files written = WriteMeshes(folder, scene, MeshFormat::kGlb);
  std::vector<std::string> names;
  for (const fs::path& mesh : written) names.push_back(mesh.filename().string());
  const fs::path script = folder / "blender_setup.py";
  renderer::WriteFileAtomically(script,
                                BlenderScript(scene, names, loaded.config.render.max_bounces));
  for (const std::string& gap : BlenderGaps(scene)) log.Warn(gap);
  const Files environment = WriteEnvironment(folder, scene);
  written.insert(written.end(), environment.begin(), environment.end());
  written.insert(written.begin(), script);
  return written;
}

struct ExportFormat {
  const char* word;
  bool has_meshes;
  Files (*write)(const fs::path& folder, const RunScene& loaded, Log& log);
};
template <std::size_t kIndex>
constexpr ExportFormat kMeshRow = {
    kMeshFormats[kIndex].first, true, WriteMeshesAs<kMeshFormats[kIndex].second>};
static_assert(kMeshFormats.size() == 3);
constexpr std::array<ExportFormat, 6> kFormats = {{kMeshRow<0>,
                                                   kMeshRow<1>,
                                                   kMeshRow<2>,
                                                   {"colmap", false, WriteColmap},
                                                   {"transforms", false, WriteTransforms},
                                                   {"blender", true, WriteBlender}}};

/// "glb,obj" and so on: what --to may hold.
std::string FormatWords() { return TypeOfWords(kFormats, ',', &ExportFormat::word); }

struct Options {
  std::vector<std::string> formats;
  std::string stage;
  fs::path output;
  int triangles = 0;  ///< 0: all
};

bool Wants(const Options& own, const ExportFormat& format) {
  return std::ranges::find(own.formats, format.word) != own.formats.end();
}

void Declare(OptionList& options, Options& own) {
  options.Threads();
  options.List("--to", FormatWords(), "Formats, one or more", own.formats);
  options.Text(
      "--stage", "STAGE", "State at the end of a stage, or start; else the newest", own.stage);
  options.Path(
      "-o,--output",
      "DIR",
      "Folder for the files, with one of its own for each format if there are several; else "
      "export/FORMAT in the run",
      own.output);
  options.Whole("--triangles",
                "Of each mesh at most; what it loses becomes textures, its shape a normal texture",
                4,
                100000000,
                own.triangles);
  options.Check([&options, &own] {
    const bool has_meshes = std::ranges::any_of(kFormats, [&](const ExportFormat& format) {
      return format.has_meshes && Wants(own, format);
    });
    if (own.triangles > 0 && !own.formats.empty() && !has_meshes) {
      options.Fail("--triangles has no use with " + JoinNames(own.formats) +
                   ", which has no meshes");
    }
    if (own.formats.empty()) {
      options.Fail("--to is missing; give one of: " + JoinNames(WordsOfType(FormatWords())));
    }
  });
}

constexpr ResultKey kResult[] = {{"files", "map", "Paths that were written, by format"}};

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  RunScene loaded = LoadRunScene(context, line.target, own.stage);
  if (own.triangles > 0) {
    CoarseAsset asset = MakeCoarseAsset(loaded.experiment.scene, own.triangles);
    for (const std::string& text : asset.messages) context.log.Info(text);
    loaded.experiment.scene = std::move(asset.scene);
  }
  Json json = Json::object();
  // Formats have files of the same name, GLB meshes in metres and those for Blender.
  const bool apart = own.output.empty() || std::ranges::count_if(kFormats, [&](const auto& format) {
                                             return Wants(own, format);
                                           }) > 1;
  const fs::path output =
      fs::absolute(own.output.empty() ? loaded.run.root() / "export" : own.output);
  for (const ExportFormat& format : kFormats) {
    if (!Wants(own, format)) continue;
    const fs::path folder = (apart ? output / format.word : output).lexically_normal();
    renderer::CreateFolders(folder);
    for (const fs::path& file : format.write(folder, loaded, context.log)) {
      json[format.word].push_back(file.string());
      if (!line.json) fmt::print("{}\n", file.string());
    }
  }
  if (line.json) PrintResult(context, {{"files", std::move(json)}});
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kExportCommand = {"export",
                                       "Writes a run's result in other formats",
                                       "RUN",
                                       Prepare<Options, Declare, Run>,
                                       kResult};

}  // namespace pathfit::app::export_command
