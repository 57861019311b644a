#pragma once

#include <array>

#include "renderer/derivative/active_parameters.h"
#include "renderer/derivative/color_gradient.h"
#include "renderer/scene/world.h"

namespace pathfit::renderer {

/// Pulls adjoints of things that move in the world (points, normals, rays, lights) back to the
/// parameter blocks that move them: vertices, poses, lights, cameras. This is the only place that
/// knows what moves what; the interior sweep uses it with ColorGradient, the boundary estimators
/// with Vec3.
///
/// `Target` receives the result: Add(block, G) for blocks of 3 and AddScalar(block, component,
/// GradientTraits<G>::Scalar) for others. Source: path_space 1.5, 1.6, 1.8.
template <class G, class Target>
class MotionAdjoint {
 public:
  using Scalar = typename GradientTraits<G>::Scalar;

  MotionAdjoint(const World& world,
                const CameraModel& camera,
                const ActiveParameters& active,
                Target& target)
      : world_(world), camera_(camera), active_(active), target_(target) {}

  /// A vertex of a mesh at x.
  void Vertex(int mesh, std::int32_t vertex, const Vec3& x, const G& d_x) {
    const auto& b = active_.meshes[static_cast<std::size_t>(mesh)];
    if (b.positions >= 0) {
      target_.Add(b.positions + vertex, TransposedTimes(b.world_from_object, d_x));
    }
    if (b.has_pose) {
      Pose(b, x, d_x);
    }
  }

  /// A point that stays at its barycentric coordinates, its geometric normal (of the winding) and
  /// the log of the area ratio J of its triangle.
  void MaterialPoint(
      TriangleId id, double b1, double b2, const G& d_x, const G& d_n, const Scalar& d_log_area) {
    const auto& b = active_.meshes[static_cast<std::size_t>(id.mesh)];
    if (!b.moves) {
      return;
    }
    if (b.positions < 0) {  // a pose moves point, normal and area as a whole
      const TriangleGeometry& t = world_.caster().Geometry(id);
      Pose(b, t.Point(b1, b2), d_x);
      if (b.rotation >= 0) {
        target_.Add(b.rotation, TransposedTimes(b.rotation_jacobian, Cross(t.n, d_n)));
      }
      if (b.scale >= 0) {
        target_.AddScalar(b.scale, 0, d_log_area * (2.0 * b.inverse_scale));
      }
      return;
    }
    const TriangleGeometry& t = world_.caster().Geometry(id);
    const std::array<Vec3, 3> gradients = BarycentricGradients(t);
    const std::array<G, 3> by_normal = PullNormal(t, d_n);
    const std::array<double, 3> weights = {1.0 - b1 - b2, b1, b2};
    Corners(id, [&](std::size_t i) {
      return d_x * weights[i] + by_normal[i] + Outer(gradients[i], d_log_area);
    });
  }
  /// Point only.
  void MaterialPoint(TriangleId id, double b1, double b2, const G& d_x) {
    const auto& b = active_.meshes[static_cast<std::size_t>(id.mesh)];
    if (!b.moves) {
      return;
    }
    if (b.positions < 0) {
      Pose(b, world_.caster().Geometry(id).Point(b1, b2), d_x);
      return;
    }
    const std::array<double, 3> weights = {1.0 - b1 - b2, b1, b2};
    Corners(id, [&](std::size_t i) { return d_x * weights[i]; });
  }

  /// A stored vertex normal m (world, not yet normalised or turned) of a mesh.
  void VertexNormal(int mesh, std::int32_t normal, const Vec3& m, const G& d_m) {
    const auto& b = active_.meshes[static_cast<std::size_t>(mesh)];
    if (b.normals >= 0) {
      target_.Add(b.normals + normal, TransposedTimes(b.rotation_matrix, d_m));
    }
    if (b.rotation >= 0) {
      target_.Add(b.rotation, TransposedTimes(b.rotation_jacobian, Cross(m, d_m)));
    }
  }

  /// A point that stays at its place in the image: it slides along the ray of the sensor that sees
  /// it at pixel coordinates (u, v), metres `distance` from the ray's start. `n` is the normal of
  /// its triangle. Adds the material's and the ray's share, see path_space 1.5.
  void ImagePoint(TriangleId id,
                  double b1,
                  double b2,
                  const Vec3& n,
                  const Ray& ray,
                  double distance,
                  double u,
                  double v,
                  const G& d_x) {
    const Scalar along = Dot(d_x, ray.direction) * (1.0 / Dot(n, ray.direction));
    const G d_material = Outer(n, along);
    MaterialPoint(id, b1, b2, d_material);
    if (active_.camera.Any()) {
      const G d_ray = d_x - d_material;
      CameraRay(ray, u, v, d_ray, d_ray * distance);
    }
  }

  /// The ray through fixed pixel coordinates.
  void CameraRay(const Ray& ray, double u, double v, const G& d_origin, const G& d_direction) {
    const auto& b = active_.camera;
    CameraMotion(d_origin,
                 Cross(ray.origin - b.center, d_origin) + Cross(ray.direction, d_direction));
    if (b.intrinsics) {
      const CameraModel::RayIntrinsics by = camera_.RayByIntrinsics(u, v);
      std::array<Scalar, CameraModel::kNumIntrinsics> d{};
      for (std::size_t i = 0; i < d.size(); ++i) {
        d[i] = Dot(d_origin, by.origin[i]) + Dot(d_direction, by.direction[i]);
      }
      Intrinsics(d);
    }
  }

  /// The sensor's share of the motion of pixel coordinates of a point x fixed in the world, whose
  /// adjoint is (d_u, d_v).
  void PixelOfFixedPoint(const Vec3& x, const Projection& p, const Scalar& d_u, const Scalar& d_v) {
    if (!active_.camera.Any()) {
      return;
    }
    // The sensor's motion is the opposite motion of the world.
    const G d_x = Outer(p.du, d_u) + Outer(p.dv, d_v);
    CameraMotion(-d_x, -Cross(x - active_.camera.center, d_x));
    PixelIntrinsics(x, d_u, d_v);
  }
  /// The same for a direction w fixed in the world, a point at infinity seen by a perspective
  /// camera: its translation changes nothing. `p` is the projection of the centre + w.
  void PixelOfFixedDirection(const Vec3& w,
                             const Projection& p,
                             const Scalar& d_u,
                             const Scalar& d_v) {
    if (!active_.camera.Any()) {
      return;
    }
    CameraMotion(G{}, -Cross(w, Outer(p.du, d_u) + Outer(p.dv, d_v)));
    PixelIntrinsics(camera_.Origin() + w, d_u, d_v);
  }

  /// Sensor as a rigid body: translation, and spin (small rotation vector) about its centre.
  void CameraMotion(const G& d_translation, const G& d_spin) {
    const auto& b = active_.camera;
    if (b.position >= 0) {
      target_.Add(b.position, d_translation);
    }
    if (b.rotation >= 0) {
      target_.Add(b.rotation, TransposedTimes(b.rotation_jacobian, d_spin));
    }
  }
  void Intrinsics(const std::array<Scalar, CameraModel::kNumIntrinsics>& d) {
    const auto& b = active_.camera;
    const auto add = [&](std::int32_t block, int component, const Scalar& value) {
      if (block >= 0) {
        target_.AddScalar(block, component, value);
      }
    };
    add(b.focal, 0, d[0] * b.scale_x);
    add(b.focal, 1, d[1] * b.scale_y);
    add(b.principal_point, 0, d[2] * b.scale_x);
    add(b.principal_point, 1, d[3] * b.scale_y);
    for (int i = 0; i < 3; ++i) add(b.radial, i, d[static_cast<std::size_t>(4 + i)]);
    for (int i = 0; i < 2; ++i) add(b.tangential, i, d[static_cast<std::size_t>(7 + i)]);
  }

  /// Position of a point, spot or projector, world frame.
  void LightPosition(int emitter, const Vec3& position, const G& d_position) {
    const auto& b = active_.lights[static_cast<std::size_t>(emitter)];
    if (b.position >= 0) {
      target_.Add(b.position, TransposedTimes(b.world_from_frame, d_position));
    }
    if (b.camera_frame && active_.camera.moves) {
      CameraMotion(d_position, Cross(position - active_.camera.center, d_position));
    }
  }
  /// Spin (small rotation vector, world frame) of a light about its own place.
  void LightSpin(int emitter, const G& d_spin) {
    const auto& b = active_.lights[static_cast<std::size_t>(emitter)];
    if (b.rotation >= 0) {
      target_.Add(
          b.rotation,
          TransposedTimes(b.rotation_jacobian, TransposedTimes(b.world_from_frame, d_spin)));
    }
    if (b.camera_frame && active_.camera.rotation >= 0) {
      CameraMotion(G{}, d_spin);
    }
  }

  /// Whether moving the light changes anything.
  [[nodiscard]] bool LightMoves(int emitter) const {
    return active_.lights[static_cast<std::size_t>(emitter)].moves;
  }

 private:
  template <class Adjoint>
  void Corners(TriangleId id, const Adjoint& adjoint) {
    const Mesh& mesh = world_.mesh(id.mesh);
    const Triangle& corners = mesh.triangles[static_cast<std::size_t>(id.triangle)];
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& x = mesh.positions[static_cast<std::size_t>(corners[i])];
      Vertex(id.mesh, corners[i], x, adjoint(i));
    }
  }
  using MeshBlocks = ActiveParameters::MeshBlocks;

  void PixelIntrinsics(const Vec3& x, const Scalar& d_u, const Scalar& d_v) {
    if (!active_.camera.intrinsics) {
      return;
    }
    const auto by = camera_.PixelByIntrinsics(x);
    std::array<Scalar, CameraModel::kNumIntrinsics> d{};
    for (std::size_t i = 0; i < d.size(); ++i) {
      d[i] = d_u * by[i].x + d_v * by[i].y;
    }
    Intrinsics(d);
  }

  void Pose(const MeshBlocks& b, const Vec3& x, const G& d_x) {
    if (b.translation >= 0) {
      target_.Add(b.translation, d_x);
    }
    if (b.rotation >= 0) {
      target_.Add(b.rotation, TransposedTimes(b.rotation_jacobian, Cross(x - b.center, d_x)));
    }
    if (b.scale >= 0) {
      target_.AddScalar(b.scale, 0, Dot(d_x, x - b.center) * b.inverse_scale);
    }
  }

  static std::array<Vec3, 3> PullNormal(const TriangleGeometry& t, const Vec3& d_n) {
    return NormalAdjoint(t, d_n);
  }
  static std::array<ColorGradient, 3> PullNormal(const TriangleGeometry& t,
                                                 const ColorGradient& d_n) {
    std::array<ColorGradient, 3> out;
    for (int c = 0; c < 3; ++c) {
      const std::array<Vec3, 3> one = NormalAdjoint(t, d_n[c]);
      for (std::size_t i = 0; i < 3; ++i) {
        out[i][c] = one[i];
      }
    }
    return out;
  }

  const World& world_;
  const CameraModel& camera_;
  const ActiveParameters& active_;
  Target& target_;
};

}  // namespace pathfit::renderer
