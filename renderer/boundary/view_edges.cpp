#include "renderer/boundary/view_edges.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pathfit::renderer {
namespace {

// Faces whose normals differ by less than this are one plane: no silhouette, no crease.
constexpr double kCoplanar = 1e-7;
// Nearest depth that is kept, relative to the distance of the edge's far end.
constexpr double kNearPlane = 1e-6;

struct FaceNormal {
  Vec3 n;         // unit
  double facing;  // positive if the face looks at the camera
};

FaceNormal NormalTowards(const Mesh& mesh, std::int32_t face, const Vec3& eye) {
  const Triangle& t = mesh.triangles[static_cast<std::size_t>(face)];
  const auto p = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(t[i])]; };
  const Vec3 n = Normalized(Cross(p(1) - p(0), p(2) - p(0)));
  return {n, Dot(n, eye - p(0))};
}

bool IsOutsideBox(const Mesh& mesh, const Vec3& eye) {
  for (int i = 0; i < 3; ++i) {
    const auto below = [&](const Vec3& p) { return p[i] < eye[i]; };
    if (std::all_of(mesh.positions.begin(), mesh.positions.end(), below) ||
        std::none_of(mesh.positions.begin(), mesh.positions.end(), below)) {
      return true;
    }
  }
  return false;
}

bool HasColorSeam(const Mesh& mesh, const MeshEdge& edge) {
  const auto color_of = [&](int side, std::int32_t vertex) {
    const auto face = static_cast<std::size_t>(edge.faces[static_cast<std::size_t>(side)]);
    const Triangle& t = mesh.triangles[face];
    const auto corner = static_cast<std::size_t>(std::find(t.begin(), t.end(), vertex) - t.begin());
    return mesh.colors[static_cast<std::size_t>(mesh.color_triangles[face][corner])];
  };
  return !(color_of(0, edge.vertices[0]) == color_of(1, edge.vertices[0])) ||
         !(color_of(0, edge.vertices[1]) == color_of(1, edge.vertices[1]));
}

/// Part of segment a..b (camera frame, looking along -z) with |x|, |y| <= limit * depth and depth >
/// near.
std::optional<std::pair<double, double>> ClipToView(const Vec3& a, const Vec3& b, double limit) {
  double t0 = 0.0;
  double t1 = 1.0;
  const auto clip = [&](double at_a, double at_b) {  // keep where the linear function is positive
    if (at_a <= 0.0 && at_b <= 0.0) {
      t1 = -1.0;
    } else if (at_a <= 0.0) {
      t0 = std::max(t0, at_a / (at_a - at_b));
    } else if (at_b <= 0.0) {
      t1 = std::min(t1, at_a / (at_a - at_b));
    }
  };
  const double near = kNearPlane * std::max(std::abs(a.z), std::abs(b.z));
  clip(-a.z - near, -b.z - near);
  clip(-limit * a.z - a.x, -limit * b.z - b.x);
  clip(-limit * a.z + a.x, -limit * b.z + b.x);
  clip(-limit * a.z - a.y, -limit * b.z - b.y);
  clip(-limit * a.z + a.y, -limit * b.z + b.y);
  if (t1 <= t0) {
    return std::nullopt;
  }
  return std::pair{t0, t1};
}

/// How much the image may jump across the edge, 0 if not at all.
double JumpEstimate(const SceneMesh& mesh,
                    const Material& material,
                    const MeshEdge& edge,
                    const Vec3& eye,
                    bool opaque) {
  if (edge.faces[1] < 0) {
    return 1.0;
  }
  const FaceNormal first = NormalTowards(mesh.mesh, edge.faces[0], eye);
  const FaceNormal second = NormalTowards(mesh.mesh, edge.faces[1], eye);
  if (opaque && first.facing <= 0.0 && second.facing <= 0.0) {
    return 0.0;
  }
  const double bend = Norm(first.n - second.n);
  const bool seam = material.vertex_colors && HasColorSeam(mesh.mesh, edge);
  if ((first.facing > 0.0) != (second.facing > 0.0)) {
    return 1.0;
  }
  if (seam) {
    return 1.0;
  }
  return bend < kCoplanar ? 0.0 : std::clamp(bend, ViewEdges::kMinJump, 1.0);
}

}  // namespace

ViewEdges::ViewEdges(const Scene& scene,
                     const std::vector<MeshTopology>& topologies,
                     const std::vector<bool>& moves,
                     const CameraModel& camera) {
  const Vec3& eye = camera.Origin();
  const Transform camera_from_world = RigidInverse(camera.camera().world_from_camera);
  std::vector<double> weights;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (!moves[m]) {
      continue;
    }
    const SceneMesh& mesh = scene.meshes[m];
    const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
    // Nothing behind the faces of a closed mesh is seen from outside it.
    const bool opaque = topologies[m].closed && IsOutsideBox(mesh.mesh, eye);
    const auto& edges = topologies[m].edges;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto end = [&](std::size_t i) {
        return camera_from_world.Point(
            mesh.mesh.positions[static_cast<std::size_t>(edges[e].vertices[i])]);
      };
      const Vec3 a = end(0);
      const Vec3 b = end(1);
      const auto part = ClipToView(a, b, camera.MaxTangent());
      if (!part) {
        continue;
      }
      const double jump = JumpEstimate(mesh, material, edges[e], eye, opaque);
      if (jump == 0.0) {
        continue;
      }
      const auto pixel = [&](double t) {
        const Vec3 p = a * (1.0 - t) + b * t;
        return Vec2{camera.camera().fx * p.x / -p.z, camera.camera().fy * p.y / -p.z};
      };
      const Vec2 span = pixel(part->second) - pixel(part->first);
      weights.push_back(jump * std::hypot(span.x, span.y));
      edges_.push_back(
          {static_cast<int>(m), static_cast<std::int32_t>(e), part->first, part->second});
    }
  }
  distribution_ = Distribution1D(weights);
}

}  // namespace pathfit::renderer
