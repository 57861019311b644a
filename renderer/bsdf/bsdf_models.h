#pragma once

#include <algorithm>
#include <optional>

#include "renderer/bsdf/bsdf.h"

namespace pathfit::renderer {

// What each model implements, one overload per alternative of Bsdf that is not Lambert; bsdf.cpp
// dispatches. Cosines and directions come with cos_o >= kMinCosO.

/// A direction in the frame of the normal (+z).
struct LocalSample {
  Vec3 wi;
  double pdf = 0.0;
};

Rgb EvalModel(const MetallicRoughnessBsdf& model, const BsdfInputs& inputs, const BsdfCosines& c);
Rgb EvalModel(const RoughConductorBsdf& model, const BsdfInputs& inputs, const BsdfCosines& c);
Rgb EvalModel(const RoughDielectricBsdf& model, const BsdfInputs& inputs, const BsdfCosines& c);

BsdfPartials EvalModelPartials(const MetallicRoughnessBsdf& model,
                               const BsdfInputs& inputs,
                               const BsdfCosines& c);
BsdfPartials EvalModelPartials(const RoughConductorBsdf& model,
                               const BsdfInputs& inputs,
                               const BsdfCosines& c);
BsdfPartials EvalModelPartials(const RoughDielectricBsdf& model,
                               const BsdfInputs& inputs,
                               const BsdfCosines& c);

/// Density of SampleModel, plain or mirrored.
double ModelPdf(const MetallicRoughnessBsdf& model,
                const BsdfInputs& inputs,
                const BsdfCosines& c,
                bool mirrored);
double ModelPdf(const RoughConductorBsdf& model,
                const BsdfInputs& inputs,
                const BsdfCosines& c,
                bool mirrored);
double ModelPdf(const RoughDielectricBsdf& model,
                const BsdfInputs& inputs,
                const BsdfCosines& c,
                bool mirrored);

/// Direction and its density under the sampler that is not mirrored.
struct UnitSample {
  double u0, u1, u2;
  bool mirrored;
};
std::optional<LocalSample> SampleModel(const MetallicRoughnessBsdf& model,
                                       const BsdfInputs& inputs,
                                       const Vec3& wo,
                                       const UnitSample& u);
std::optional<LocalSample> SampleModel(const RoughConductorBsdf& model,
                                       const BsdfInputs& inputs,
                                       const Vec3& wo,
                                       const UnitSample& u);
std::optional<LocalSample> SampleModel(const RoughDielectricBsdf& model,
                                       const BsdfInputs& inputs,
                                       const Vec3& wo,
                                       const UnitSample& u);

/// Weights of the mirrored and the refracted direction, cos_o > 0.
DeltaPartials EvalDeltaModel(const MirrorBsdf& model,
                             const BsdfInputs& inputs,
                             double cos_o,
                             bool transmit,
                             TransportMode mode);
DeltaPartials EvalDeltaModel(const SmoothDielectricBsdf& model,
                             const BsdfInputs& inputs,
                             double cos_o,
                             bool transmit,
                             TransportMode mode);

/// Index on the far side of a dielectric over the one on the side of wo, and its derivative by eta.
inline double BeyondOverHere(double eta, const BsdfInputs& inputs) {
  return inputs.from_inside ? 1.0 / eta : eta;
}
inline double BeyondOverHereByEta(double eta, const BsdfInputs& inputs) {
  return inputs.from_inside ? -1.0 / (eta * eta) : 1.0;
}

/// Probability of reflecting off an interface of this reflectance: both lobes keep some, so that
/// derivatives have support too.
inline double ReflectionProbability(double reflectance) {
  return reflectance >= 1.0 ? 1.0 : std::clamp(reflectance, 0.1, 0.9);
}

/// Roughness below kMinRoughness (a texel) counts as kMinRoughness.
inline double Alpha(const BsdfInputs& inputs) {
  const double roughness = std::max(inputs.roughness, kMinRoughness);
  return roughness * roughness;
}
inline double AlphaByRoughness(const BsdfInputs& inputs) {
  return inputs.roughness < kMinRoughness ? 0.0 : 2.0 * inputs.roughness;
}

/// A pair of directions this close to opposite has no half vector.
inline constexpr double kMinOnePlusDot = 1e-9;
inline double ClampedDot(const BsdfCosines& c) { return std::max(c.dot_io, kMinOnePlusDot - 1.0); }

}  // namespace pathfit::renderer
