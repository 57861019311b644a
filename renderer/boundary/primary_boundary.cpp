#include "renderer/boundary/primary_boundary.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pathfit::renderer {
namespace {

constexpr std::uint64_t kPrimaryDomain = 3;
// Faces are told apart by looking this far beside the edge, in pixels; only planes are intersected
// there.
constexpr double kSideStep = 1e-3;
// The background is shaded this far beside the edge, in pixels, on its own side: a light near the
// sensor sees the edge and the point behind it in line, so that the shadow ray would graze the
// edge.
constexpr double kBackgroundStep = 2e-2;
// Faces are shaded this far inside, as a share of the way to their centre, so that shadow rays
// clear the fold.
constexpr double kInset = 2e-3;
// An edge point is hidden if something lies this share of the scene's extent in front of it.
constexpr double kDepthTolerance = 2e-5;

/// Uniform numbers without lattice: edge samples are already systematic along the edges.
class IndependentSampler {
 public:
  explicit IndependentSampler(CounterRng rng) : rng_(rng) {}
  double Next() { return rng_.Next(); }

 private:
  CounterRng rng_;
};

}  // namespace

struct PrimaryBoundary::EdgePoint {
  const MeshEdge* edge;
  int mesh;
  Vec3 a, b, x;
  Ray ray;          // from the sensor through x
  double distance;  // of x
  Projection projection;
  Vec2 m;  // normal of the edge's image, times |du/dt|; points to the plus side
};

/// The face seen on each side of the edge; invalid where the background is seen.
struct PrimaryBoundary::Sides {
  TriangleId minus, plus;
};

std::int64_t PrimaryBoundary::NumSamples(double sppe) const {
  return static_cast<std::int64_t>(std::ceil(sppe * edges_.distribution().Total()));
}

Ray PrimaryBoundary::RayBeside(const EdgePoint& point, double step) const {
  const Vec2 shift = point.m * (step / std::hypot(point.m.x, point.m.y));
  return camera_.RayThrough(point.projection.u + shift.x, point.projection.v + shift.y);
}

PrimaryBoundary::Sides PrimaryBoundary::FacesBySide(const EdgePoint& point) const {
  const Vec3& eye = point.ray.origin;
  const Vec3 plane = Cross(point.a - eye, point.b - eye);  // of the sensor and the edge
  const Ray plus_ray = RayBeside(point, kSideStep);
  const Ray minus_ray = RayBeside(point, -kSideStep);
  const double plus_sign = Dot(plane, plus_ray.direction) > 0.0 ? 1.0 : -1.0;
  const Mesh& mesh = context_.scene->meshes[static_cast<std::size_t>(point.mesh)].mesh;

  Sides sides;
  std::array<double, 2> nearest = {-1.0, -1.0};  // minus, plus
  for (std::size_t i = 0; i < 2 && point.edge->faces[i] >= 0; ++i) {
    const TriangleId face{point.mesh, point.edge->faces[i]};
    const Vec3& apex = mesh.positions[static_cast<std::size_t>(point.edge->apex[i])];
    const bool on_plus = Dot(plane, apex - eye) * plus_sign > 0.0;
    const Ray& beside = on_plus ? plus_ray : minus_ray;
    // Depth beside the edge, relative to the edge: the nearer face hides the other.
    const double depth =
        IntersectPlane(context_.caster->Geometry(face), eye, beside.direction).distance;
    TriangleId& side = on_plus ? sides.plus : sides.minus;
    double& best = nearest[on_plus ? 1 : 0];
    if (!side.IsValid() || depth < best) {
      side = face;
      best = depth;
    }
  }
  return sides;
}

Rgba PrimaryBoundary::ShadeFace(const EdgePoint& point, TriangleId face, CounterRng rng) const {
  const TriangleGeometry& geometry = context_.caster->Geometry(face);
  const PlaneHit at_edge = IntersectPlane(geometry, point.ray.origin, point.ray.direction);
  Hit hit{face, 0.0, 0.0, point.distance};
  hit.b1 = at_edge.b1 + kInset * (1.0 / 3.0 - at_edge.b1);
  hit.b2 = at_edge.b2 + kInset * (1.0 / 3.0 - at_edge.b2);
  SurfacePoint p = MakeSurfacePoint(*context_.scene, *context_.caster, hit, point.ray);
  p.x = geometry.Point(hit.b1, hit.b2);
  IndependentSampler sampler(rng);
  NullPathRecorder recorder;
  return {TraceRadiance(context_, p, sampler, recorder), 1.0};
}

Rgba PrimaryBoundary::ShadeBackground(const EdgePoint& point,
                                      const std::optional<Hit>& hit,
                                      double side,
                                      CounterRng rng) const {
  if (!hit) {
    const LightSet& lights = context_.lights;
    if (!lights.environment || !lights.environment_visible) {
      return {};
    }
    return {EnvironmentRadianceInWorld(*lights.environment, point.ray.direction), 0.0};
  }
  const Ray ray = RayBeside(point, side * kBackgroundStep);
  const PlaneHit beside =
      IntersectPlane(context_.caster->Geometry(hit->id), ray.origin, ray.direction);
  // A background seen edge on has no such neighbour on the same triangle.
  const bool usable = beside.distance > point.distance;
  const SurfacePoint p =
      MakeSurfacePoint(*context_.scene,
                       *context_.caster,
                       usable ? Hit{hit->id, beside.b1, beside.b2, beside.distance} : *hit,
                       usable ? ray : point.ray);
  IndependentSampler sampler(rng);
  NullPathRecorder recorder;
  return {TraceRadiance(context_, p, sampler, recorder), 1.0};
}

std::optional<PrimaryBoundarySample> PrimaryBoundary::Sample(const RenderOptions& options,
                                                             std::int64_t index,
                                                             std::int64_t count,
                                                             RenderStats& stats) const {
  ++stats.edge_samples;
  CounterRng rng(options.seed, kPrimaryDomain, options.view, static_cast<std::uint64_t>(index), 0);
  double remainder = 0.0;
  const int choice = edges_.distribution().Sample(
      (static_cast<double>(index) + rng.Next()) / static_cast<double>(count), remainder);
  const ViewEdge& view_edge = edges_.edge(choice);
  const Mesh& mesh = context_.scene->meshes[static_cast<std::size_t>(view_edge.mesh)].mesh;
  const MeshEdge& edge = topologies_[static_cast<std::size_t>(view_edge.mesh)]
                             .edges[static_cast<std::size_t>(view_edge.edge)];

  EdgePoint point;
  point.edge = &edge;
  point.mesh = view_edge.mesh;
  point.a = mesh.positions[static_cast<std::size_t>(edge.vertices[0])];
  point.b = mesh.positions[static_cast<std::size_t>(edge.vertices[1])];
  const double t = view_edge.t0 + (view_edge.t1 - view_edge.t0) * remainder;
  point.x = point.a * (1.0 - t) + point.b * t;
  const auto projection = camera_.Project(point.x);
  if (!projection) {
    return std::nullopt;
  }
  point.projection = *projection;
  const double px = std::floor(projection->u);
  const double py = std::floor(projection->v);
  if (px < 0.0 || py < 0.0 || px >= camera_.camera().width || py >= camera_.camera().height) {
    return std::nullopt;
  }
  const Vec3 along = point.b - point.a;
  point.m = {-Dot(projection->dv, along), Dot(projection->du, along)};
  if (!(std::hypot(point.m.x, point.m.y) > 0.0)) {
    return std::nullopt;
  }
  const Vec3 to_point = point.x - camera_.Origin();
  point.distance = Norm(to_point);
  point.ray = {camera_.Origin(), to_point / point.distance};

  const std::array<TriangleId, 2> faces = {TriangleId{point.mesh, edge.faces[0]},
                                           TriangleId{point.mesh, edge.faces[1]}};
  const auto beyond = context_.caster->IntersectIgnoring(point.ray, 0.0, faces);
  const double tolerance = kDepthTolerance * context_.caster->Extent();
  if (beyond && beyond->distance < point.distance - tolerance) {
    ++stats.edge_samples_hidden;
    return std::nullopt;
  }

  // Both sides see the same random numbers: their difference is less noisy than either.
  const Sides sides = FacesBySide(point);
  const auto shade = [&](TriangleId face, double side) {
    return face.IsValid() ? ShadeFace(point, face, rng) : ShadeBackground(point, beyond, side, rng);
  };
  const double probability =
      edges_.distribution().Probability(choice) / (view_edge.t1 - view_edge.t0);
  PrimaryBoundarySample sample;
  sample.x = static_cast<int>(px);
  sample.y = static_cast<int>(py);
  sample.mesh = point.mesh;
  sample.vertex_a = edge.vertices[0];
  sample.vertex_b = edge.vertices[1];
  sample.t = t;
  sample.direction = (projection->du * point.m.x + projection->dv * point.m.y) *
                     (1.0 / (probability * static_cast<double>(count)));
  sample.jump = shade(sides.minus, -1.0) - shade(sides.plus, 1.0);
  if (!IsFinite(sample.jump.Color()) || !IsFinite(sample.direction)) {
    ++stats.non_finite_samples;
    return std::nullopt;
  }
  return sample;
}

}  // namespace pathfit::renderer
