#pragma once

#include <vector>

#include "renderer/boundary/boundary_technique.h"

namespace pathfit::renderer {

/// Estimator of the pixel boundary integral: in material form under a box filter, visible points
/// cross the border of a pixel's support.
///
/// dI = -(1 / support area) * border integral of (n . u') L ds, n outward, u' the image velocity of
/// the visible material point. All lines that bound supports are swept; a line between two pixels
/// serves both, with opposite signs. One sample takes the points at one place of all parallel
/// lines, with the same random numbers: a pixel gains on one side what it loses on the other, and
/// most of the noise cancels. Two ways: columns and rows. What the interior estimator keeps in
/// image form has no part in it (see IsInImageForm). Source: path_space 1.9, eq. (P).
class PixelBoundary : public BoundaryTechnique {
 public:
  explicit PixelBoundary(const BoundaryContext& context);

  [[nodiscard]] std::vector<BoundaryWay> Ways() const override;
  /// The budget counts points on lines per pixel in which anything may move.
  [[nodiscard]] std::int64_t NumSamples() const override;
  void Sample(std::size_t way, const BoundaryDraw& draw, SplatBuffer& splats) const override;

 private:
  /// A line of constant u or v.
  struct Line {
    double at = 0.0;
    int gains = -1;  ///< column or row whose support starts here, -1: none
    int loses = -1;  ///< column or row whose support ends here, -1: none
  };
  static std::vector<Line> LinesOf(int first, int end, double radius);
  /// The point at `along`, in pixels, that stands for `length` of its line.
  void SamplePoint(bool is_column,
                   const Line& line,
                   double along,
                   double length,
                   LatticeSampler sampler,
                   SplatBuffer& splats) const;

  const BoundaryContext& context_;
  PixelBounds bounds_;  // of the pixels in which anything may move
  std::vector<Line> columns_, rows_;
};

}  // namespace pathfit::renderer
