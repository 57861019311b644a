#pragma once

#include <memory>
#include <vector>

#include "renderer/derivative/derivative_sink.h"
#include "renderer/image/image.h"
#include "renderer/render_options.h"
#include "renderer/render_stats.h"
#include "renderer/scene/parameter_layout.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {

class World;

/// Renders a scene and its derivatives. Owns the acceleration structure; all results are a pure
/// function of (scene, sensor, options) and do not depend on the number of threads.
class Renderer {
 public:
  /// Throws SceneError if the scene is not valid.
  explicit Renderer(Scene scene);
  /// For a scene that differs a little from another renderer's: rays are rounded and offset alike,
  /// so that differences of their images tell of the scenes alone.
  Renderer(Scene scene, const Renderer& alike);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  [[nodiscard]] const Scene& scene() const;
  /// Writes parameter values into the scene and rebuilds what depends on them.
  void SetParameters(const ParameterLayout& layout, const std::vector<double>& values);
  /// The same of any values: throws SceneError, and changes nothing, if the scene would not be
  /// valid.
  void SetCheckedParameters(const ParameterLayout& layout, const std::vector<double>& values);

  /// Image of `camera`, which need not be one of the scene's sensors (pyramid levels, crops).
  [[nodiscard]] Film RenderPrimal(const Camera& camera,
                                  const RenderOptions& options,
                                  const RenderServices& services = {}) const;

  /// Emits the derivative of every pixel by every block of `layout` into `sink` and returns the
  /// image of the same interior samples (equal to RenderPrimal with the same options, bit for bit;
  /// without pixels if options.with_image is off).
  /// `sensor` is the index whose exposure the camera carries, -1 for none.
  Film RenderDerivative(const Camera& camera,
                        int sensor,
                        const RenderOptions& options,
                        const ParameterLayout& layout,
                        DerivativeSink& sink,
                        const RenderServices& services = {}) const;

 private:
  std::unique_ptr<World> world_;
};

}  // namespace pathfit::renderer
