#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "renderer/derivative/active_parameters.h"
#include "renderer/derivative/path_recorder.h"
#include "renderer/render_options.h"
#include "renderer/scene/world.h"

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
  /// `world` must outlive the result. `lights`: which meshes shine.
  NearMotion(const World& world,
             const LightSet& lights,
             const ActiveParameters& active,
             const RenderOptions& options);

  /// Vertices of a path, a bit each; later ones than there are bits stand in for none.
  using VertexBits = std::uint64_t;
  /// The first vertex (from 0) of a path, from `first` on, that touches something, or whose
  /// direction should be drawn more than once, and how often; count 1 if there is none. `share`: of
  /// the path in its sample, after splits at earlier vertices; 0: no more splits.
  struct Split {
    int vertex = 0;
    int count = 1;
    bool touches = false;  ///< the vertex is closer than kTouch: the `contact` of PathAdjoint
    /// Of the vertices looked at: those beside a strip of others that touch, which they stand for.
    VertexBits stand_ins = 0;
  };
  [[nodiscard]] Split FirstSplit(const PathRecord& path,
                                 const PathContext& context,
                                 int first,
                                 double share) const;

  /// Splits begin at this distance, in half diagonals of the scene, or of kLarge times the smaller
  /// of the two meshes if that is less.
  static constexpr double kReach = 0.03;
  static constexpr double kLarge = 8.0;
  /// Closer, as a share of that distance (and at least kMissed ray offsets), to a surface that
  /// meets its own, a vertex touches: directions away from so narrow a strip are kept fixed, and
  /// with them the largest outliers. Their derivative is bounded and hardly changes across the
  /// strip, so the strip beside it, up to kStandIn times as far away, stands in for it: there what
  /// turns counts kStandInWeight times. Where a gap is left, nothing is so near that it has to be
  /// left out.
  static constexpr double kTouch = 4e-3;
  static constexpr double kStandIn = 3.0;
  static constexpr double kStandInWeight = kStandIn / (kStandIn - 1.0);

 private:
  /// How near what moves against a vertex is, as a share of the distance at which splits begin; at
  /// most `most`. `is_last`: of the last reflection, which meets what shines only. Fills `facts`
  /// where something is nearer.
  [[nodiscard]] double NearnessOfMotion(
      const SurfacePoint& p, bool slides, bool is_last, double most, NearFacts& facts) const;
  [[nodiscard]] bool MayReachLight(const SurfacePoint& p) const;

  const World& world_;
  const RayCaster& caster_;
  bool any_ = false;
  bool camera_moves_ = false;
  bool image_form_ = false;
  // By mesh: distance at which splits begin, of all and of those that move; 0 for the others.
  struct Reaches {
    std::vector<double> of_all, of_moving;
  };
  Reaches reach_, reach_of_shining_;
  std::vector<int> shining_;
  std::vector<bool> meets_own_corners_;                           // of those that slide
  double least_reach_ = std::numeric_limits<double>::infinity();  // of all
};

}  // namespace pathfit::renderer
