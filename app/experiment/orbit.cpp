#include "app/experiment/orbit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "renderer/core/error.h"
#include "renderer/math/box.h"

namespace pathfit::app {
namespace {

using renderer::Camera;
using renderer::Mat3;
using renderer::Transform;
using renderer::Vec3;

constexpr double kSnap = 0.9994;    // cosine of two degrees
constexpr double kAgrees = 0.5;     // cosine between the two ways to tell what is up
constexpr int kIterations = 200;    // of the power iteration; directions need few digits
constexpr double kRoom = 1.15;      // of the ball that fills the picture
constexpr double kLeastSide = 0.2;  // of the distance, off the vertical

/// Unit, or +y of what is too short to have a direction.
Vec3 UnitOr(const Vec3& v, const Vec3& otherwise) {
  const double length = Norm(v);
  return length > 1e-9 ? v * (1.0 / length) : otherwise;
}

/// Ball about all meshes, from the middle of their box.
struct Ball {
  Vec3 centre;
  double radius = 0.0;
};

Ball BallOfMeshes(const renderer::Scene& scene) {
  renderer::Box box;
  const std::vector<renderer::Mesh> meshes = renderer::WorldMeshes(scene);
  for (const renderer::Mesh& mesh : meshes) {
    box.Include(renderer::BoxAround(mesh.positions));
  }
  Ball ball{box.Middle()};
  for (const renderer::Mesh& mesh : meshes) {
    for (const Vec3& p : mesh.positions) ball.radius = std::max(ball.radius, Norm(p - ball.centre));
  }
  return ball;
}

}  // namespace

Vec3 UpDirection(const renderer::Scene& scene) {
  Vec3 mean;
  for (const Camera& camera : scene.sensors) mean += renderer::CameraPose(camera).linear.y;
  mean = UnitOr(mean, {0.0, 1.0, 0.0});
  // The power iteration of (1 - mean of x x^T) finds what is most across the x axes.
  Vec3 up = mean;
  for (int i = 0; i < kIterations && scene.sensors.size() > 1; ++i) {
    Vec3 next = up;
    for (const Camera& camera : scene.sensors) {
      const Vec3 x = renderer::CameraPose(camera).linear.x;
      next -= x * (Dot(x, up) / static_cast<double>(scene.sensors.size()));
    }
    up = UnitOr(next, mean);
  }
  if (Dot(up, mean) < kAgrees) up = mean;
  for (const Vec3& axis : {Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}}) {
    if (std::abs(Dot(axis, up)) > kSnap) up = Dot(axis, up) > 0.0 ? axis : -axis;
  }
  return up;
}

std::vector<Camera> OrbitCameras(const renderer::Scene& scene, int count) {
  if (scene.sensors.empty() || scene.meshes.empty()) {
    throw renderer::SceneError("an orbit needs a mesh to go round and a camera to begin with");
  }
  const Vec3 up = UpDirection(scene);
  const Ball ball = BallOfMeshes(scene);
  const auto num_cameras = static_cast<double>(scene.sensors.size());
  double distance = 0.0, height = 0.0, exposure = 0.0;
  for (const Camera& camera : scene.sensors) {
    const Vec3 from = renderer::CameraPose(camera).translation - ball.centre;
    distance += Norm(from) / num_cameras;
    height += Dot(from, up) / num_cameras;
    exposure += std::log(camera.gain) / num_cameras;
  }
  Camera camera = scene.sensors.front();
  const Vec3 first = renderer::CameraPose(camera).translation - ball.centre;
  camera.distortion = {};
  camera.vignetting = {};
  camera.fx = camera.fy = std::sqrt(camera.fx * camera.fy);
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  camera.gain = std::exp(exposure);
  camera.rotation = {};
  if (camera.projection == renderer::ProjectionKind::kPerspective) {
    const double half_side = 0.5 * std::min(camera.width, camera.height) / camera.fx;
    const double sine = half_side / std::sqrt(1.0 + half_side * half_side);
    const double least = kRoom * ball.radius / sine;
    if (distance < least) {
      height = distance > 0.0 ? height * (least / distance) : 0.0;
      distance = least;
    }
  }
  if (!(distance > 0.0)) distance = ball.radius;
  const double highest = std::sqrt(1.0 - kLeastSide * kLeastSide) * distance;
  height = std::clamp(height, -highest, highest);
  const double side = std::sqrt(distance * distance - height * height);
  const Vec3 across = std::abs(up.x) < 0.9 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 0.0, 1.0};
  const Vec3 start = UnitOr(first - up * Dot(first, up), Normalized(across - up * Dot(across, up)));
  const Vec3 quarter = Cross(up, start);
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / count;
    const Vec3 origin = ball.centre + up * height + start * (side * std::cos(angle)) +
                        quarter * (side * std::sin(angle));
    camera.name = fmt::format("orbit_{:03}", i);
    camera.world_from_camera = renderer::LookAt(origin, ball.centre, up);
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace pathfit::app
