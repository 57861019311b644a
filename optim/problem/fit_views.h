#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "optim/observation/observation.h"
#include "optim/problem/loss_spec.h"
#include "renderer/image/image.h"

namespace pathfit::optim {

/// All views at one pyramid level, and which of them are fitted.
struct FitViews {
  std::vector<PackedLevel> levels;  ///< by view
  std::vector<std::string> names;
  std::vector<int> fitted, validation;
  bool silhouettes = false;  ///< masks are evidence: coverage residuals exist
  /// Valid pixel-channels of the fitted views: 3 times the sum of their colour weights, at least 1.
  /// The solver's cost is the plain sum over pixels; every reported cost is that divided by
  /// num_channels, so that stages of different resolution compare. A coverage residual of weight 1
  /// counts like one colour channel.
  double num_channels = 1.0;
};

/// All but the images: names, and which views are fitted.
FitViews ListViews(const ObservationSet& observations);

/// `observations` must outlive them. Photos and masks are looked at unless num_channels is known.
FitViews MakeFitViews(const ObservationSet& observations,
                      double scale,
                      std::optional<double> num_channels = {});

/// What multiplies (rendered - target) of each pixel: r, g, b, coverage; 0 = not compared. Frozen
/// for a round.
using RowScales = std::vector<std::array<float, 4>>;

/// What a round's own rendering says about a photo's pixels; frozen for the round.
struct PixelTrust {
  /// Bit c: channel c may be clipped in the photo, and the rendering is not surely darker. The
  /// photo only says "at least this". Empty: no pixel of the photo clipped.
  std::vector<unsigned char> censored;
  /// Square root of the robust loss' weight in steps of 1 / 255. Empty: no robust loss.
  std::vector<unsigned char> huber;
};
/// By both halves of the rendering.
PixelTrust JudgePixels(const ViewLevel& level,
                       const LossSpec& loss,
                       const renderer::Film& a,
                       const renderer::Film& b);

/// Square root of the pixel's weight, times that of the robust loss, divided by (photo + floor) for
/// relative residuals; silhouette_weight for coverage; 0 for censored channels.
RowScales MakeRowScales(const ViewLevel& level,
                        bool silhouettes,
                        const LossSpec& loss,
                        const PixelTrust& trust);

/// Residual of one pixel: scale * (rendered - target) for r, g, b, coverage.
std::array<double, 4> PixelResidual(const ViewLevel& level,
                                    const std::array<float, 4>& scale,
                                    const renderer::Rgba& rendered,
                                    std::size_t pixel);

/// (a + b) / 2.
renderer::Film AverageFilm(const renderer::Film& a, const renderer::Film& b);

}  // namespace pathfit::optim
