#pragma once

#include <vector>

#include "optim/problem/image_source.h"
#include "renderer/renderer.h"

namespace pathfit::optim {

/// The renderer as an ImageSource: view i is seen by the scene's sensor i, whose pose, lens and
/// gain may be parameters, at the size of cameras[i].
class SceneImageSource : public ImageSource {
 public:
  SceneImageSource(renderer::Scene scene,
                   renderer::ParameterLayout layout,
                   std::vector<renderer::Camera> cameras,
                   const renderer::EstimatorOptions& estimators,
                   const renderer::CancelFlag* cancel);

  void SetValues(const std::vector<double>& values) override;
  [[nodiscard]] renderer::Film RenderPrimal(int view, const SampleSet& samples) const override;
  renderer::Film RenderDerivative(int view,
                                  const SampleSet& samples,
                                  renderer::DerivativeSink& sink) const override;

  [[nodiscard]] const renderer::Scene& scene() const { return renderer_.scene(); }

 private:
  [[nodiscard]] renderer::Camera CameraOf(int view) const;
  [[nodiscard]] renderer::RenderOptions OptionsOf(int view, const SampleSet& samples) const;

  renderer::Renderer renderer_;
  renderer::ParameterLayout layout_;
  std::vector<renderer::Camera> cameras_;
  renderer::EstimatorOptions estimators_;
  const renderer::CancelFlag* cancel_;
  std::vector<double> values_;  ///< set last; empty: none yet
  /// The second half of a linearisation draws by the guides that the first one learned; new values
  /// start anew, so that a resumed fit has the same bits.
  mutable renderer::GuideStore guides_;
};

}  // namespace pathfit::optim
