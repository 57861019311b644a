#include "renderer/boundary/direct_boundary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "renderer/geometry/tangent_wedge.h"
#include "renderer/math/warp.h"

namespace pathfit::renderer {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
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
    ways_.push_back({Way::Kind::kArea});
  }
  if (lights.environment) {
    ways_.push_back({Way::Kind::kEnvironment});
  }
  if (context.path.HasExtendedLights() && total > 0.0) {
    ways_.push_back({Way::Kind::kWedge});
  }
  for (std::size_t i = 0; i < lights.points.size(); ++i) {
    ways_.push_back({Way::Kind::kPoint, static_cast<int>(i)});
  }
  for (std::size_t i = 0; i < lights.directionals.size(); ++i) {
    ways_.push_back({Way::Kind::kDirectional, static_cast<int>(i)});
  }
}

std::vector<BoundaryWay> DirectBoundary::Ways() const {
  std::vector<BoundaryWay> ways;
  for (const Way& way : ways_) {
    const bool has_extent = way.kind != Way::Kind::kPoint && way.kind != Way::Kind::kDirectional;
    ways.push_back({has_extent ? 3 : 1});
  }
  return ways;
}

std::int64_t DirectBoundary::NumSamples() const {
  return SamplesPerPixel(context_, context_.options.spp_direct);
}

void DirectBoundary::Sample(std::size_t way, const BoundaryDraw& draw, SplatBuffer& splats) const {
  const Way& w = ways_[way];
  const std::array<double, 3>& u = draw.u;
  const double weight = draw.weight;
  IndependentSampler sampler = draw.Independent();
  const LightSet& lights = context_.path.lights;
  switch (w.kind) {
    case Way::Kind::kArea:
      return SampleArea(u, weight, sampler, splats);
    case Way::Kind::kEnvironment:
      return SampleEnvironment(u, weight, sampler, splats);
    case Way::Kind::kWedge:
      return SampleWedgeDirection(u, weight, sampler, splats);
    case Way::Kind::kPoint:
      return SamplePoint(
          lights.points[static_cast<std::size_t>(w.index)], u[0], weight, sampler, splats);
    case Way::Kind::kDirectional:
      return SampleDirectional(
          lights.directionals[static_cast<std::size_t>(w.index)], u[0], weight, sampler, splats);
  }
}

double DirectBoundary::LightShare(double pdf) const {
  const double by_light = pdf / silhouette_length_;
  const double by_wedge = kWedgeShare * wedge_density_;
  return by_light * by_light / (by_light * by_light + by_wedge * by_wedge);
}

void DirectBoundary::Connect(const BoundarySegment& segment,
                             const Rgb& radiance,
                             double weight,
                             IndependentSampler& sampler,
                             SplatBuffer& splats) const {
  ConnectDetectors(context_, segment, {radiance}, weight, sampler, splats);
}

void DirectBoundary::SampleArea(const std::array<double, 3>& u,
                                double weight,
                                IndependentSampler& sampler,
                                SplatBuffer& splats) const {
  const LightSet& lights = context_.path.lights;
  const AreaSample y = lights.area_sampler->Sample(u[1], u[2]);
  const TriangleGeometry& triangle = context_.path.world->caster().Geometry(y.id);
  const Vec3 position = triangle.Point(y.b1, y.b2);
  const EdgeTree::Pick pick = context_.edges.SampleFromPoint(position, true, u[0]);
  if (pick.edge < 0) {
    return;
  }
  const BoundaryEdge& edge = context_.edges.edges()[static_cast<std::size_t>(pick.edge)];
  const Vec3 x_b = edge.a + (edge.b - edge.a) * pick.remainder;
  BoundarySegment segment;
  segment.t2 = Norm(position - x_b);
  const Vec3 w = (position - x_b) * (1.0 / segment.t2);
  const double cos_light = -Dot(triangle.n, w);
  const LightSet::AreaLight& light = *lights.AreaLightOf(y.id.mesh);
  const Rgb radiance = AreaRadiance(light, y.id.triangle, y.b1, y.b2, cos_light > 0.0 ? 1.0 : -1.0);
  if (!(segment.t2 > 0.0) || cos_light == 0.0 || IsBlack(radiance) ||
      !StartSegment(context_, edge, pick.remainder, w, segment)) {
    return;
  }
  const auto hit = TraceFromEdge(context_, segment, w);
  if (hit && !(hit->id == y.id) && hit->distance < segment.t2 * (1.0 - kReachTolerance)) {
    return;
  }
  segment.source = {y.id, y.b1, y.b2, -1, false, {}};
  if (!TraceDetectorEnd(context_, segment)) {
    return;
  }
  const double pdf_w = y.pdf * segment.t2 * segment.t2 / std::abs(cos_light);
  const double pdf = pick.probability / edge.Length() * pdf_w;
  Connect(segment, radiance, weight * LightShare(pdf_w) / pdf, sampler, splats);
}

void DirectBoundary::SampleEnvironment(const std::array<double, 3>& u,
                                       double weight,
                                       IndependentSampler& sampler,
                                       SplatBuffer& splats) const {
  const LightSet::Environment& environment = *context_.path.lights.environment;
  DirectionSample sample;
  if (environment.light->texels.size() == 1) {  // the same from everywhere
    sample.direction = SampleUniformSphere(u[1], u[2]);
    sample.pdf = 0.25 * std::numbers::inv_pi;
  } else {
    sample = environment.sampler->Sample({}, u[1], u[2]);
  }
  const Vec3 w = environment.world_from_light * sample.direction;
  const EdgeTree::Pick pick = context_.edges.SampleAlongDirection(w, u[0]);
  if (pick.edge < 0 || !(sample.pdf > 0.0)) {
    return;
  }
  const BoundaryEdge& edge = context_.edges.edges()[static_cast<std::size_t>(pick.edge)];
  BoundarySegment segment;
  segment.t2 = kInfinity;
  if (!StartSegment(context_, edge, pick.remainder, w, segment) ||
      TraceFromEdge(context_, segment, w) || !TraceDetectorEnd(context_, segment)) {
    return;
  }
  segment.source = {{}, 0.0, 0.0, environment.emitter, true, {}};
  const double pdf = pick.probability / edge.Length() * sample.pdf;
  Connect(segment,
          EnvironmentRadianceInWorld(environment, w),
          weight * LightShare(sample.pdf) / pdf,
          sampler,
          splats);
}

void DirectBoundary::SampleWedgeDirection(const std::array<double, 3>& u,
                                          double weight,
                                          IndependentSampler& sampler,
                                          SplatBuffer& splats) const {
  const EdgeTree::Pick pick = context_.edges.SampleByWedge(u[0]);
  if (pick.edge < 0) {
    return;
  }
  const BoundaryEdge& edge = context_.edges.edges()[static_cast<std::size_t>(pick.edge)];
  const Vec3 w = SampleWedge(edge, u[1], u[2]);
  BoundarySegment segment;
  if (!StartSegment(context_, edge, pick.remainder, w, segment)) {
    return;
  }
  const LightSet& lights = context_.path.lights;
  const double pdf = pick.probability / (edge.Length() * 4.0 * WedgeAngle(edge));
  Rgb radiance;
  double light_pdf = 0.0;
  if (const auto hit = TraceFromEdge(context_, segment, w)) {
    const LightSet::AreaLight* light = lights.AreaLightOf(hit->id.mesh);
    if (light == nullptr) {
      return;
    }
    const double cos_light = -Dot(context_.path.world->caster().Geometry(hit->id).n, w);
    radiance =
        AreaRadiance(*light, hit->id.triangle, hit->b1, hit->b2, cos_light > 0.0 ? 1.0 : -1.0);
    light_pdf =
        lights.area_sampler->Pdf(hit->id) * hit->distance * hit->distance / std::abs(cos_light);
    segment.t2 = std::max(0.0, hit->distance);
    segment.source = {hit->id, hit->b1, hit->b2, -1, false, {}};
  } else if (lights.environment) {
    const auto& environment = *lights.environment;
    radiance = EnvironmentRadianceInWorld(environment, w);
    light_pdf =
        environment.light->texels.size() == 1
            ? 0.25 * std::numbers::inv_pi
            : environment.sampler->Pdf(EnvironmentUv(environment.light_from_world * w), true);
    segment.t2 = kInfinity;
    segment.source = {{}, 0.0, 0.0, environment.emitter, true, {}};
  }
  if (IsBlack(radiance) || !TraceDetectorEnd(context_, segment)) {
    return;
  }
  Connect(segment, radiance, weight * (1.0 - LightShare(light_pdf)) / pdf, sampler, splats);
}

void DirectBoundary::SamplePoint(const LightSet::PointLight& light,
                                 double u,
                                 double weight,
                                 IndependentSampler& sampler,
                                 SplatBuffer& splats) const {
  const EdgeTree::Pick pick = context_.edges.SampleFromPoint(light.position, true, u);
  if (pick.edge < 0) {
    return;
  }
  const BoundaryEdge& edge = context_.edges.edges()[static_cast<std::size_t>(pick.edge)];
  const Vec3 x_b = edge.a + (edge.b - edge.a) * pick.remainder;
  BoundarySegment segment;
  segment.t2 = Norm(light.position - x_b);
  const Vec3 w = (light.position - x_b) * (1.0 / segment.t2);
  const Rgb intensity = IntensityTowards(light, -w);
  if (!(segment.t2 > 0.0) || IsBlack(intensity) ||
      !StartSegment(context_, edge, pick.remainder, w, segment)) {
    return;
  }
  const auto hit = TraceFromEdge(context_, segment, w);
  if ((hit && hit->distance < segment.t2 * (1.0 - kReachTolerance)) ||
      !TraceDetectorEnd(context_, segment)) {
    return;
  }
  segment.source = {{}, 0.0, 0.0, light.emitter, false, light.position};
  const double pdf = pick.probability / edge.Length();
  Connect(segment, intensity, weight / (pdf * segment.t2 * segment.t2), sampler, splats);
}

void DirectBoundary::SampleDirectional(const LightSet::Directional& light,
                                       double u,
                                       double weight,
                                       IndependentSampler& sampler,
                                       SplatBuffer& splats) const {
  const EdgeTree::Pick pick = context_.edges.SampleAlongDirection(light.to_light, u);
  if (pick.edge < 0) {
    return;
  }
  const BoundaryEdge& edge = context_.edges.edges()[static_cast<std::size_t>(pick.edge)];
  BoundarySegment segment;
  segment.t2 = kInfinity;
  if (!StartSegment(context_, edge, pick.remainder, light.to_light, segment) ||
      TraceFromEdge(context_, segment, light.to_light) || !TraceDetectorEnd(context_, segment)) {
    return;
  }
  segment.source = {{}, 0.0, 0.0, light.emitter, true, {}};
  Connect(segment, light.irradiance, weight * edge.Length() / pick.probability, sampler, splats);
}

}  // namespace pathfit::renderer
