#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/config/experiment_config.h"
#include "optim/parameter/unknown_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

/// An unknown `MATERIAL.PROPERTY` that changes its form: one for each stage that frees it, the last
/// for all further ones.
struct PromotedUnknown {
  std::size_t index = 0;  ///< in the config
  optim::Promotion promotion;
  std::vector<SurfaceForm> forms;  ///< not empty
};

/// Those unknowns of the config that say `as`; what is wrong with them is added to `problems`.
std::vector<PromotedUnknown> ReadPromotions(const ExperimentConfig& config,
                                            const renderer::Scene& scene,
                                            std::vector<Problem>& problems);

/// Name of the texture that a property becomes: "bronze_base_color".
std::string PromotedTextureName(const renderer::Scene& scene, const optim::Promotion& promotion);

/// Adds the textures that unknowns become, of one texel until a stage frees them: the lists of a
/// scene stay the same throughout a fit.
void AddPromotedTextures(const ExperimentConfig& config, renderer::Scene& scene);

}  // namespace pathfit::app
