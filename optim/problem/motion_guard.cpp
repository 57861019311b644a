#include "optim/problem/motion_guard.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pathfit::optim {
namespace {

constexpr std::size_t kMaxPointsPerMesh = 500;

bool IsInside(const renderer::Vec2& p, const renderer::Camera& camera) {
  return p.x >= 0.0 && p.y >= 0.0 && p.x <= camera.width && p.y <= camera.height;
}

}  // namespace

MotionGuard::MotionGuard(const renderer::Scene& scene,
                         const ParameterSet& set,
                         const FitViews& views,
                         const std::vector<double>& values)
    : scene_(scene),
      set_(set),
      views_(views),
      anything_moves_(set.layout().AnyKind(renderer::MovesInImages)) {
  if (anything_moves_) {
    start_ = See(values);
  }
}

MotionGuard::Seen MotionGuard::See(const std::vector<double>& values) const {
  renderer::Scene scene = scene_;
  set_.layout().Scatter(values, scene);
  std::vector<renderer::CameraModel> cameras;
  for (const int view : views_.fitted) {
    const auto v = static_cast<std::size_t>(view);
    const renderer::Camera& level = views_.levels[v].camera();
    cameras.emplace_back(renderer::ScaledCamera(scene.sensors[v], level.width, level.height));
  }
  Seen seen;
  for (const renderer::SceneMesh& mesh : scene.meshes) {
    renderer::SceneMesh thinned;
    thinned.pose = mesh.pose;
    std::vector<renderer::Vec3> points;
    const std::size_t stride = mesh.mesh.positions.size() / kMaxPointsPerMesh + 1;
    for (std::size_t i = 0; i < mesh.mesh.positions.size(); i += stride) {
      points.push_back(mesh.mesh.positions[i]);
    }
    thinned.mesh.positions = std::move(points);
    const renderer::Mesh placed = renderer::WorldMesh(thinned);
    std::vector<std::optional<renderer::Vec2>> pixels;
    for (const renderer::CameraModel& camera : cameras) {
      for (std::size_t i = 0; i < placed.positions.size(); ++i) {
        const auto projection = camera.Project(placed.positions[i]);
        pixels.push_back(projection ? std::optional(renderer::Vec2{projection->u, projection->v})
                                    : std::nullopt);
      }
    }
    seen.push_back(std::move(pixels));
  }
  return seen;
}

double MotionGuard::LargestMotion(const std::vector<double>& values) const {
  double largest = 0.0;
  const Seen moved = anything_moves_ ? See(values) : Seen();
  for (std::size_t m = 0; m < moved.size(); ++m) {
    const std::size_t per_view = moved[m].size() / std::max<std::size_t>(1, views_.fitted.size());
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < moved[m].size(); ++i) {
      const auto view = static_cast<std::size_t>(views_.fitted[i / per_view]);
      const renderer::Camera& camera = views_.levels[view].camera();
      const auto& before = start_[m][i];
      if (before && IsInside(*before, camera)) {
        const double dx = moved[m][i] ? moved[m][i]->x - before->x : camera.width;
        const double dy = moved[m][i] ? moved[m][i]->y - before->y : camera.height;
        sum += dx * dx + dy * dy;
        ++count;
      }
    }
    if (count > 0) {
      largest = std::max(largest, std::sqrt(sum / static_cast<double>(count)));
    }
  }
  return largest;
}

}  // namespace pathfit::optim
