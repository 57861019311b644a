#pragma once

#include <optional>
#include <variant>

#include "renderer/math/rgb.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Ideal diffuse reflection: base_color / pi.
struct LambertBsdf {
  friend bool operator==(const LambertBsdf&, const LambertBsdf&) = default;
};

/// glTF 2.0 metallic-roughness: GGX (alpha = roughness^2), height-correlated Smith, Schlick Fresnel
/// with F0 = lerp(0.04, base_color, metallic). Source: glTF 2.0 specification, appendix B.
struct MetallicRoughnessBsdf {
  double roughness = 0.5;  ///< perceptual, in [kMinRoughness, 1]
  double metallic = 0.0;   ///< 0..1
  friend bool operator==(const MetallicRoughnessBsdf&, const MetallicRoughnessBsdf&) = default;
};

using Bsdf = std::variant<LambertBsdf, MetallicRoughnessBsdf>;

/// Below this the lobe is nearly a delta, whose material-form derivative does not exist.
inline constexpr double kMinRoughness = 0.1;

/// Isotropic BSDFs depend on directions through three cosines only. `wi` points to the light, `wo`
/// to the camera, both unit and away from the surface; the normal is turned to the side of wo.
struct BsdfCosines {
  double cos_i = 0.0;   ///< n . wi
  double cos_o = 0.0;   ///< n . wo
  double dot_io = 0.0;  ///< wi . wo
};

/// Value and partial derivatives. base_color acts channel by channel, so its partial is a diagonal.
struct BsdfPartials {
  Rgb value;
  Rgb d_cos_i, d_cos_o, d_dot_io;
  Rgb d_base_color, d_roughness, d_metallic;
};

struct BsdfSample {
  Vec3 wi;           ///< unit, world
  double pdf = 0.0;  ///< per solid angle
};

/// BSDF value (1/sr, without the cosine); zero unless cos_i and cos_o are positive.
Rgb EvalBsdf(const Bsdf& bsdf, const Rgb& base_color, const BsdfCosines& cosines);
BsdfPartials EvalBsdfPartials(const Bsdf& bsdf, const Rgb& base_color, const BsdfCosines& cosines);

/// Draws wi given wo from three uniform numbers. Empty when the draw falls below the surface.
std::optional<BsdfSample> SampleBsdf(const Bsdf& bsdf,
                                     const Rgb& base_color,
                                     const Vec3& n,
                                     const Vec3& wo,
                                     double u0,
                                     double u1,
                                     double u2);
/// Solid-angle density of SampleBsdf.
double BsdfPdf(const Bsdf& bsdf, const Rgb& base_color, const BsdfCosines& cosines);

}  // namespace pathfit::renderer
