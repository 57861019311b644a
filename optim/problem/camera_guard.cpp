#include "optim/problem/camera_guard.h"

#include <cstddef>
#include <utility>

#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

using renderer::ParameterKind;

constexpr int kHalvings = 20;
// Of the way to the border: from on it no further step of the lens would lead anywhere.
constexpr double kShareOfWay = 0.9;

bool IsLens(ParameterKind kind) {
  return kind == ParameterKind::kRadialDistortion || kind == ParameterKind::kTangentialDistortion ||
         kind == ParameterKind::kVignetting;
}

}  // namespace

CameraGuard::CameraGuard(const renderer::Scene& scene,
                         const ParameterSet& set,
                         const std::vector<double>& values) {
  sensors_.sensors = scene.sensors;
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (renderer::TraitsOf(group.kind).list == renderer::ObjectList::kSensors) {
      renderer::ParameterLayout layout(sensors_);
      layout.Add(group.kind, group.object, group.sharing);
      moving_.insert(group.object);
      moving_.insert(group.sharing.begin(), group.sharing.end());
      const auto first = values.begin() + group.first_scalar;
      const std::size_t count = group.NumScalars();
      std::vector<double> start;
      if (IsLens(group.kind)) start.assign(first, first + static_cast<std::ptrdiff_t>(count));
      groups_.push_back({std::move(layout),
                         static_cast<std::size_t>(group.first_scalar),
                         count,
                         std::move(start)});
    }
  }
}

bool CameraGuard::Restrain(std::vector<double>& values) const {
  if (CanRender(values)) return true;
  double share = 0.0, step = 0.5;
  if (!CanRender(Shortened(values, share))) return false;
  for (int i = 0; i < kHalvings; ++i, step *= 0.5) {
    if (CanRender(Shortened(values, share + step))) share += step;
  }
  std::vector<double> shortened = Shortened(values, kShareOfWay * share);
  if (!CanRender(shortened)) return false;
  values = std::move(shortened);
  return true;
}

bool CameraGuard::CanRender(const std::vector<double>& values) const {
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

std::vector<double> CameraGuard::Shortened(const std::vector<double>& wanted, double share) const {
  std::vector<double> values = wanted;
  for (const Group& group : groups_) {
    for (std::size_t i = 0; i < group.start.size(); ++i) {
      double& value = values[group.first + i];
      value = group.start[i] + share * (value - group.start[i]);
    }
  }
  return values;
}

}  // namespace pathfit::optim
