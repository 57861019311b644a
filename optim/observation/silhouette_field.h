#pragma once

#include <optional>
#include <vector>

#include "optim/observation/observation.h"

namespace pathfit::optim {

/// Signed distance to the intersection of the silhouettes' viewing cones, positive inside, in units
/// of the world: the least over all views of the distance to the mask's outline in pixels, times
/// depth / focal length; or the least but some, so that the body is where all but so many views
/// have it. Outside the image counts as outside the mask, unless the image's border cuts the mask
/// off: then nobody knows. Exact at zero, an estimate elsewhere.
class SilhouetteField {
 public:
  /// A value and its derivative by position. Far outside every view the value is very negative, the
  /// gradient zero.
  struct Sample {
    double value = 0.0;
    renderer::Vec3 gradient;
  };

  /// Uses the views that are fitted and have a mask; `dissent` (0 to below 1): share of them that
  /// may leave out what the others have. Throws SceneError if there is none, or a mask is black.
  explicit SilhouetteField(const ObservationSet& observations, double dissent = 0.0);

  /// Once the value is known to be below `enough`, it may be anything between the true value and
  /// that.
  [[nodiscard]] double Value(const renderer::Vec3& x, double enough) const;
  [[nodiscard]] Sample ValueAndGradient(const renderer::Vec3& x) const;

  /// Point nearest to the rays through the masks' centroids, by least squares. Throws SceneError if
  /// the rays are so nearly parallel that it is not determined.
  [[nodiscard]] renderer::Vec3 Center() const;
  /// Radius of a ball about `center` onto which every mask falls.
  [[nodiscard]] double Radius(const renderer::Vec3& center) const;

  /// How wide a pixel is at a point that some view is before, in units of the world: median.
  [[nodiscard]] double PixelWidth(const renderer::Vec3& at) const;

  /// Takes what is outside of an image as outside of its mask also where its border cuts the mask
  /// off. False: there is no such image.
  bool TrustBorders();

  [[nodiscard]] std::size_t NumViews() const { return views_.size(); }
  /// Cells of a square grid over the box of a view's silhouette whose centres lie in it.
  [[nodiscard]] int NumCells(std::size_t view, int cells_along) const;
  /// The cell, row by row, in which a point is seen; -1: outside of the grid.
  [[nodiscard]] int CellOf(std::size_t view, int cells_along, const renderer::Vec3& x) const;

 private:
  struct SilhouetteView {
    renderer::CameraModel camera;
    renderer::Image distance;  ///< pixels, positive inside
    double focal = 1.0;        ///< pixels
    renderer::Vec2 low, high;  ///< bounding box of the mask in pixel coordinates
    renderer::Vec2 centroid;
    bool is_cut = false;  ///< by the image's border
  };
  /// Pixels; `gradient` by (u, v).
  struct PixelDistance {
    double value = 0.0;
    renderer::Vec2 gradient;
  };
  static PixelDistance Lookup(const SilhouetteView& view, double u, double v);
  static SilhouetteView MakeView(const View& view);
  /// Of a point by one view; nothing where that does not tell.
  static std::optional<double> Distance(const SilhouetteView& view, const renderer::Vec3& x);

  /// The views with the least distances at a point, farthest outside first: one more than may
  /// dissent, so that the last of them tells.
  class Outermost;

  std::vector<SilhouetteView> views_;
  std::size_t num_dissenting_ = 0;
};

}  // namespace pathfit::optim
