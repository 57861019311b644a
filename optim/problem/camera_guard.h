#pragma once

#include <set>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Refuses steps to cameras that cannot render: a focal length that is not positive, a distortion
/// that folds inside the image, numbers that are not finite.
class CameraGuard {
 public:
  CameraGuard(const renderer::Scene& scene, const ParameterSet& set);

  /// `values`: in units of the scene.
  [[nodiscard]] bool Admits(const std::vector<double>& values) const;

 private:
  struct Group {
    renderer::ParameterLayout layout;  ///< of this group alone
    std::size_t first = 0, count = 0;  ///< of its scalars in the values
  };
  renderer::Scene sensors_;  ///< nothing else
  std::vector<Group> groups_;
  std::set<int> moving_;  ///< sensors that have one of the groups, alone or with others
};

}  // namespace pathfit::optim
