#pragma once

#include <span>
#include <vector>

#include "renderer/renderer.h"

namespace pathfit::renderer {

/// A camera and directions of parameter space (flat, over the layout's scalars) whose derivative
/// images are wanted.
struct DerivativeImages {
  const Camera& camera;
  int sensor = -1;  ///< as of Renderer::RenderDerivative
  const ParameterLayout& layout;
  std::span<const std::vector<double>> directions;
};

/// `options` with what makes derivative images least noisy for their cost: with options.spp of the
/// interior, boundaries have samples by what they add to the error, together at most
/// kMostBoundaryCost times the cost of an image; and the form is the better one. What is given
/// stays. Measured by renderings of few samples, with seeds of their own: a function of its
/// arguments alone, whatever the threads. Nothing is measured where nothing moves. Throws as
/// RenderDerivative.
RenderOptions ChooseDerivative(const Renderer& renderer,
                               const DerivativeImages& images,
                               const RenderOptions& options,
                               const DerivativeChoice& given,
                               const CancelFlag* cancel = nullptr);

inline constexpr double kMostBoundaryCost = 6.0;

}  // namespace pathfit::renderer
