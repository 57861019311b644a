#pragma once

#include <memory>
#include <vector>

#include "renderer/derivative/active_parameters.h"
#include "renderer/derivative/own_corners.h"
#include "renderer/derivative/path_recorder.h"
#include "renderer/render_options.h"

namespace pathfit::renderer {

/// How often the direction at a vertex close to something that moves against it is drawn.
///
/// In material form a short segment between two vertices that move against each other changes by
/// velocity / length: its derivative over all directions stays bounded, but that of one direction
/// does not, and near a contact its variance has no bound. Averaging over an even set of directions
/// cancels it; the size of the set grows as the distance to the moving surface shrinks, which
/// depends on the vertex alone, so that the mean stays. In image form the visible point slides, so
/// that all surfaces near it move against it, those of its own mesh included.
class NearMotion {
 public:
  /// `caster` must outlive the result.
  NearMotion(const RayCaster& caster, const ActiveParameters& active, const RenderOptions& options);

  /// The first vertex (from 0) of a path, from `first` on, that touches something, or whose
  /// direction should be drawn more than once, and how often; count 1 if there is none. `share`: of
  /// the path in its sample, after splits at earlier vertices; 0: no more splits.
  struct Split {
    int vertex = 0;
    int count = 1;
    bool touches = false;  ///< the vertex is closer than kTouch: the `contact` of PathAdjoint
  };
  [[nodiscard]] Split FirstSplit(const PathRecord& path,
                                 const PathContext& context,
                                 int first,
                                 double share) const;

  static constexpr double kReach = 0.03;  ///< splits begin at this distance, half diagonals
  /// Closer, in ray offsets, rays no longer meet what is near as they should. What leaves so narrow
  /// a strip has a bounded derivative, which is left out: a share of about kTouch * kRayOffset.
  static constexpr double kTouch = 32.0;

 private:
  /// Distance to what moves against a vertex, at most `reach`.
  [[nodiscard]] double DistanceToMotion(const SurfacePoint& p, bool slides, double reach) const;

  const RayCaster& caster_;
  bool any_ = false;
  bool camera_moves_ = false;
  bool image_form_ = false;
  // By mesh; all_but_ of those that move or slide, own_corners_ of those that slide.
  std::vector<bool> moving_;
  std::vector<std::vector<bool>> all_but_;
  std::vector<std::unique_ptr<OwnCorners>> own_corners_;
};

}  // namespace pathfit::renderer
