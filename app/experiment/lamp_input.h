#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "optim/observation/load_observations.h"
#include "optim/observation/shading.h"
#include "renderer/image/image.h"
#include "renderer/math/rgb.h"
#include "renderer/math/vector.h"

namespace pathfit::app {

/// Where a person says things are; what is empty is looked for.
struct LampPlaces {
  std::filesystem::path photos = {};  ///< folder
  std::filesystem::path lamps = {};   ///< file: optim::ReadLampList; empty: by the ball
  /// Of a shiny ball under the same lamps: the folder of its photos and their mask, by their
  /// numbers; or a file, its mask in the photos themselves.
  std::filesystem::path ball = {};
  std::filesystem::path mask = {};  ///< file, of all photos
};

/// Photos by one camera that stood still, each under a lamp of its own (photometric stereo), as
/// they were found and loaded. The frame: x right, y up, z to the camera; the origin is what the
/// middle of the photos shows.
struct FoundLamps {
  struct Lamp {
    std::string photo;       ///< file name
    renderer::Vec3 towards;  ///< unit
    renderer::Rgb strength;  ///< relative, mean 1
  };
  static constexpr double kPixel = 0.01;  ///< width of a pixel, units of the frame
  /// Complete but for `masks` where the mask was made. The camera is taken as far away; of few
  /// photos none is held out.
  optim::ObservationOptions options;
  bool all_pictures = true;           ///< of the folder are photos
  std::string pattern;                ///< that fits their names alone; empty if there is none
  std::filesystem::path lamp_source;  ///< file of lamps, or the ball's folder or mask
  bool by_ball = false;
  std::vector<Lamp> lamps;  ///< in the order of the file
  bool strengths_known = false;
  renderer::Image mask;  ///< 1 channel, size of the photos
  bool mask_made = false;
  optim::ObservationSet observations;
  optim::ShadingFit shading;
  std::vector<std::string> guesses;  ///< sentences
};

/// The file of lamps in or above a folder: light_directions.txt, lights.txt, lamps.txt or *.lp.
/// Empty if there is none or more than one.
std::filesystem::path FindLampFile(const std::filesystem::path& photos);

/// Finds photos and mask for the lamps of a file or a ball: photos by the names in it, by those of
/// a filenames.txt beside it, else by their numbers; strengths also in light_intensities.txt beside
/// it; the mask by its name beside the photos or above, else what is not black in their mean.
/// What photos do not say is told by how well a matt surface explains their shading: whether their
/// values are linear, where strengths are unknown those, and which way the file's y points. Throws
/// IoError, ObservationError or SceneError saying what does not fit.
FoundLamps FindLamps(const LampPlaces& places);

}  // namespace pathfit::app
