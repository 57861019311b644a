#pragma once

#include "renderer/boundary/boundary_technique.h"

namespace pathfit::renderer {

/// A segment x_D x_S that grazes an edge at x_B: path_space 1.6, 1.7.
struct BoundarySegment {
  const BoundaryEdge* edge = nullptr;
  double t = 0.0;  ///< x_B = (1 - t) a + t b
  Vec3 x_b;
  Vec3 w;                ///< unit, from D to S
  Vec3 n_b;              ///< unit, normal to edge and segment, points into the occluder
  double sin_phi = 0.0;  ///< between edge and segment
  double share = 1.0;    ///< of the contribution: the line may be an edge of another surface, too
  FacesAtEdge faces;     ///< of the edge, and what touches it at x_B
  std::optional<Hit> beside;  ///< what touches the edge and goes on beside it, where it is free
  Hit d;                      ///< detector end; distance is t1 = |x_B - x_D|
  Vec3 x_d;
  double t2 = 0.0;  ///< |x_S - x_B|; infinity for lights at infinity
  LightEnd source;  ///< x_S, or what shines from the direction w
};

/// Fills edge point, frame and contacts of a segment for direction w; false if the edge is no
/// silhouette for it, or something that touches it hides it from the detector side.
bool StartSegment(const BoundaryContext& context,
                  const BoundaryEdge& edge,
                  double t,
                  const Vec3& w,
                  BoundarySegment& segment);

/// What the line meets beyond x_B, the edge's own faces left out.
std::optional<Hit> TraceSourceEnd(const BoundaryContext& context, const BoundarySegment& segment);

/// Finds the detector end by tracing against w; false if there is none. Set source and t2 first.
/// Where a surface touches the edge, it can be the source and not the detector: a point that gets
/// covered is covered from both its neighbours on a path at once, and counts once.
bool TraceDetectorEnd(const BoundaryContext& context, BoundarySegment& segment);

/// Small step along the surface of a segment's end `x`, to the side that the edge hides from the
/// other end.
Vec3 StepIntoShadow(const BoundaryContext& context,
                    const BoundarySegment& segment,
                    TriangleId id,
                    const Vec3& x);

/// Whether a surface at this distance from x_B touches the edge.
bool TouchesEdge(const BoundaryContext& context, const BoundarySegment& segment, double distance);

/// Number of samples of a budget per pixel of the image.
std::int64_t SamplesPerPixel(const BoundaryContext& context, double spp);

/// Radiance that leaves x_S along the segment, by the number of surfaces that reflected it:
/// cumulative[i] holds all with at most i reflections at and behind x_S.
using CumulativeRadiance = std::vector<Rgb>;

/// Grows the detector subpath from x_D, connects all its vertices to the sensor and adds to
/// `splats`: importance * radiance * weight * sin(phi), times the gradient of the segment's normal
/// velocity n_B . (v_B - (1 - lambda) v_D - lambda v_S).  [path_space B, V]
/// A path is reflected at most max_bounces times in all: detector vertex k (0 = x_D) takes
/// cumulative[min(max_bounces - 1 - k, size - 1)].
void ConnectDetectors(const BoundaryContext& context,
                      const BoundarySegment& segment,
                      const CumulativeRadiance& cumulative,
                      double weight,
                      IndependentSampler& sampler,
                      SplatBuffer& splats);

}  // namespace pathfit::renderer
