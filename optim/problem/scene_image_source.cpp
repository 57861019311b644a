#include "optim/problem/scene_image_source.h"

#include <cstddef>
#include <utility>

namespace pathfit::optim {

SceneImageSource::SceneImageSource(renderer::Scene scene,
                                   renderer::ParameterLayout layout,
                                   std::vector<renderer::Camera> cameras,
                                   const renderer::EstimatorOptions& estimators,
                                   const renderer::CancelFlag* cancel)
    : renderer_(std::move(scene)),
      layout_(std::move(layout)),
      cameras_(std::move(cameras)),
      estimators_(estimators),
      cancel_(cancel) {}

void SceneImageSource::SetValues(const std::vector<double>& values) {
  guides_.Clear();
  // A round begins where the last one ended, and ends where its trial was.
  if (values != values_) {
    renderer_.SetParameters(layout_, values);
    values_ = values;
  }
}

renderer::Camera SceneImageSource::CameraOf(int view) const {
  const auto v = static_cast<std::size_t>(view);
  return renderer::ScaledCamera(
      renderer_.scene().sensors[v], cameras_[v].width, cameras_[v].height);
}

renderer::RenderOptions SceneImageSource::OptionsOf(int view, const SampleSet& samples) const {
  return {samples, estimators_, samples.seed, static_cast<std::uint64_t>(view)};
}

renderer::Film SceneImageSource::RenderPrimal(int view, const SampleSet& samples) const {
  return renderer_.RenderPrimal(CameraOf(view), OptionsOf(view, samples), {.cancel = cancel_});
}

renderer::Film SceneImageSource::RenderDerivative(int view,
                                                  const SampleSet& samples,
                                                  renderer::DerivativeSink& sink) const {
  return renderer_.RenderDerivative(CameraOf(view),
                                    view,
                                    OptionsOf(view, samples),
                                    layout_,
                                    sink,
                                    {.guides = &guides_, .cancel = cancel_});
}

}  // namespace pathfit::optim
