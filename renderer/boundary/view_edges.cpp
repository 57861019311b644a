#include "renderer/boundary/view_edges.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "renderer/boundary/visible_point.h"
#include "renderer/core/parallel.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/scene/scene_edges.h"

namespace pathfit::renderer {
namespace {

// Nearest depth that is kept, relative to the distance of the edge's far end.
constexpr double kNearPlane = 1e-6;

/// What of a mesh can change the image.
struct Candidates {
  bool outlines = false;  ///< silhouettes and borders
  bool inner = false;     ///< all other edges, where the radiance jumps
  bool resting = false;
};

Candidates CandidatesOf(const BoundaryContext& context, std::size_t mesh) {
  const ActiveParameters& active = context.active;
  const bool sweeps = active.meshes[mesh].moves || active.camera.Any();
  if (context.options.form == DerivativeForm::kImage) {
    return {sweeps, sweeps, false};
  }
  return {sweeps || active.any_mesh_moves || SkyMoves(context), false, !sweeps};
}

struct FaceNormal {
  Vec3 n;         // unit
  double facing;  // positive if the face looks at the camera
};

FaceNormal NormalTowards(const Mesh& mesh, std::int32_t face, const CameraModel& camera) {
  const TriangleGeometry triangle = GeometryOf(mesh, mesh.triangles[Index(face)]);
  double distance = 0.0;
  return {triangle.n, Dot(triangle.n, camera.RayTo(triangle.p0, distance).direction)};
}

/// Whether all sensor rays start outside the mesh: the centre is outside its bounding box, or the
/// plane of parallel rays is in front of it.
bool IsViewedFromOutside(const Mesh& mesh, const CameraModel& camera) {
  const auto& points = mesh.positions;
  if (camera.IsOrthographic()) {
    return std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
      return Dot(camera.Pose().linear.z, p - camera.Origin()) < 0.0;
    });
  }
  return IsOutsideBox(mesh, camera.Origin());
}

/// Whether a list that is indexed by its own triangles has different values on both sides.
template <class T>
bool HasSeam(const Mesh& mesh,
             const MeshEdge& edge,
             const SharedVector<T>& values,
             const SharedVector<Triangle>& triangles) {
  if (triangles.empty()) {
    return false;
  }
  const auto value = [&](std::size_t side, std::int32_t vertex) -> const T& {
    const auto face = static_cast<std::size_t>(edge.faces[side]);
    const Triangle& t = mesh.triangles[face];
    const auto corner = static_cast<std::size_t>(std::find(t.begin(), t.end(), vertex) - t.begin());
    return values[static_cast<std::size_t>(triangles[face][corner])];
  };
  return std::any_of(edge.vertices.begin(), edge.vertices.end(), [&](std::int32_t v) {
    return !(value(0, v) == value(1, v));
  });
}

/// Which of a mesh's lists the radiance depends on.
struct SeamKinds {
  bool colors = false, uvs = false;
};

SeamKinds SeamKindsOf(const BoundaryContext& context, int mesh, const Material& material) {
  const LightSet::AreaLight* light = context.path.lights.AreaLightOf(mesh);
  return {material.vertex_colors,
          material.IsTextured() || (light != nullptr && light->texture != nullptr)};
}

/// How much the image may jump across the edge, 0 if not at all. `solid`: nothing behind the faces
/// is seen.
double JumpEstimate(const Mesh& mesh,
                    const MeshEdge& edge,
                    const CameraModel& camera,
                    bool solid,
                    bool inner,
                    const SeamKinds& seams) {
  if (edge.faces[1] < 0) {
    return 1.0;
  }
  const FaceNormal first = NormalTowards(mesh, edge.faces[0], camera);
  const FaceNormal second = NormalTowards(mesh, edge.faces[1], camera);
  if ((first.facing > 0.0) != (second.facing > 0.0)) {
    const auto at = [&](std::int32_t v) { return mesh.positions[static_cast<std::size_t>(v)]; };
    const bool concave = Dot(first.n, at(edge.apex[1]) - at(edge.vertices[0])) > 0.0;
    return solid && concave ? 0.0 : 1.0;
  }
  if (!inner || (solid && first.facing <= 0.0)) {
    return 0.0;
  }
  if ((seams.colors && HasSeam(mesh, edge, mesh.colors, mesh.color_triangles)) ||
      (seams.uvs && HasSeam(mesh, edge, mesh.uvs, mesh.uv_triangles)) ||
      HasSeam(mesh, edge, mesh.normals, mesh.normal_triangles)) {
    return 1.0;
  }
  const double bend = Norm(first.n - second.n);
  if (bend < kCoplanar) {
    return 0.0;
  }
  // Smooth shading, too, cuts light off at the horizon of each facet.
  return std::clamp(bend, ViewEdges::kMinJump, 1.0);
}

/// The film with the filter's reach around it in normalised coordinates, x right and y up; of a
/// distorted camera all that it accepts.
class FieldOfView {
 public:
  explicit FieldOfView(const CameraModel& camera)
      : camera_from_world_(RigidInverse(camera.Pose())), parallel_(camera.IsOrthographic()) {
    const Camera& c = camera.camera();
    fx_ = c.fx;
    fy_ = c.fy;
    x1_ = y1_ = camera.MaxTangent();
    x0_ = y0_ = -x1_;
    if (c.distortion.IsNone()) {
      const double reach = c.filter.radius - 0.5;
      x0_ = (-reach - c.cx) / c.fx;
      x1_ = (c.width + reach - c.cx) / c.fx;
      y0_ = (c.cy - c.height - reach) / c.fy;
      y1_ = (c.cy + reach) / c.fy;
    }
  }

  struct Part {
    double t0 = 0.0, t1 = 1.0;
    double length = 0.0;  ///< pixels, without distortion
    double depth_ratio = 1.0;
  };
  /// The part of a segment that is seen.
  [[nodiscard]] std::optional<Part> Clip(const Vec3& a_in_world, const Vec3& b_in_world) const {
    const Vec3 a = camera_from_world_.Point(a_in_world);
    const Vec3 b = camera_from_world_.Point(b_in_world);
    Part part;
    const auto keep_positive = [&](double at_a, double at_b) {
      if (at_a <= 0.0 && at_b <= 0.0) {
        part.t1 = -1.0;
      } else if (at_a <= 0.0) {
        part.t0 = std::max(part.t0, at_a / (at_a - at_b));
      } else if (at_b <= 0.0) {
        part.t1 = std::min(part.t1, at_a / (at_a - at_b));
      }
    };
    const double near = parallel_ ? 0.0 : kNearPlane * std::max(std::abs(a.z), std::abs(b.z));
    const double scale_a = parallel_ ? 1.0 : -a.z;
    const double scale_b = parallel_ ? 1.0 : -b.z;
    keep_positive(-a.z - near, -b.z - near);
    keep_positive(a.x - x0_ * scale_a, b.x - x0_ * scale_b);
    keep_positive(x1_ * scale_a - a.x, x1_ * scale_b - b.x);
    keep_positive(a.y - y0_ * scale_a, b.y - y0_ * scale_b);
    keep_positive(y1_ * scale_a - a.y, y1_ * scale_b - b.y);
    if (part.t1 <= part.t0) {
      return std::nullopt;
    }
    const Vec3 first = a * (1.0 - part.t0) + b * part.t0;
    const Vec3 last = a * (1.0 - part.t1) + b * part.t1;
    const Vec2 p0 = Pixel(first);
    const Vec2 p1 = Pixel(last);
    part.length = std::hypot(p1.x - p0.x, p1.y - p0.y);
    part.depth_ratio = parallel_ ? 1.0 : first.z / last.z;
    return part;
  }

 private:
  [[nodiscard]] Vec2 Pixel(const Vec3& p) const {
    const double scale = parallel_ ? 1.0 : -1.0 / p.z;
    return {fx_ * p.x * scale, fy_ * p.y * scale};
  }

  Transform camera_from_world_;
  bool parallel_;
  double fx_, fy_;
  double x0_, x1_, y0_, y1_;
};

struct WeightedEdge {
  ViewEdge edge;
  double weight = 0.0;
};

constexpr std::int64_t kPieces = 16;  // of a mesh's edges, that are looked at together

/// The corner of a triangle from which an edge of it starts.
std::size_t FirstCorner(const Triangle& t, const MeshEdge& edge) {
  for (std::size_t i = 0; i < 2; ++i) {
    if ((t[i] == edge.vertices[0] && t[i + 1] == edge.vertices[1]) ||
        (t[i] == edge.vertices[1] && t[i + 1] == edge.vertices[0])) {
      return i;
    }
  }
  return 2;
}

}  // namespace

ViewEdges::ViewEdges(const BoundaryContext& context) {
  const World& world = *context.path.world;
  const FieldOfView field(context.camera);
  sides_.resize(static_cast<std::size_t>(world.NumMeshes()));
  std::vector<double> weights;
  for (int m = 0; m < world.NumMeshes(); ++m) {
    const Mesh& mesh = world.mesh(m);
    const Candidates candidates = CandidatesOf(context, static_cast<std::size_t>(m));
    if (!candidates.outlines) {
      continue;
    }
    const bool solid = world.topology(m).solid && IsViewedFromOutside(mesh, context.camera);
    const SeamKinds seams = SeamKindsOf(context, m, world.MaterialOf(m));
    const auto& edges = world.topology(m).edges;
    const auto num_edges = static_cast<std::int64_t>(edges.size());
    const auto list = [&](std::int64_t piece, std::vector<WeightedEdge>& seen) {
      for (std::int64_t e = piece * num_edges / kPieces; e < (piece + 1) * num_edges / kPieces;
           ++e) {
        const MeshEdge& edge = edges[static_cast<std::size_t>(e)];
        const auto end = [&](std::size_t i) { return mesh.positions[Index(edge.vertices[i])]; };
        const auto part = field.Clip(end(0), end(1));
        if (!part) {
          continue;
        }
        const double jump =
            JumpEstimate(mesh, edge, context.camera, solid, candidates.inner, seams);
        if (jump == 0.0) {
          continue;
        }
        seen.push_back({{m, static_cast<std::int32_t>(e), part->t0, part->t1, part->depth_ratio},
                        jump * part->length * (candidates.resting ? kRestingWeight : 1.0)});
      }
    };
    std::vector<std::uint8_t>& sides = sides_[static_cast<std::size_t>(m)];
    sides.assign(mesh.triangles.size(), 0);
    for (const auto& seen : ParallelParts<std::vector<WeightedEdge>>(kPieces, list)) {
      for (const WeightedEdge& weighted : seen) {
        weights.push_back(weighted.weight);
        edges_.push_back(weighted.edge);
        const MeshEdge& edge = edges[Index(weighted.edge.edge)];
        for (const std::int32_t face : edge.faces) {
          if (face >= 0) {
            sides[Index(face)] |=
                static_cast<std::uint8_t>(1U << FirstCorner(mesh.triangles[Index(face)], edge));
          }
        }
      }
    }
  }
  distribution_ = Distribution1D(weights);
}

}  // namespace pathfit::renderer
