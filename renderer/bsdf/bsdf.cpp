#include "renderer/bsdf/bsdf.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>

#include "renderer/bsdf/bsdf_models.h"
#include "renderer/bsdf/fresnel_kernel.h"
#include "renderer/math/frame.h"

namespace pathfit::renderer {
namespace {

constexpr double kInvPi = std::numbers::inv_pi;

template <class Model>
concept Diffuse = std::same_as<Model, LambertBsdf>;  // its formulas: bsdf.h
template <class Model>
concept Delta = std::same_as<Model, MirrorBsdf> || std::same_as<Model, SmoothDielectricBsdf>;
template <class Model>
concept Dielectric =
    std::same_as<Model, RoughDielectricBsdf> || std::same_as<Model, SmoothDielectricBsdf>;

/// Where wo is below kMinCosO, what counts is the direction of kMinCosO in its plane with n. The
/// tangential part of wo grows by this ratio.
double TangentialRatio(double cos_o) {
  constexpr double kNoTangent = 1e-12;
  return std::sqrt((1.0 - kMinCosO * kMinCosO) / std::max(1.0 - cos_o * cos_o, kNoTangent));
}

BsdfCosines Raised(const BsdfCosines& c) {
  const double ratio = TangentialRatio(c.cos_o);
  return {c.cos_i, kMinCosO, c.cos_i * kMinCosO + (c.dot_io - c.cos_i * c.cos_o) * ratio};
}

Vec3 Raised(const Vec3& wo) {
  const double planar = std::hypot(wo.x, wo.y);
  const double radius = std::sqrt(1.0 - kMinCosO * kMinCosO);
  return planar > 0.0 ? Vec3{wo.x / planar * radius, wo.y / planar * radius, kMinCosO}
                      : Vec3{radius, 0.0, kMinCosO};
}

/// Partials by the cosines of wo from those by the raised ones.
void ChainRaised(const BsdfCosines& c, BsdfPartials& p) {
  const double ratio = TangentialRatio(c.cos_o);
  const double tangential = c.dot_io - c.cos_i * c.cos_o;
  const double ratio_by_cos_o = ratio * c.cos_o * ratio * ratio / (1.0 - kMinCosO * kMinCosO);
  p.d_cos_i += p.d_dot_io * (kMinCosO - c.cos_o * ratio);
  p.d_cos_o = p.d_dot_io * (tangential * ratio_by_cos_o - c.cos_i * ratio);
  p.d_dot_io *= ratio;
}

/// Mirrored or, if `model` refracts and u falls there, refracted wo.
template <Delta Model>
std::optional<BsdfSample> SampleDelta(
    const Model& model, const BsdfInputs& inputs, const Vec3& n, const Vec3& wo, double u) {
  const double cos_o = Dot(n, wo);
  if (cos_o <= 0.0) return std::nullopt;
  double reflect = 1.0;
  if constexpr (Dielectric<Model>) {
    const double e = BeyondOverHere(model.eta, inputs);
    reflect = ReflectionProbability(FresnelDielectric(cos_o, e));
    if (u >= reflect) {
      const double cos_refracted = std::sqrt(1.0 - (1.0 - cos_o * cos_o) / (e * e));
      return BsdfSample{n * (cos_o / e - cos_refracted) - wo / e, 1.0 - reflect, true};
    }
  }
  return BsdfSample{n * (2.0 * cos_o) - wo, reflect, true};
}

}  // namespace

Rgb bsdf_internal::Eval(const Bsdf& bsdf, const BsdfInputs& inputs, const BsdfCosines& cosines) {
  return std::visit(
      [&]<class Model>(const Model& model) -> Rgb {
        if constexpr (Diffuse<Model> || Delta<Model>) {
          return {};
        } else {
          const BsdfCosines& c = cosines;
          return EvalModel(model, inputs, c.cos_o < kMinCosO ? Raised(c) : c);
        }
      },
      bsdf);
}

BsdfPartials EvalBsdfPartials(const Bsdf& bsdf,
                              const BsdfInputs& inputs,
                              const BsdfCosines& cosines) {
  return std::visit(
      [&]<class Model>(const Model& model) -> BsdfPartials {
        BsdfPartials p;
        if constexpr (Diffuse<Model>) {
          if (cosines.cos_i > 0.0) {
            p.value = inputs.base_color * kInvPi;
            p.d_base_color = Rgb::Constant(kInvPi);
          }
        } else if constexpr (!Delta<Model>) {
          if (cosines.cos_o < kMinCosO) {
            p = EvalModelPartials(model, inputs, Raised(cosines));
            ChainRaised(cosines, p);
          } else {
            p = EvalModelPartials(model, inputs, cosines);
          }
        }
        return p;
      },
      bsdf);
}

std::optional<BsdfSample> bsdf_internal::Sample(const Bsdf& bsdf,
                                                const BsdfInputs& inputs,
                                                const Vec3& n,
                                                const Vec3& wo,
                                                double u0,
                                                double u1,
                                                double u2,
                                                bool mirrored) {
  return std::visit(
      [&]<class Model>(const Model& model) -> std::optional<BsdfSample> {
        if constexpr (Delta<Model>) {
          return SampleDelta(model, inputs, n, wo, u2);
        } else if constexpr (Diffuse<Model>) {
          return std::nullopt;
        } else {
          const Frame frame = Frame::FromNormal(n);
          const Vec3 local = frame.ToLocal(wo);
          const auto sample = SampleModel(
              model, inputs, local.z < kMinCosO ? Raised(local) : local, {u0, u1, u2, mirrored});
          return sample ? std::optional(BsdfSample{frame.ToWorld(sample->wi), sample->pdf})
                        : std::nullopt;
        }
      },
      bsdf);
}

double bsdf_internal::Pdf(const Bsdf& bsdf,
                          const BsdfInputs& inputs,
                          const BsdfCosines& cosines,
                          bool mirrored) {
  return std::visit(
      [&]<class Model>(const Model& model) {
        if constexpr (Diffuse<Model> || Delta<Model>) {
          return 0.0;
        } else {
          const BsdfCosines& c = cosines;
          return ModelPdf(model, inputs, c.cos_o < kMinCosO ? Raised(c) : c, mirrored);
        }
      },
      bsdf);
}

DeltaPartials EvalDelta(
    const Bsdf& bsdf, const BsdfInputs& inputs, double cos_o, bool transmit, TransportMode mode) {
  return std::visit(
      [&]<class Model>(const Model& model) -> DeltaPartials {
        if constexpr (Delta<Model>) {
          return cos_o > 0.0 ? EvalDeltaModel(model, inputs, cos_o, transmit, mode)
                             : DeltaPartials{};
        } else {
          return {};
        }
      },
      bsdf);
}

double RelativeEta(const Bsdf& bsdf, const BsdfInputs& inputs) {
  return std::visit(
      [&]<class Model>(const Model& model) {
        if constexpr (Dielectric<Model>) {
          return 1.0 / BeyondOverHere(model.eta, inputs);
        } else {
          return 1.0;
        }
      },
      bsdf);
}

}  // namespace pathfit::renderer
