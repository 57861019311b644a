#pragma once

#include <optional>

#include "optim/observation/observation.h"
#include "renderer/geometry/mesh.h"

namespace pathfit::optim {

struct VisualHullOptions {
  static constexpr int kMinResolution = 16, kMaxResolution = 512;
  /// Of those that are found.
  static constexpr int kLeastFound = 32, kMostFound = 256;
  static constexpr double kMaxDissent = 0.4;
  /// Voxels along the longest side of the hull's box; none: as wide as a pixel is there.
  std::optional<int> resolution = {};
  double dissent = 0.0;  ///< share of the views that may leave out what the others have
};

/// Surface of the bodies whose silhouettes lie inside the masks of all fitted views but those that
/// may dissent, found from cameras and masks alone: closed, manifold, outward winding, welded, in
/// the frame of the cameras; the largest component, and those without which a part of the masks
/// would show nothing. Throws SceneError with advice: no silhouette masks,
/// views from one side only, nothing left after carving, a body that the views do not bound,
/// options out of range.
renderer::Mesh CarveVisualHull(const ObservationSet& observations,
                               const VisualHullOptions& options);

}  // namespace pathfit::optim
