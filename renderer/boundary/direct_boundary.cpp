#include "renderer/boundary/direct_boundary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "renderer/geometry/tangent_wedge.h"

namespace pathfit::renderer {
namespace {

// A ray that should reach a light may fall short of it by this share.
constexpr double kReachTolerance = 1e-4;
// The wedge way takes over where drawing by the light is this much rarer: close to the light. It
// gets few samples, so a larger share would make each of them heavy.
constexpr double kWedgeShare = 0.2;

}  // namespace

DirectBoundary::DirectBoundary(const BoundaryContext& context) : context_(context) {
  const LightSet& lights = context.path.lights;
  const double total = context.edges.WedgeTotal();
  wedge_density_ = total > 0.0 ? 1.0 / (4.0 * total) : 0.0;
  silhouette_length_ = total / std::numbers::pi;
  if (context.edges.Empty() || context.path.max_bounces == 0) {
    return;
  }
  if (!lights.areas.empty()) {
    ways_.emplace_back(AreaWay{});
  }
  if (lights.environment) {
    ways_.emplace_back(&*lights.environment);
  }
  if (context.path.HasExtendedLights() && total > 0.0) {
    ways_.emplace_back(WedgeWay{});
  }
  for (const auto& light : lights.points) {
    ways_.emplace_back(&light);
  }
  for (const auto& light : lights.directionals) {
    ways_.emplace_back(&light);
  }
}

std::vector<BoundaryWay> DirectBoundary::Ways() const {
  std::vector<BoundaryWay> ways;
  for (const Way& way : ways_) {
    const bool edge_only = std::holds_alternative<const LightSet::PointLight*>(way) ||
                           std::holds_alternative<const LightSet::Directional*>(way);
    ways.push_back({edge_only ? 1 : 3});
  }
  return ways;
}

std::int64_t DirectBoundary::NumSamples() const {
  return SamplesPerPixel(context_, context_.options.spp_direct);
}

void DirectBoundary::Sample(std::size_t way, const BoundaryDraw& draw, SplatBuffer& splats) const {
  const LightSet& lights = context_.path.lights;
  const EdgeTree& edges = context_.edges;
  const auto& [u0, u1, u2] = draw.u;
  std::visit(Visitor{[&](AreaWay) {
                       const World& world = *context_.path.world;
                       const AreaSample y = lights.area_sampler->Sample(u1, u2);
                       const Vec3 position = world.caster().Geometry(y.id).Point(y.b1, y.b2);
                       SampleLightFirst(
                           draw,
                           edges.SampleFromPoint(position, true, u0),
                           [&](const Vec3& x_b) {
                             return SeeAreaPoint(world, lights, {y.id, y.b1, y.b2}, y.pdf, x_b);
                           },
                           splats);
                     },
                     [&](WedgeWay) { SampleWedgeFirst(draw, splats); },
                     [&](const LightSet::Environment* environment) {
                       const auto light = SeeEnvironment(
                           *environment, SampleWithoutReceiver(*environment, u1, u2));
                       if (light) {
                         SampleLightFirst(
                             draw,
                             edges.SampleAlongDirection(light->w, u0),
                             [&](const Vec3&) { return light; },
                             splats);
                       }
                     },
                     [&](const LightSet::PointLight* point) {
                       SampleLightFirst(
                           draw,
                           edges.SampleFromPoint(point->position, true, u0),
                           [&](const Vec3& x_b) { return SeePointLight(*point, x_b); },
                           splats);
                     },
                     [&](const LightSet::Directional* directional) {
                       SampleLightFirst(
                           draw,
                           edges.SampleAlongDirection(directional->to_light, u0),
                           [&](const Vec3&) { return SeeDirectional(*directional); },
                           splats);
                     }},
             ways_[way]);
}

double DirectBoundary::LightShare(double pdf) const {
  const double by_light = pdf / silhouette_length_;
  const double by_wedge = kWedgeShare * wedge_density_;
  return by_light * by_light / (by_light * by_light + by_wedge * by_wedge);
}

bool DirectBoundary::IsHidden(const BoundarySegment& segment) const {
  const auto hit = TraceSourceEnd(context_, segment);
  const auto* x_s = std::get_if<MaterialPoint>(&segment.source);
  return hit && !(x_s != nullptr && hit->id == x_s->id) &&
         hit->distance < segment.t2 * (1.0 - kReachTolerance);
}

template <class See>
void DirectBoundary::SampleLightFirst(const BoundaryDraw& draw,
                                      const EdgeTree::Pick& pick,
                                      See see,
                                      SplatBuffer& splats) const {
  if (pick.edge < 0) {
    return;
  }
  const BoundaryEdge& edge = context_.edges.edges()[static_cast<std::size_t>(pick.edge)];
  const std::optional<SeenLight> light = see(edge.a + (edge.b - edge.a) * pick.remainder);
  BoundarySegment segment;
  if (!light || IsBlack(light->radiance) ||
      !StartSegment(context_, edge, pick.remainder, light->w, segment)) {
    return;
  }
  segment.t2 = light->distance;
  segment.source = light->end;
  if (IsHidden(segment) || !TraceDetectorEnd(context_, segment)) {
    return;
  }
  const double pdf = pick.probability / edge.Length() * light->pdf;
  const double share = light->has_extent ? LightShare(light->pdf) : 1.0;
  IndependentSampler sampler = draw.Independent();
  ConnectDetectors(
      context_, segment, {light->radiance}, draw.weight * share / pdf, sampler, splats);
}

void DirectBoundary::SampleWedgeFirst(const BoundaryDraw& draw, SplatBuffer& splats) const {
  const EdgeTree::Pick pick = context_.edges.SampleByWedge(draw.u[0]);
  if (pick.edge < 0) {
    return;
  }
  const BoundaryEdge& edge = context_.edges.edges()[static_cast<std::size_t>(pick.edge)];
  const Vec3 w = SampleWedge(edge, draw.u[1], draw.u[2]);
  BoundarySegment segment;
  if (!StartSegment(context_, edge, pick.remainder, w, segment)) {
    return;
  }
  const LightSet& lights = context_.path.lights;
  Rgb radiance;
  double light_pdf = 0.0;
  if (const auto hit = TraceSourceEnd(context_, segment)) {
    const LightSet::AreaLight* light = lights.AreaLightOf(hit->id.mesh);
    if (light == nullptr) {
      return;
    }
    // By the direction that was drawn, not that to the point: where the edge touches the light,
    // they are one point.
    const double cos_light = -Dot(context_.path.world->caster().Geometry(hit->id).n, w);
    radiance =
        AreaRadiance(*light, hit->id.triangle, hit->b1, hit->b2, cos_light > 0.0 ? 1.0 : -1.0);
    light_pdf =
        lights.area_sampler->Pdf(hit->id) * hit->distance * hit->distance / std::abs(cos_light);
    segment.t2 = std::max(0.0, hit->distance);
    segment.source = MaterialPoint{hit->id, hit->b1, hit->b2};
  } else if (lights.environment) {
    radiance = EnvironmentRadianceInWorld(*lights.environment, w);
    light_pdf = PdfWithoutReceiver(*lights.environment, w);
    segment.t2 = std::numeric_limits<double>::infinity();
    segment.source = &*lights.environment;
  }
  if (IsBlack(radiance) || !TraceDetectorEnd(context_, segment)) {
    return;
  }
  const double pdf = pick.probability / (edge.Length() * 4.0 * context_.edges.Wedge(pick.edge));
  IndependentSampler sampler = draw.Independent();
  ConnectDetectors(context_,
                   segment,
                   {radiance},
                   draw.weight * (1.0 - LightShare(light_pdf)) / pdf,
                   sampler,
                   splats);
}

}  // namespace pathfit::renderer
