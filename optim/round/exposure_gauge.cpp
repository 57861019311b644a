#include "optim/round/exposure_gauge.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pathfit::optim {
using renderer::ParameterKind;

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
  const auto block_of = [&](ParameterKind kind, int view) {
    return set.layout().FirstBlock(kind, view);
  };
  const bool has_gains = std::ranges::all_of(
      fitted, [&](int view) { return block_of(ParameterKind::kExposure, view) >= 0; });
  const bool has_balances = std::ranges::all_of(
      fitted, [&](int view) { return block_of(ParameterKind::kWhiteBalance, view) >= 0; });
  if (!has_gains && !has_balances) {
    return;
  }
  double gain = 0.0, red = 0.0, blue = 0.0;  // mean logarithms
  for (const int view : fitted) {
    const auto v = static_cast<std::size_t>(view);
    const renderer::Camera& sensor = scene.sensors[v];
    const auto count = static_cast<double>(fitted.size());
    if (has_gains) gain += std::log(sensor.gain / exposure.start_gains[v]) / count;
    if (has_balances) red += std::log(sensor.red) / count;
    if (has_balances) blue += std::log(sensor.blue) / count;
  }
  std::vector<double> values = set.layout().Gather(scene);
  const renderer::Rgb factors = {std::exp(gain + red), std::exp(gain), std::exp(gain + blue)};
  for (std::size_t e = 0; e < scene.emitters.size(); ++e) {
    const int g = GroupOfStrength(set, static_cast<int>(e));
    if (g < 0) {
      return;
    }
    const renderer::ParameterGroup& group = set.layout().groups()[static_cast<std::size_t>(g)];
    const auto first = static_cast<std::size_t>(group.first_scalar);
    const std::size_t count = group.NumScalars();
    for (std::size_t i = 0; i < count; ++i) {
      values[first + i] *= factors[static_cast<int>(i % 3)];
    }
  }
  for (const int view : fitted) {
    if (has_gains) {
      values[set.BlockOffset(block_of(ParameterKind::kExposure, view))] /= std::exp(gain);
    }
    if (has_balances) {
      const std::size_t offset = set.BlockOffset(block_of(ParameterKind::kWhiteBalance, view));
      values[offset] /= std::exp(red);
      values[offset + 1] /= std::exp(blue);
    }
  }
  if (ClampToBounds(set, values)) {
    set.layout().Scatter(values, scene);
  }
}

FreeGains FreeGainsOf(const std::vector<UnknownSpec>& unknowns) {
  const auto is_free = [&](ParameterKind kind) {
    return std::ranges::any_of(unknowns, [kind](const UnknownSpec& unknown) {
      return unknown.kind == kind && !unknown.hold;
    });
  };
  if (is_free(ParameterKind::kWhiteBalance)) return FreeGains::kPerChannel;
  return is_free(ParameterKind::kExposure) ? FreeGains::kOne : FreeGains::kNone;
}

renderer::Rgb EstimateGainFactors(const ViewLevel& level,
                                  const renderer::Film& a,
                                  const renderer::Film& b,
                                  FreeGains free) {
  renderer::Rgb factors = renderer::Rgb::Constant(1.0);
  if (free == FreeGains::kNone) return factors;
  renderer::Rgb numerator, denominator;
  for (std::size_t p = 0; p < a.pixels.size(); ++p) {
    const auto weight = static_cast<double>(level.color_weight.data[p]);
    const bool clipped = !level.clipped.Empty() && level.clipped.data[p] > 0.0F;
    for (int c = 0; weight > 0.0 && !clipped && c < 3; ++c) {
      const double f_a = a.pixels[p][c];
      const double f_b = b.pixels[p][c];
      const int sum = free == FreeGains::kOne ? 0 : c;
      numerator[sum] += weight * 0.5 * (f_a + f_b) *
                        static_cast<double>(level.photo.data[3 * p + static_cast<std::size_t>(c)]);
      denominator[sum] += weight * f_a * f_b;
    }
  }
  for (int c = 0; c < 3; ++c) {
    const int sum = free == FreeGains::kOne ? 0 : c;
    if (numerator[sum] > 0.0 && denominator[sum] > 0.0) {
      factors[c] = numerator[sum] / denominator[sum];
    }
  }
  return factors;
}

}  // namespace pathfit::optim
