#pragma once

#include <cstdint>
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
  double view_angle_y = 0.0;  ///< beside it; 0: pixels are square
  bool has_principal_point = true;  ///< false: the image centre
  std::string place;                ///< where it stands, for messages: "transforms.json: frames[3]"
};

struct ImportedCameras {
  std::string_view format;       ///< for people, such as "COLMAP model"
  std::filesystem::path folder;  ///< masks are relative to it
  /// Where photos are looked for unless the options name a folder.
  std::vector<std::filesystem::path> image_folders;
  /// The cameras were found on the photos in these folders: their sizes must agree.
  bool has_own_photos = false;
  std::vector<std::filesystem::path> files;  ///< everything that was read
  std::vector<ImportedCamera> cameras;       ///< in file order
  /// File of the sparse points that were found with the cameras (ReadSparsePoints); empty: none.
  std::filesystem::path points;
  double metres_per_unit = 0.0;  ///< 0 when the file does not say; poses are not multiplied by it
  /// What was added to the file's principal points, which count from the first pixel's centre.
  double pixel_shift = 0.0;
  std::vector<std::string> notes;  ///< what else was assumed or left out, as sentences
};

/// Reads a nerfstudio or NeRF camera file: camera-to-world matrices, x right, y up, looking along
/// -z, pixel origin at the image corner; intrinsics for all frames or per frame; models OPENCV,
/// PINHOLE and their simpler forms, and our own ORTHOGRAPHIC, whose fl_x and fl_y are pixels per
/// unit. What nerfstudio's applied_transform and applied_scale say is undone: poses are in the
/// frame they were found in, which exports keep. Throws IoError naming the file and the line or
/// key: malformed, out of range, a lens model that is not known, a pose that is not a rotation to
/// 1e-4 (better ones are made exact).
ImportedCameras ReadTransformsJson(const std::filesystem::path& path);

/// Reads a COLMAP model: `cameras_file` is its cameras.bin or cameras.txt, with images.bin or
/// images.txt beside it (world-to-camera, x right, y down, z forward; pixel origin at the image
/// corner); also models of COLMAP 3.12 and later, with rigs and frames. Lenses SIMPLE_PINHOLE,
/// PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, and FULL_OPENCV with k4 = k5 = k6 = 0. Throws IoError
/// with file:line, or with file and image of a binary model.
ImportedCameras ReadColmapModel(const std::filesystem::path& cameras_file);

/// Reads points3D.bin or points3D.txt of a COLMAP model: places in the frame of its cameras, but
/// for those that are not sure (IsSurePoint). Throws IoError as ReadColmapModel does.
std::vector<renderer::Vec3> ReadColmapPoints(const std::filesystem::path& path);

/// Reads poses_bounds.npy of LLFF: of each photo a 3 x 5 matrix (axes down, right, backwards, the
/// position, then height, width and focal length) and the nearest and farthest depth, which are not
/// used. Photos are the pictures in `photos`, or in the folder `images` beside the file, or beside
/// it, in the order of their names. Throws IoError with file and row; when there are not as many
/// pictures as poses.
ImportedCameras ReadLlffPoses(const std::filesystem::path& path,
                              const std::filesystem::path& photos);

/// Reads OpenCV's calibration files, YAML or XML (also camera_info of ROS): camera_matrix,
/// distortion_coefficients, image_width and image_height, by their usual spellings. Pixels count
/// from the first pixel's centre: 0.5 is added. No lens but the Brown one. The pose is left alone.
/// Throws IoError with file and key.
renderer::Camera ReadOpencvIntrinsics(const std::filesystem::path& path);

/// The same with the poses of the photos the camera was calibrated on, in the frame of the board:
/// extrinsic_parameters, or rvecs and tvecs. Photos as the file names them (images or image_names),
/// else as of ReadLlffPoses. Throws IoError too if there is no pose.
ImportedCameras ReadOpencvCalibration(const std::filesystem::path& path,
                                      const std::filesystem::path& photos);

/// Reads cameras that Metashape exported as XML: one chunk, sensors of type frame with f, cx, cy,
/// b1, k1, k2, k3, p1, p2. Cameras without a pose are left out. In local coordinates poses are
/// those of the chunk's transform, as in meshes exported so; georeferenced ones stay in the chunk's
/// own frame, whose scale is metres_per_unit. Throws IoError with file, line and element.
ImportedCameras ReadMetashapeXml(const std::filesystem::path& path);

/// Reads SfM data of AliceVision (Meshroom) as JSON, of versions 1.0 to 1.2: pinhole cameras
/// without distortion, with radialk1, radialk3 or brown. Views without a pose are left out. Throws
/// IoError with file and element.
ImportedCameras ReadAliceVisionSfm(const std::filesystem::path& path);

/// The landmarks of such a file (`structure`), as of ReadColmapPoints.
std::vector<renderer::Vec3> ReadAliceVisionPoints(const std::filesystem::path& path);

/// Of ImportedCameras::points, whatever wrote them.
std::vector<renderer::Vec3> ReadSparsePoints(const std::filesystem::path& path);

/// Whether a point that so many photos agree on, 0 if the file does not say, is kept: those of two
/// are mismatches more often.
inline bool IsSurePoint(std::uint64_t photos) { return photos == 0 || photos >= 3; }

/// Reads a plain list of cameras in YAML, for what was measured or written by a program of one's
/// own: `cameras`, of each `image`, perhaps `mask`, and its pose, either world_from_camera (3 or 4
/// rows; x right, y up, looking along -z; with `axes: opencv` y down, z forward) or look_at
/// (origin, target, up). `type`, `size_px`, `focal_px` (one number or two; pixels per unit of an
/// orthographic camera), `principal_point_px` (from the image corner), `distortion` (k1 k2 k3 p1
/// p2) and `axes` belong to a camera, or to the whole file. `metres_per_unit` may be there. Throws
/// IoError with file:line:column and key, also of keys that are not known.
ImportedCameras ReadCameraList(const std::filesystem::path& path);

/// What ImportCameras takes: "auto" and a word for each kind of camera file.
std::vector<std::string> CameraFormatWords();

/// Whether a folder holds, or a file is, cameras of a format that ImportCameras knows.
bool HasCameras(const std::filesystem::path& path);

/// What is looked for, for people: "transforms.json (or another .json file), ...".
std::string CameraFormatList();

/// The first format that is there; only the one with this word of CameraFormatWords, unless it is
/// "auto". `photos` is their folder, for files that do not name them; it may be empty. Throws
/// IoError when nothing of this kind is there.
ImportedCameras ImportCameras(const std::filesystem::path& path,
                              std::string_view word,
                              const std::filesystem::path& photos = {});

/// Gives all cameras the size, intrinsics and lens of an OpenCV calibration; poses stay.
void UseCalibration(const std::filesystem::path& calibration, ImportedCameras& cameras);

/// The camera with size and intrinsics filled in from a photo of this size, where the file left
/// them open.
renderer::Camera CompleteCamera(const ImportedCamera& imported, int width, int height);

/// The rotation nearest to `matrix`. Throws IoError starting with `place` when the matrix differs
/// from a rotation by more than 1e-4 (largest entry of M^T M - I, or a reflection).
renderer::Mat3 ExactRotation(const renderer::Mat3& matrix, const std::string& place);

/// Our pose of a camera whose axes are x right, y down, z forward: OpenCV's and COLMAP's.
/// `rotation` takes these axes to the world. Throws IoError starting with `place` as CheckedCentre
/// does.
renderer::Transform PoseFromForwardAxes(const renderer::Mat3& rotation,
                                        const renderer::Vec3& centre,
                                        const std::string& place);

/// The pictures in `photos`, or where that is empty in `images` beside `file`, else beside it, by
/// name. Throws IoError unless there are `count`.
std::vector<std::filesystem::path> PicturesOf(const std::filesystem::path& file,
                                              const std::filesystem::path& photos,
                                              std::size_t count);

/// `centre` if its coordinates are numbers up to renderer::kMaxCoordinate. Throws IoError starting
/// with `place`.
renderer::Vec3 CheckedCentre(const renderer::Vec3& centre, const std::string& place);

}  // namespace pathfit::optim
