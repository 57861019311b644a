#include "optim/observation/located_point.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "optim/observation/short_number.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/math/frame.h"
#include "renderer/math/transform.h"

namespace pathfit::optim {
namespace {

using renderer::CameraModel;
using renderer::Cross;
using renderer::Dot;
using renderer::Mat3;
using renderer::Norm;
using renderer::Vec3;

constexpr double kLeastAngle = 2.0 * std::numbers::pi / 180.0;
constexpr double kMostOffPx = 3.0;
constexpr double kMostOffShare = 0.005;
constexpr int kMaxSteps = 20;

/// Sums of symmetric matrices and right-hand sides of three unknowns.
struct NormalEquations {
  Mat3 matrix{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  Vec3 right{0.0, 0.0, 0.0};

  void AddRow(const Vec3& row, double value) {
    matrix.x = matrix.x + row * row.x;
    matrix.y = matrix.y + row * row.y;
    matrix.z = matrix.z + row * row.z;
    right = right + row * value;
  }
  [[nodiscard]] Vec3 Solve() const {
    const double scale = 1.0 / Determinant(matrix);
    return {Dot(right, Cross(matrix.y, matrix.z)) * scale,
            Dot(matrix.x, Cross(right, matrix.z)) * scale,
            Dot(matrix.x, Cross(matrix.y, right)) * scale};
  }
};

struct FileSize {
  int width = 0, height = 0;
};
/// Of the photo; a view without a file has that of its camera.
FileSize SizeOfFile(const View& view) {
  return {view.file_width > 0 ? view.file_width : view.camera.width,
          view.file_height > 0 ? view.file_height : view.camera.height};
}

/// A pick with its camera and its ray.
class Sight {
 public:
  Sight(const View& view, const PickedPoint& pick)
      : model_(view.camera),
        name_(view.name),
        file_(SizeOfFile(view)),
        scale_x_(static_cast<double>(file_.width) / view.camera.width),
        scale_y_(static_cast<double>(file_.height) / view.camera.height),
        x_(pick.x),
        y_(pick.y),
        ray_(model_.RayThrough(pick.x / scale_x_, pick.y / scale_y_)) {}

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const renderer::Ray& ray() const { return ray_; }
  [[nodiscard]] double MostOff() const {
    return kMostOffPx + kMostOffShare * std::max(file_.width, file_.height);
  }
  /// Distance of the point from the ray, as two rows.
  void AddDistance(NormalEquations& equations) const {
    const renderer::Frame across = renderer::Frame::FromNormal(ray_.direction);
    for (const Vec3& row : {across.s, across.t}) equations.AddRow(row, Dot(row, ray_.origin));
  }
  /// Pixels of the file; empty where the camera does not see the point.
  struct Miss {
    double x = 0.0, y = 0.0;
    Vec3 dx, dy;
  };
  [[nodiscard]] std::optional<Miss> MissOf(const Vec3& point) const {
    const std::optional<renderer::Projection> seen = model_.Project(point);
    if (!seen) return std::nullopt;
    return Miss{
        seen->u * scale_x_ - x_, seen->v * scale_y_ - y_, seen->du * scale_x_, seen->dv * scale_y_};
  }

 private:
  CameraModel model_;
  std::string name_;
  FileSize file_;
  double scale_x_, scale_y_;  // pixels of the file per pixel of the view
  double x_, y_;
  renderer::Ray ray_;
};

double LargestAngle(const std::vector<Sight>& sights) {
  double most = 0.0;
  for (const Sight& a : sights) {
    for (const Sight& b : sights) {
      most = std::max(most, Norm(Cross(a.ray().direction, b.ray().direction)));
    }
  }
  return std::asin(std::min(1.0, most));
}

/// Sum of the squares of misses and the step that makes it least; empty where the point is not
/// seen.
struct Step {
  double cost = 0.0;
  Vec3 change;
};
std::optional<Step> StepAt(const std::vector<Sight>& sights, const Vec3& point) {
  NormalEquations equations;
  Step step;
  for (const Sight& sight : sights) {
    const auto miss = sight.MissOf(point);
    if (!miss) return std::nullopt;
    step.cost += miss->x * miss->x + miss->y * miss->y;
    equations.AddRow(miss->dx, -miss->x);
    equations.AddRow(miss->dy, -miss->y);
  }
  step.change = equations.Solve();
  return step;
}

}  // namespace

bool IsInPhoto(const View& view, double x, double y) {
  const FileSize file = SizeOfFile(view);
  return x >= 0.0 && y >= 0.0 && x <= file.width && y <= file.height;
}

LocatedPoint LocatePoint(const std::vector<View>& views, std::span<const PickedPoint> picks) {
  PATHFIT_CHECK(picks.size() >= 2);
  std::vector<Sight> sights;
  for (const PickedPoint& pick : picks) sights.emplace_back(views[pick.view], pick);
  const double angle = LargestAngle(sights);
  if (angle < kLeastAngle) {
    throw renderer::SceneError("the photos see it from nearly the same side (their rays are " +
                               ShortNumber(angle * 180.0 / std::numbers::pi) +
                               " degrees apart, at least 2 are needed); pick it in photos from "
                               "sides that differ more");
  }
  NormalEquations nearest;
  for (const Sight& sight : sights) sight.AddDistance(nearest);
  Vec3 point = nearest.Solve();
  std::optional<Step> step = StepAt(sights, point);
  for (int i = 0; i < kMaxSteps && step; ++i) {
    const Vec3 next = point + step->change;
    const std::optional<Step> after = StepAt(sights, next);
    if (!after || !(after->cost < step->cost)) break;
    point = next;
    step = after;
  }
  LocatedPoint located{point, {}};
  for (const Sight& sight : sights) {
    const auto miss = sight.MissOf(point);
    if (!miss) {
      throw renderer::SceneError("the rays of its picks meet where " + sight.name() +
                                 " does not see; are all of them the same mark?");
    }
    located.off_px.push_back(std::hypot(miss->x, miss->y));
  }
  for (std::size_t i = 0; i < sights.size(); ++i) {
    if (located.off_px[i] <= sights[i].MostOff()) continue;
    throw renderer::SceneError("its picks do not belong together: the nearest point is seen " +
                               ShortNumber(located.off_px[i]) + " pixels from the pick in " +
                               sights[i].name() + " (at most " + ShortNumber(sights[i].MostOff()) +
                               "); are all of them the same mark, and the cameras right?");
  }
  return located;
}

}  // namespace pathfit::optim
