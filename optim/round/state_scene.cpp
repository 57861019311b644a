#include "optim/round/state_scene.h"

#include <numeric>

#include "optim/parameter/parameter_set.h"
#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

std::vector<int> AllOf(std::size_t count) {
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

}  // namespace

renderer::Scene SceneOfState(renderer::Scene start, const FitSpec& spec, const FitState& state) {
  ExposureModel exposure;
  for (const auto& sensor : start.sensors) {
    exposure.start_gains.push_back(sensor.gain);
  }
  exposure.sigma_ev = spec.exposure_sigma_ev;
  exposure.max_ev = spec.exposure_max_ev;
  const ParameterSet all(
      start, spec.unknowns, AllOf(spec.unknowns.size()), AllOf(start.sensors.size()), exposure);
  if (state.current.size() != all.NumScalars()) {
    throw renderer::IoError("the checkpoint belongs to another configuration");
  }
  all.layout().Scatter(state.current, start);
  return start;
}

}  // namespace pathfit::optim
