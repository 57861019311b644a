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

constexpr double kTurn = 0.35;  // rad

/// Of one rotation after another, both as vectors: the product of their quaternions.
renderer::Vec3 Composed(const renderer::Vec3& second, const renderer::Vec3& first) {
  struct Quaternion {
    double w;
    renderer::Vec3 v;
  };
  const auto quaternion = [](const renderer::Vec3& vector) {
    const double angle = Norm(vector);
    const double share = angle > 0.0 ? std::sin(0.5 * angle) / angle : 0.5;
    return Quaternion{std::cos(0.5 * angle), vector * share};
  };
  const Quaternion a = quaternion(second), b = quaternion(first);
  const double w = a.w * b.w - Dot(a.v, b.v);
  const renderer::Vec3 v = b.v * a.w + a.v * b.w + Cross(a.v, b.v);
  const double sine = Norm(v);
  return sine > 0.0 ? v * (2.0 * std::atan2(sine, w) / sine) : renderer::Vec3{};
}

}  // namespace

std::vector<renderer::Scene> TurnedStarts(const renderer::Scene& scene,
                                          const UnknownSpec& unknown) {
  if (unknown.kind != renderer::ParameterKind::kObjectRotation || unknown.hold ||
      unknown.gaussian) {
    return {};
  }
  std::vector<renderer::Scene> starts;
  for (const renderer::Vec3& axis : {renderer::Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
    for (const double turn : {-kTurn, kTurn}) {
      renderer::Scene& start = starts.emplace_back(scene);
      renderer::Vec3& rotation =
          start.meshes[static_cast<std::size_t>(unknown.object)].pose.rotation;
      rotation = Composed(axis * turn, rotation);
    }
  }
  return starts;
}

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
