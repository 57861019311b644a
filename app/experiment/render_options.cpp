#include "renderer/render_options.h"

#include "app/experiment/experiment.h"

namespace pathfit::app {

renderer::RenderOptions MakeRenderOptions(const ExperimentConfig& config) {
  const RenderConfig& render = config.render;
  renderer::RenderOptions options;
  options.seed = config.seed;
  options.spp = render.spp;
  options.sppe = render.sppe;
  options.spp_direct = render.spp_direct;
  options.spp_indirect = render.spp_indirect;
  options.spp_pixel = render.spp_pixel;
  options.max_bounces = render.max_bounces;
  options.rr_depth = render.rr_depth;
  options.terms = {.interior = render.interior,
                   .primary = render.primary,
                   .direct = render.direct,
                   .indirect = render.indirect,
                   .pixel = render.pixel};
  options.form =
      render.material_form ? renderer::DerivativeForm::kMaterial : renderer::DerivativeForm::kImage;
  switch (render.guiding) {
    case RenderConfig::Guiding::kNone:
      options.guide = renderer::GuideKind::kNone;
      break;
    case RenderConfig::Guiding::kGrid:
      options.guide = renderer::GuideKind::kGrid;
      break;
    case RenderConfig::Guiding::kAdaptive:
      options.guide = renderer::GuideKind::kAdaptive;
      break;
  }
  options.guide_share = render.guide_share;
  options.antithetic = render.antithetic;
  return options;
}

}  // namespace pathfit::app
