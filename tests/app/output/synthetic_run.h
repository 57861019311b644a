#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <unistd.h>

#include "app/output/run_directory.h"
#include "optim/observation/observation.h"
#include "optim/round/fit_report.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

/// A folder of its own, removed at the end.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& name)
      : path_(std::filesystem::temp_directory_path() /
              ("pathfit_" + name + "_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A shaded disc that stands for an object; `wrong` between 0 (the photo) and 1 moves, shrinks and
/// darkens it.
inline renderer::Film DiscFilm(int width, int height, int view, double wrong) {
  renderer::Film film(width, height);
  const double radius = 0.36 * height * (1.0 + 0.15 * wrong);
  const double center_x = 0.5 * width + 0.04 * width * wrong;
  const double center_y = 0.5 * height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double dx = (x + 0.5 - center_x) / radius, dy = (y + 0.5 - center_y) / radius;
      const double r2 = dx * dx + dy * dy;
      if (r2 >= 1.0) continue;
      const double dz = std::sqrt(1.0 - r2);
      const double shade = std::max(0.05, 0.5 * dx - 0.6 * dy + 0.6 * dz) * (1.0 - 0.4 * wrong);
      const double stripes = 0.6 + (1.0 - wrong) * 0.4 * std::sin(9.0 * dx + view);
      film.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)] =
          renderer::Rgba(shade * stripes, 0.7 * shade * stripes, 0.4 * shade, 1.0);
    }
  }
  return film;
}

inline std::string ViewName(int view) {
  const std::string number = std::to_string(view);
  return "IMG_" + std::string(4 - number.size(), '0') + number + ".jpg";
}

inline optim::ObservationSet MakeObservations(int num_views, int width, int height) {
  optim::ObservationSet set;
  set.mask_meaning = optim::MaskMeaning::kSilhouette;
  for (int i = 0; i < num_views; ++i) {
    const renderer::Film film = DiscFilm(width, height, i, 0.0);
    optim::View view;
    view.name = ViewName(i);
    view.photo = renderer::ColorImage(film);
    view.mask = renderer::CoverageImage(film);
    view.validation = i % 4 == 0;
    view.camera.width = width;
    view.camera.height = height;
    set.views.push_back(std::move(view));
  }
  return set;
}

/// Round `step` of a run of stages light, shape, colours with `rounds_per_stage` rounds each.
inline optim::RoundReport MakeRound(int step, int rounds_per_stage) {
  const std::vector<std::string> stages = {"light", "shape", "colours"};
  const int stage = std::min((step - 1) / rounds_per_stage, 2);
  optim::RoundReport r;
  r.step = step;
  r.stage = stages[static_cast<std::size_t>(stage)];
  r.stage_index = stage;
  r.num_stages = 3;
  r.round = step - stage * rounds_per_stage;
  r.max_rounds = rounds_per_stage;
  r.wall_s = 4.2 * step;
  r.cost_image = 0.08 * std::exp(-0.09 * step) + 2e-3 * (1.0 + 0.2 * std::sin(3.0 * step));
  r.cost_silhouette = 0.02 * std::exp(-0.12 * step) + 1e-4;
  r.cost_priors = 1e-4 * (1.0 + 0.02 * step);
  r.cost_total = r.cost_image + r.cost_silhouette + r.cost_priors;
  r.cost_change_rel = -0.09 * std::exp(-0.05 * step);
  r.gradient_max = 1e-2 / step;
  r.step_norm = 0.3 * std::exp(-0.05 * step);
  r.trust_radius = 2.0 * r.step_norm;
  r.accepted = step % 7 != 5;
  r.samples.spp = 8 + 4 * r.round;
  r.noise_relative = 0.15 + 0.008 * step;
  r.psnr_linear_fit = 31.0 - 14.0 * std::exp(-0.07 * step);
  r.psnr_linear_val = r.psnr_linear_fit - 0.5;
  r.iou_fit = 0.997 - 0.06 * std::exp(-0.1 * step);
  r.iou_val = r.iou_fit - 0.002;
  r.render_s = 0.9;
  r.jacobian_s = 2.2 + 0.3 * stage;
  r.linear_s = 0.4 + 0.2 * stage;
  r.jacobian_mb = 180.0 * (1 + stage);
  r.peak_rss_mb = 500.0 + 200.0 * stage;
  r.linear_solver = stage == 1 ? "cholesky" : "gram";
  return r;
}

inline optim::StageReport MakeStage(const std::string& name,
                                    int rounds,
                                    double wrong,
                                    const optim::ObservationSet& set) {
  optim::StageReport report;
  report.stage = name;
  report.rounds = rounds;
  report.wall_s = 4.5 * rounds;
  report.cost_before = 0.05 * (wrong + 0.3);
  report.cost_after = 0.05 * wrong + 1e-3;
  report.kept = rounds == 0 ? "start" : "averaged";
  report.stop_reason = rounds == 0 ? "" : "all rounds were used";
  double num_fit = 0.0, num_val = 0.0;
  report.iou_fit = report.iou_val = 0.0;
  for (std::size_t i = 0; i < set.views.size(); ++i) {
    optim::ViewReport view;
    view.name = set.views[i].name;
    view.validation = set.views[i].validation;
    view.psnr_srgb = 33.0 - 17.0 * wrong - (view.validation ? 0.6 : 0.0) -
                     0.3 * std::sin(static_cast<double>(i));
    view.psnr_linear = view.psnr_srgb - 1.2;
    view.iou = 0.996 - 0.1 * wrong;
    view.gain = std::exp2(0.25 * std::sin(2.3 * static_cast<double>(i)) * (1.0 - wrong));
    (view.validation ? num_val : num_fit) += 1.0;
    (view.validation ? report.psnr_srgb_val : report.psnr_srgb_fit) += view.psnr_srgb;
    (view.validation ? report.psnr_linear_val : report.psnr_linear_fit) += view.psnr_linear;
    (view.validation ? report.iou_val : report.iou_fit) += view.iou;
    report.views.push_back(view);
  }
  report.psnr_srgb_fit /= num_fit;
  report.psnr_linear_fit /= num_fit;
  report.iou_fit /= num_fit;
  report.psnr_srgb_val /= num_val;
  report.psnr_linear_val /= num_val;
  report.iou_val /= num_val;
  return report;
}

/// A sphere with vertex colours under a camera-fixed environment, a point and a directional light.
inline renderer::Scene MakeScene(const optim::ObservationSet& set) {
  renderer::Scene scene;
  renderer::SceneMesh mesh;
  mesh.name = "axe";
  mesh.mesh = renderer::MakeIcosphere(1, 0.1);
  renderer::SetUniformVertexColors({0.6, 0.4, 0.2}, mesh.mesh);
  scene.meshes.push_back(mesh);
  scene.materials.push_back(
      {.name = "paint", .bsdf = renderer::MetallicRoughnessBsdf{0.4, 0.0}, .vertex_colors = true});
  renderer::EnvironmentEmitter sky;
  sky.width = 16;
  sky.height = 8;
  sky.texels.clear();
  for (int i = 0; i < 16 * 8; ++i) {
    const double bright = 0.2 + std::exp(-0.02 * (i - 30) * (i - 30)) * 3.0;
    sky.texels.push_back({bright, 0.9 * bright, 0.7 * bright});
  }
  sky.intensity = {1.5, 1.5, 1.5};
  scene.emitters.push_back(
      {.name = "room", .frame = renderer::LightFrame::kCamera, .light = std::move(sky)});
  scene.emitters.push_back(
      {.name = "lamp", .light = renderer::PointEmitter{{0.0, 1.0, 0.0}, {2.0, 2.0, 2.0}}});
  scene.emitters.push_back({.name = "sun", .light = renderer::DirectionalEmitter{}});
  for (const optim::View& view : set.views) {
    renderer::Camera camera = view.camera;
    camera.name = view.name;
    camera.fx = camera.fy = 500.0;
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
    scene.sensors.push_back(camera);
  }
  return scene;
}

inline optim::FitSpec MakeSpec() {
  optim::FitSpec spec;
  const auto add = [&spec](const char* name, renderer::ParameterKind kind, int object) {
    optim::UnknownSpec& unknown = spec.unknowns.emplace_back();
    unknown.name = name;
    unknown.kind = kind;
    unknown.object = object;
    return &unknown;
  };
  add("axe.vertices", renderer::ParameterKind::kVertexPositions, 0);
  add("paint.roughness", renderer::ParameterKind::kRoughness, 0)->lower = 0.1;
  spec.unknowns.back().upper = 1.0;
  add("paint.metallic", renderer::ParameterKind::kMetallic, 0)->hold = true;
  spec.unknowns.back().lower = 0.0;
  spec.unknowns.back().upper = 1.0;
  add("room.intensity", renderer::ParameterKind::kLightIntensity, 0)->lower = 0.0;
  add("room.texels", renderer::ParameterKind::kEnvironmentTexels, 0)->lower = 0.0;
  add("exposure", renderer::ParameterKind::kExposure, -1);
  return spec;
}

}  // namespace pathfit::app
