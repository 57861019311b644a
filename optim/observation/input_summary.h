#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "optim/observation/load_observations.h"

namespace pathfit::optim {

enum class MaskSource { kNone, kFolder, kMaskPath, kAlpha };

/// What was met while one photo was loaded.
struct FrameFacts {
  int bits = 0;
  bool srgb = false;
  int exif_orientation = 1;
  bool distorted = false;
  bool reduced = false;       ///< area-averaged to the largest size allowed
  std::string rescaled_from;  ///< size of its camera, if that was another
  MaskSource mask_source = MaskSource::kNone;
  bool mask_is_black = false;  ///< no value above 1/2
  std::int64_t clipped_pixels = 0;
  std::int64_t pixels = 0;  ///< of the file
};

/// One sentence per rule that was applied to the input, for people to check. `facts` belong to
/// `set.views`.
std::vector<std::string> SummariseInput(const ObservationOptions& options,
                                        const ImportedCameras& cameras,
                                        const ObservationSet& set,
                                        const std::vector<FrameFacts>& facts);

}  // namespace pathfit::optim
