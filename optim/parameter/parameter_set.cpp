#include "optim/parameter/parameter_set.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "optim/parameter/promotion.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

// A logarithmic unknown cannot be zero: darker values count as this.
constexpr double kSmallestLogValue = 1e-6;
constexpr double kSmallestScale = 1e-6;  // an object of size zero has no surface
// Cones: the ratio, and the outer angle, below a right angle. At an inner angle of zero nothing
// would say how it should change.
constexpr double kSmallestRatio = 1e-4, kLargestRatio = 0.98;
constexpr double kSmallestOuterAngle = 0.01, kLargestOuterAngle = 1.55;

bool IsOfSensors(renderer::ParameterKind kind) {
  return renderer::TraitsOf(kind).list == renderer::ObjectList::kSensors;
}

double OneMinusCos(double x) {
  const double s = std::sin(0.5 * x);
  return 2.0 * s * s;
}

}  // namespace

double StartOfGain(const ExposureModel& exposure, renderer::ParameterKind kind, int sensor) {
  return kind == renderer::ParameterKind::kExposure
             ? std::log(exposure.start_gains.at(static_cast<std::size_t>(sensor)))
             : 0.0;
}

std::vector<SensorGroup> GroupsOfSensors(const UnknownSpec& unknown,
                                         const std::vector<int>& sensors) {
  const std::vector<int>& first_of = unknown.sharing;
  std::vector<SensorGroup> groups;
  for (const int sensor : sensors) {
    const int first = first_of.empty() ? sensor : first_of.at(static_cast<std::size_t>(sensor));
    if (std::ranges::find(groups, first, &SensorGroup::first) == groups.end()) {
      groups.push_back({first, {}});
    }
  }
  for (SensorGroup& group : groups) {
    for (int other = 0; other < static_cast<int>(first_of.size()); ++other) {
      if (other != group.first && first_of[static_cast<std::size_t>(other)] == group.first) {
        group.sharing.push_back(other);
      }
    }
  }
  return groups;
}

ParameterSet::ParameterSet(const renderer::Scene& scene,
                           const std::vector<UnknownSpec>& unknowns,
                           const std::vector<int>& active,
                           const std::vector<int>& sensors,
                           const ExposureModel& exposure)
    : layout_(scene) {
  std::vector<int> order;
  for (const int index : active) {
    if (index < 0 || index >= static_cast<int>(unknowns.size())) {
      throw renderer::SceneError("a stage frees unknown number " + std::to_string(index) +
                                 "; there are " + std::to_string(unknowns.size()));
    }
    const UnknownSpec& unknown = unknowns[static_cast<std::size_t>(index)];
    if (!unknown.hold && !IsReplaced(scene, unknown, unknowns)) order.push_back(index);
  }
  std::ranges::stable_sort(order, [&](int a, int b) {
    return unknowns[static_cast<std::size_t>(a)].kind < unknowns[static_cast<std::size_t>(b)].kind;
  });
  for (const int index : order) {
    const UnknownSpec& unknown = unknowns[static_cast<std::size_t>(index)];
    if (IsOfSensors(unknown.kind) && unknown.object < 0) {
      for (const SensorGroup& group : GroupsOfSensors(unknown, sensors)) {
        AddGroup(scene, unknown, index, group.first, group.sharing, exposure);
      }
    } else {
      AddGroup(scene, unknown, index, unknown.object, {}, exposure);
    }
  }
}

void ParameterSet::AddGroup(const renderer::Scene& scene,
                            const UnknownSpec& unknown,
                            int index,
                            int object,
                            std::vector<int> sharing,
                            const ExposureModel& exposure) {
  layout_.Add(unknown.kind, object, std::move(sharing));
  unknown_of_group_.push_back(index);
  const renderer::ParameterGroup& group = layout_.groups().back();
  const bool is_gain = IsOfExposure(unknown.kind);
  const bool is_log = is_gain || unknown.parameterization == Parameterization::kLog;
  double lower = unknown.lower;
  double upper = unknown.upper;
  if (unknown.kind == renderer::ParameterKind::kObjectScale) {
    lower = std::max(lower, kSmallestScale);
  }
  if (is_log && !is_gain) {
    lower = std::log(std::max(lower, kSmallestLogValue));
    upper = std::log(std::max(upper, kSmallestLogValue));
  } else if (is_gain) {
    const double start = StartOfGain(exposure, unknown.kind, object);
    lower = start - exposure.prior.max_ev * std::log(2.0);
    upper = start + exposure.prior.max_ev * std::log(2.0);
  }
  const auto block_size = static_cast<std::size_t>(group.block_size);
  const auto num_blocks = static_cast<std::size_t>(group.num_blocks);
  const std::size_t count = mapping_.size() + group.NumScalars();
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    throw renderer::SceneError("more than 2^32 numbers are free at once");
  }
  for (std::size_t i = 0; i < num_blocks; ++i) {
    block_offset_.push_back(static_cast<std::uint32_t>(mapping_.size() + i * block_size));
  }
  block_size_.resize(block_size_.size() + num_blocks, static_cast<std::uint8_t>(block_size));
  if (unknown.kind == renderer::ParameterKind::kLightRotation) {
    const renderer::Emitter& light = scene.emitters[static_cast<std::size_t>(object)];
    if (const std::optional<renderer::Vec3> axis = renderer::AxisOfSymmetry(light)) {
      turns_.push_back({group.first_block, *axis});
    }
  }
  mapping_.resize(count, is_log ? Mapping::kLog : Mapping::kIdentity);
  if (unknown.kind == renderer::ParameterKind::kSpotAngles) {
    mapping_[count - 2] = Mapping::kCone;
    runs_.push_back({count - 1, kSmallestRatio, kLargestRatio});
    runs_.push_back({count, kSmallestOuterAngle, kLargestOuterAngle});
  } else {
    const double factor = renderer::TraitsOf(unknown.kind).largest_factor;
    runs_.push_back(is_log && !is_gain
                        ? Run{count, lower, upper, factor, unknown.lower, unknown.upper}
                        : Run{count, lower, upper, factor});
  }
}

void ParameterSet::DropTurnsAboutAxes(const std::vector<double>& from,
                                      std::vector<double>& to) const {
  for (const Turn& turn : turns_) {
    const std::size_t first = BlockOffset(turn.block);
    const renderer::Vec3 step{
        to[first] - from[first], to[first + 1] - from[first + 1], to[first + 2] - from[first + 2]};
    const renderer::Vec3 about = turn.axis * Dot(step, turn.axis);
    to[first] -= about.x;
    to[first + 1] -= about.y;
    to[first + 2] -= about.z;
  }
}

std::array<double, 2> ParameterSet::ConeSlopes(double inner, double outer) {
  // 1 - cos(inner) = ratio (1 - cos(outer))
  const double u_outer = OneMinusCos(outer);
  const double sine = std::sin(inner);
  return {u_outer / sine, OneMinusCos(inner) / u_outer * std::sin(outer) / sine};
}

std::vector<bool> ParameterSet::InsideBounds(const std::vector<double>& theta) const {
  std::vector<bool> inside(theta.size());
  for (std::size_t i = 0; i < theta.size(); ++i) {
    inside[i] = theta[i] > Lower(i) && theta[i] < Upper(i);
  }
  return inside;
}

std::vector<double> ParameterSet::ThetaFromValues(const std::vector<double>& values) const {
  PATHFIT_CHECK_EQ(values.size(), NumScalars());
  std::vector<double> theta(values.size());
  auto run = runs_.begin();
  for (std::size_t i = 0; i < values.size(); ++i) {
    double t = values[i];
    if (IsLog(i)) {
      t = std::log(std::max(t, kSmallestLogValue));
    } else if (mapping_[i] == Mapping::kCone) {
      t = OneMinusCos(t) / OneMinusCos(std::max(values[i + 1], kSmallestOuterAngle));
    }
    if (i == run->end) {
      ++run;
    }
    theta[i] = std::clamp(t, run->lower, run->upper);
  }
  return theta;
}

std::vector<double> ParameterSet::ValuesFromTheta(const std::vector<double>& theta) const {
  PATHFIT_CHECK_EQ(theta.size(), NumScalars());
  std::vector<double> values(theta.size());
  auto run = runs_.begin();
  for (std::size_t i = 0; i < theta.size(); ++i) {
    if (i == run->end) {
      ++run;
    }
    if (IsLog(i)) {
      values[i] = std::clamp(std::exp(theta[i]), run->least, run->most);
    } else if (mapping_[i] == Mapping::kCone) {
      values[i] = 2.0 * std::asin(std::sqrt(theta[i]) * std::sin(0.5 * theta[i + 1]));
    } else {
      values[i] = theta[i];
    }
  }
  return values;
}

void MoveIntoBounds(const std::vector<UnknownSpec>& unknowns, renderer::Scene& scene) {
  for (const UnknownSpec& unknown : unknowns) {
    if (unknown.hold || IsReplaced(scene, unknown, unknowns)) {
      continue;
    }
    renderer::ParameterLayout layout(scene);
    layout.Add(unknown.kind, unknown.object);
    std::vector<double> values = layout.Gather(scene);
    bool is_inside = true;
    for (double& value : values) {
      const double start = std::exchange(value, std::clamp(value, unknown.lower, unknown.upper));
      is_inside = is_inside && value == start;
    }
    if (!is_inside) {
      layout.Scatter(values, scene);
    }
  }
}

int GroupOfStrength(const ParameterSet& set, int object) {
  const auto& groups = set.layout().groups();
  int found = -1;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].object != object) {
      continue;
    }
    if (groups[g].kind == renderer::ParameterKind::kLightIntensity) {
      return static_cast<int>(g);
    }
    if (groups[g].kind == renderer::ParameterKind::kEnvironmentTexels) {
      found = static_cast<int>(g);
    }
  }
  return found;
}

}  // namespace pathfit::optim
