#include "renderer/boundary/indirect_boundary.h"

#include <algorithm>

#include "renderer/geometry/tangent_wedge.h"

namespace pathfit::renderer {
namespace {

/// Sorts a path's radiance by the number of reflections.
class RadianceByBounce : public NullListener {
 public:
  explicit RadianceByBounce(CumulativeRadiance& radiance) : radiance_(radiance) {}
  void OnRadiance(int bounces, const Rgb& radiance) {
    radiance_[static_cast<std::size_t>(bounces)] += radiance;
  }

 private:
  CumulativeRadiance& radiance_;
};

}  // namespace

std::vector<BoundaryWay> IndirectBoundary::Ways() const {
  if (context_.path.max_bounces < 2 || context_.edges.WedgeTotal() == 0.0) {
    return {};
  }
  return {{}};
}

std::int64_t IndirectBoundary::NumSamples() const {
  return SamplesPerPixel(context_, context_.options.spp_indirect);
}

void IndirectBoundary::Sample(std::size_t /*way*/,
                              const BoundaryDraw& draw,
                              SplatBuffer& splats) const {
  const EdgeTree::Pick pick = context_.edges.SampleByWedge(draw.u[0]);
  if (pick.edge < 0) {
    return;
  }
  const BoundaryEdge& edge = context_.edges.edges()[static_cast<std::size_t>(pick.edge)];
  BoundarySegment segment;
  if (!StartSegment(
          context_, edge, pick.remainder, SampleWedge(edge, draw.u[1], draw.u[2]), segment)) {
    return;
  }
  const auto hit = TraceSourceEnd(context_, segment);
  if (!hit) {
    return;
  }
  segment.t2 = std::max(0.0, hit->distance);
  segment.source = MaterialPoint{hit->id, hit->b1, hit->b2};
  if (!TraceDetectorEnd(context_, segment)) {
    return;
  }
  const PathContext& path = context_.path;
  Vec3 x = path.world->caster().Geometry(hit->id).Point(hit->b1, hit->b2);
  if (TouchesEdge(
          context_, segment, segment.t2)) {  // shade what is seen of it, not what lies in the dark
    x -= StepIntoShadow(context_, segment, hit->id, x);
  }
  const SurfacePoint source =
      MakeSurfacePoint(*path.world, hit->id, hit->b1, hit->b2, x, -segment.w);
  if (IsDelta(source.material->bsdf)) {
    return;  // a reflection in a mirror moves over it: no material point
  }
  IndependentSampler sampler = draw.Independent();
  CumulativeRadiance radiance(static_cast<std::size_t>(path.max_bounces));
  RadianceByBounce listener(radiance);
  TraceRadiance(path, source, sampler, listener, {path.max_bounces - 1, false, false});
  for (std::size_t i = 1; i < radiance.size(); ++i) {
    radiance[i] += radiance[i - 1];
  }
  if (IsBlack(radiance.back())) {
    return;
  }
  const double pdf = pick.probability / (edge.Length() * 4.0 * context_.edges.Wedge(pick.edge));
  ConnectDetectors(context_, segment, radiance, draw.weight / pdf, sampler, splats);
}

}  // namespace pathfit::renderer
