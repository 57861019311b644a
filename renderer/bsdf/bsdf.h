#pragma once

#include <numbers>
#include <optional>
#include <variant>

#include "renderer/math/frame.h"
#include "renderer/math/rgb.h"
#include "renderer/math/vector.h"
#include "renderer/math/warp.h"

namespace pathfit::renderer {

// Models of how a surface scatters light. Each is a value with its own constants; what may vary
// over the surface comes with BsdfInputs. Roughness is perceptual, alpha = roughness^2; an
// index of refraction is relative to the outside, which is the side the mesh's normals point to.

/// Ideal diffuse reflection: base_color / pi.
struct LambertBsdf {
  friend bool operator==(const LambertBsdf&, const LambertBsdf&) = default;
};

/// glTF 2.0 metallic-roughness: GGX (alpha = roughness^2), height-correlated Smith, Schlick Fresnel
/// with F0 = lerp(0.04 specular, base_color, metallic), F90 = lerp(specular, 1, metallic). Source:
/// glTF 2.0 specification, appendix B, and KHR_materials_specular.
struct MetallicRoughnessBsdf {
  double roughness = 0.5;  ///< perceptual, in [kMinRoughness, 1]
  double metallic = 0.0;   ///< 0..1
  double specular = 1.0;   ///< factor of the dielectric's reflection, 0..1: 4 % of it at 1
  friend bool operator==(const MetallicRoughnessBsdf&, const MetallicRoughnessBsdf&) = default;
};

/// How the normals of microfacets are spread. alpha is the width of GGX, and of Beckmann sqrt(2)
/// times the standard deviation of slopes along one axis.
enum class MicrofacetDistribution { kGgx, kBeckmann };

/// Rough metal with the exact Fresnel reflectance of eta + i k, times base_color.
struct RoughConductorBsdf {
  double roughness = 0.5;   ///< perceptual, in [kMinRoughness, 1]
  Rgb eta{0.2, 0.92, 1.1};  ///< index of refraction per channel, >= 0; here copper
  Rgb k{3.9, 2.45, 2.14};   ///< extinction coefficient per channel, >= 0
  MicrofacetDistribution distribution = MicrofacetDistribution::kGgx;
  friend bool operator==(const RoughConductorBsdf&, const RoughConductorBsdf&) = default;
};

/// Rough interface between the outside and a medium of index `eta` on the side the normal points
/// away from: reflects and refracts (radiance scales by the squared index ratio), times base_color.
/// Source: [Walter2007].
struct RoughDielectricBsdf {
  double roughness = 0.5;  ///< perceptual, in [kMinRoughness, 1]
  double eta = 1.5;        ///< inside over outside, > 0, not 1
  MicrofacetDistribution distribution = MicrofacetDistribution::kGgx;
  friend bool operator==(const RoughDielectricBsdf&, const RoughDielectricBsdf&) = default;
};

/// Perfect mirror: base_color times the Fresnel reflectance of eta + i k; k = 0 and eta = 0 means
/// reflectance 1.
struct MirrorBsdf {
  Rgb eta{0.0, 0.0, 0.0};
  Rgb k{0.0, 0.0, 0.0};
  friend bool operator==(const MirrorBsdf&, const MirrorBsdf&) = default;
};

/// Smooth interface: reflects and refracts, times base_color.
struct SmoothDielectricBsdf {
  double eta = 1.5;  ///< inside over outside, > 0, not 1
  friend bool operator==(const SmoothDielectricBsdf&, const SmoothDielectricBsdf&) = default;
};

using Bsdf = std::variant<LambertBsdf,
                          MetallicRoughnessBsdf,
                          RoughConductorBsdf,
                          RoughDielectricBsdf,
                          MirrorBsdf,
                          SmoothDielectricBsdf>;

/// Below this the lobe is nearly a delta, whose material-form derivative does not exist.
inline constexpr double kMinRoughness = 0.03;

/// Whether the model scatters into single directions only (mirror, smooth glass): then EvalBsdf and
/// the densities are zero, and SampleBsdf and EvalDelta tell all.
inline bool HasRoughness(const Bsdf& bsdf) {
  return std::visit(
      [](const auto& model) {
        return requires { model.roughness; };
      },
      bsdf);
}
inline bool IsDelta(const Bsdf& bsdf) {
  return std::holds_alternative<MirrorBsdf>(bsdf) ||
         std::holds_alternative<SmoothDielectricBsdf>(bsdf);
}
/// Whether the model lets light through to the other side of the surface (both dielectrics).
inline bool IsTransmissive(const Bsdf& bsdf) {
  return std::holds_alternative<RoughDielectricBsdf>(bsdf) ||
         std::holds_alternative<SmoothDielectricBsdf>(bsdf);
}

/// What may vary over the surface (constants, vertex colours or textures), at one point.
struct BsdfInputs {
  Rgb base_color{1.0, 1.0, 1.0};  ///< linear, 0..1
  double roughness = 0.5;         ///< of all rough models; replaces the constant of the model
  double metallic = 0.0;          ///< of MetallicRoughnessBsdf; replaces the constant of the model
  bool from_inside = false;       ///< wo is on the side the normal of the winding points away from
};

/// Isotropic BSDFs depend on directions through three cosines only. `wi` points to the light, `wo`
/// to the camera, both unit and away from the surface; the normal is turned to the side of wo.
/// A cos_o below kMinCosO (interpolated normals near a silhouette) counts as kMinCosO: rough models
/// see wo raised to it in its plane with n, and all partials are exact for that; Lambert ignores
/// cos_o.
struct BsdfCosines {
  double cos_i = 0.0;   ///< n . wi, negative for transmission
  double cos_o = 0.0;   ///< n . wo
  double dot_io = 0.0;  ///< wi . wo
};
inline constexpr double kMinCosO = 1e-2;

/// Partial derivatives by what a material is made of. base_color, eta and k act channel by channel,
/// so their partials are diagonals; one number, such as the eta of a dielectric, has a partial per
/// channel. Zero for what the model does not have.
struct MaterialPartials {
  Rgb d_base_color, d_roughness, d_metallic, d_specular, d_eta, d_k;

  /// Adds `weight`, channel by channel, times the partials `p`.
  void AddScaled(const Rgb& weight, const MaterialPartials& p) {
    d_base_color += weight * p.d_base_color;
    d_roughness += weight * p.d_roughness;
    d_metallic += weight * p.d_metallic;
    d_specular += weight * p.d_specular;
    d_eta += weight * p.d_eta;
    d_k += weight * p.d_k;
  }
};

/// Value of EvalBsdf and its partial derivatives; those by the cosines take all three as
/// independent.
struct BsdfPartials : MaterialPartials {
  Rgb value;
  Rgb d_cos_i, d_cos_o, d_dot_io;
};

struct BsdfSample {
  Vec3 wi;             ///< unit, world
  double pdf = 0.0;    ///< per solid angle; of a delta lobe: its probability
  bool delta = false;  ///< wi is the mirrored or refracted wo; weigh with EvalDelta / pdf
};

namespace bsdf_internal {
// All models but Lambert's, whose few operations are done in line.
Rgb Eval(const Bsdf& bsdf, const BsdfInputs& inputs, const BsdfCosines& cosines);
std::optional<BsdfSample> Sample(const Bsdf& bsdf,
                                 const BsdfInputs& inputs,
                                 const Vec3& n,
                                 const Vec3& wo,
                                 double u0,
                                 double u1,
                                 double u2,
                                 bool mirrored);
double Pdf(const Bsdf& bsdf, const BsdfInputs& inputs, const BsdfCosines& cosines, bool mirrored);
}  // namespace bsdf_internal

/// BSDF value (1/sr, without the cosine), radiance leaving along wo per irradiance along wi. Zero
/// for delta models, and on the other side unless transmissive.
inline Rgb EvalBsdf(const Bsdf& bsdf, const BsdfInputs& inputs, const BsdfCosines& cosines) {
  if (std::holds_alternative<LambertBsdf>(bsdf)) {
    return cosines.cos_i > 0.0 ? inputs.base_color * std::numbers::inv_pi : Rgb{};
  }
  return bsdf_internal::Eval(bsdf, inputs, cosines);
}
/// The same value with its partials; all zero where it is zero by the sides of wi and wo.
BsdfPartials EvalBsdfPartials(const Bsdf& bsdf,
                              const BsdfInputs& inputs,
                              const BsdfCosines& cosines);

/// Draws wi given wo from three uniform numbers. Empty when the draw is absorbed (below the
/// surface of an opaque model). `n` is the shading normal on the side of wo.
/// With `mirrored`, the microfacet normal (or the cosine-distributed direction) is reflected about
/// n first and the choice of the lobe kept: the antithetic partner of the same numbers (path_space
/// 1.10). `pdf` is then the density of the returned direction under SampleBsdf without `mirrored`;
/// an estimator from pairs divides by MirroredPairPdf instead.
inline std::optional<BsdfSample> SampleBsdf(const Bsdf& bsdf,
                                            const BsdfInputs& inputs,
                                            const Vec3& n,
                                            const Vec3& wo,
                                            double u0,
                                            double u1,
                                            double u2,
                                            bool mirrored = false) {
  if (std::holds_alternative<LambertBsdf>(bsdf)) {
    const Vec3 local = SampleCosineHemisphere(u0, u1);
    if (local.z <= 0.0) return std::nullopt;
    const Vec3 wi =
        Frame::FromNormal(n).ToWorld(mirrored ? Vec3{-local.x, -local.y, local.z} : local);
    return BsdfSample{wi, local.z * std::numbers::inv_pi};
  }
  return bsdf_internal::Sample(bsdf, inputs, n, wo, u0, u1, u2, mirrored);
}
/// Solid-angle density of SampleBsdf (not mirrored); zero for delta models.
inline double BsdfPdf(const Bsdf& bsdf, const BsdfInputs& inputs, const BsdfCosines& cosines) {
  return std::holds_alternative<LambertBsdf>(bsdf)
             ? CosineHemispherePdf(cosines.cos_i)
             : bsdf_internal::Pdf(bsdf, inputs, cosines, false);
}
/// Mean of the densities of SampleBsdf with and without `mirrored`: what one direction of an
/// antithetic pair is divided by. With wi_0, wi_1 drawn from the same numbers without and with
/// `mirrored`, half the sum of g(wi_k) / MirroredPairPdf(wi_k), absorbed draws counting zero, has
/// the expectation of the integral of g over solid angle, and what is odd in the microfacet normal
/// about n cancels (in its measure both divide by the same number). In MIS it takes the place of
/// BsdfPdf in every weight. Zero for delta models.
inline double MirroredPairPdf(const Bsdf& bsdf,
                              const BsdfInputs& inputs,
                              const BsdfCosines& cosines) {
  return std::holds_alternative<LambertBsdf>(bsdf)
             ? CosineHemispherePdf(cosines.cos_i)
             : 0.5 * (bsdf_internal::Pdf(bsdf, inputs, cosines, false) +
                      bsdf_internal::Pdf(bsdf, inputs, cosines, true));
}

/// What travels along a path against the light: radiance, which refraction scales by the squared
/// index ratio, or with it importance (sensor responsivity, or photons), which it does not.
enum class TransportMode { kRadiance, kImportance };

/// Weight of a delta lobe: what leaves along wo per what arrives along the mirrored (`transmit`
/// false) or refracted direction, radiance or importance. Zero for rough models, for cos_o <= 0,
/// and for transmission through a mirror or in total reflection. `cos_o` is n . wo; in d_cos_o the
/// other angle follows from it.
struct DeltaPartials : MaterialPartials {
  Rgb value;
  Rgb d_cos_o;
};
DeltaPartials EvalDelta(const Bsdf& bsdf,
                        const BsdfInputs& inputs,
                        double cos_o,
                        bool transmit,
                        TransportMode mode = TransportMode::kRadiance);

/// Index of refraction on the side of wo over that beyond the surface: outside over inside, or the
/// inverse when wo is inside. 1 for models that are not transmissive.
double RelativeEta(const Bsdf& bsdf, const BsdfInputs& inputs);

}  // namespace pathfit::renderer
