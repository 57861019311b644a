#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/bsdf/bsdf_models.h"
#include "renderer/bsdf/microfacet_kernel.h"
#include "renderer/bsdf/visible_normal.h"
#include "renderer/math/warp.h"

namespace pathfit::renderer {
namespace {

constexpr double kDielectricF0 = 0.04;
constexpr double kInvPi = std::numbers::inv_pi;

/// Schlick's Fresnel term is F0 + (F90 - F0) (1 - cos)^5; that of the dielectric is scaled as a
/// whole.
double DielectricF0(const MetallicRoughnessBsdf& model) { return kDielectricF0 * model.specular; }

Rgb NormalReflectance(const MetallicRoughnessBsdf& model, const BsdfInputs& in) {
  return Rgb::Constant(DielectricF0(model) * (1.0 - in.metallic)) + in.base_color * in.metallic;
}

double GrazingReflectance(const MetallicRoughnessBsdf& model, const BsdfInputs& in) {
  return 1.0 - (1.0 - model.specular) * (1.0 - in.metallic);
}

/// Share of samples drawn from the specular lobe; both lobes keep some, so that derivatives have
/// support too.
double SpecularProbability(const MetallicRoughnessBsdf& model, const BsdfInputs& in, double cos_o) {
  const double c = 1.0 - cos_o;
  const double weight = c * c * c * c * c;
  const double base = Luminance(in.base_color);
  const double f0 = DielectricF0(model) * (1.0 - in.metallic) + base * in.metallic;
  const double specular = f0 + (GrazingReflectance(model, in) - f0) * weight;
  const double diffuse = (1.0 - specular) * (1.0 - in.metallic) * base;
  const double sum = specular + diffuse;
  return sum > 0.0 ? std::clamp(specular / sum, 0.1, 0.9) : 0.5;
}

/// Density of both lobes; `facing` is the mirrored facing for the mirrored sampler, else one.
double MixedPdf(double specular_probability, double alpha, const BsdfCosines& c, double facing) {
  const double sum = c.cos_i + c.cos_o;
  const double cos_h2 = sum * sum / (2.0 + 2.0 * ClampedDot(c));
  const double specular = 0.25 * VisibleNormalFactor<Ggx>(cos_h2, c.cos_o, alpha) * facing;
  return specular_probability * specular + (1.0 - specular_probability) * c.cos_i * kInvPi;
}

}  // namespace

Rgb EvalModel(const MetallicRoughnessBsdf& model, const BsdfInputs& in, const BsdfCosines& c) {
  if (c.cos_i <= 0.0) return {};
  const double dot = ClampedDot(c);
  const double specular = MicrofacetReflection(c.cos_i, c.cos_o, dot, Alpha(in));
  const double weight = SchlickWeight(dot);
  const double diffuse_share = (1.0 - in.metallic) * kInvPi;
  const Rgb f0 = NormalReflectance(model, in);
  const double f90 = GrazingReflectance(model, in);
  Rgb value;
  for (int i = 0; i < 3; ++i) {
    const double fresnel = f0[i] + (f90 - f0[i]) * weight;
    value[i] = (1.0 - fresnel) * diffuse_share * in.base_color[i] + fresnel * specular;
  }
  return value;
}

BsdfPartials EvalModelPartials(const MetallicRoughnessBsdf& model,
                               const BsdfInputs& in,
                               const BsdfCosines& c) {
  BsdfPartials p;
  if (c.cos_i <= 0.0) return p;
  const double dot = ClampedDot(c);
  const MicrofacetPartials specular =
      MicrofacetReflectionPartials(c.cos_i, c.cos_o, dot, Alpha(in));
  const double half = std::sqrt(0.5 + 0.5 * dot);
  const double grazing = 1.0 - half;
  const double grazing4 = grazing * grazing * grazing * grazing;
  const double weight = grazing4 * grazing;
  const double weight_by_dot = -1.25 * grazing4 / half;
  const double by_roughness = specular.d_alpha * AlphaByRoughness(in);
  const double diffuse_share = (1.0 - in.metallic) * kInvPi;
  const Rgb f0 = NormalReflectance(model, in);
  const double f90 = GrazingReflectance(model, in);
  for (int i = 0; i < 3; ++i) {
    const double base = in.base_color[i];
    const double fresnel = f0[i] + (f90 - f0[i]) * weight;
    const double by_fresnel = specular.value - base * diffuse_share;
    p.value[i] = base * diffuse_share + fresnel * by_fresnel;
    p.d_cos_i[i] = fresnel * specular.d_cos_i;
    p.d_cos_o[i] = fresnel * specular.d_cos_o;
    p.d_dot_io[i] = fresnel * specular.d_dot_io + (f90 - f0[i]) * weight_by_dot * by_fresnel;
    p.d_roughness[i] = fresnel * by_roughness;
    const double by_f0 = (1.0 - weight) * by_fresnel;
    p.d_base_color[i] = by_f0 * in.metallic + (1.0 - fresnel) * diffuse_share;
    const double by_f90 = weight * by_fresnel;
    p.d_metallic[i] = by_f0 * (base - DielectricF0(model)) + by_f90 * (1.0 - model.specular) -
                      (1.0 - fresnel) * base * kInvPi;
    p.d_specular[i] = (by_f0 * kDielectricF0 + by_f90) * (1.0 - in.metallic);
  }
  return p;
}

double ModelPdf(const MetallicRoughnessBsdf& model,
                const BsdfInputs& in,
                const BsdfCosines& c,
                bool mirrored) {
  if (c.cos_i <= 0.0) return 0.0;
  const double facing = mirrored ? MirroredFacing(c.cos_i, c.cos_o, ClampedDot(c)) : 1.0;
  return MixedPdf(SpecularProbability(model, in, c.cos_o), Alpha(in), c, facing);
}

std::optional<LocalSample> SampleModel(const MetallicRoughnessBsdf& model,
                                       const BsdfInputs& in,
                                       const Vec3& wo,
                                       const UnitSample& u) {
  const double alpha = Alpha(in);
  const double specular_probability = SpecularProbability(model, in, wo.z);
  const bool specular = u.u2 < specular_probability;
  Vec3 drawn = specular ? SampleVisibleNormal(Ggx{}, wo, alpha, u.u0, u.u1)
                        : SampleCosineHemisphere(u.u0, u.u1);
  if (u.mirrored) drawn = MirroredNormal(drawn);
  const Vec3 wi = specular ? drawn * (2.0 * Dot(wo, drawn)) - wo : drawn;
  if (wi.z <= 0.0) return std::nullopt;
  return LocalSample{wi, MixedPdf(specular_probability, alpha, {wi.z, wo.z, Dot(wi, wo)}, 1.0)};
}

}  // namespace pathfit::renderer
