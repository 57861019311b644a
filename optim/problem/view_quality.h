#pragma once

#include <cmath>

#include "optim/observation/observation.h"
#include "renderer/image/image.h"

namespace pathfit::optim {

/// How well a rendering agrees with its photo. What cannot be told is NaN: PSNR where no pixel's
/// colour is compared, IoU without a mask that is a silhouette. Squared errors are products of
/// those of two independent halves, so that PSNR is of the scene, however few its samples; errors
/// that do not stand out of the noise count as what would.
struct ViewQuality {
  double psnr_linear = 0.0;  ///< colours weighted by color_weight, peak 1, dB, at most kMaxPsnr
  double psnr_srgb = 0.0;    ///< after clamping to 0..1 and the sRGB curve
  double iou = 0.0;          ///< rendered coverage > 1/2 against mask > 1/2; 1 if both are empty
};

inline constexpr double kMaxPsnr = 100.0;

/// Mean of the figures that are known; NaN if none is.
class KnownMean {
 public:
  void Add(double figure) {
    if (std::isnan(figure)) return;
    sum_ += figure;
    count_ += 1.0;
  }
  [[nodiscard]] double Value() const { return sum_ / count_; }  // 0 / 0 is NaN

 private:
  double sum_ = 0.0, count_ = 0.0;
};

/// Two halves with samples of their own.
ViewQuality MeasureView(const ViewLevel& level,
                        const renderer::Film& a,
                        const renderer::Film& b,
                        bool silhouettes);
/// Of one picture as it is, its noise included.
ViewQuality MeasureView(const ViewLevel& level, const renderer::Film& film, bool silhouettes);

}  // namespace pathfit::optim
