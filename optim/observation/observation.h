#pragma once

#include <string>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/sensor/camera.h"

namespace pathfit::optim {

/// What black in a mask says: the object is not there (evidence, compared with rendered coverage),
/// or no data.
enum class MaskMeaning { kNone, kSilhouette, kIgnore };

/// One photo with its camera, at the resolution it is fitted at most.
struct View {
  std::string name;  ///< file name of the photo
  renderer::Camera camera;
  renderer::Image photo;  ///< 3 channels, linear Rec.709; size of the camera
  renderer::Image mask;   ///< 1 channel, 0..1, 1 = object (or data); empty without masks
  /// 1 channel: share of each pixel that was at or above the clipping level in the file; empty if
  /// none is.
  renderer::Image clipped;
  bool validation = false;  ///< never fitted, always reported
};

struct ObservationSet {
  std::vector<View> views;
  MaskMeaning mask_meaning = MaskMeaning::kNone;
  int mask_erode_px = 0;  ///< colours are compared this far inside the mask, at full size
  std::vector<std::string> assumptions;  ///< sentences for `check`, run.json and the report
};

/// A view area-averaged to `scale` times its size (rounded, at least 1 px).
/// `color_weight`: 1 channel, share of the pixel that is valid colour evidence (eroded mask or 1).
struct ViewLevel {
  renderer::Camera camera;
  renderer::Image photo;
  renderer::Image mask;
  renderer::Image clipped;
  renderer::Image color_weight;
};
ViewLevel MakeViewLevel(const View& view, const ObservationSet& observations, double scale);

/// Intersection over union of a rendered coverage (> 1/2) and a mask (> 1/2), both of one channel
/// and the same size; 1 when both are empty.
double MaskIou(const renderer::Image& coverage, const renderer::Image& mask);

}  // namespace pathfit::optim
