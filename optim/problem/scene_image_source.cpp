#include "optim/problem/scene_image_source.h"

#include <cstddef>
#include <utility>

namespace pathfit::optim {

SceneImageSource::SceneImageSource(renderer::Scene scene,
                                   renderer::ParameterLayout layout,
                                   std::vector<renderer::Camera> cameras,
                                   const renderer::RenderOptions& options)
    : renderer_(std::move(scene)),
      layout_(std::move(layout)),
      cameras_(std::move(cameras)),
      options_(options) {}

void SceneImageSource::SetValues(const std::vector<double>& values) {
  guides_.Clear();
  renderer_.SetParameters(layout_, values);
}

renderer::Camera SceneImageSource::CameraOf(int view) const {
  const auto v = static_cast<std::size_t>(view);
  return renderer::ScaledCamera(
      renderer_.scene().sensors[v], cameras_[v].width, cameras_[v].height);
}

renderer::RenderOptions SceneImageSource::OptionsOf(int view, const SampleSet& samples) const {
  renderer::RenderOptions options = options_;
  options.seed = samples.seed;
  options.view = static_cast<std::uint64_t>(view);
  options.spp = samples.spp;
  options.sppe = samples.sppe;
  options.spp_direct = samples.spp_direct;
  options.spp_indirect = samples.spp_indirect;
  options.spp_pixel = samples.spp_pixel;
  return options;
}

renderer::Film SceneImageSource::RenderPrimal(int view, const SampleSet& samples) const {
  return renderer_.RenderPrimal(CameraOf(view), OptionsOf(view, samples));
}

renderer::Film SceneImageSource::RenderDerivative(int view,
                                                  const SampleSet& samples,
                                                  renderer::DerivativeSink& sink) const {
  renderer::RenderOptions options = OptionsOf(view, samples);
  options.guides = &guides_;
  return renderer_.RenderDerivative(CameraOf(view), view, options, layout_, sink);
}

}  // namespace pathfit::optim
