#include "optim/round/exposure_gauge.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pathfit::optim {
using renderer::ParameterKind;

int GroupOfStrength(const ParameterSet& set, int object) {
  const auto& groups = set.layout().groups();
  int found = -1;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].object != object) {
      continue;
    }
    if (groups[g].kind == ParameterKind::kLightIntensity) {
      return static_cast<int>(g);
    }
    if (groups[g].kind == ParameterKind::kEnvironmentTexels) {
      found = static_cast<int>(g);
    }
  }
  return found;
}

bool ClampToBounds(const ParameterSet& set, std::vector<double>& values) {
  constexpr double kInvisible = 1e-5;  // of the group's largest value
  const std::vector<double> clamped = set.ValuesFromTheta(set.ThetaFromValues(values));
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    const auto first = static_cast<std::size_t>(group.first_scalar);
    const std::size_t count = group.NumScalars();
    double change = 0.0, largest = 0.0;
    for (std::size_t i = first; i < first + count; ++i) {
      change = std::max(change, std::abs(clamped[i] - values[i]));
      largest = std::max(largest, std::abs(values[i]));
    }
    if (!(change <= kInvisible * largest)) {
      return false;
    }
  }
  values = clamped;
  return true;
}

ExposureModel MakeExposureModel(const renderer::Scene& scene, const ExposurePrior& prior) {
  ExposureModel exposure{{}, prior};
  for (const renderer::Camera& sensor : scene.sensors) {
    exposure.start_gains.push_back(sensor.gain);
  }
  return exposure;
}

void FixExposureGauge(const ParameterSet& set,
                      const std::vector<int>& fitted,
                      const ExposureModel& exposure,
                      renderer::Scene& scene) {
  double mean = 0.0;
  for (const int view : fitted) {
    const auto v = static_cast<std::size_t>(view);
    if (set.layout().FirstBlock(ParameterKind::kExposure, view) < 0) {
      return;
    }
    mean += std::log(scene.sensors[v].gain / exposure.start_gains[v]) /
            static_cast<double>(fitted.size());
  }
  std::vector<double> values = set.layout().Gather(scene);
  const double factor = std::exp(mean);
  for (std::size_t e = 0; e < scene.emitters.size(); ++e) {
    const int g = GroupOfStrength(set, static_cast<int>(e));
    if (g < 0) {
      return;
    }
    const renderer::ParameterGroup& group = set.layout().groups()[static_cast<std::size_t>(g)];
    const auto first = static_cast<std::size_t>(group.first_scalar);
    const std::size_t count = group.NumScalars();
    for (std::size_t i = first; i < first + count; ++i) {
      values[i] *= factor;
    }
  }
  for (const int view : fitted) {
    const std::int32_t block = set.layout().FirstBlock(ParameterKind::kExposure, view);
    values[set.BlockOffset(block)] /= factor;
  }
  if (ClampToBounds(set, values)) {
    set.layout().Scatter(values, scene);
  }
}

double EstimateGainFactor(const ViewLevel& level,
                          const renderer::Film& a,
                          const renderer::Film& b) {
  double numerator = 0.0, denominator = 0.0;
  for (std::size_t p = 0; p < a.pixels.size(); ++p) {
    const auto weight = static_cast<double>(level.color_weight.data[p]);
    const bool clipped = !level.clipped.Empty() && level.clipped.data[p] > 0.0F;
    for (std::size_t c = 0; weight > 0.0 && !clipped && c < 3; ++c) {
      const double f_a = a.pixels[p][static_cast<int>(c)];
      const double f_b = b.pixels[p][static_cast<int>(c)];
      numerator += weight * 0.5 * (f_a + f_b) * static_cast<double>(level.photo.data[3 * p + c]);
      denominator += weight * f_a * f_b;
    }
  }
  const bool usable = numerator > 0.0 && denominator > 0.0;
  return usable ? numerator / denominator : 1.0;
}

}  // namespace pathfit::optim
