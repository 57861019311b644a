#include <cmath>

#include "renderer/bsdf/bsdf_models.h"
#include "renderer/bsdf/microfacet_kernel.h"
#include "renderer/bsdf/visible_normal.h"

namespace pathfit::renderer {
namespace {

/// Density of choosing to reflect, seen from the cosine at the microfacet the choice is made at.
double ChoiceOfReflection(double facing, double e) {
  return ReflectionProbability(FresnelDielectric(std::max(facing, 0.0), e));
}

template <class Distribution>
double ReflectionPdf(double e, double alpha, const BsdfCosines& c, bool mirrored) {
  const double dot = ClampedDot(c);
  const double sum = c.cos_i + c.cos_o;
  const double ratio = mirrored ? MirroredFacing(c.cos_i, c.cos_o, dot) : 1.0;
  const double facing = ratio * std::sqrt(0.5 + 0.5 * dot);
  return ChoiceOfReflection(facing, e) * 0.25 * ratio *
         VisibleNormalFactor<Distribution>(sum * sum / (2.0 + 2.0 * dot), c.cos_o, alpha);
}

template <class Distribution>
double TransmissionPdf(double e, double alpha, const BsdfCosines& c, bool mirrored) {
  const double sum = c.cos_o + e * c.cos_i;
  const double side = sum > 0.0 ? 1.0 : -1.0;
  const double length2 = (1.0 - e) * (1.0 - e) + 2.0 * e * (1.0 + c.dot_io);
  const double facing_o = side * (1.0 + e * c.dot_io);  // times |wo + e wi|, as facing_i
  const double facing_i = -side * (e + c.dot_io);
  if (facing_o <= 0.0 || facing_i <= 0.0) return 0.0;
  const double length = std::sqrt(length2);
  const double drawn_at =
      (mirrored ? std::max(0.0, 2.0 * side * sum * c.cos_o - facing_o) : facing_o) / length;
  // Solid angle of h per solid angle of wi: e^2 |wi.h| / |wo + e wi|^2.  [Walter2007, eq. 17]
  return (1.0 - ChoiceOfReflection(drawn_at, e)) *
         VisibleNormalFactor<Distribution>(sum * sum / length2, c.cos_o, alpha) * drawn_at * e * e *
         facing_i / (length * length2);
}

template <class Distribution>
BsdfPartials ReflectionPartials(double eta, const BsdfInputs& in, const BsdfCosines& c) {
  using D2 = Dual<2>;
  const double dot = ClampedDot(c);
  const MicrofacetPartials specular =
      MicrofacetReflectionPartials<Distribution>(c.cos_i, c.cos_o, dot, Alpha(in));
  const double half = std::sqrt(0.5 + 0.5 * dot);
  const D2 fresnel =
      FresnelDielectric(D2::Variable(half, 0), D2::Variable(BeyondOverHere(eta, in), 1));
  const Rgb& base = in.base_color;
  const double value = fresnel.v * specular.value;
  BsdfPartials p;
  p.value = base * value;
  p.d_base_color = Rgb::Constant(value);
  p.d_cos_i = base * (fresnel.v * specular.d_cos_i);
  p.d_cos_o = base * (fresnel.v * specular.d_cos_o);
  p.d_dot_io =
      base * (fresnel.v * specular.d_dot_io + fresnel.d[0] * (0.25 / half) * specular.value);
  p.d_roughness = base * (fresnel.v * specular.d_alpha * AlphaByRoughness(in));
  p.d_eta = base * (fresnel.d[1] * BeyondOverHereByEta(eta, in) * specular.value);
  return p;
}

template <class Distribution>
BsdfPartials TransmissionPartials(double eta, const BsdfInputs& in, const BsdfCosines& c) {
  using D5 = Dual<5>;
  const D5 f = MicrofacetTransmission<Distribution>(D5::Variable(c.cos_i, 0),
                                                    D5::Variable(c.cos_o, 1),
                                                    D5::Variable(c.dot_io, 2),
                                                    D5::Variable(Alpha(in), 3),
                                                    D5::Variable(BeyondOverHere(eta, in), 4));
  const Rgb& base = in.base_color;
  BsdfPartials p;
  p.value = base * f.v;
  p.d_base_color = Rgb::Constant(f.v);
  p.d_cos_i = base * f.d[0];
  p.d_cos_o = base * f.d[1];
  p.d_dot_io = base * f.d[2];
  p.d_roughness = base * (f.d[3] * AlphaByRoughness(in));
  p.d_eta = base * (f.d[4] * BeyondOverHereByEta(eta, in));
  return p;
}

}  // namespace

Rgb EvalModel(const RoughDielectricBsdf& model, const BsdfInputs& in, const BsdfCosines& c) {
  const double e = BeyondOverHere(model.eta, in);
  return WithDistribution(model.distribution, [&]<class D>(D) -> Rgb {
    if (c.cos_i > 0.0) {
      const double dot = ClampedDot(c);
      return in.base_color * (FresnelDielectric(std::sqrt(0.5 + 0.5 * dot), e) *
                              MicrofacetReflection<D>(c.cos_i, c.cos_o, dot, Alpha(in)));
    }
    if (c.cos_i < 0.0) {
      return in.base_color * MicrofacetTransmission<D>(c.cos_i, c.cos_o, c.dot_io, Alpha(in), e);
    }
    return {};
  });
}

BsdfPartials EvalModelPartials(const RoughDielectricBsdf& model,
                               const BsdfInputs& in,
                               const BsdfCosines& c) {
  return WithDistribution(model.distribution, [&]<class D>(D) -> BsdfPartials {
    if (c.cos_i > 0.0) return ReflectionPartials<D>(model.eta, in, c);
    if (c.cos_i < 0.0) return TransmissionPartials<D>(model.eta, in, c);
    return {};
  });
}

double ModelPdf(const RoughDielectricBsdf& model,
                const BsdfInputs& in,
                const BsdfCosines& c,
                bool mirrored) {
  const double e = BeyondOverHere(model.eta, in);
  return WithDistribution(model.distribution, [&]<class D>(D) {
    if (c.cos_i > 0.0) return ReflectionPdf<D>(e, Alpha(in), c, mirrored);
    return c.cos_i < 0.0 ? TransmissionPdf<D>(e, Alpha(in), c, mirrored) : 0.0;
  });
}

std::optional<LocalSample> SampleModel(const RoughDielectricBsdf& model,
                                       const BsdfInputs& in,
                                       const Vec3& wo,
                                       const UnitSample& u) {
  const double e = BeyondOverHere(model.eta, in);
  Vec3 h = WithDistribution(model.distribution, [&](auto distribution) {
    return SampleVisibleNormal(distribution, wo, Alpha(in), u.u0, u.u1);
  });
  const bool reflect = u.u2 < ChoiceOfReflection(Dot(wo, h), e);
  if (u.mirrored) h = MirroredNormal(h);
  const double facing = Dot(wo, h);
  if (facing <= 0.0 || (!reflect && IsTotalReflection(facing, e))) return std::nullopt;
  Vec3 wi = h * (2.0 * facing) - wo;
  if (!reflect) {
    const double cos_refracted = std::sqrt(1.0 - (1.0 - facing * facing) / (e * e));
    wi = h * (facing / e - cos_refracted) - wo / e;
  }
  if (reflect ? wi.z <= 0.0 : wi.z >= 0.0) return std::nullopt;
  return LocalSample{wi, ModelPdf(model, in, {wi.z, wo.z, Dot(wi, wo)}, false)};
}

}  // namespace pathfit::renderer
