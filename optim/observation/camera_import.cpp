#include "optim/observation/camera_import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <system_error>
#include <utility>

#include "optim/observation/photo_file.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"

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

/// Whether a file of this ending has the text in its beginning.
bool StartsWithText(const fs::path& path, std::string_view text) {
  constexpr std::size_t kBeginning = 4096;
  std::string start(kBeginning, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  return start.find(text) != std::string::npos;
}

/// Whether a line of the file is this key of the outermost map.
bool HasKey(const fs::path& path, std::string_view key) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    std::string_view rest = line;
    if (!rest.starts_with(key)) continue;
    rest.remove_prefix(key.size());
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
    if (rest.starts_with(':')) return true;
  }
  return false;
}

/// The file, or the first of these names in the folder, that passes.
template <class Passes>
fs::path FindFile(const fs::path& path,
                  std::initializer_list<const char*> names,
                  const Passes& passes) {
  if (IsFile(path)) return passes(path) ? path : fs::path();
  for (const char* name : names) {
    if (const fs::path file = path / name; IsFile(file) && passes(file)) return file;
  }
  return {};
}

fs::path FindAliceVision(const fs::path& path, bool is_named) {
  return FindFile(path, {"cameras.sfm", "sfm.json"}, [&](const fs::path& file) {
    const std::string ending = renderer::LowerCase(file.extension().string());
    return is_named || ending == ".sfm" ||
           (ending == ".json" &&
            (StartsWithText(file, "\"featuresFolders\"") || StartsWithText(file, "\"viewId\"")));
  });
}

fs::path FindTransforms(const fs::path& path, bool is_named) {
  return FindFile(path, {"transforms.json"}, [&](const fs::path& file) {
    return is_named || file.extension() == ".json";
  });
}

fs::path FindLlff(const fs::path& path, bool is_named) {
  return FindFile(path, {"poses_bounds.npy"}, [&](const fs::path& file) {
    return is_named || file.extension() == ".npy";
  });
}

bool IsXml(const fs::path& path) {
  return renderer::LowerCase(path.extension().string()) == ".xml";
}

fs::path FindMetashape(const fs::path& path, bool is_named) {
  return FindFile(path, {"cameras.xml"}, [&](const fs::path& file) {
    return is_named || (IsXml(file) && StartsWithText(file, "<document"));
  });
}

bool IsYaml(const fs::path& path) {
  const std::string ending = renderer::LowerCase(path.extension().string());
  return ending == ".yaml" || ending == ".yml";
}

fs::path FindList(const fs::path& path, bool is_named) {
  return FindFile(path, {"cameras.yaml", "cameras.yml"}, [&](const fs::path& file) {
    return is_named || (IsYaml(file) && HasKey(file, "cameras"));
  });
}

/// Only by its own name: most calibrations beside photos hold no poses.
fs::path FindOpencv(const fs::path& path, bool is_named) {
  return FindFile(path, {}, [&](const fs::path& file) {
    return is_named || IsYaml(file) || (IsXml(file) && StartsWithText(file, "<opencv_storage"));
  });
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
  /// `photos`: their folder, or empty.
  ImportedCameras (*read)(const std::filesystem::path& path, const std::filesystem::path& photos);
};

/// Of files that name their photos.
template <ImportedCameras (*kRead)(const fs::path&)>
ImportedCameras Named(const fs::path& path, const fs::path& /*photos*/) {
  return kRead(path);
}

constexpr std::array<CameraFormat, 7> kFormats = {{
    {"alicevision",
     "AliceVision SfM",
     "cameras.sfm or sfm.json of AliceVision (Meshroom)",
     FindAliceVision,
     Named<ReadAliceVisionSfm>},
    {"transforms",
     "transforms.json",
     "transforms.json (or another .json file)",
     FindTransforms,
     Named<ReadTransformsJson>},
    {"colmap",
     "COLMAP model",
     "cameras.bin or cameras.txt of a COLMAP model (here, in sparse/0 or in sparse)",
     FindColmap,
     Named<ReadColmapModel>},
    {"llff", "LLFF poses", "poses_bounds.npy of LLFF", FindLlff, ReadLlffPoses},
    {"metashape",
     "Metashape cameras",
     "cameras.xml of Metashape (or another .xml file)",
     FindMetashape,
     Named<ReadMetashapeXml>},
    {"list",
     "list of cameras",
     "cameras.yaml, a list of cameras (or another .yaml or .yml file that holds one)",
     FindList,
     Named<ReadCameraList>},
    {"opencv",
     "OpenCV calibration",
     "a .yaml, .yml or .xml file of an OpenCV calibration",
     FindOpencv,
     ReadOpencvCalibration},
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

std::string CameraFormatList() {
  std::string list;
  for (const CameraFormat& format : kFormats) {
    list += (list.empty() ? "" : ", ") + std::string(format.wanted);
  }
  return list;
}

std::vector<renderer::Vec3> ReadSparsePoints(const std::filesystem::path& path) {
  const std::filesystem::path ending = path.extension();
  return ending == ".bin" || ending == ".txt" ? ReadColmapPoints(path)
                                              : ReadAliceVisionPoints(path);
}

ImportedCameras ImportCameras(const fs::path& path, std::string_view word, const fs::path& photos) {
  std::error_code ignored;
  if (path.empty() || !fs::exists(path, ignored)) {
    throw IoError(path.string() + ": no such camera file or folder");
  }
  std::string missing;
  for (const CameraFormat& format : kFormats) {
    if (word != "auto" && word != format.word) continue;
    if (const fs::path found = format.find(path, word == format.word); !found.empty()) {
      ImportedCameras cameras = format.read(found, photos);
      cameras.format = format.name;
      return cameras;
    }
    missing += (missing.empty() ? ": there is no " : ", and no ") + std::string(format.wanted);
  }
  PATHFIT_CHECK(!missing.empty());
  throw IoError(path.string() + missing);
}

void UseCalibration(const fs::path& calibration, ImportedCameras& cameras) {
  const renderer::Camera lens = ReadOpencvIntrinsics(calibration);
  for (ImportedCamera& imported : cameras.cameras) {
    renderer::Camera& camera = imported.camera;
    camera.projection = lens.projection;
    camera.width = lens.width;
    camera.height = lens.height;
    camera.fx = lens.fx;
    camera.fy = lens.fy;
    camera.cx = lens.cx;
    camera.cy = lens.cy;
    camera.distortion = lens.distortion;
    imported.view_angle_x = imported.view_angle_y = 0.0;
    imported.has_principal_point = true;
  }
  cameras.pixel_shift = 0.5;
  cameras.files.push_back(calibration);
  std::string note =
      "Calibration: size, focal lengths, principal point and lens of all cameras are those of " +
      calibration.string() + ".";
  if (lens.width == 0) note += " It says no size: taken as that of the photos.";
  if (lens.distortion.IsNone()) note += " It says no distortion: rays are straight.";
  cameras.notes.push_back(std::move(note));
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
    camera.fy = imported.view_angle_y > 0.0
                    ? 0.5 * camera.height / std::tan(0.5 * imported.view_angle_y)
                    : camera.fx;
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

renderer::Transform PoseFromForwardAxes(const Mat3& rotation,
                                        const renderer::Vec3& centre,
                                        const std::string& place) {
  // Ours is turned by pi about x: y up, looking along -z.
  return {{rotation.x, -rotation.y, -rotation.z}, CheckedCentre(centre, place)};
}

std::vector<fs::path> PicturesOf(const fs::path& file, const fs::path& photos, std::size_t count) {
  std::vector<fs::path> pictures =
      PicturesIn(photos.empty() ? file.parent_path() / "images" : photos);
  if (photos.empty() && pictures.empty()) pictures = PicturesIn(file.parent_path());
  if (pictures.size() != count) pictures = WithoutRawTwins(std::move(pictures));
  if (pictures.size() == count) return pictures;
  throw IoError(file.string() + ": has " + std::to_string(count) +
                " poses and names no photos, but there are " + std::to_string(pictures.size()) +
                " pictures in " +
                (!photos.empty() ? photos.string()
                                 : (file.parent_path() / "images").string() + " or beside it") +
                "; the folder must hold the posed photos alone");
}

renderer::Vec3 CheckedCentre(const renderer::Vec3& centre, const std::string& place) {
  if (!renderer::IsWithinBounds(centre)) {
    throw IoError(place + ": the camera's centre has a coordinate beyond 1e12");
  }
  return centre;
}

}  // namespace pathfit::optim
