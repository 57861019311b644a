// Renders the derivative image of a ball by the intensity of its light and compares sums: an image
// is linear in its lights, so along the intensity itself the derivative is the image.
#include <cmath>
#include <cstdio>

#include "pathfit/optim/round/fit.h"
#include "pathfit/renderer/derivative/film_sink.h"
#include "pathfit/renderer/geometry/mesh_primitives.h"
#include "pathfit/renderer/renderer.h"

namespace {

double Sum(const pathfit::renderer::Film& film) {
  double sum = 0.0;
  for (const pathfit::renderer::Rgba& pixel : film.pixels) sum += pixel[0] + pixel[1] + pixel[2];
  return sum;
}

}  // namespace

int main() {
  namespace renderer = pathfit::renderer;
  renderer::Scene scene;
  scene.materials.push_back({.name = "grey", .bsdf = renderer::MetallicRoughnessBsdf{}});
  scene.meshes.push_back({.name = "ball", .mesh = renderer::MakeIcosphere(2, 0.8)});
  scene.emitters.push_back(
      {.name = "lamp", .light = renderer::PointEmitter{{1.0, 2.0, 3.0}, {9.0, 6.0, 3.0}}});
  renderer::Camera camera{
      .name = "camera", .width = 32, .height = 32, .fx = 40.0, .fy = 40.0, .cx = 16.0, .cy = 16.0};
  camera.world_from_camera.translation = {0.0, 0.0, 3.0};
  scene.sensors.push_back(camera);

  renderer::ParameterLayout layout(scene);
  layout.Add(renderer::ParameterKind::kLightIntensity, 0);
  renderer::FilmSink derivative(layout, layout.Gather(scene), camera.width, camera.height);
  const renderer::Film image =
      renderer::Renderer(scene).RenderDerivative(camera, 0, {}, layout, derivative);
  const bool has_fit = &pathfit::optim::RunFit != nullptr;  // links the fit and what it needs
  std::printf("image %.6f derivative %.6f\n", Sum(image), Sum(derivative.film()));
  const bool agree = std::abs(Sum(derivative.film()) - Sum(image)) < 1e-9 * Sum(image);
  return has_fit && Sum(image) > 1.0 && agree ? 0 : 1;
}
