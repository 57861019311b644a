#pragma once

#include "renderer/derivative/active_parameters.h"
#include "renderer/derivative/derivative_accumulator.h"
#include "renderer/derivative/path_recorder.h"

namespace pathfit::renderer {

/// Pulls adjoints of what surfaces and lights look like (colours, roughness, textures, UVs, radiant
/// intensities) back to parameter blocks.
class AppearanceAdjoint {
 public:
  AppearanceAdjoint(const PathContext& context,
                    const ActiveParameters& active,
                    DerivativeAccumulator& sum)
      : context_(context), active_(active), sum_(sum) {}

  /// Material at a vertex from its d_base_color, d_roughness, ...
  void Material(const SurfacePoint& p, const VertexAdjoint& d);
  /// Radiance of an area light at a point, times weight.
  void AreaEmission(const MaterialPoint& y, double side, const Rgb& weight);
  /// Radiance of the environment in a world direction, times weight.
  void Environment(const LightSet::Environment& environment,
                   const Vec3& direction,
                   const Rgb& weight);
  /// Intensity of a point, spot or projector whose partials are given, times weight.
  void Intensity(const LightSet::PointLight& light,
                 const IntensityPartials& partials,
                 const Rgb& weight);
  /// Irradiance of a directional light, times weight.
  void Irradiance(const LightSet::Directional& light, const Rgb& weight);

  /// In-plane gradient of a vertex' radiance by moving over the material: colours, textures and the
  /// shading normal change with the barycentrics.
  [[nodiscard]] ColorGradient LabelGradient(const PathRecord::Vertex& v,
                                            const VertexAdjoint& d) const;

 private:
  void Texels(int texture, const TextureLookup& lookup, const Rgb& d_value, bool scalar_only);
  void Uv(TriangleId id, double b1, double b2, const Rgb& d_u, const Rgb& d_v);
  void TextureRole(const SurfacePoint& p, int texture, const Rgb& d_value);

  const PathContext& context_;
  const ActiveParameters& active_;
  DerivativeAccumulator& sum_;
};

}  // namespace pathfit::renderer
