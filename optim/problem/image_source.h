#pragma once

#include <cstdint>
#include <vector>

#include "renderer/derivative/derivative_sink.h"
#include "renderer/image/image.h"
#include "renderer/render_options.h"

namespace pathfit::optim {

/// One set of random samples: equal sets give equal images of equal parameters.
struct SampleSet : renderer::SampleBudget {
  std::uint64_t seed = 0;
};

/// Two independent sample sets; their mean is the image, their half difference its noise.
struct SampleHalves {
  SampleSet a, b;
};

/// Renders the views of an observation set with parameters that move. The seam between least
/// squares and the renderer.
class ImageSource {
 public:
  ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;
  virtual ~ImageSource() = default;

  /// Parameter values in units of the scene, in the layout's order.
  virtual void SetValues(const std::vector<double>& values) = 0;
  [[nodiscard]] virtual renderer::Film RenderPrimal(int view, const SampleSet& samples) const = 0;
  /// Image of the same samples, and its derivatives by the layout's blocks into `sink`.
  virtual renderer::Film RenderDerivative(int view,
                                          const SampleSet& samples,
                                          renderer::DerivativeSink& sink) const = 0;
};

}  // namespace pathfit::optim
