#include "renderer/boundary/primary_boundary.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/boundary/visible_point.h"

namespace pathfit::renderer {
namespace {

// The background is shaded beside the edge, on its own side, where the ray passes the edge at this
// many offsets of secondary rays: a light near the sensor sees the edge and the point behind it in
// line, so that the shadow ray would graze the edge.
constexpr double kClearance = 10.0;
// Faces are shaded this far inside, in offsets of secondary rays, so that shadow rays clear the
// fold, but at most this share of the way to their centre.
constexpr double kInset = 2.0;
constexpr double kMaxInset = 0.1;
// That point's distance from the sensor differs by less than this share.
constexpr double kNearby = 0.1;
// It stays on its triangle, which ends at most this share of the way to the border: a surface seen
// under a grazing angle goes on elsewhere than its plane.
constexpr double kMostOfTriangle = 0.9;
// An edge point is hidden if something lies this many offsets of rays in front of it.
constexpr double kDepthTolerance = 5.0;
// Slopes that differ less, relative to their size, are those of one plane: its own face hides what
// lies in the plane of a face of the edge.
constexpr double kOnePlane = 1e-6;

/// From a point of a triangle towards another one of its plane, as far as the triangle allows.
Vec2 MoveInside(const Hit& from, const PlaneHit& to) {
  double share = 1.0;
  const auto stop_at_border = [&](double at_from, double at_to) {
    if (at_to < 0.0 && at_to < at_from) {
      share = std::min(share, kMostOfTriangle * std::max(0.0, at_from) / (at_from - at_to));
    }
  };
  stop_at_border(from.b1, to.b1);
  stop_at_border(from.b2, to.b2);
  stop_at_border(1.0 - from.b1 - from.b2, 1.0 - to.b1 - to.b2);
  return {from.b1 + share * (to.b1 - from.b1), from.b2 + share * (to.b2 - from.b2)};
}

}  // namespace

struct PrimaryBoundary::EdgePoint {
  explicit EdgePoint(const BoundaryDraw& draw) : sampler(draw.Lattice()) {}

  // Both sides use the same numbers: less noise in their difference.
  LatticeSampler sampler;
  const MeshEdge* edge = nullptr;
  int mesh = 0;
  FacesAtEdge faces;
  double t = 0.0;
  Vec3 a, b, x;
  Ray ray;                // of the sensor, through x
  double distance = 0.0;  // of x
  Projection projection;
  Vec2 m;                // normal of the edge's image, times |du/dt|; points to the plus side
  Vec3 g;                // gradient of m . u by x: normal of the plane of edge and ray
  double density = 0.0;  // of the sample, per t
};

/// The face seen on one side of the edge; invalid where the background is seen.
struct PrimaryBoundary::Side {
  TriangleId face;
  bool own = false;  // of the edge
  int border = -1;   // of another face: its side on which the edge point lies, if any
  double slope = 0.0;
};

std::vector<BoundaryWay> PrimaryBoundary::Ways() const {
  if (edges_.distribution().Empty()) {
    return {};
  }
  // A guide would cost more than it wins: the distribution knows lengths and jumps, and at equal
  // numbers of samples the variance was 0.6 to 1.5 times that without, most often above 1.
  return {{1, false, 1}};
}

std::int64_t PrimaryBoundary::NumSamples() const {
  return static_cast<std::int64_t>(
      std::ceil(context_.options.sppe * edges_.distribution().Total()));
}

std::optional<PrimaryBoundary::EdgePoint> PrimaryBoundary::PointAt(const BoundaryDraw& draw) const {
  const CameraModel& camera = context_.camera;
  double share = 0.0;
  const int choice = edges_.distribution().Sample(draw.u[0], share);
  const ViewEdge& view_edge = edges_.edge(choice);
  const ViewEdge::Point at = view_edge.At(share);
  const MeshEdge& edge =
      context_.path.world->topology(view_edge.mesh).edges[static_cast<std::size_t>(view_edge.edge)];
  const Mesh& mesh = context_.path.world->mesh(view_edge.mesh);

  // Neighbours along an edge, which add to the same pixels, spread over the lights together.
  EdgePoint point(draw);
  point.edge = &edge;
  point.mesh = view_edge.mesh;
  point.t = at.t;
  point.a = mesh.positions[static_cast<std::size_t>(edge.vertices[0])];
  point.b = mesh.positions[static_cast<std::size_t>(edge.vertices[1])];
  point.x = point.a * (1.0 - at.t) + point.b * at.t;
  point.density = edges_.distribution().Probability(choice) / at.dt;
  const auto projection = camera.Project(point.x);
  if (!projection) {
    return std::nullopt;
  }
  const Camera& film = camera.camera();
  const CoveringRange columns = CoveringPixels(film.filter, projection->u, film.width);
  const CoveringRange rows = CoveringPixels(film.filter, projection->v, film.height);
  if (columns.first >= columns.end || rows.first >= rows.end) {
    return std::nullopt;
  }
  point.projection = *projection;
  const Vec3 along = point.b - point.a;
  point.m = {-Dot(projection->dv, along), Dot(projection->du, along)};
  if (!(std::hypot(point.m.x, point.m.y) > 0.0)) {
    return std::nullopt;
  }
  point.g = projection->du * point.m.x + projection->dv * point.m.y;
  const Ray to_sensor = camera.RayTo(point.x, point.distance);
  point.ray = {point.x + to_sensor.direction * point.distance, -to_sensor.direction};
  point.faces = context_.contacts.At(view_edge.mesh, view_edge.edge, at.t);
  return point;
}

std::array<PrimaryBoundary::Side, 2> PrimaryBoundary::FacesBySide(const EdgePoint& point) const {
  const RayCaster& caster = context_.path.world->caster();
  const Mesh& mesh = context_.path.world->mesh(point.mesh);
  std::array<Side, 2> sides;
  // Where several are on one side, the one that falls away least hides the others.
  const auto offer = [&](bool plus, const Side& face) {
    Side& side = sides[plus ? 1 : 0];
    const double tie = face.own ? 0.0 : kOnePlane * (std::abs(face.slope) + Norm(point.g));
    if (!side.face.IsValid() || face.slope < side.slope - tie) {
      side = face;
    }
  };
  for (std::size_t i = 0; i < 2 && point.edge->faces[i] >= 0; ++i) {
    const TriangleId face{point.mesh, point.edge->faces[i]};
    const Vec3& apex = mesh.positions[static_cast<std::size_t>(point.edge->apex[i])];
    const bool plus = Dot(point.g, apex - point.a) > 0.0;
    if (const auto slope = SlopeBeside(caster.Geometry(face), point.ray.direction, point.g)) {
      offer(plus, {face, true, -1, plus ? *slope : -*slope});
    }
  }
  const Vec3 along = Normalized(point.b - point.a);
  for (const TriangleId face : point.faces.Touching()) {
    const TriangleGeometry& triangle = caster.Geometry(face);
    const auto slope = SlopeBeside(triangle, point.ray.direction, point.g);
    if (!slope) {
      continue;
    }
    const int border = BorderAlong(triangle, point.x, along, caster);
    const double apex = border < 0 ? 0.0 : Dot(point.g, ApexOf(triangle, border) - point.x);
    if (apex >= 0.0) {
      offer(true, {face, false, border, *slope});
    }
    if (apex <= 0.0) {
      offer(false, {face, false, border, -*slope});
    }
  }
  return sides;
}

Rgb PrimaryBoundary::ShadeFace(const EdgePoint& point, TriangleId face) const {
  const RayCaster& caster = context_.path.world->caster();
  const TriangleGeometry& geometry = caster.Geometry(face);
  const PlaneHit at_edge = IntersectPlane(geometry, point.ray.origin, point.ray.direction);
  const double to_center = Norm(geometry.Point(1.0 / 3.0, 1.0 / 3.0) - point.x);
  const double inset = std::min(kMaxInset, kInset * caster.Offset(point.x) / to_center);
  const double b1 = at_edge.b1 + inset * (1.0 / 3.0 - at_edge.b1);
  const double b2 = at_edge.b2 + inset * (1.0 / 3.0 - at_edge.b2);
  const SurfacePoint p = MakeSurfacePoint(
      *context_.path.world, face, b1, b2, geometry.Point(b1, b2), -point.ray.direction);
  LatticeSampler sampler = point.sampler;
  NullListener listener;
  return TraceRadiance(context_.path, p, sampler, listener, {context_.path.max_bounces});
}

Rgb PrimaryBoundary::ShadeBackground(const EdgePoint& point,
                                     const std::optional<Hit>& hit,
                                     double side) const {
  if (!hit) {
    const LightSet& lights = context_.path.lights;
    return lights.ShowsEnvironment()
               ? EnvironmentRadianceInWorld(*lights.environment, point.ray.direction)
               : Rgb{};
  }
  const RayCaster& caster = context_.path.world->caster();
  // Moving x by v along g moves the image by m . u' = |g| v across the edge.
  const double pixels_per_metre = Norm(point.g) / std::hypot(point.m.x, point.m.y);
  // The shadow ray starts beside the background, which moves it less at the edge.
  const Vec3 x = point.ray.origin + point.ray.direction * hit->distance;
  const double nearer = context_.camera.IsOrthographic() ? 1.0 : point.distance / hit->distance;
  const double offset = std::max(caster.Offset(point.x), caster.Offset(x) * nearer);
  const double step = side * kClearance * offset * pixels_per_metre;
  const Vec2 shift = point.m * (step / std::hypot(point.m.x, point.m.y));
  const Ray ray =
      context_.camera.RayThrough(point.projection.u + shift.x, point.projection.v + shift.y);
  const TriangleGeometry& geometry = caster.Geometry(hit->id);
  const PlaneHit beside = IntersectPlane(geometry, ray.origin, ray.direction);
  // A background seen edge on has no such neighbour on the same triangle. Where the edge touches
  // the background, the neighbour may be nearer than the edge.
  const bool usable = std::abs(beside.distance - hit->distance) < kNearby * hit->distance;
  const Vec2 b = usable ? MoveInside(*hit, beside) : Vec2{hit->b1, hit->b2};
  const SurfacePoint p = MakeSurfacePoint(*context_.path.world,
                                          hit->id,
                                          b.x,
                                          b.y,
                                          geometry.Point(b.x, b.y),
                                          usable ? -ray.direction : -point.ray.direction);
  LatticeSampler sampler = point.sampler;
  NullListener listener;
  return TraceRadiance(context_.path, p, sampler, listener, {context_.path.max_bounces});
}

void PrimaryBoundary::Sample(std::size_t /*way*/,
                             const BoundaryDraw& draw,
                             SplatBuffer& splats) const {
  const auto point = PointAt(draw);
  if (!point) {
    return;
  }
  const RayCaster& caster = context_.path.world->caster();
  auto behind = caster.IntersectIgnoring(point->ray, 0.0, point->faces.All());
  const std::array<Side, 2> sides = FacesBySide(*point);
  const bool hidden =
      behind && behind->distance < point->distance - kDepthTolerance * caster.Offset(point->x);
  if (hidden || !(sides[0].own || sides[1].own)) {
    ++splats.stats.edge_samples_hidden;
    return;
  }
  // The same line may be an edge of what touches this one: each counts a share.
  double share = 1.0;
  for (const Side& side : sides) {
    if (!side.own && side.face.IsValid()) {
      behind = HitInside(
          side.face,
          IntersectPlane(caster.Geometry(side.face), point->ray.origin, point->ray.direction));
      share = side.border >= 0 && edges_.Contains(side.face, side.border) ? 0.5 : 1.0;
    }
  }

  MotionRow of_edge;
  MotionAdjoint<Vec3, MotionRow> motion(
      *context_.path.world, context_.camera, context_.active, of_edge);
  motion.Vertex(point->mesh, point->edge->vertices[0], point->a, point->g * (1.0 - point->t));
  motion.Vertex(point->mesh, point->edge->vertices[1], point->b, point->g * point->t);
  motion.PixelOfFixedPoint(point->x, point->projection, point->m.x, point->m.y);
  const bool background_in_image = IsInImageForm(context_, behind);
  MotionRow relative = of_edge;
  if (!background_in_image) {
    AddMotionOfVisiblePoint(context_, behind, point->ray, {-point->m.x, -point->m.y}, relative);
  }

  Rgba in_image;
  Rgb in_material;
  const auto add = [&](const Side& face, double side) {
    if (face.own) {
      const bool counts = context_.options.form == DerivativeForm::kImage && !of_edge.Empty();
      in_image += Rgba(counts ? ShadeFace(*point, face.face) : Rgb{}, 1.0) * -side;
      return;
    }
    const bool counts = !(background_in_image ? of_edge : relative).Empty();
    const Rgb radiance = counts ? ShadeBackground(*point, behind, side) : Rgb{};
    in_image += Rgba(background_in_image ? radiance : Rgb{}, behind ? 1.0 : 0.0) * -side;
    in_material += (background_in_image ? Rgb{} : radiance) * -side;
  };
  add(sides[0], -1.0);
  add(sides[1], 1.0);
  const double weight = draw.weight / point->density;
  const auto splat = [&](const Rgba& color, const MotionRow& row) {
    if (!row.Empty() && !(color == Rgba())) {
      splats.Splat(
          context_.camera.camera(), point->projection.u, point->projection.v, color * weight, row);
    }
  };
  splat(in_image * share, of_edge);
  splat(Rgba(in_material, 0.0), relative);
}

}  // namespace pathfit::renderer
