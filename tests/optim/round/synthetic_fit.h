#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "optim/observation/observation.h"
#include "optim/round/fit.h"
#include "renderer/core/check.h"
#include "renderer/renderer.h"
#include "tests/support/test_scenes.h"

namespace pathfit::tests {

/// Radius of the bumped ball in a direction (unit).
inline double BumpRadius(const renderer::Vec3& d) {
  return 1.0 + 0.12 * std::sin(3.0 * d.x + 0.5) * std::cos(2.5 * d.y) + 0.06 * d.z;
}

/// A ball of uniform grey (mesh 0, material 0, vertex colours) under a gradient environment (not
/// seen behind it), with `num_views` cameras of `size` pixels squared on a spiral around it.
inline renderer::Scene BallScene(int subdivisions, int num_views, int size) {
  renderer::Scene scene;
  renderer::Mesh ball = renderer::MakeIcosphere(subdivisions, 1.0);
  renderer::SetUniformVertexColors({0.6, 0.6, 0.6}, ball);
  scene.meshes = {{"ball", ball, 0}};
  scene.materials = {{"paint", renderer::LambertBsdf{}, {0.6, 0.6, 0.6}, true}};
  scene.emitters = {GradientEnvironment(8, 4)};
  scene.environment_visible = false;
  for (int i = 0; i < num_views; ++i) {
    const double y = -0.75 + 1.5 * (i + 0.5) / num_views;
    const double angle = 2.4 * i;
    const double r = std::sqrt(1.0 - y * y);
    const renderer::Vec3 origin{4.0 * r * std::sin(angle), 4.0 * y, 4.0 * r * std::cos(angle)};
    scene.sensors.push_back(CameraAt(origin, {0, 0, 0}, 1.45 * size, size, size));
    scene.sensors.back().name = "view" + std::to_string(i);
  }
  return scene;
}

inline void Bump(renderer::Scene& scene) {
  for (renderer::Vec3& p : scene.meshes[0].mesh.positions) {
    p = Normalized(p) * BumpRadius(Normalized(p));
  }
}

/// Pulls vertices of the ball that are far from each other, and where(vertex), out to needles.
template <class Where>
void PullNeedles(renderer::Mesh& ball, const Where& where) {
  std::vector<renderer::Vec3> pulled;
  for (renderer::Vec3& p : ball.positions) {
    const bool is_apart = std::ranges::all_of(
        pulled, [&p](const renderer::Vec3& other) { return Norm(p - other) > 0.5; });
    if (is_apart && where(p)) {
      pulled.push_back(p);
      p = p * 1.35;
    }
  }
}
inline void PullNeedles(renderer::Mesh& ball) {
  PullNeedles(ball, [](const renderer::Vec3&) { return true; });
}

/// Mean distance of the vertices from the bumped ball, along the radius.
inline double BumpError(const renderer::Scene& scene) {
  double sum = 0.0;
  const auto& positions = scene.meshes[0].mesh.positions;
  for (const renderer::Vec3& p : positions) {
    sum += std::abs(Norm(p) - BumpRadius(Normalized(p))) / static_cast<double>(positions.size());
  }
  return sum;
}

/// Photos of `truth` by its own sensors, with silhouettes as masks; the last view is held out.
inline optim::ObservationSet Photograph(const renderer::Scene& truth, int spp) {
  optim::ObservationSet observations;
  observations.mask_meaning = optim::MaskMeaning::kSilhouette;
  const renderer::Renderer renderer(truth);
  for (std::size_t i = 0; i < truth.sensors.size(); ++i) {
    renderer::RenderOptions options;
    options.seed = 77;
    options.view = i;
    options.spp = spp;
    const renderer::Film film = renderer.RenderPrimal(truth.sensors[i], options);
    optim::View view;
    view.name = "view" + std::to_string(i);
    view.camera = truth.sensors[i];
    view.camera.gain = 1.0;
    view.photo = renderer::ColorImage(film);
    view.mask = renderer::CoverageImage(film);
    view.validation = i + 1 == truth.sensors.size();
    observations.views.push_back(std::move(view));
  }
  return observations;
}

/// Calls edit(photo) for each photo.
template <class Edit>
void EditPhotos(const Edit& edit, optim::ObservationSet& observations) {
  for (optim::View& view : observations.views) {
    renderer::Image photo = view.photo.Unpack();
    edit(photo);
    view.photo = photo;
  }
}

/// Keeps everything it hears; prints nothing.
class RecordingObserver : public optim::FitObserver {
 public:
  void OnRound(const optim::RoundReport& report) override {
    rounds.push_back(report);
    if (cancel_after > 0 && static_cast<int>(rounds.size()) == cancel_after) {
      cancel.store(true);
    }
  }
  void OnView(const std::string& stage,
              std::size_t view,
              const renderer::Film& image,
              const optim::ViewLevel& observed) override {
    PATHFIT_CHECK(image.width == observed.photo.width && image.height == observed.photo.height);
    num_images = stage == stage_ ? num_images + 1 : 1;
    PATHFIT_CHECK(view + 1 == num_images);
    stage_ = stage;
  }
  void OnStage(const optim::StageReport& report) override { stages.push_back(report); }
  void OnMessage(const std::string& text) override { messages.push_back(text); }
  void OnWarning(const std::string& text) override { warnings.push_back(text); }

  std::vector<optim::RoundReport> rounds;
  std::vector<optim::StageReport> stages;
  std::vector<std::string> messages, warnings;
  std::size_t num_images = 0;  ///< of the last stage
  int cancel_after = 0;        ///< raise `cancel` after so many rounds; 0 = never
  renderer::CancelFlag cancel{false};

 private:
  std::string stage_;
};

}  // namespace pathfit::tests
