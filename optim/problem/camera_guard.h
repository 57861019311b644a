#pragma once

#include <set>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Keeps steps from cameras that cannot render: a focal length that is not positive, a distortion
/// that folds inside the image, a vignetting that leaves no light, numbers that are not finite.
class CameraGuard {
 public:
  /// `values`: the round's start, in units of the scene.
  CameraGuard(const renderer::Scene& scene,
              const ParameterSet& set,
              const std::vector<double>& values);

  /// Where lenses lead there, all distortions and vignettings go only a part of their way, which
  /// ends before the border; poses, focal lengths and all others keep theirs. False where that does
  /// not help.
  [[nodiscard]] bool Restrain(std::vector<double>& values) const;

 private:
  struct Group {
    renderer::ParameterLayout layout;  ///< of this group alone
    std::size_t first = 0, count = 0;  ///< of its scalars in the values
    std::vector<double> start;         ///< of a distortion or a vignetting; else empty
  };
  [[nodiscard]] bool CanRender(const std::vector<double>& values) const;
  /// `wanted` with this share of the lenses' step.
  [[nodiscard]] std::vector<double> Shortened(const std::vector<double>& wanted,
                                              double share) const;

  renderer::Scene sensors_;  ///< nothing else
  std::vector<Group> groups_;
  std::set<int> moving_;  ///< sensors that have one of the groups, alone or with others
};

}  // namespace pathfit::optim
