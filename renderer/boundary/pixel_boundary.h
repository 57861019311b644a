#pragma once

#include <cstdint>
#include <vector>

#include "renderer/boundary/boundary_segment.h"
#include "renderer/render_stats.h"

namespace pathfit::renderer {

/// Estimator of the pixel boundary integral: in material form under a box filter, visible points
/// cross the border of a pixel's support.
///
/// dI = -(1 / support area) * border integral of (n . u') L ds, n outward, u' the image velocity of
/// the visible material point. All lines that bound supports are swept; a line between two pixels
/// serves both, with opposite signs. Points at equal places of parallel lines share their random
/// numbers: a pixel gains on one side what it loses on the other, and most of the noise cancels.
/// What the interior estimator keeps in image form has no part in it (see IsInImageForm).
/// Source: path_space 1.9, eq. (P).
class PixelBoundary {
 public:
  /// `context` must outlive it; its camera must have a box filter.
  explicit PixelBoundary(const BoundaryContext& context);

  /// Number of samples for a budget of `spp_pixel` per pixel in which anything may move: a multiple
  /// of the number of lines.
  [[nodiscard]] std::int64_t NumSamples(double spp_pixel) const;

  /// Adds sample `index` of `count`, a result of NumSamples, stratified along the lines; the sum
  /// over all of them is the estimate.
  void Sample(std::int64_t index,
              std::int64_t count,
              RenderStats& stats,
              SplatBuffer& splats) const;

 private:
  /// A line of constant u or v.
  struct Line {
    double at = 0.0;
    int gains = -1;  ///< column or row whose support starts here, -1: none
    int loses = -1;  ///< column or row whose support ends here, -1: none
  };
  static std::vector<Line> LinesOf(int first, int end, double radius);
  [[nodiscard]] std::int64_t NumLines() const {
    return static_cast<std::int64_t>(columns_.size() + rows_.size());
  }

  const BoundaryContext& context_;
  PixelBounds bounds_;  // of the pixels in which anything may move
  std::vector<Line> columns_, rows_;
};

}  // namespace pathfit::renderer
