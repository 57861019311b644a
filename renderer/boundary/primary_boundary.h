#pragma once

#include <optional>

#include "renderer/boundary/view_edges.h"
#include "renderer/path/path_tracer.h"
#include "renderer/render_options.h"
#include "renderer/render_stats.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::renderer {

/// One sample of the primary boundary: pixel `x, y` gains `jump` per unit by which `direction .
/// x_B'` moves the edge point x_B = (1 - t) a + t b.
struct PrimaryBoundarySample {
  int x = 0, y = 0;
  std::int32_t mesh = 0;
  std::int32_t vertex_a = 0, vertex_b = 0;
  double t = 0.0;
  Vec3 direction;  ///< pixel^2 per metre, sampling density included
  Rgba jump;  ///< radiance and coverage on the side the edge moves away from, minus the side it
              ///< moves to
};

/// Estimator of the primary boundary integral in image form: mesh edges seen by the sensor sweep
/// over pixels.
///
/// With the edge's image u(t) and any velocity x_B', dI = integral over t of (L_minus - L_plus) (m
/// . u') dt, where m = perp(du/dt) points to the plus side and u' = (du/dx) x_B'. Right for any
/// smooth projection, distortion included. Source: path_space 1.9, eq. (B1); [Zhang2020, primary
/// boundary].
class PrimaryBoundary {
 public:
  PrimaryBoundary(const PathContext& context,
                  const std::vector<MeshTopology>& topologies,
                  const CameraModel& camera,
                  const ViewEdges& edges)
      : context_(context), topologies_(topologies), camera_(camera), edges_(edges) {}

  /// Number of samples for a budget of `sppe` per pixel of weighted edge length.
  [[nodiscard]] std::int64_t NumSamples(double sppe) const;

  /// Sample `index` of `count`, systematic along the edges. Empty if it contributes nothing.
  [[nodiscard]] std::optional<PrimaryBoundarySample> Sample(const RenderOptions& options,
                                                            std::int64_t index,
                                                            std::int64_t count,
                                                            RenderStats& stats) const;

 private:
  struct EdgePoint;
  struct Sides;
  /// Sensor ray `step` pixels beside the edge, towards its plus side.
  [[nodiscard]] Ray RayBeside(const EdgePoint& point, double step) const;
  [[nodiscard]] Sides FacesBySide(const EdgePoint& point) const;
  /// Radiance and coverage of a face at the edge point.
  [[nodiscard]] Rgba ShadeFace(const EdgePoint& point, TriangleId face, CounterRng rng) const;
  /// What lies behind the edge; `side` is +1 where the plus side sees it, -1 for the minus side.
  [[nodiscard]] Rgba ShadeBackground(const EdgePoint& point,
                                     const std::optional<Hit>& hit,
                                     double side,
                                     CounterRng rng) const;

  const PathContext& context_;
  const std::vector<MeshTopology>& topologies_;
  const CameraModel& camera_;
  const ViewEdges& edges_;
};

}  // namespace pathfit::renderer
