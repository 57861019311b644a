#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "optim/observation/observation.h"
#include "renderer/core/error.h"
#include "renderer/io/raw_file.h"

namespace pathfit::optim {

/// Which views may lack a mask: none of them (kAll), some (kSome), or every one (kNone).
enum class MaskRequirement { kAll, kSome, kNone };

struct MaskOptions {
  MaskMeaning meaning = MaskMeaning::kNone;  ///< kNone: no mask is looked for
  /// For a photo a.jpg this folder is searched for a.jpg.png, a.png, a.mask.png; a file is the mask
  /// of all photos. Empty: `mask_path` of the camera file, then the photo's alpha channel unless it
  /// is opaque everywhere.
  std::filesystem::path folder;
  bool alpha = false;   ///< the photo's alpha channel and nothing else
  bool invert = false;  ///< the files have black where the object (or data) is
  int erode_px = 0;
  MaskRequirement require = MaskRequirement::kAll;
};

/// What the numbers in photo files mean. kAuto: 8 and 16 bit by the sRGB curve, floats linear. RAW
/// photos are linear, and refused with kSrgb.
enum class Transfer { kAuto, kSrgb, kLinear };

/// kModel: rays are bent as the lens does. kRefuse: a camera with distortion is a problem.
enum class DistortionPolicy { kModel, kRefuse };

struct ObservationOptions {
  std::filesystem::path cameras;  ///< file or folder
  /// Instead of a camera file: took every picture in `images_dir`, from the same place.
  std::optional<renderer::Camera> fixed_camera;
  std::vector<std::string> fixed_photos;  ///< of these file names alone; empty: every one
  std::string camera_format = "auto";     ///< one of CameraFormatWords
  std::filesystem::path calibration;      ///< OpenCV's, for all cameras; empty: as their file says
  DistortionPolicy distortion = DistortionPolicy::kModel;
  /// Empty: relative to transforms.json; for COLMAP the folder `images` beside or up to two levels
  /// above the model.
  std::filesystem::path images_dir;
  bool apply_exif_orientation = false;  ///< camera programs work on the pixels as stored
  MaskOptions masks;
  Transfer transfer = Transfer::kAuto;
  /// Share of the encoded range of an integer file (of RAW photos: of the sensor's range) from
  /// which a pixel counts as clipped; 1 = never.
  double clip_above = 0.99;
  renderer::RawWhiteBalance white_balance = renderer::RawWhiteBalance::kCamera;  ///< of RAW photos
  int max_size_px = 0;       ///< longest side after area averaging; 0 = as it is
  int validation_every = 8;  ///< every so many views, starting with the first by name; 0 = none
  std::vector<std::string> validation_names;  ///< instead of validation_every: names of views
};

struct InputFile {
  std::filesystem::path path;
};

/// Everything that is wrong with the photos, their cameras and masks; what() has one line for each.
class ObservationError : public renderer::IoError {
 public:
  explicit ObservationError(std::vector<std::string> problems);
  [[nodiscard]] const std::vector<std::string>& Problems() const { return problems_; }

 private:
  std::vector<std::string> problems_;
};

/// Reads cameras, photos and masks into linear views, sorted by name; poses stay in the units of
/// the camera file. A photo that is the camera's size times or divided by a whole number (to half a
/// pixel) rescales the camera, except photos of a COLMAP model in its own folder, which must have
/// the size the model says; other differences of size are problems. `files`, if given, receives
/// every file that was used, in a fixed order. Throws IoError for a malformed camera file,
/// ObservationError for everything else, all problems at once.
ObservationSet LoadObservations(const ObservationOptions& options,
                                std::vector<InputFile>* files = nullptr);

/// Says how long the unit of the camera file is, in place of what that file says; `reason` is for
/// people: "as two points ... are 0.08 m".
void SetMetresPerUnit(double metres_per_unit, const std::string& reason, ObservationSet& set);

}  // namespace pathfit::optim
