#include "optim/round/other_starts.h"

#include <algorithm>
#include <cmath>

#include "optim/parameter/promotion.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::optim {
namespace {

constexpr double kElsewhere = 0.1;  // from a start

renderer::ParameterLayout LayoutOf(const renderer::Scene& scene, const UnknownSpec& unknown) {
  renderer::ParameterLayout layout(scene);
  layout.Add(unknown.kind, unknown.object);
  return layout;
}

}  // namespace

std::vector<double> OtherStarts(const renderer::Scene& scene,
                                const UnknownSpec& unknown,
                                const std::vector<UnknownSpec>& unknowns) {
  std::vector<double> values;
  if (unknown.kind != renderer::ParameterKind::kMetallic || unknown.hold || unknown.gaussian ||
      IsReplaced(scene, unknown, unknowns)) {
    return values;
  }
  const double start = StartOf(scene, unknown);
  for (const double end : {0.0, 1.0}) {
    const double value = std::clamp(end, unknown.lower, unknown.upper);
    if (std::abs(value - start) > kElsewhere) {
      values.push_back(value);
    }
  }
  return values;
}

renderer::Scene StartingAt(renderer::Scene scene, const UnknownSpec& unknown, double value) {
  LayoutOf(scene, unknown).Scatter({value}, scene);
  return scene;
}

double StartOf(const renderer::Scene& scene, const UnknownSpec& unknown) {
  return LayoutOf(scene, unknown).Gather(scene).front();
}

}  // namespace pathfit::optim
