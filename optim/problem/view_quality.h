#pragma once

#include "optim/observation/observation.h"
#include "renderer/image/image.h"

namespace pathfit::optim {

/// How well a rendering agrees with its photo.
struct ViewQuality {
  double psnr_linear = 0.0;  ///< colours weighted by color_weight, peak 1, dB, at most kMaxPsnr
  double psnr_srgb = 0.0;    ///< after clamping to 0..1 and the sRGB curve
  double iou = 1.0;  ///< rendered coverage > 1/2 against mask > 1/2; 1 unless masks are silhouettes
};

inline constexpr double kMaxPsnr = 100.0;

ViewQuality MeasureView(const ViewLevel& level, const renderer::Film& film, bool silhouettes);

}  // namespace pathfit::optim
