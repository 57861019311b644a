#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "optim/observation/camera_import.h"
#include "optim/observation/exif_exposure.h"
#include "optim/observation/load_observations.h"
#include "renderer/image/image.h"
#include "renderer/io/raw_file.h"
#include "renderer/math/rgb.h"

namespace pathfit::optim {

/// How a RAW photo was developed.
struct RawDevelopment {
  renderer::RawWhiteBalance white_balance;  ///< that was used
  renderer::Rgb multipliers;                ///< of the camera's channels; green is 1
  bool has_color_matrix = true;
};

/// A photo at the size of its file, made linear.
struct PhotoFile {
  renderer::Image photo;        ///< 3 channels, linear
  renderer::Image clipped;      ///< 1 channel, 1 = clipped; empty if no pixel is
  renderer::Image alpha;        ///< 1 channel or empty
  bool straight_alpha = false;  ///< colours are not multiplied by it: PNG and TIFF, not EXR
  int bits = 0;                 ///< per channel in the file; 32 for floats
  bool grey = false;            ///< the file has one channel, but for alpha
  bool srgb = false;            ///< the sRGB curve was undone
  std::string profile;          ///< name of the colour profile that was undone; else empty
  int exif_orientation = 1;
  std::optional<ExifExposure> exif_exposure;
  std::optional<RawDevelopment> raw;  ///< of RAW photos
};

/// JPEG, PNG, TIFF, HDR, EXR, and by their extensions RAW photos. Throws IoError: unreadable, or a
/// value that is not finite.
PhotoFile ReadPhotoFile(const std::filesystem::path& path, const ObservationOptions& options);

/// A mask file as shares 0..1 of one channel (mean of the colours). Throws IoError like
/// ReadPhotoFile.
renderer::Image ReadMaskFile(const std::filesystem::path& path, bool apply_exif_orientation);

/// What a photo of this size is averaged to: within the largest size allowed.
std::pair<int, int> ReducedSize(int width, int height, const ObservationOptions& options);
/// Averages photo and clipping to that size; an alpha channel stays as it is.
void ReducePhoto(const ObservationOptions& options, PhotoFile& file);
/// Turns what a file says into shares that are object (or data).
void FinishMask(const MaskOptions& options, renderer::Image& mask);

/// Whether a path is a file with the extension of a picture, RAW photos among them.
bool IsPicture(const std::filesystem::path& path);
/// The pictures in a folder, by name; none where there is no folder.
std::vector<std::filesystem::path> PicturesIn(const std::filesystem::path& folder);
/// Without the RAW photos beside which the same photo is as JPEG or in another format, as cameras
/// write both.
std::vector<std::filesystem::path> WithoutRawTwins(std::vector<std::filesystem::path> pictures);

/// Candidates of one input in the order they were looked for, and the first that exists.
struct FileSearch {
  std::vector<std::filesystem::path> tried;
  std::optional<std::filesystem::path> found;
};

/// `image` as the camera file calls it, in the folders the options allow; NeRF files leave out the
/// extension. Where no file has that name, the RAW photo whose name differs by the extension alone:
/// camera programs work on the JPEG beside it.
FileSearch FindPhoto(const std::string& image,
                     const ImportedCameras& cameras,
                     const std::filesystem::path& images_dir);

/// The mask of a photo in a mask folder, or by the camera file's mask_path.
FileSearch FindMask(const ImportedCamera& camera,
                    const std::filesystem::path& photo,
                    const ImportedCameras& cameras,
                    const ObservationOptions& options);

/// "a, b, c" of the file names that were tried.
std::string TriedNames(const FileSearch& search);

}  // namespace pathfit::optim
