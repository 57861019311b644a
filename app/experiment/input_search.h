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

/// Photos with cameras and masks, as they were found and loaded.
struct FoundInput {
  /// Complete but for `masks.erode_px`; `masks.meaning` is kNone where no masks were found.
  optim::ObservationOptions options;
  std::string camera_format;           ///< for people: "COLMAP model"
  double metres_per_unit = 0.0;        ///< 0: the camera file does not say
  std::size_t num_without_camera = 0;  ///< pictures beside the photos
  std::size_t num_masks = 0;
  std::optional<double> mask_agreement;  ///< of masks that were made (optim::ObjectMasks)
  optim::ObservationSet observations;
  std::optional<CameraLayout> layout;
  /// Difference of the background between neighbouring photos over its brightness, at equal pixels
  /// (medians); empty if there is too little background. Small: camera and surroundings
  /// stood still, and the object turned.
  std::optional<double> background_change;
  /// Whether the light goes with the camera, as a person says; empty: to be guessed.
  std::optional<bool> light_with_camera;
};

/// Looks for cameras in the folder of the photos, its `sparse`, `colmap` and other folders, and two
/// levels above; for photos by the names in the camera file; for masks as the camera file says, in
/// folders beside or in that of the photos whose name speaks of masks, and in alpha channels. Masks
/// that are white along the picture's border are inverted. Throws IoError saying what was looked
/// for, or which of several sets it should be.
FoundInput FindInput(const InputPlaces& places);

/// Of photos whose masks were made, a mask that misses something (optim::VisualHullOptions).
inline constexpr double kDissent = 0.1;

/// Makes masks for photos without any, of what the cameras look at, as `folder`/PHOTO.png, and goes
/// on with them. False if the photos do not tell the object from its background, or show it from
/// one side only; nothing is written then. Throws IoError when they cannot be written.
bool MakeMasks(const std::filesystem::path& folder, FoundInput& input);

/// A background that changes less stands still.
inline constexpr double kStillBackground = 0.1;

}  // namespace pathfit::app
