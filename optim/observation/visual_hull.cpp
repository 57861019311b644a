#include "optim/observation/visual_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "optim/observation/silhouette_field.h"
#include "optim/observation/voxel_surface.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/geometry/mesh_folds.h"
#include "renderer/math/box.h"

namespace pathfit::optim {
namespace {

using renderer::Box;
using renderer::Mesh;
using renderer::SceneError;
using renderer::Triangle;
using renderer::Vec3;

// Search for the box.
constexpr int kSearchResolution = 32;
constexpr int kMaxEnlargements = 6;
constexpr int kMaxTightenings = 6;
constexpr double kTightEnough = 0.9;  // stop when the longest side shrinks by less than this
/// A voxel can hold body if its centre is this far outside, in half diagonals: the field's slope
/// may pass 1 a little.
constexpr double kSlack = 1.25;
constexpr int kBlock = 4;  // nodes

// Surface, in voxels.
constexpr int kPadding = 2;
constexpr double kBand = 3.0;       // values are cut off here
constexpr double kNearNode = 0.02;  // a crossing nearer to a node would make slivers
constexpr double kInset = 1e-3;

// Moving vertices to the exact zero.
constexpr int kNewtonSteps = 5;
constexpr double kMaxStep = 0.25;  // voxels
constexpr double kMaxMove = 1.0;   // voxels, in total
constexpr double kMaxTurn = 0.3;   // least cosine between a triangle's normals before and after
constexpr double kMinArea = 1e-4;  // twice the area, in squared voxels
constexpr int kMaxReverts = 20;

// Parts: cells along a silhouette's box, a few voxels each, and the share of the cells that no
// other part covers. Parts beyond so many are specks.
constexpr int kCellsAlong = 32;
constexpr double kLeastShare = 0.02;
constexpr std::size_t kMostParts = 64;

double LongestSide(const Box& box) { return box.Size()[box.LongestAxis()]; }

VoxelGrid MakeGrid(const Vec3& origin, double spacing, const std::array<int, 3>& size) {
  VoxelGrid grid{.origin = origin, .spacing = spacing, .size = size, .values = {}};
  grid.values.resize(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
                     static_cast<std::size_t>(size[2]));
  return grid;
}

/// Some nodes of a grid.
struct Block {
  std::array<int, 3> low{}, end{};

  [[nodiscard]] Vec3 Middle(const VoxelGrid& grid) const {
    return (grid.Node(low[0], low[1], low[2]) + grid.Node(end[0] - 1, end[1] - 1, end[2] - 1)) *
           0.5;
  }
  template <class Function>
  void ForEach(Function function) const {
    for (int z = low[2]; z < end[2]; ++z) {
      for (int y = low[1]; y < end[1]; ++y) {
        for (int x = low[0]; x < end[0]; ++x) function(x, y, z);
      }
    }
  }
};

/// Values in units of the spacing, cut off at +-band. Of a block whose middle is so deep inside
/// that all of it is, no more is looked at: most views must be asked before a node is inside.
void FillGrid(const SilhouetteField& field, double band, VoxelGrid& grid) {
  const double deep = band + kSlack * 0.5 * std::sqrt(3.0) * (kBlock - 1);
  std::array<std::int64_t, 3> blocks{};
  for (std::size_t a = 0; a < 3; ++a) blocks[a] = (grid.size[a] + kBlock - 1) / kBlock;
  renderer::ParallelFor(blocks[0] * blocks[1] * blocks[2], [&](std::int64_t i) {
    const std::array<std::int64_t, 3> at = {
        i % blocks[0], i / blocks[0] % blocks[1], i / (blocks[0] * blocks[1])};
    Block block;
    for (std::size_t a = 0; a < 3; ++a) {
      block.low[a] = static_cast<int>(at[a]) * kBlock;
      block.end[a] = std::min(block.low[a] + kBlock, grid.size[a]);
    }
    const double enough = deep * grid.spacing;
    const bool is_deep = field.Value(block.Middle(grid), enough) > enough;
    block.ForEach([&](int x, int y, int z) {
      const double value =
          is_deep ? band : field.Value(grid.Node(x, y, z), -band * grid.spacing) / grid.spacing;
      grid.values[grid.Offset(x, y, z)] = static_cast<float>(std::clamp(value, -band, band));
    });
  });
}

int CellsAlong(double extent, double spacing) {
  return std::max(1, static_cast<int>(std::ceil(extent / spacing)));
}

/// The box of all voxels that can hold body, one voxel wider; nothing when there is none.
struct Carving {
  bool found = false;
  Box box;
  std::array<bool, 6> touches{};  ///< sides of the searched box: low x y z, high x y z
};

Carving CarveCoarsely(const SilhouetteField& field, const Box& box) {
  const double spacing = LongestSide(box) / kSearchResolution;
  const Vec3 extent = box.Size();
  const std::array<int, 3> size = {
      CellsAlong(extent.x, spacing), CellsAlong(extent.y, spacing), CellsAlong(extent.z, spacing)};
  VoxelGrid grid = MakeGrid(box.low + Vec3{0.5, 0.5, 0.5} * spacing, spacing, size);
  const double margin = kSlack * 0.5 * std::sqrt(3.0);
  FillGrid(field, 2.0 * margin, grid);
  std::array<int, 3> low = size;
  std::array<int, 3> high = {-1, -1, -1};
  for (int z = 0; z < size[2]; ++z) {
    for (int y = 0; y < size[1]; ++y) {
      for (int x = 0; x < size[0]; ++x) {
        if (static_cast<double>(grid.values[grid.Offset(x, y, z)]) < -margin) continue;
        const std::array<int, 3> at = {x, y, z};
        for (std::size_t a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], at[a]);
          high[a] = std::max(high[a], at[a]);
        }
      }
    }
  }
  Carving out;
  out.found = high[0] >= 0;
  if (!out.found) return out;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    out.touches[i] = low[i] == 0;
    out.touches[i + 3] = high[i] == size[i] - 1;
    out.box.low[a] = box.low[a] + (low[i] - 1) * spacing;
    out.box.high[a] = box.low[a] + (high[i] + 2) * spacing;
  }
  return out;
}

[[noreturn]] void FailEmpty() {
  throw SceneError(
      "visual hull: nothing is left after carving with all masks; the masks and cameras do not "
      "belong together, one "
      "mask misses the object, or black and white are exchanged (invert)");
}

/// The box of the hull from cameras and masks alone: a ball onto which all masks fall, enlarged
/// until its carving does not touch the box, then tightened. Empty: it always does.
std::optional<Box> FindBox(const SilhouetteField& field) {
  const Vec3 center = field.Center();
  const double radius = 1.2 * field.Radius(center);
  Box box{center - Vec3{radius, radius, radius}, center + Vec3{radius, radius, radius}};
  Carving carving = CarveCoarsely(field, box);
  const auto touches = [&] {
    return std::ranges::any_of(carving.touches, [](bool t) { return t; });
  };
  for (int i = 0; carving.found && touches(); ++i) {
    if (i == kMaxEnlargements) return std::nullopt;
    const Vec3 extent = box.Size();
    for (int a = 0; a < 3; ++a) {
      box.low[a] -= carving.touches[static_cast<std::size_t>(a)] ? 0.5 * extent[a] : 0.0;
      box.high[a] += carving.touches[static_cast<std::size_t>(a) + 3] ? 0.5 * extent[a] : 0.0;
    }
    carving = CarveCoarsely(field, box);
  }
  for (int i = 0; carving.found && i < kMaxTightenings; ++i) {
    const bool done = LongestSide(carving.box) > kTightEnough * LongestSide(box);
    box = carving.box;
    if (done) return box;
    carving = CarveCoarsely(field, box);
  }
  if (!carving.found) FailEmpty();
  return box;
}

/// What is a few pixels wide in photos is a few voxels wide.
int ResolutionOf(const SilhouetteField& field, const Box& box) {
  const double pixels = LongestSide(box) / field.PixelWidth(field.Center());
  return static_cast<int>(std::lround(
      std::clamp<double>(pixels, VisualHullOptions::kLeastFound, VisualHullOptions::kMostFound)));
}

VoxelGrid CarveFinely(const SilhouetteField& field, const Box& box, int resolution) {
  const double spacing = LongestSide(box) / resolution;
  const Vec3 extent = box.Size();
  const std::array<int, 3> size = {CellsAlong(extent.x, spacing) + 1 + 2 * kPadding,
                                   CellsAlong(extent.y, spacing) + 1 + 2 * kPadding,
                                   CellsAlong(extent.z, spacing) + 1 + 2 * kPadding};
  VoxelGrid grid = MakeGrid(box.low - Vec3{1.0, 1.0, 1.0} * (kPadding * spacing), spacing, size);
  FillGrid(field, kBand, grid);
  bool any = false;
  for (float& v : grid.values) {
    if (std::abs(static_cast<double>(v)) < kNearNode) {
      v = static_cast<float>(v > 0.0F ? kNearNode : -kNearNode);
    }
    any = any || v > 0.0F;
  }
  if (!any) {
    throw SceneError("visual hull: what is left after carving is thinner than a voxel (" +
                     std::to_string(spacing) + " units); use a resolution above " +
                     std::to_string(resolution) +
                     ", and check that masks and cameras belong together");
  }
  return grid;
}

/// What the parts cover of a view's silhouette.
struct Coverage {
  std::vector<std::uint64_t> parts;  ///< by cell, a bit for each
  double num_cells = 0.0;            ///< of the silhouette, at least 1
};

Coverage CoverageOf(const SilhouetteField& field,
                    std::size_t view,
                    const Mesh& mesh,
                    const MeshParts& parts) {
  Coverage out;
  out.parts.resize(static_cast<std::size_t>(kCellsAlong) * kCellsAlong);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    if (parts.of_triangle[f] >= kMostParts) continue;
    const Vec3& corner = mesh.positions[static_cast<std::size_t>(mesh.triangles[f][0])];
    const int cell = field.CellOf(view, kCellsAlong, corner);
    if (cell >= 0) {
      out.parts[static_cast<std::size_t>(cell)] |= std::uint64_t{1} << parts.of_triangle[f];
    }
  }
  out.num_cells = std::max(1, field.NumCells(view, kCellsAlong));
  return out;
}

/// Keeps the largest part, and of the others those that some of the silhouettes are of: what lies
/// where viewing cones of other bodies meet by chance is behind or before these everywhere.
void KeepPartsOfSilhouettes(const SilhouetteField& field, Mesh& mesh) {
  const MeshParts parts = PartsByVolume(mesh);
  if (parts.volumes.size() < 2) {
    KeepLargestPart(mesh);
    return;
  }
  std::vector<Coverage> views(field.NumViews());
  renderer::ParallelFor(static_cast<std::int64_t>(views.size()), [&](std::int64_t i) {
    const auto view = static_cast<std::size_t>(i);
    views[view] = CoverageOf(field, view, mesh, parts);
  });
  std::uint64_t kept = ~std::uint64_t{0};
  for (std::size_t part = std::min(parts.volumes.size(), kMostParts); part-- > 1;) {
    const std::uint64_t bit = std::uint64_t{1} << part;
    double share = 0.0;
    for (const Coverage& view : views) {
      const auto num_alone = std::ranges::count_if(
          view.parts, [&](std::uint64_t here) { return (here & kept) == bit; });
      share += static_cast<double>(num_alone) / view.num_cells;
    }
    if (share < kLeastShare * static_cast<double>(views.size())) kept &= ~bit;
  }
  std::vector<bool> keep;
  for (const std::size_t part : parts.of_triangle) {
    keep.push_back(part < kMostParts && ((kept >> part) & 1) != 0);
  }
  KeepTriangles(keep, mesh);
}

/// Newton steps along the gradient; the result is kept only where it is nearer to the zero.
Vec3 NearestZero(const SilhouetteField& field, const Vec3& start, double spacing) {
  Vec3 best = start;
  SilhouetteField::Sample at = field.ValueAndGradient(start);
  for (int i = 0; i < kNewtonSteps; ++i) {
    const double slope2 = SquaredNorm(at.gradient);
    if (!(slope2 > 0.0)) return best;
    const double step =
        std::clamp(at.value / std::sqrt(slope2), -kMaxStep * spacing, kMaxStep * spacing);
    const Vec3 next = best - at.gradient * (step / std::sqrt(slope2));
    const SilhouetteField::Sample there = field.ValueAndGradient(next);
    if (!(std::abs(there.value) < std::abs(at.value)) || Norm(next - start) > kMaxMove * spacing) {
      return best;
    }
    best = next;
    at = there;
  }
  return best;
}

Vec3 TwiceAreaNormal(const std::vector<Vec3>& positions, const Triangle& t) {
  const Vec3& a = positions[static_cast<std::size_t>(t[0])];
  return Cross(positions[static_cast<std::size_t>(t[1])] - a,
               positions[static_cast<std::size_t>(t[2])] - a);
}

/// Moves vertices onto the zero of the field; those of triangles that would fold or vanish stay
/// where they are.
void MoveToZero(const SilhouetteField& field, double spacing, Mesh& mesh) {
  const std::vector<Vec3>& positions = mesh.positions;
  std::vector<Vec3> moved(positions.size());
  renderer::ParallelFor(static_cast<std::int64_t>(moved.size()), [&](std::int64_t i) {
    const auto v = static_cast<std::size_t>(i);
    moved[v] = NearestZero(field, positions[v], spacing);
  });
  for (int i = 0; i < kMaxReverts; ++i) {
    bool reverted = false;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 before = TwiceAreaNormal(mesh.positions, t);
      const Vec3 after = TwiceAreaNormal(moved, t);
      const double area = Norm(after);
      if (area > kMinArea * spacing * spacing &&
          Dot(before, after) > kMaxTurn * area * Norm(before)) {
        continue;
      }
      for (const std::int32_t v : t) {
        const auto k = static_cast<std::size_t>(v);
        reverted = reverted || !(moved[k] == mesh.positions[k]);
        moved[k] = mesh.positions[k];
      }
    }
    if (!reverted) {
      mesh.positions = std::move(moved);
      return;
    }
  }
}

}  // namespace

Mesh CarveVisualHull(const ObservationSet& observations, const VisualHullOptions& options) {
  constexpr int kMin = VisualHullOptions::kMinResolution;
  constexpr int kMax = VisualHullOptions::kMaxResolution;
  if (options.resolution && (*options.resolution < kMin || *options.resolution > kMax)) {
    throw SceneError("visual hull: the resolution is " + std::to_string(*options.resolution) +
                     " (allowed: " + std::to_string(kMin) + " to " + std::to_string(kMax) + ")");
  }
  if (!(options.dissent >= 0.0 && options.dissent <= VisualHullOptions::kMaxDissent)) {
    throw SceneError("visual hull: the share of photos that may dissent is " +
                     std::to_string(options.dissent) + " (allowed: 0 to " +
                     std::to_string(VisualHullOptions::kMaxDissent) + ")");
  }
  SilhouetteField field(observations, options.dissent);
  std::optional<Box> box = FindBox(field);
  if (!box && field.TrustBorders()) box = FindBox(field);
  if (!box) {
    throw SceneError(
        "visual hull: the views do not bound the object on all sides; add photos with masks from "
        "other sides, or start from a mesh file");
  }
  const VoxelGrid grid = CarveFinely(
      field, *box, options.resolution ? *options.resolution : ResolutionOf(field, *box));
  Mesh mesh = ExtractSurface(grid);
  SeparateTouchingParts(kInset * grid.spacing, mesh);
  KeepPartsOfSilhouettes(field, mesh);
  MoveToZero(field, grid.spacing, mesh);
  WeldPositions(mesh);
  renderer::Unfold(mesh);  // at corners of the cones
  ValidateMesh(mesh, "visual hull");
  return mesh;
}

}  // namespace pathfit::optim
