#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/camera_layout.h"
#include "optim/observation/load_observations.h"

namespace pathfit::app {

/// Where a person says things are; what is empty is looked for.
struct InputPlaces {
  std::filesystem::path photos = {};       ///< folder of the photos, or of everything
  std::filesystem::path cameras = {};      ///< camera file, or its folder
  std::filesystem::path masks = {};        ///< folder
  std::filesystem::path calibration = {};  ///< OpenCV's; what is empty is as the camera file says
};

/// What photos show beside the object. Numbers are over its brightness, medians.
struct Background {
  double change = 0.0;     ///< from photo to photo, at equal pixels and exposures
  double structure = 0.0;  ///< between a pixel and the middle of its photo
  [[nodiscard]] bool IsStill() const { return change < kStill; }
  /// So, and not only because there is nothing in it that could change: the noise of an even
  /// background changes it by 1.4 times its structure.
  [[nodiscard]] bool ShowsThatItIsStill() const { return IsStill() && 1.5 * change < structure; }
  static constexpr double kStill = 0.1;
};

/// Photos with cameras and masks, as they were found and loaded.
struct FoundInput {
  /// Complete but for `masks.erode_px`; `masks.meaning` is kNone where no masks were found.
  optim::ObservationOptions options;
  std::string camera_format;           ///< for people: "COLMAP model"
  double metres_per_unit = 0.0;        ///< 0: the camera file does not say
  std::size_t num_without_camera = 0;  ///< pictures beside the photos
  std::size_t num_masks = 0;
  std::optional<double> mask_agreement;  ///< of masks that were made (optim::ObjectMasks)
  std::filesystem::path points;          ///< found with the cameras; empty: none
  bool start_of_points = false;          ///< MakeStart: masks are of meaning kIgnore
  optim::ObservationSet observations;
  std::optional<CameraLayout> layout;
  std::optional<Background> background;  ///< empty if there is too little of it, or it is black
};

/// Looks for cameras in the folder of the photos, its `sparse`, `colmap` and other folders, and two
/// levels above; for photos by the names in the camera file; for masks as the camera file says, in
/// folders beside or in that of the photos whose name speaks of masks, and in alpha channels. Masks
/// that are white along the picture's border are inverted. Throws IoError saying what was looked
/// for, or which of several sets it should be.
FoundInput FindInput(const InputPlaces& places);

/// Whether FindInput would find cameras.
bool HasCamerasNear(const InputPlaces& places);

/// Of photos whose masks were made, a mask that misses something (optim::VisualHullOptions).
inline constexpr double kDissent = 0.1;

/// Makes masks for photos without any, of what the cameras look at, as `folder`/PHOTO.png, and goes
/// on with them. False if the photos do not tell the object from its background, or show it from
/// one side only; nothing is written then. Throws IoError when they cannot be written.
bool MakeMasks(const std::filesystem::path& folder, FoundInput& input);

/// For photos without masks, what the sparse points of the cameras lie on (optim::BodyOfPoints), as
/// a start mesh, and as `folder`/PHOTO.png where it is seen: only there photos count. False if the
/// cameras have no points, or these tell no body; nothing is written then. Throws IoError when the
/// points cannot be read or files not written.
bool MakeStart(const std::filesystem::path& mesh,
               const std::filesystem::path& folder,
               FoundInput& input);

}  // namespace pathfit::app
