#pragma once

#include <array>
#include <vector>

#include "renderer/derivative/active_parameters.h"
#include "renderer/derivative/derivative_accumulator.h"
#include "renderer/path/path_tracer.h"

namespace pathfit::renderer {

/// Gradient of a colour by a point or vector: one Vec3 per channel.
using ColorGradient = std::array<Vec3, 3>;

/// One path as the tracer built it: what the reverse sweep needs to differentiate it.
class PathRecorder {
 public:
  struct Vertex {
    SurfacePoint p;
    std::size_t first_direct = 0, end_direct = 0;  ///< range in directs
    bool continues = false;
    Vec3 wi;              ///< towards the next vertex
    double factor = 0.0;  ///< of the radiance beyond, see NullPathRecorder::OnContinue

    // Filled by the sweep.
    Rgb throughput;
    ColorGradient d_x{}, d_n{};  ///< by position and by the normal on the side of wo
    Rgb d_log_area;              ///< by log of the area ratio J
    Rgb d_base_color, d_roughness, d_metallic;
  };

  void Clear() {
    vertices.clear();
    directs.clear();
  }
  void OnVertex(const SurfacePoint& p) {
    vertices.emplace_back();
    vertices.back().p = p;
    vertices.back().first_direct = vertices.back().end_direct = directs.size();
  }
  void OnDirect(const DirectContribution& direct) {
    directs.push_back(direct);
    vertices.back().end_direct = directs.size();
  }
  void OnContinue(const Vec3& wi, const Rgb& /*bsdf*/, double factor) {
    Vertex& v = vertices.back();
    v.continues = true;
    v.wi = wi;
    v.factor = factor;
  }

  std::vector<Vertex> vertices;
  std::vector<DirectContribution> directs;
};

/// Adds the derivative of the path's radiance by every active parameter to `sum`, by one reverse
/// sweep.
///
/// The camera vertex is in image form: its pixel is fixed, so it slides along the camera ray when
/// its triangle moves, x' = w (n.v) / (n.w), and its barycentrics change by their in-plane
/// gradient. All later vertices are in material form: barycentrics fixed, the factor G J of each
/// segment attached, sampling densities and MIS weights detached. Visibility is constant here; its
/// change is the boundary estimators' part. Source: path_space 1.4, 1.5 (table, row "image"), 1.12;
/// [Zhang2020].
void AccumulatePathAdjoint(const PathContext& context,
                           const ActiveParameters& active,
                           PathRecorder& path,
                           DerivativeAccumulator& sum);

/// Adds the derivative of an environment's radiance in a direction (world frame), times `weight`,
/// by its texels and its intensity.
void AccumulateEnvironmentAdjoint(const LightSet::Environment& environment,
                                  const Vec3& direction,
                                  const Rgb& weight,
                                  const ActiveParameters& active,
                                  DerivativeAccumulator& sum);

}  // namespace pathfit::renderer
