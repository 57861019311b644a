#include "renderer/boundary/boundary_segment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace pathfit::renderer {
namespace {

// Edge and segment are parallel below this sine: no plane is defined.
constexpr double kMinSinPhi = 1e-9;

// How far inside the shadow of an edge visibility is tested, and outside it a source that touches
// the edge is shaded, as a multiple of the same offset.
constexpr double kIntoShadow = 4.0;
// A surface that is nearly edge-on to the shadow's border is not followed further than this allows.
constexpr double kMinTangent = 0.1;
// Planes of triangles whose normals' cosine differs less from 1 are one.
constexpr double kSamePlane = 1e-9;
// Slopes that differ less are those of one plane: in it a face of the edge is before what touches
// it.
constexpr double kOnePlane = 1e-6;

double TouchDistance(const BoundaryContext& context, const BoundarySegment& segment) {
  return kTouch * context.path.world->caster().Offset(segment.x_b);
}

using RowMotion = MotionAdjoint<Vec3, MotionRow>;

/// How the sensor sees a point.
struct ImageView {
  Ray ray;
  double distance = 0.0;
  double u = 0.0, v = 0.0;
};

/// Gradient of the segment's normal velocity. `view`: of x_D if x_D is kept at its place in the
/// image, else null.
void FillRow(const BoundaryContext& context,
             const BoundarySegment& s,
             const ImageView* view,
             MotionRow& row) {
  row.Clear();
  RowMotion motion(*context.path.world, context.camera, context.active, row);
  const MeshEdge& edge =
      context.path.world->topology(s.edge->mesh).edges[static_cast<std::size_t>(s.edge->edge)];
  if (context.active.meshes[static_cast<std::size_t>(s.edge->mesh)].moves) {
    motion.Vertex(s.edge->mesh, edge.vertices[0], s.edge->a, s.n_b * (1.0 - s.t));
    motion.Vertex(s.edge->mesh, edge.vertices[1], s.edge->b, s.n_b * s.t);
  }
  const double lambda = s.d.distance / (s.d.distance + s.t2);  // 0 at infinity
  const Vec3 d_detector = s.n_b * (lambda - 1.0);
  if (view != nullptr) {
    motion.ImagePoint(s.d.id,
                      s.d.b1,
                      s.d.b2,
                      context.path.world->caster().Geometry(s.d.id).n,
                      view->ray,
                      view->distance,
                      view->u,
                      view->v,
                      d_detector);
  } else {
    motion.MaterialPoint(s.d.id, s.d.b1, s.d.b2, d_detector);
  }
  std::visit(Visitor{[&](const MaterialPoint& x_s) {
                       motion.MaterialPoint(x_s.id, x_s.b1, x_s.b2, s.n_b * -lambda);
                     },
                     [&](const LightSet::PointLight* light) {
                       if (motion.LightMoves(light->emitter)) {
                         motion.LightPosition(light->emitter, light->position, s.n_b * -lambda);
                       }
                     },
                     [&](const auto* direction) {  // lambda v_S -> t1 (spin x w)
                       if (motion.LightMoves(direction->emitter)) {
                         motion.LightSpin(direction->emitter, Cross(s.w, s.n_b * -s.d.distance));
                       }
                     }},
             s.source);
}

/// One vertex of the detector subpath: what arrives at it comes from `wi`.
struct Detector {
  TriangleId id;
  double b1 = 0.0, b2 = 0.0;
  Vec3 x;
  Vec3 wi;
};

struct Connection {
  Rgb importance;  // BSDF times pixel area per surface area, without filter
  ImageView view;
};

/// Factor |n_s . wi| / |n_g . wi|: light arrives by the shading normal's cosine, the geometry term
/// holds the other.  [path_space 1.7]
double ShadingCorrection(const SurfacePoint& p, const Vec3& wi) {
  return std::abs(Dot(p.n, wi) / Dot(p.ng, wi));
}

/// `step`: visibility is tested so far beside the vertex.
std::optional<Connection> Connect(const BoundaryContext& context,
                                  const Detector& detector,
                                  const Vec3& step) {
  const Camera& camera = context.camera.camera();
  const auto projection = context.camera.Project(detector.x);
  const double margin = camera.filter.radius;
  if (!projection || projection->u < -margin || projection->v < -margin ||
      projection->u > camera.width + margin || projection->v > camera.height + margin) {
    return std::nullopt;
  }
  Connection connection;
  const Ray to_camera = context.camera.RayTo(detector.x, connection.view.distance);
  const RayCaster& caster = context.path.world->caster();
  const SurfacePoint p = MakeSurfacePoint(
      *context.path.world, detector.id, detector.b1, detector.b2, detector.x, to_camera.direction);
  if (!p.Reflects() || !p.Accepts(detector.wi)) {
    return std::nullopt;
  }
  connection.importance = EvalBsdf(p.material->bsdf, p.inputs, p.Cosines(detector.wi)) *
                          (ShadingCorrection(p, detector.wi) *
                           std::abs(Dot(p.ng, Cross(projection->du, projection->dv))));
  if (IsBlack(connection.importance) ||
      caster.Occluded(
          {RayStart(p, p.wo) + step, p.wo},
          ShadowDistance(
              caster, connection.view.distance, detector.x + p.wo * connection.view.distance))) {
    return std::nullopt;
  }
  connection.view.u = projection->u;
  connection.view.v = projection->v;
  connection.view.ray = {detector.x + to_camera.direction * connection.view.distance,
                         -to_camera.direction};
  return connection;
}

/// Goes on from a detector vertex towards the sensor. Updates the throughput; false when it ends.
bool Advance(const BoundaryContext& context,
             Detector& detector,
             Rgb& throughput,
             IndependentSampler& sampler) {
  const World& world = *context.path.world;
  const RayCaster& caster = world.caster();
  // Directions are drawn as if light came from where it goes to: the densities are alike.
  const SurfacePoint from_light =
      MakeSurfacePoint(world, detector.id, detector.b1, detector.b2, detector.x, detector.wi);
  const double u0 = sampler.Next();
  const double u1 = sampler.Next();
  const double u2 = sampler.Next();
  const Bsdf& bsdf = from_light.material->bsdf;
  const auto sample = SampleBsdf(bsdf, from_light.inputs, from_light.n, detector.wi, u0, u1, u2);
  if (!sample || !(sample->pdf > 0.0)) {
    return false;
  }
  const SurfacePoint p =
      MakeSurfacePoint(world, detector.id, detector.b1, detector.b2, detector.x, sample->wi);
  if (!p.Reflects() || !p.Accepts(detector.wi)) {
    return false;
  }
  const BsdfCosines cosines = p.Cosines(detector.wi);
  if (IsDelta(bsdf)) {
    throughput *=
        EvalDelta(bsdf, p.inputs, cosines.cos_o, cosines.cos_i < 0.0, TransportMode::kImportance)
            .value *
        (ShadingCorrection(p, detector.wi) / (ShadingCorrection(p, sample->wi) * sample->pdf));
  } else {
    throughput *=
        EvalBsdf(bsdf, p.inputs, cosines) *
        (ShadingCorrection(p, detector.wi) * std::abs(Dot(p.ng, sample->wi)) / sample->pdf);
  }
  if (IsBlack(throughput)) {
    return false;
  }
  const auto hit = caster.Intersect({RayStart(p, p.wo), p.wo});
  if (!hit) {
    return false;
  }
  detector = {
      hit->id, hit->b1, hit->b2, caster.Geometry(hit->id).Point(hit->b1, hit->b2), -sample->wi};
  return true;
}

/// A triangle that touches the edge point of a segment.
struct TouchingFace {
  double slope = 0.0;  ///< see SlopeBeside
  bool ends = false;   ///< at the edge
  double apex = 0.0;  ///< how far its third corner is on the edge's own side; 0: it goes on on both
};

/// Empty: seen edge-on.
std::optional<TouchingFace> TouchingFaceOf(const BoundaryContext& context,
                                           const BoundarySegment& s,
                                           TriangleId id) {
  const RayCaster& caster = context.path.world->caster();
  const TriangleGeometry& triangle = caster.Geometry(id);
  const auto slope = SlopeBeside(triangle, s.w, s.n_b);
  if (!slope) {
    return std::nullopt;
  }
  const int border = BorderAlong(triangle, s.x_b, Normalized(s.edge->b - s.edge->a), caster);
  const double apex = border < 0 ? 0.0 : Dot(s.n_b, ApexOf(triangle, border) - s.x_b);
  return TouchingFace{*slope, border >= 0, apex};
}

/// Finds where what touches the edge point goes on beside the edge, and whether it hides the edge.
bool PlaceContacts(const BoundaryContext& context, BoundarySegment& s) {
  const RayCaster& caster = context.path.world->caster();
  const std::span<const TriangleId> all = s.faces.All();
  const std::span<const TriangleId> touching = s.faces.Touching();
  double own = std::numeric_limits<double>::infinity();
  for (const TriangleId id : all.first(all.size() - touching.size())) {
    if (id.triangle >= 0) {
      own = std::min(own, SlopeBeside(caster.Geometry(id), s.w, s.n_b).value_or(own));
    }
  }
  double nearest = 0.0;
  TriangleId beside;
  bool ends = false;  // at the edge
  for (const TriangleId id : touching) {
    const auto face = TouchingFaceOf(context, s, id);
    if (!face) {
      continue;
    }
    if (face->apex >= 0.0 && face->slope < own - kOnePlane * (1.0 + std::abs(own))) {
      return false;
    }
    if (face->apex <= 0.0 && (!beside.IsValid() || -face->slope < nearest)) {
      nearest = -face->slope;
      beside = id;
      ends = face->ends;
    }
  }
  if (!beside.IsValid()) {
    return true;
  }
  const TriangleGeometry& triangle = caster.Geometry(beside);
  s.beside = HitInside(beside, IntersectPlane(triangle, s.x_b, triangle.n));
  s.beside->distance = 0.0;
  const auto goes_on = [&](TriangleId id) {
    const auto face = id.mesh == beside.mesh ? TouchingFaceOf(context, s, id) : std::nullopt;
    return face && face->apex >= 0.0;
  };
  s.share = ends && std::none_of(touching.begin(), touching.end(), goes_on) ? 0.5 : 1.0;
  return true;
}

/// What the line meets beyond x_B.
std::optional<Hit> TraceIgnoring(const BoundaryContext& context,
                                 const BoundarySegment& s,
                                 const Vec3& direction,
                                 std::span<const TriangleId> ignored) {
  // The ray starts a little before the edge point: a surface that touches the edge there is met,
  // which rounding would otherwise decide by chance.
  const double start = TouchDistance(context, s);
  // A face that the line grazes would be met at its far border: the ray passes it on the free side.
  const double aside = s.edge->Grazes(s.w) ? start : 0.0;
  auto hit = context.path.world->caster().IntersectIgnoring(
      {s.x_b - direction * start - s.n_b * aside, direction}, 0.0, ignored);
  if (hit) {
    hit->distance -= start;
  }
  return hit;
}

}  // namespace

std::int64_t SamplesPerPixel(const BoundaryContext& context, double spp) {
  const Camera& camera = context.camera.camera();
  return static_cast<std::int64_t>(spp * (static_cast<double>(camera.width) * camera.height));
}

Vec3 StepIntoShadow(const BoundaryContext& context,
                    const BoundarySegment& segment,
                    TriangleId id,
                    const Vec3& x) {
  const RayCaster& caster = context.path.world->caster();
  const Vec3& n = caster.Geometry(id).n;
  const Vec3 tangent = segment.n_b - n * Dot(n, segment.n_b);
  const double length = std::max(Norm(tangent), kMinTangent);
  return tangent *
         (kIntoShadow * std::max(caster.Offset(x), caster.Offset(segment.x_b)) / (length * length));
}

bool StartSegment(const BoundaryContext& context,
                  const BoundaryEdge& edge,
                  double t,
                  const Vec3& w,
                  BoundarySegment& segment) {
  if (!edge.IsSilhouette(w)) {
    return false;
  }
  const Vec3 along = edge.b - edge.a;
  const Vec3 normal = Cross(along, w) * (1.0 / Norm(along));
  segment.sin_phi = Norm(normal);
  if (!(segment.sin_phi > kMinSinPhi)) {
    return false;
  }
  segment.edge = &edge;
  segment.t = t;
  segment.x_b = edge.a + along * t;
  segment.w = w;
  const MeshEdge& mesh_edge =
      context.path.world->topology(edge.mesh).edges[static_cast<std::size_t>(edge.edge)];
  const Mesh& mesh = context.path.world->mesh(edge.mesh);
  const auto side_of = [&](std::size_t face) {
    const Vec3& apex = mesh.positions[static_cast<std::size_t>(mesh_edge.apex[face])];
    return Dot(normal, apex - edge.a);
  };
  double side = side_of(0);
  // A face that the line grazes is on neither side.
  if (edge.Grazes(w) && !edge.border && std::abs(side_of(1)) > std::abs(side)) side = side_of(1);
  segment.n_b = normal * ((side > 0.0 ? 1.0 : -1.0) / segment.sin_phi);
  segment.faces = context.contacts.At(edge.mesh, edge.edge, t);
  return segment.faces.Touching().empty() || PlaceContacts(context, segment);
}

bool TouchesEdge(const BoundaryContext& context, const BoundarySegment& segment, double distance) {
  return distance <= TouchDistance(context, segment);
}

std::optional<Hit> TraceSourceEnd(const BoundaryContext& context, const BoundarySegment& segment) {
  return segment.beside ? segment.beside
                        : TraceIgnoring(context, segment, segment.w, segment.faces.All());
}

bool TraceDetectorEnd(const BoundaryContext& context, BoundarySegment& segment) {
  const RayCaster& caster = context.path.world->caster();
  auto hit = TraceIgnoring(context, segment, -segment.w, segment.faces.All());
  const auto* x_s = std::get_if<MaterialPoint>(&segment.source);
  if (x_s != nullptr && TouchesEdge(context, segment, segment.t2)) {
    // The ray starts behind the source's plane, which may be made of several triangles here.
    const Vec3& n = caster.Geometry(x_s->id).n;
    const auto is_of_plane = [&] {
      return hit && TouchesEdge(context, segment, hit->distance) &&
             std::abs(Dot(n, caster.Geometry(hit->id).n)) > 1.0 - kSamePlane;
    };
    if (is_of_plane()) {
      const std::span<const TriangleId> faces = segment.faces.All();
      std::vector<TriangleId> passed(faces.begin(), faces.end());
      while (is_of_plane()) {
        passed.push_back(hit->id);
        hit = TraceIgnoring(context, segment, -segment.w, passed);
      }
    }
  }
  if (!hit || TouchesEdge(context, segment, hit->distance)) {
    return false;
  }
  segment.d = *hit;
  segment.x_d = caster.Geometry(hit->id).Point(hit->b1, hit->b2);
  return true;
}

void ConnectDetectors(const BoundaryContext& context,
                      const BoundarySegment& segment,
                      const CumulativeRadiance& cumulative,
                      double weight,
                      IndependentSampler& sampler,
                      SplatBuffer& splats) {
  const int max_bounces = context.path.max_bounces;
  const auto material_of = [&](TriangleId id) -> const Material& {
    return context.path.world->MaterialOf(id.mesh);
  };
  if (IsDelta(material_of(segment.d.id).bsdf)) {
    return;  // a moving direct reflection has no boundary segment that could be sampled
  }
  Detector detector{segment.d.id, segment.d.b1, segment.d.b2, segment.x_d, segment.w};
  Rgb throughput = Rgb::Constant(weight * segment.sin_phi * segment.share);
  MotionRow row;
  bool has_material_row = false;
  for (int k = 0; k < max_bounces; ++k) {
    const auto available =
        std::min<std::size_t>(static_cast<std::size_t>(max_bounces - 1 - k), cumulative.size() - 1);
    const Rgb& radiance = cumulative[available];
    const bool delta = IsDelta(material_of(detector.id).bsdf);
    if (!delta && !IsBlack(radiance)) {
      // The border of a shadow is seen where its dark side is, too. A light in the camera's own
      // place casts shadows exactly behind what it lights, which rounding would show or hide.
      const Vec3 step =
          k == 0 ? StepIntoShadow(context, segment, segment.d.id, segment.x_d) : Vec3{};
      if (const auto connection = Connect(context, detector, step)) {
        const bool image = k == 0 && context.options.form == DerivativeForm::kImage;
        if (image) {
          FillRow(context, segment, &connection->view, row);
        } else if (!has_material_row) {
          FillRow(context, segment, nullptr, row);
          has_material_row = true;
        }
        if (!row.Empty()) {
          splats.Splat(context.camera.camera(),
                       connection->view.u,
                       connection->view.v,
                       Rgba(throughput * radiance * connection->importance, 0.0),
                       row);
        }
      }
    }
    if (k + 1 == max_bounces || !Advance(context, detector, throughput, sampler)) {
      return;
    }
  }
}

}  // namespace pathfit::renderer
