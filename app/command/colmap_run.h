#pragma once

#include <filesystem>

#include "app/command/command_line.h"
#include "app/command/stop_signals.h"

namespace pathfit::app {

inline constexpr int kFewestPhotosOfColmap = 3;

struct ColmapInput {
  std::filesystem::path photos;  ///< folder of the photos, or of everything
  std::filesystem::path masks;   ///< folder; empty: the whole photos are matched
  std::filesystem::path
      calibration;                  ///< OpenCV's, which is then kept; empty: COLMAP finds the lens
  std::filesystem::path workspace;  ///< to make: database, log and models
};

struct ColmapResult {
  std::filesystem::path photos;  ///< their very folder
  std::filesystem::path model;   ///< the one with the most photos; empty if a signal came
};

/// Finds the cameras of photos with the program COLMAP: features, matches (of all pairs, or of
/// neighbours where there are many), mapper. One camera took all photos if they have one size and
/// their EXIF names one camera and focal length. What COLMAP says goes to `workspace`/colmap.log.
/// Throws IoError saying what to do: COLMAP is not there, a step failed, no model was found.
ColmapResult RunColmap(const ColmapInput& input,
                       const StopSignals& signals,
                       CommandContext& context);

}  // namespace pathfit::app
