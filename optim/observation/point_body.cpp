#include "optim/observation/point_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "optim/observation/reduced_camera.h"
#include "optim/observation/voxel_surface.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/math/median.h"

namespace pathfit::optim {
namespace {

using renderer::CameraModel;
using renderer::Mesh;
using renderer::Projection;
using renderer::Vec3;

// More points, and more cameras, tell no more of a start; they are taken evenly.
constexpr std::size_t kFewestPoints = 200, kMostPoints = 8000;
constexpr std::size_t kFewestCameras = 6, kMostCameras = 100;
constexpr std::size_t kNeighbours = 8;
constexpr double kLonely = 3.0;  // times as far from them as the median point: a mismatch
constexpr double kReach = 1.35;  // radius of a disc, in distances to the neighbours
constexpr double kLeastReach = 0.05, kMostReach = 0.3;  // in radii of the ball
constexpr int kDepthPx = 170;                           // longest side of a depth map
constexpr int kVoxels = 80;                             // along the ball's diameter
constexpr int kFewestViews = 4;                         // that must see a voxel
constexpr double kEmpty = 0.2;  // share of the views that see through a voxel of the body at most
constexpr double kRim = 0.9;    // of the ball's radius: a body that ends is not beyond,
constexpr double kRimFilled = 0.35;    // but for this share, which others hide,
constexpr double kLeastFilled = 5e-3;  // and fills so much of the ball
constexpr double kCutApart = 0.02;     // voxels
constexpr float kSurfaceOff = 0.01F;   // of a node, in shares of views

/// Every n-th, so that at most `most` are left.
template <class Value>
std::vector<Value> Thinned(const std::vector<Value>& values, std::size_t most) {
  if (values.size() <= most) return values;
  std::vector<Value> out;
  for (std::size_t i = 0; i < most; ++i) out.push_back(values[i * values.size() / most]);
  return out;
}

/// A point that hides what is behind it.
struct Disc {
  Vec3 at;
  double reach = 0.0;
};

/// How far each point's neighbours are away: the distance to the eighth.
std::vector<double> DistancesToNeighbours(const std::vector<Vec3>& points) {
  std::vector<double> distances(points.size());
  renderer::ParallelFor(static_cast<std::int64_t>(points.size()), [&](std::int64_t i) {
    std::vector<double> squares;
    for (const Vec3& other : points) {
      squares.push_back(SquaredNorm(other - points[static_cast<std::size_t>(i)]));
    }
    const auto nth = squares.begin() + kNeighbours;  // the point itself is the first
    std::nth_element(squares.begin(), nth, squares.end());
    distances[static_cast<std::size_t>(i)] = std::sqrt(*nth);
  });
  return distances;
}

/// Of the points in the ball that have neighbours; none if these are too few.
std::vector<Disc> MakeDiscs(const std::vector<Vec3>& points, const Vec3& centre, double radius) {
  std::vector<Vec3> near;
  for (const Vec3& p : points) {
    if (Norm(p - centre) < radius) near.push_back(p);
  }
  if (near.size() < kFewestPoints) return {};
  near = Thinned(near, kMostPoints);
  std::vector<double> distances = DistancesToNeighbours(near);
  const double lonely = kLonely * renderer::Median(distances);
  std::vector<Vec3> sure;
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (distances[i] <= lonely) sure.push_back(near[i]);
  }
  if (sure.size() < kFewestPoints) return {};
  distances = DistancesToNeighbours(sure);
  std::vector<Disc> discs;
  for (std::size_t i = 0; i < sure.size(); ++i) {
    discs.push_back(
        {sure[i], std::clamp(kReach * distances[i], kLeastReach * radius, kMostReach * radius)});
  }
  return discs;
}

/// Depth of the nearest disc in each pixel of a small picture; infinite without one.
class DepthMap {
 public:
  /// `camera`: of the small picture.
  DepthMap(const renderer::Camera& camera, const std::vector<Disc>& discs)
      : camera_(camera),
        width_(camera.width),
        height_(camera.height),
        depth_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_),
               std::numeric_limits<double>::infinity()) {
    const double focal = std::sqrt(camera.fx * camera.fy);
    for (const Disc& disc : discs) {
      const std::optional<Projection> p = camera_.Project(disc.at);
      if (!p) continue;
      Draw(p->u, p->v, disc.reach * focal / (camera_.IsOrthographic() ? 1.0 : p->depth), p->depth);
    }
  }

  /// Whether a place is seen, and if so, whether before every disc.
  struct Sight {
    bool seen = false, through = false;
  };
  [[nodiscard]] Sight At(const Vec3& x, double margin) const {
    const std::optional<Projection> p = camera_.Project(x);
    if (!p) return {};
    const double column = std::floor(p->u);
    const double row = std::floor(p->v);
    if (!(column >= 0.0 && column < width_ && row >= 0.0 && row < height_)) return {};
    const auto pixel = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                       static_cast<std::size_t>(column);
    return {true, p->depth < depth_[pixel] - margin};
  }

 private:
  void Draw(double u, double v, double radius, double depth) {
    const auto clamped = [](double x, int size) {
      return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(size)));
    };
    for (int y = clamped(v - radius, height_); y < clamped(v + radius + 1.0, height_); ++y) {
      for (int x = clamped(u - radius, width_); x < clamped(u + radius + 1.0, width_); ++x) {
        if (std::hypot(x + 0.5 - u, y + 0.5 - v) > radius) continue;
        double& nearest = depth_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                 static_cast<std::size_t>(x)];
        nearest = std::min(nearest, depth);
      }
    }
  }

  CameraModel camera_;
  int width_, height_;
  std::vector<double> depth_;
};

/// Calls visit(x, y, z) for the inner nodes of a slice.
template <class Visit>
void ForEachInner(const VoxelGrid& grid, int z, const Visit& visit) {
  if (z == 0 || z + 1 == grid.size[2]) return;
  for (int y = 1; y + 1 < grid.size[1]; ++y) {
    for (int x = 1; x + 1 < grid.size[0]; ++x) visit(x, y, z);
  }
}

/// How far the share of views that see through is below kEmpty; -kEmpty outside of the ball.
VoxelGrid Carve(const std::vector<DepthMap>& views, const Vec3& centre, double radius) {
  VoxelGrid grid;
  grid.spacing = 2.0 * radius / kVoxels;
  grid.origin = centre - Vec3{1.0, 1.0, 1.0} * (radius + grid.spacing);
  grid.size = {kVoxels + 3, kVoxels + 3, kVoxels + 3};
  grid.values.assign(grid.Offset(0, 0, grid.size[2]), -static_cast<float>(kEmpty));
  renderer::ParallelFor(grid.size[2], [&](std::int64_t slice) {
    ForEachInner(grid, static_cast<int>(slice), [&](int x, int y, int z) {
      const Vec3 at = grid.Node(x, y, z);
      if (Norm(at - centre) > radius) return;
      int seen = 0, through = 0;
      for (const DepthMap& view : views) {
        const DepthMap::Sight sight = view.At(at, 0.5 * grid.spacing);
        seen += sight.seen ? 1 : 0;
        through += sight.through ? 1 : 0;
      }
      if (seen < kFewestViews) return;
      grid.values[grid.Offset(x, y, z)] = static_cast<float>(kEmpty - 1.0 * through / seen);
    });
  });
  return grid;
}

/// Mean with the neighbours along one axis, binomial.
void Smooth(int axis, VoxelGrid& grid) {
  const std::array<std::size_t, 3> steps = {1, grid.Offset(0, 1, 0), grid.Offset(0, 0, 1)};
  const std::size_t step = steps[static_cast<std::size_t>(axis)];
  const std::vector<float> before = grid.values;
  renderer::ParallelFor(grid.size[2], [&](std::int64_t slice) {
    ForEachInner(grid, static_cast<int>(slice), [&](int x, int y, int z) {
      const std::size_t i = grid.Offset(x, y, z);
      grid.values[i] = 0.5F * before[i] + 0.25F * (before[i - step] + before[i + step]);
    });
  });
}

/// A surface through a node would have vertices of several cells there.
void KeepOffNodes(VoxelGrid& grid) {
  for (float& value : grid.values) {
    if (std::abs(value) < kSurfaceOff) value = value > 0.0F ? kSurfaceOff : -kSurfaceOff;
  }
}

/// Whether there is a body, and it ends in the ball.
bool IsBounded(const VoxelGrid& grid, const Vec3& centre, double radius) {
  double inside = 0.0, rim = 0.0, rim_inside = 0.0;
  for (int z = 0; z < grid.size[2]; ++z) {
    ForEachInner(grid, z, [&](int x, int y, int k) {
      const double distance = Norm(grid.Node(x, y, k) - centre);
      if (distance > radius) return;
      const double filled = grid.values[grid.Offset(x, y, k)] > 0.0F ? 1.0 : 0.0;
      inside += filled;
      if (distance < kRim * radius) return;
      rim += 1.0;
      rim_inside += filled;
    });
  }
  return inside > kLeastFilled * kVoxels * kVoxels * kVoxels && rim_inside < kRimFilled * rim;
}

}  // namespace

std::optional<Mesh> BodyOfPoints(const std::vector<Vec3>& points,
                                 const std::vector<renderer::Camera>& cameras,
                                 const Vec3& centre,
                                 double radius) {
  if (cameras.size() < kFewestCameras || !(radius > 0.0)) return std::nullopt;
  const std::vector<Disc> discs = MakeDiscs(points, centre, radius);
  if (discs.empty()) return std::nullopt;
  std::vector<DepthMap> views;
  for (const renderer::Camera& camera : Thinned(cameras, kMostCameras)) {
    views.emplace_back(ReducedCamera(camera, kDepthPx), discs);
  }
  VoxelGrid grid = Carve(views, centre, radius);
  for (const int axis : {0, 1, 2}) Smooth(axis, grid);
  KeepOffNodes(grid);
  if (!IsBounded(grid, centre, radius)) return std::nullopt;
  try {
    Mesh mesh = ExtractSurface(grid);
    SeparateTouchingParts(kCutApart * grid.spacing, mesh);
    KeepLargestPart(mesh);
    ValidateMesh(mesh, "body of sparse points");
    return mesh;
  } catch (const renderer::SceneError&) {
    return std::nullopt;
  }
}

}  // namespace pathfit::optim
