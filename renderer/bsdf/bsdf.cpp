#include "renderer/bsdf/bsdf.h"

#include <algorithm>
#include <numbers>

#include "renderer/bsdf/microfacet_kernel.h"
#include "renderer/math/dual.h"
#include "renderer/math/frame.h"
#include "renderer/math/warp.h"

namespace pathfit::renderer {
namespace {

constexpr double kDielectricF0 = 0.04;
constexpr double kInvPi = std::numbers::inv_pi;
// A pair of directions this close to opposite has no half vector.
constexpr double kMinOnePlusDot = 1e-9;

bool IsReflection(const BsdfCosines& c) { return c.cos_i > 0.0 && c.cos_o > 0.0; }
double ClampedDot(const BsdfCosines& c) { return std::max(c.dot_io, kMinOnePlusDot - 1.0); }
double Alpha(const MetallicRoughnessBsdf& m) { return m.roughness * m.roughness; }

Rgb DiffuseAlbedo(const MetallicRoughnessBsdf& m, const Rgb& base) {
  return base * (1.0 - m.metallic);
}
Rgb NormalReflectance(const MetallicRoughnessBsdf& m, const Rgb& base) {
  return Rgb::Constant(kDielectricF0 * (1.0 - m.metallic)) + base * m.metallic;
}

/// Share of samples drawn from the specular lobe; both lobes keep some, so that derivatives have
/// support too.
double SpecularProbability(const MetallicRoughnessBsdf& m, const Rgb& base, double cos_o) {
  const double c = 1.0 - cos_o;
  const double weight = c * c * c * c * c;
  const double f0 = Luminance(NormalReflectance(m, base));
  const double specular = f0 + (1.0 - f0) * weight;
  const double diffuse = (1.0 - specular) * Luminance(DiffuseAlbedo(m, base));
  const double sum = specular + diffuse;
  return sum > 0.0 ? std::clamp(specular / sum, 0.1, 0.9) : 0.5;
}

/// Density of reflecting about visible normals: D G1(o) / (4 cos_o).  [Heitz 2018]
double VisibleNormalPdf(double alpha, const BsdfCosines& c) {
  const double alpha2 = alpha * alpha;
  const double sum = c.cos_i + c.cos_o;
  const double cos_h2 = sum * sum / (2.0 + 2.0 * ClampedDot(c));
  const double base = cos_h2 * (alpha2 - 1.0) + 1.0;
  const double distribution = alpha2 / (std::numbers::pi * base * base);
  const double g1_over_cos =
      2.0 / (c.cos_o + std::sqrt(alpha2 + (1.0 - alpha2) * c.cos_o * c.cos_o));
  return 0.25 * distribution * g1_over_cos;
}

/// Visible GGX normal in the local frame.  [Heitz 2018, Sampling the GGX Distribution of Visible
/// Normals]
Vec3 SampleVisibleNormal(const Vec3& wo, double alpha, double u0, double u1) {
  const Vec3 stretched = Normalized(Vec3{alpha * wo.x, alpha * wo.y, wo.z});
  const Frame frame = Frame::FromNormal(stretched);
  const double radius = std::sqrt(u0);
  const double phi = 2.0 * std::numbers::pi * u1;
  const double s = 0.5 * (1.0 + stretched.z);
  // The projected hemisphere is a half disk towards +z of the local frame; align the frame's t with
  // it.
  const double planar = std::hypot(stretched.x, stretched.y);
  const Vec3 t1 = planar > 1e-9 ? Vec3{-stretched.y / planar, stretched.x / planar, 0.0} : frame.s;
  const Vec3 t2 = Cross(stretched, t1);
  const double p1 = radius * std::cos(phi);
  double p2 = radius * std::sin(phi);
  p2 = (1.0 - s) * std::sqrt(std::max(0.0, 1.0 - p1 * p1)) + s * p2;
  const double p3 = std::sqrt(std::max(0.0, 1.0 - p1 * p1 - p2 * p2));
  const Vec3 n = t1 * p1 + t2 * p2 + stretched * p3;
  return Normalized(Vec3{alpha * n.x, alpha * n.y, std::max(1e-12, n.z)});
}

Rgb EvalMetallicRoughness(const MetallicRoughnessBsdf& m, const Rgb& base, const BsdfCosines& c) {
  const double dot = ClampedDot(c);
  const double specular = MicrofacetReflection(c.cos_i, c.cos_o, dot, Alpha(m));
  const double weight = SchlickWeight(dot);
  const Rgb diffuse = DiffuseAlbedo(m, base) * kInvPi;
  const Rgb f0 = NormalReflectance(m, base);
  Rgb value;
  for (int i = 0; i < 3; ++i) {
    const double fresnel = f0[i] + (1.0 - f0[i]) * weight;
    value[i] = (1.0 - fresnel) * diffuse[i] + fresnel * specular;
  }
  return value;
}

BsdfPartials PartialsMetallicRoughness(const MetallicRoughnessBsdf& m,
                                       const Rgb& base,
                                       const BsdfCosines& c) {
  using D4 = Dual<4>;
  const double dot = ClampedDot(c);
  const double alpha = Alpha(m);
  const D4 specular = MicrofacetReflection(D4::Variable(c.cos_i, 0),
                                           D4::Variable(c.cos_o, 1),
                                           D4::Variable(dot, 2),
                                           D4::Variable(alpha, 3));
  const Dual<1> weight = SchlickWeight(Dual<1>::Variable(dot, 0));
  const Rgb f0 = NormalReflectance(m, base);
  BsdfPartials p;
  for (int i = 0; i < 3; ++i) {
    const double diffuse = base[i] * (1.0 - m.metallic) * kInvPi;
    const double fresnel = f0[i] + (1.0 - f0[i]) * weight.v;
    const double by_fresnel = specular.v - diffuse;
    p.value[i] = diffuse + fresnel * by_fresnel;
    p.d_cos_i[i] = fresnel * specular.d[0];
    p.d_cos_o[i] = fresnel * specular.d[1];
    p.d_dot_io[i] = fresnel * specular.d[2] + (1.0 - f0[i]) * weight.d[0] * by_fresnel;
    p.d_roughness[i] = fresnel * specular.d[3] * 2.0 * m.roughness;
    const double by_f0 = (1.0 - weight.v) * by_fresnel;
    p.d_base_color[i] = by_f0 * m.metallic + (1.0 - fresnel) * (1.0 - m.metallic) * kInvPi;
    p.d_metallic[i] = by_f0 * (base[i] - kDielectricF0) - (1.0 - fresnel) * base[i] * kInvPi;
  }
  return p;
}

}  // namespace

Rgb EvalBsdf(const Bsdf& bsdf, const Rgb& base_color, const BsdfCosines& cosines) {
  if (!IsReflection(cosines)) {
    return {};
  }
  if (const auto* m = std::get_if<MetallicRoughnessBsdf>(&bsdf)) {
    return EvalMetallicRoughness(*m, base_color, cosines);
  }
  return base_color * kInvPi;
}

BsdfPartials EvalBsdfPartials(const Bsdf& bsdf, const Rgb& base_color, const BsdfCosines& cosines) {
  if (!IsReflection(cosines)) {
    return {};
  }
  if (const auto* m = std::get_if<MetallicRoughnessBsdf>(&bsdf)) {
    return PartialsMetallicRoughness(*m, base_color, cosines);
  }
  BsdfPartials p;
  p.value = base_color * kInvPi;
  p.d_base_color = Rgb::Constant(kInvPi);
  return p;
}

std::optional<BsdfSample> SampleBsdf(const Bsdf& bsdf,
                                     const Rgb& base_color,
                                     const Vec3& n,
                                     const Vec3& wo,
                                     double u0,
                                     double u1,
                                     double u2) {
  const Frame frame = Frame::FromNormal(n);
  const auto* m = std::get_if<MetallicRoughnessBsdf>(&bsdf);
  if (m == nullptr) {
    const Vec3 local = SampleCosineHemisphere(u0, u1);
    if (local.z <= 0.0) {
      return std::nullopt;
    }
    return BsdfSample{frame.ToWorld(local), local.z * kInvPi};
  }
  const Vec3 wo_local = frame.ToLocal(wo);
  Vec3 local;
  if (u2 < SpecularProbability(*m, base_color, wo_local.z)) {
    const Vec3 h = SampleVisibleNormal(wo_local, Alpha(*m), u0, u1);
    local = h * (2.0 * Dot(wo_local, h)) - wo_local;
  } else {
    local = SampleCosineHemisphere(u0, u1);
  }
  if (local.z <= 0.0) {
    return std::nullopt;
  }
  const BsdfCosines cosines{local.z, wo_local.z, Dot(local, wo_local)};
  return BsdfSample{frame.ToWorld(local), BsdfPdf(bsdf, base_color, cosines)};
}

double BsdfPdf(const Bsdf& bsdf, const Rgb& base_color, const BsdfCosines& cosines) {
  if (!IsReflection(cosines)) {
    return 0.0;
  }
  const auto* m = std::get_if<MetallicRoughnessBsdf>(&bsdf);
  if (m == nullptr) {
    return cosines.cos_i * kInvPi;
  }
  const double p = SpecularProbability(*m, base_color, cosines.cos_o);
  return p * VisibleNormalPdf(Alpha(*m), cosines) + (1.0 - p) * cosines.cos_i * kInvPi;
}

}  // namespace pathfit::renderer
