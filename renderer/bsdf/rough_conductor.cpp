#include <cmath>

#include "renderer/bsdf/bsdf_models.h"
#include "renderer/bsdf/microfacet_kernel.h"
#include "renderer/bsdf/visible_normal.h"

namespace pathfit::renderer {

Rgb EvalModel(const RoughConductorBsdf& model, const BsdfInputs& in, const BsdfCosines& c) {
  if (c.cos_i <= 0.0) return {};
  const double dot = ClampedDot(c);
  const double specular = WithDistribution(model.distribution, [&]<class D>(D) {
    return MicrofacetReflection<D>(c.cos_i, c.cos_o, dot, Alpha(in));
  });
  const double half = std::sqrt(0.5 + 0.5 * dot);
  Rgb value;
  for (int i = 0; i < 3; ++i) {
    value[i] = in.base_color[i] * specular * FresnelConductor(half, model.eta[i], model.k[i]);
  }
  return value;
}

BsdfPartials EvalModelPartials(const RoughConductorBsdf& model,
                               const BsdfInputs& in,
                               const BsdfCosines& c) {
  using D3 = Dual<3>;
  BsdfPartials p;
  if (c.cos_i <= 0.0) return p;
  const double dot = ClampedDot(c);
  const MicrofacetPartials specular = WithDistribution(model.distribution, [&]<class D>(D) {
    return MicrofacetReflectionPartials<D>(c.cos_i, c.cos_o, dot, Alpha(in));
  });
  const double half = std::sqrt(0.5 + 0.5 * dot);
  const double half_by_dot = 0.25 / half;
  const double by_roughness = specular.d_alpha * AlphaByRoughness(in);
  for (int i = 0; i < 3; ++i) {
    const D3 fresnel = FresnelConductor(
        D3::Variable(half, 0), D3::Variable(model.eta[i], 1), D3::Variable(model.k[i], 2));
    const double base = in.base_color[i];
    const double tint = base * fresnel.v;
    p.value[i] = tint * specular.value;
    p.d_cos_i[i] = tint * specular.d_cos_i;
    p.d_cos_o[i] = tint * specular.d_cos_o;
    p.d_dot_io[i] = tint * specular.d_dot_io + base * fresnel.d[0] * half_by_dot * specular.value;
    p.d_roughness[i] = tint * by_roughness;
    p.d_base_color[i] = fresnel.v * specular.value;
    p.d_eta[i] = base * fresnel.d[1] * specular.value;
    p.d_k[i] = base * fresnel.d[2] * specular.value;
  }
  return p;
}

double ModelPdf(const RoughConductorBsdf& model,
                const BsdfInputs& in,
                const BsdfCosines& c,
                bool mirrored) {
  if (c.cos_i <= 0.0) return 0.0;
  const double dot = ClampedDot(c);
  const double sum = c.cos_i + c.cos_o;
  const double facing = mirrored ? MirroredFacing(c.cos_i, c.cos_o, dot) : 1.0;
  const double cos_h2 = sum * sum / (2.0 + 2.0 * dot);
  return 0.25 * facing * WithDistribution(model.distribution, [&]<class D>(D) {
           return VisibleNormalFactor<D>(cos_h2, c.cos_o, Alpha(in));
         });
}

std::optional<LocalSample> SampleModel(const RoughConductorBsdf& model,
                                       const BsdfInputs& in,
                                       const Vec3& wo,
                                       const UnitSample& u) {
  Vec3 h = WithDistribution(model.distribution, [&](auto distribution) {
    return SampleVisibleNormal(distribution, wo, Alpha(in), u.u0, u.u1);
  });
  if (u.mirrored) h = MirroredNormal(h);
  const Vec3 wi = h * (2.0 * Dot(wo, h)) - wo;
  if (wi.z <= 0.0) return std::nullopt;
  return LocalSample{wi, ModelPdf(model, in, {wi.z, wo.z, Dot(wi, wo)}, false)};
}

}  // namespace pathfit::renderer
