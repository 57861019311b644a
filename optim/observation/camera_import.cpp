#include "optim/observation/camera_import.h"

#include <cmath>
#include <system_error>

#include "renderer/core/check.h"
#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// The file itself, or transforms.json in a folder; empty if neither is there.
fs::path FindTransforms(const fs::path& path) {
  if (IsFile(path)) {
    return path;
  }
  return IsFile(path / "transforms.json") ? path / "transforms.json" : fs::path();
}

/// The folder of cameras.txt: the path, or where a COLMAP workspace keeps its model.
fs::path FindColmap(const fs::path& path) {
  for (const fs::path& folder : {path, path / "sparse" / "0", path / "sparse"}) {
    if (IsFile(folder / "cameras.txt")) {
      return folder;
    }
    if (IsFile(folder / "cameras.bin")) {
      throw IoError(
          (folder / "cameras.bin").string() +
          ": binary COLMAP models are not read; run: colmap model_converter --input_path " +
          folder.string() + " --output_path " + folder.string() + " --output_type TXT");
    }
  }
  return {};
}

}  // namespace

ImportedCameras ImportCameras(const fs::path& path, CameraFormat format) {
  std::error_code ignored;
  if (path.empty() || !fs::exists(path, ignored)) {
    throw IoError(path.string() + ": no such camera file or folder");
  }
  if (format != CameraFormat::kColmap) {
    const fs::path file = FindTransforms(path);
    if (!file.empty() && (format == CameraFormat::kTransforms || file.extension() == ".json")) {
      return ReadTransformsJson(file);
    }
  }
  if (format != CameraFormat::kTransforms) {
    const fs::path folder = FindColmap(IsFile(path) ? path.parent_path() : path);
    if (!folder.empty()) {
      return ReadColmapText(folder);
    }
  }
  switch (format) {
    case CameraFormat::kTransforms:
      throw IoError(path.string() + ": there is no transforms.json");
    case CameraFormat::kColmap:
      throw IoError(path.string() +
                    ": there is no cameras.txt (looked here, in sparse/0 and in sparse)");
    case CameraFormat::kAuto:
      break;
  }
  throw IoError(path.string() +
                ": neither a .json camera file nor a COLMAP text model (cameras.txt here, in "
                "sparse/0 or in sparse)");
}

renderer::Camera CompleteCamera(const ImportedCamera& imported, int width, int height) {
  PATHFIT_CHECK(width > 0 && height > 0);
  renderer::Camera camera = imported.camera;
  if (camera.width == 0) {
    camera.width = width;
    camera.height = height;
  }
  if (imported.view_angle_x > 0.0) {
    camera.fx = 0.5 * camera.width / std::tan(0.5 * imported.view_angle_x);
    camera.fy = camera.fx;
  }
  if (!imported.has_principal_point) {
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
  }
  return camera;
}

}  // namespace pathfit::optim
