#pragma once

#include "renderer/derivative/active_parameters.h"
#include "renderer/derivative/path_recorder.h"

namespace pathfit::renderer {

/// How often the direction at a vertex close to something that moves against it is drawn.
///
/// In material form a short segment between two vertices that move against each other changes by
/// velocity / length: its derivative over all directions stays bounded, but that of one direction
/// does not, and near a contact its variance has no bound. Averaging over an even set of directions
/// cancels it; the size of the set grows as the distance to the moving surface shrinks, which
/// depends on the vertex alone, so that the mean stays.
class NearMotion {
 public:
  /// `placed` and `caster` must outlive the result.
  NearMotion(const RayCaster& caster, const ActiveParameters& active);

  /// The first vertex (from 0) of a path whose direction should be drawn more than once, and how
  /// often; count 1 if there is none.
  struct Split {
    int vertex = 0;
    int count = 1;
  };
  [[nodiscard]] Split FirstSplit(const PathRecorder& path, const PathContext& context) const;

  static constexpr double kReach = 0.03;  ///< splits begin at this distance, half diagonals
  static constexpr int kMaxCount = 64;

 private:
  const RayCaster& caster_;
  bool any_ = false;
  std::vector<bool> moving_;                // by mesh
  std::vector<std::vector<bool>> all_but_;  // by moving mesh: all others
};

}  // namespace pathfit::renderer
