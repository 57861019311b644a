#include "app/output/parameter_table.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <variant>

#include "optim/parameter/parameter_set.h"
#include "optim/parameter/promotion.h"
#include "renderer/core/indices.h"
#include "renderer/math/median.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::app {
namespace {

using renderer::ParameterKind;
using renderer::Scene;

constexpr std::size_t kMaxSeparateScalars = 3;
constexpr double kAtBoundRelative = 1e-6;

renderer::ParameterLayout LayoutOf(const optim::UnknownSpec& unknown, const Scene& scene) {
  renderer::ParameterLayout layout(scene);
  if (unknown.object >= 0) {
    layout.Add(unknown.kind, unknown.object);
    return layout;
  }
  const std::vector<int> sensors = renderer::AllIndices(scene.sensors.size());
  for (const optim::SensorGroup& group : optim::GroupsOfSensors(unknown, sensors)) {
    layout.Add(unknown.kind, group.first, group.sharing);
  }
  return layout;
}

/// Empty where others stand for it.
std::vector<double> ValuesOf(const optim::FitSpec& spec,
                             const optim::UnknownSpec& unknown,
                             const Scene& scene) {
  if (optim::IsReplaced(scene, unknown, spec.unknowns)) return {};
  return LayoutOf(unknown, scene).Gather(scene);
}

// ".x" of a scalar that has a component.
std::string ComponentOf(const optim::UnknownSpec& unknown, const Scene& scene, std::size_t scalar) {
  const renderer::ParameterLayout layout = LayoutOf(unknown, scene);
  const auto size = static_cast<std::size_t>(layout.groups().front().block_size);
  const auto block = static_cast<std::int32_t>(scalar / size);
  const std::string name = layout.ScalarName(block, static_cast<int>(scalar % size));
  return name.substr(layout.GroupOfBlock(block).name.size());
}

bool AtBound(double value, double bound) {
  return std::isfinite(bound) &&
         std::abs(value - bound) <= kAtBoundRelative * std::max(std::abs(bound), 1e-3);
}

/// One per scalar of the unknown, NaN where it is not known.
std::vector<double> ErrorsOf(const optim::UnknownSpec& unknown,
                             const Scene& scene,
                             const StandardErrorsByName& errors) {
  std::vector<double> all;
  const renderer::ParameterLayout layout = LayoutOf(unknown, scene);
  for (const renderer::ParameterGroup& group : layout.groups()) {
    const std::size_t size = group.NumScalars();
    const auto known = errors.find(group.name);
    if (known != errors.end() && known->second.size() == size) {
      all.insert(all.end(), known->second.begin(), known->second.end());
    } else {
      all.resize(all.size() + size, std::nan(""));
    }
  }
  return all;
}

double Mean(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? std::nan("") : sum / static_cast<double>(values.size());
}

ParameterSummary Summary(std::span<const double> initial,
                         std::span<const double> final,
                         double lower,
                         double upper) {
  ParameterSummary summary;
  summary.num_scalars = static_cast<std::int64_t>(final.size());
  summary.initial = Mean(initial);
  summary.value = Mean(final);
  summary.lower_bound = lower;
  summary.upper_bound = upper;
  if (final.empty()) return summary;
  const auto [least, most] = std::ranges::minmax_element(final);
  summary.minimum = *least;
  summary.maximum = *most;
  summary.rms_change = std::nan("");
  if (initial.size() == final.size()) {
    double squares = 0.0;
    for (std::size_t i = 0; i < final.size(); ++i) {
      squares += (final[i] - initial[i]) * (final[i] - initial[i]);
    }
    summary.rms_change = std::sqrt(squares / static_cast<double>(final.size()));
  }
  summary.num_at_bound = std::ranges::count_if(
      final, [&](double value) { return AtBound(value, lower) || AtBound(value, upper); });
  return summary;
}

}  // namespace

std::vector<ParameterSummary> SummarizeParameters(const optim::FitSpec& spec,
                                                  const Scene& start,
                                                  const Scene& result,
                                                  const StandardErrorsByName& errors) {
  std::vector<ParameterSummary> summaries;
  for (const optim::UnknownSpec& unknown : spec.unknowns) {
    if (optim::IsReplaced(result, unknown, spec.unknowns)) continue;
    const std::vector<double> initial = ValuesOf(spec, unknown, start);
    const std::vector<double> final = ValuesOf(spec, unknown, result);
    const std::vector<double> known = ErrorsOf(unknown, result, errors);
    double lower = unknown.lower, upper = unknown.upper;
    const bool exposure = optim::IsOfExposure(unknown.kind);
    if (exposure) {
      const double gain = initial.empty() ? 1.0 : Mean(initial);
      lower = std::max(lower, gain * std::exp2(-spec.exposure.max_ev));
      upper = std::min(upper, gain * std::exp2(spec.exposure.max_ev));
    }
    const bool separate =
        !exposure && final.size() <= kMaxSeparateScalars && initial.size() == final.size();
    const std::size_t step = separate ? 1 : std::max<std::size_t>(final.size(), 1);
    for (std::size_t i = 0; i < std::max<std::size_t>(final.size(), 1); i += step) {
      const bool whole = step >= final.size();
      ParameterSummary summary =
          whole
              ? Summary(initial, final, lower, upper)
              : Summary(
                    std::span(initial).subspan(i, 1), std::span(final).subspan(i, 1), lower, upper);
      summary.name = unknown.name;
      if (!whole) summary.name += ComponentOf(unknown, result, i);
      const renderer::ParameterTraits& traits =
          renderer::TraitsOf(unknown.kind, result, std::max(0, unknown.object));
      summary.unit = traits.unit;
      summary.held = unknown.hold;
      std::vector<double> told;
      const std::size_t end = std::min(i + step, known.size());
      for (std::size_t k = i; k < end; ++k) {
        summary.num_undetermined += std::isinf(known[k]) ? 1 : 0;
        if (std::isfinite(known[k])) told.push_back(known[k]);
      }
      const bool is_single = end == i + 1;
      summary.standard_error = is_single      ? known[i]
                               : told.empty() ? std::nan("")
                                              : renderer::Median(told);
      if (whole && final.size() > 1 && traits.IsPlace()) {
        summary.initial = summary.value = std::nan("");
      }
      summaries.push_back(std::move(summary));
    }
  }
  return summaries;
}

std::vector<double> GainErrors(const Scene& scene, const StandardErrorsByName& errors) {
  optim::UnknownSpec gains;
  gains.kind = ParameterKind::kExposure;
  gains.object = -1;
  return ErrorsOf(gains, scene, errors);
}

std::vector<double> BlockErrors(const Scene& scene,
                                ParameterKind kind,
                                int object,
                                std::size_t num_blocks,
                                const StandardErrorsByName& errors) {
  if (num_blocks == 0) return {};
  renderer::ParameterLayout layout(scene);
  layout.Add(kind, object);
  const renderer::ParameterGroup& group = layout.groups().front();
  const auto size = static_cast<std::size_t>(group.block_size);
  const auto known = errors.find(group.name);
  if (known == errors.end() || known->second.size() != size * num_blocks) return {};
  const auto is_known = [](double error) { return !std::isnan(error); };
  if (std::ranges::none_of(known->second, is_known)) return {};
  std::vector<double> roots;
  for (std::size_t b = 0; b < num_blocks; ++b) {
    // The root keeps what is infinite and what is not a number.
    double squares = 0.0;
    for (std::size_t c = 0; c < size; ++c) {
      const double error = known->second[size * b + c];
      squares += error * error;
    }
    roots.push_back(std::sqrt(squares));
  }
  return roots;
}

}  // namespace pathfit::app
