#include "optim/observation/camera_import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <system_error>

#include "renderer/core/check.h"
#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using renderer::Cross;
using renderer::Dot;
using renderer::IoError;
using renderer::Mat3;

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

fs::path FindTransforms(const fs::path& path, bool is_named) {
  if (IsFile(path)) return is_named || path.extension() == ".json" ? path : fs::path();
  return IsFile(path / "transforms.json") ? path / "transforms.json" : fs::path();
}

/// cameras.bin or cameras.txt at the path, or where a COLMAP workspace keeps its model. As in
/// COLMAP the binary one comes first, unless a text file was named.
fs::path FindColmap(const fs::path& path, bool /*is_named*/) {
  const bool is_file = IsFile(path);
  const fs::path top = is_file ? path.parent_path() : path;
  for (const fs::path& folder : {top, top / "sparse" / "0", top / "sparse"}) {
    for (const char* name : {"cameras.bin", "cameras.txt"}) {
      const fs::path found = folder / name;
      if (IsFile(found) &&
          !(is_file && path.extension() == ".txt" && found.extension() != ".txt")) {
        return found;
      }
    }
  }
  return {};
}

/// A kind of camera file. A new one is a reader, its row here and its source in CMake.
struct CameraFormat {
  std::string_view word;    ///< in the config: "colmap"
  std::string_view name;    ///< for people: "COLMAP model"
  std::string_view wanted;  ///< what must be there, for people
  /// What `read` takes if `path` (file or folder) is of this kind, else empty. `is_named`: this
  /// format was asked for, so that unusual file names are fine.
  std::filesystem::path (*find)(const std::filesystem::path& path, bool is_named);
  ImportedCameras (*read)(const std::filesystem::path& path);
};

constexpr std::array<CameraFormat, 2> kFormats = {{
    {"transforms",
     "transforms.json",
     "transforms.json (or another .json file)",
     FindTransforms,
     ReadTransformsJson},
    {"colmap",
     "COLMAP model",
     "cameras.bin or cameras.txt of a COLMAP model (here, in sparse/0 or in sparse)",
     FindColmap,
     ReadColmapModel},
}};

constexpr double kRotationTolerance = 1e-4;
/// What rounding leaves of a rotation: nothing to mend.
constexpr double kRounding = 4e-15;
/// The error squares each time: 1e-4 is far below rounding after three.
constexpr int kPolarIterations = 6;

}  // namespace

std::vector<std::string> CameraFormatWords() {
  std::vector<std::string> words = {"auto"};
  for (const CameraFormat& format : kFormats) words.emplace_back(format.word);
  return words;
}

bool HasCameras(const fs::path& path) {
  return std::ranges::any_of(
      kFormats, [&](const CameraFormat& format) { return !format.find(path, false).empty(); });
}

ImportedCameras ImportCameras(const fs::path& path, std::string_view word) {
  std::error_code ignored;
  if (path.empty() || !fs::exists(path, ignored)) {
    throw IoError(path.string() + ": no such camera file or folder");
  }
  std::string missing;
  for (const CameraFormat& format : kFormats) {
    if (word != "auto" && word != format.word) continue;
    if (const fs::path found = format.find(path, word == format.word); !found.empty()) {
      ImportedCameras cameras = format.read(found);
      cameras.format = format.name;
      return cameras;
    }
    missing += (missing.empty() ? ": there is no " : ", and no ") + std::string(format.wanted);
  }
  PATHFIT_CHECK(!missing.empty());
  throw IoError(path.string() + missing);
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

Mat3 ExactRotation(const Mat3& matrix, const std::string& place) {
  const double error = std::max({std::abs(Dot(matrix.x, matrix.x) - 1.0),
                                 std::abs(Dot(matrix.y, matrix.y) - 1.0),
                                 std::abs(Dot(matrix.z, matrix.z) - 1.0),
                                 std::abs(Dot(matrix.x, matrix.y)),
                                 std::abs(Dot(matrix.y, matrix.z)),
                                 std::abs(Dot(matrix.z, matrix.x))});
  const double determinant = Determinant(matrix);
  if (!(error <= kRotationTolerance) || determinant <= 0.0) {
    char text[200];
    std::snprintf(text,
                  sizeof text,
                  ": the rotation part is not a rotation (columns and their products are off by "
                  "%.3g, determinant "
                  "%.6g; allowed: 1e-4, +1)",
                  error,
                  determinant);
    throw IoError(place + text);
  }
  if (error <= kRounding) return matrix;  // so that what we wrote is read to the same bits
  Mat3 rotation = matrix;
  for (int i = 0; i < kPolarIterations; ++i) {
    // Newton's iteration for the polar factor: R <- (R + R^-T) / 2, the cofactors being the inverse
    // transpose.
    const double scale = 0.5 / Determinant(rotation);
    rotation = {rotation.x * 0.5 + Cross(rotation.y, rotation.z) * scale,
                rotation.y * 0.5 + Cross(rotation.z, rotation.x) * scale,
                rotation.z * 0.5 + Cross(rotation.x, rotation.y) * scale};
  }
  return rotation;
}

renderer::Vec3 CheckedCentre(const renderer::Vec3& centre, const std::string& place) {
  if (!renderer::IsWithinBounds(centre)) {
    throw IoError(place + ": the camera's centre has a coordinate beyond 1e12");
  }
  return centre;
}

}  // namespace pathfit::optim
