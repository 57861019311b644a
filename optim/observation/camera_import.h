#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/sensor/camera.h"

namespace pathfit::optim {

/// One posed photo of a camera file. A file may leave the image size open: then `camera.width` is 0
/// and CompleteCamera takes what is missing from the photo.
struct ImportedCamera {
  std::string image;  ///< as written in the file, relative to its folder (or to the image folder)
  std::filesystem::path
      mask;  ///< `mask_path` of the file, absolute or relative like `image`; may be empty
  renderer::Camera camera;    ///< pose in the file's units
  double view_angle_x = 0.0;  ///< radians; positive when only the view angle is known, fx is then 0
  bool has_principal_point = true;  ///< false: the image centre
  std::string place;                ///< where it stands, for messages: "transforms.json: frames[3]"
};

/// ImportedCameras::format of the two kinds.
inline constexpr std::string_view kTransformsFormat = "transforms.json";
inline constexpr std::string_view kColmapFormat = "COLMAP text model";

enum class CameraFormat { kAuto, kTransforms, kColmap };

struct ImportedCameras {
  std::string_view format;                   ///< kTransformsFormat or kColmapFormat
  std::filesystem::path folder;              ///< image names are relative to it
  std::vector<std::filesystem::path> files;  ///< everything that was read
  std::vector<ImportedCamera> cameras;       ///< in file order
  double metres_per_unit = 0.0;  ///< 0 when the file does not say; poses are not multiplied by it
};

/// Reads a nerfstudio or NeRF camera file: camera-to-world matrices, x right, y up, looking along
/// -z, pixel origin at the image corner; intrinsics for all frames or per frame; models OPENCV,
/// PINHOLE and their simpler forms. Throws IoError naming the file and the line or key: malformed,
/// out of range, a lens model that is not known, a pose that is not a rotation to 1e-4 (better ones
/// are made exact).
ImportedCameras ReadTransformsJson(const std::filesystem::path& path);

/// Reads cameras.txt and images.txt of a COLMAP model (world-to-camera, x right, y down, z forward;
/// pixel origin at the image corner). Models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL,
/// OPENCV. Throws IoError with file:line.
ImportedCameras ReadColmapText(const std::filesystem::path& folder);

/// kAuto: a .json file or a folder with transforms.json is transforms; a folder with cameras.txt
/// (itself, sparse/0 or sparse) is COLMAP. Throws IoError when nothing of this kind is there.
ImportedCameras ImportCameras(const std::filesystem::path& path, CameraFormat format);

/// The camera with size and intrinsics filled in from a photo of this size, where the file left
/// them open.
renderer::Camera CompleteCamera(const ImportedCamera& imported, int width, int height);

}  // namespace pathfit::optim
