#include <algorithm>

#include "renderer/bsdf/bsdf_models.h"
#include "renderer/bsdf/fresnel_kernel.h"
#include "renderer/math/dual.h"

namespace pathfit::renderer {

DeltaPartials EvalDeltaModel(const MirrorBsdf& model,
                             const BsdfInputs& in,
                             double cos_o,
                             bool transmit,
                             TransportMode /*mode*/) {
  using D3 = Dual<3>;
  DeltaPartials p;
  if (transmit) return p;
  for (int i = 0; i < 3; ++i) {
    const D3 fresnel = FresnelConductor(D3::Variable(std::min(cos_o, 1.0), 0),
                                        D3::Variable(model.eta[i], 1),
                                        D3::Variable(model.k[i], 2));
    const double base = in.base_color[i];
    p.value[i] = base * fresnel.v;
    p.d_cos_o[i] = base * fresnel.d[0];
    p.d_base_color[i] = fresnel.v;
    p.d_eta[i] = base * fresnel.d[1];
    p.d_k[i] = base * fresnel.d[2];
  }
  return p;
}

DeltaPartials EvalDeltaModel(const SmoothDielectricBsdf& model,
                             const BsdfInputs& in,
                             double cos_o,
                             bool transmit,
                             TransportMode mode) {
  using D2 = Dual<2>;
  const D2 e = D2::Variable(BeyondOverHere(model.eta, in), 1);
  const D2 reflected = FresnelDielectric(D2::Variable(std::min(cos_o, 1.0), 0), e);
  D2 weight = transmit ? D2(1.0) - reflected : reflected;
  if (transmit && mode == TransportMode::kRadiance) weight = weight / (e * e);
  DeltaPartials p;
  p.value = in.base_color * weight.v;
  p.d_cos_o = in.base_color * weight.d[0];
  p.d_base_color = Rgb::Constant(weight.v);
  p.d_eta = in.base_color * (weight.d[1] * BeyondOverHereByEta(model.eta, in));
  return p;
}

}  // namespace pathfit::renderer
