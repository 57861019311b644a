#include "optim/problem/camera_guard.h"

#include <cstddef>
#include <utility>

#include "renderer/core/error.h"

namespace pathfit::optim {

CameraGuard::CameraGuard(const renderer::Scene& scene, const ParameterSet& set) {
  sensors_.sensors = scene.sensors;
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (renderer::TraitsOf(group.kind).list == renderer::ObjectList::kSensors) {
      renderer::ParameterLayout layout(sensors_);
      layout.Add(group.kind, group.object, group.sharing);
      moving_.insert(group.object);
      moving_.insert(group.sharing.begin(), group.sharing.end());
      groups_.push_back(
          {std::move(layout), static_cast<std::size_t>(group.first_scalar), group.NumScalars()});
    }
  }
}

bool CameraGuard::Admits(const std::vector<double>& values) const {
  renderer::Scene trial = sensors_;
  for (const Group& group : groups_) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(group.first);
    group.layout.Scatter({first, first + static_cast<std::ptrdiff_t>(group.count)}, trial);
  }
  try {
    for (const int sensor : moving_) {
      const renderer::CameraModel model(trial.sensors[static_cast<std::size_t>(sensor)]);
    }
  } catch (const renderer::SceneError&) {
    return false;
  }
  return true;
}

}  // namespace pathfit::optim
