#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "optim/observation/observation.h"
#include "renderer/math/vector.h"

namespace pathfit::optim {

/// A mark as a person sees it in one photo.
struct PickedPoint {
  std::size_t view = 0;     ///< of ObservationSet::views
  double x = 0.0, y = 0.0;  ///< pixels of the photo's file, from its corner to the right and down
};

/// Where the mark is.
struct LocatedPoint {
  renderer::Vec3 position;     ///< units of the camera file
  std::vector<double> off_px;  ///< from each pick to where the position is seen, pixels of the file
};

/// Whether a point is within the photo.
bool IsInPhoto(const View& view, double x, double y);

/// The point whose pictures in the photos, through their lenses, are nearest to the picks (least
/// squares of pixels of the files). Picks must be in the photos, at least two. Throws SceneError
/// saying what is wrong: the rays are parallel to 2 degrees, they meet behind a camera, or the
/// point is seen farther from a pick than 3 pixels and half a percent of the photo's longer side.
LocatedPoint LocatePoint(const std::vector<View>& views, std::span<const PickedPoint> picks);

}  // namespace pathfit::optim
