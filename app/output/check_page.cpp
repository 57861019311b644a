#include "app/output/check_page.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include <fmt/format.h>

#include "app/output/parameter_table.h"
#include "app/output/report.h"
#include "app/output/report_images.h"
#include "app/output/sha256.h"
#include "app/output/viewed_model.h"
#include "renderer/io/image_file.h"

namespace pathfit::app {
namespace {

using renderer::Emitter;
using renderer::LightFrame;
using renderer::Scene;
using renderer::Transform;
using renderer::Vec3;

constexpr int kJpegQuality = 85;
constexpr std::size_t kManyViews = 60;  // from which on photos are small
constexpr int kManyViewsPx = 256;
constexpr std::size_t kMaxModelBytes = 4'000'000;
constexpr double kAxisLength = 0.5;  // of half the object's diagonal
constexpr double kArrowLength = 0.8;

/// Where a light is, in its frame: a place, or the direction towards it; nothing for environments.
struct LightPlace {
  std::optional<Vec3> position;
  std::optional<Vec3> direction;
};

LightPlace PlaceInFrame(const Emitter& emitter, const Scene& scene) {
  LightPlace place;
  std::visit(
      [&](const auto& light) {
        using Light = std::decay_t<decltype(light)>;
        if constexpr (std::is_same_v<Light, renderer::DirectionalEmitter>) {
          place.direction = -(renderer::RotationFromVector(emitter.rotation) * light.direction);
        } else if constexpr (std::is_same_v<Light, renderer::AreaEmitter>) {
          const auto& mesh = scene.meshes.at(static_cast<std::size_t>(light.mesh));
          place.position = renderer::BoxAround(renderer::WorldMesh(mesh).positions).Middle();
        } else if constexpr (!std::is_same_v<Light, renderer::EnvironmentEmitter>) {
          place.position = light.position;
        }
      },
      emitter.light);
  return place;
}

/// Projects into the low resolution of a view's check.
class ViewProjection {
 public:
  ViewProjection(const renderer::Camera& camera, const ViewStart& start)
      : model_(camera),
        x_scale_(static_cast<double>(start.width) / camera.width),
        y_scale_(static_cast<double>(start.height) / camera.height) {}
  [[nodiscard]] const Transform& Pose() const { return model_.Pose(); }
  /// null where it is not seen.
  [[nodiscard]] Json Pixel(const Vec3& x) const {
    const auto seen = model_.Project(x);
    return seen ? Json::array({Tenths(seen->u * x_scale_), Tenths(seen->v * y_scale_)}) : Json();
  }
  /// From a point in a direction; null unless both ends are seen.
  [[nodiscard]] Json Arrow(const Vec3& from, const Vec3& by) const {
    Json a = Pixel(from), b = Pixel(from + by);
    return a.is_null() || b.is_null() ? Json() : Json::array({std::move(a), std::move(b)});
  }
  static double Tenths(double value) { return std::round(10.0 * value) / 10.0; }

 private:
  renderer::CameraModel model_;
  double x_scale_, y_scale_;
};

std::string SvgPath(const std::vector<OutlinePiece>& pieces) {
  std::string path;
  for (const auto& [from, to] : pieces) {
    path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", from.x, from.y, to.x, to.y);
  }
  return path;
}

Json LightsJson(const Scene& scene,
                const renderer::Camera& camera,
                const ViewProjection& projection,
                const renderer::Box& box) {
  Json lights = Json::array();
  for (std::size_t i = 0; i < scene.emitters.size(); ++i) {
    const Emitter& emitter = scene.emitters[i];
    if (renderer::IsOff(camera.lights_off, static_cast<int>(i))) continue;
    LightPlace place = PlaceInFrame(emitter, scene);
    const Transform& pose = projection.Pose();
    const bool follows = emitter.frame == LightFrame::kCamera;
    const Vec3 middle = box.Middle();
    Json at;
    if (place.position) {
      const Vec3 x = follows ? pose.Point(*place.position) : *place.position;
      at = projection.Pixel(x);
      place.direction = x - middle;
    } else if (place.direction && follows) {
      place.direction = pose.linear * *place.direction;
    }
    Json arrow;
    if (place.direction && Norm(*place.direction) > 0.0) {
      const double length = kArrowLength * box.HalfDiagonal();
      arrow = projection.Arrow(middle, *place.direction * (length / Norm(*place.direction)));
    }
    lights.push_back({{"name", emitter.name}, {"at", std::move(at)}, {"arrow", std::move(arrow)}});
  }
  return lights;
}

Json ViewJson(const Experiment& experiment, const StartCheck& start, std::size_t index) {
  const optim::View& view = experiment.observations.views[index];
  const ViewStart& checked = start.views[index];
  const renderer::Camera& camera = experiment.scene.sensors[index];
  const ViewProjection projection(camera, checked);
  const int px = start.views.size() < kManyViews ? kThumbnailPx : kManyViewsPx;
  const std::vector<unsigned char> jpeg =
      renderer::EncodeJpeg(EncodedImage(ReducedImage(view.photo.Unpack(), px)), kJpegQuality);
  Json json = {
      {"index", index},
      {"name", view.name},
      {"validation", view.validation},
      {"size", Json::array({checked.width, checked.height})},
      {"iou", ToJson(checked.iou)},
      {"covered", checked.covered},
      {"pictures", {{"photo", DataUri({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()})}}},
      {"outline", SvgPath(checked.outline)},
      {"mask", SvgPath(checked.mask_outline)},
      {"axes", Json::array()},
      {"lights", Json::array()}};
  if (experiment.scene.meshes.empty()) return json;
  for (int i = 0; i < 3; ++i) {
    Vec3 axis;
    axis[i] = kAxisLength * start.box.HalfDiagonal();
    json["axes"].push_back(projection.Arrow(start.box.Middle(), axis));
  }
  json["lights"] = LightsJson(experiment.scene, camera, projection, start.box);
  return json;
}

Json ModelJson(const Experiment& experiment) {
  if (experiment.scene.meshes.empty() || experiment.observations.views.empty()) return nullptr;
  Json model = ViewedModel(experiment.scene, experiment.observations, {});
  const std::size_t size = JsonText(model, -1).size();
  if (size > kMaxModelBytes) {
    return {{"start", nullptr},
            {"result", nullptr},
            {"note",
             fmt::format("The start is not shown: it would take {:.1f} MB of this page.",
                         1e-6 * static_cast<double>(size))}};
  }
  return {{"start", nullptr}, {"result", std::move(model)}, {"note", ""}};
}

}  // namespace

std::string PlaceOfLight(const Emitter& emitter, const Scene& scene) {
  const LightPlace place = PlaceInFrame(emitter, scene);
  const auto numbers = [](const Vec3& v) {
    return fmt::format("[{:.3g}, {:.3g}, {:.3g}]", v.x + 0.0, v.y + 0.0, v.z + 0.0);  // no -0
  };
  if (place.position) return "at " + numbers(*place.position);
  if (place.direction) return "from the direction " + numbers(*place.direction);
  return "all around";
}

Json CheckJson(const ExperimentConfig& config,
               const Experiment& experiment,
               const StartCheck& start,
               Json summary) {
  Json lights = Json::array();
  const auto& sensors = experiment.scene.sensors;
  for (std::size_t i = 0; i < experiment.scene.emitters.size(); ++i) {
    const Emitter& emitter = experiment.scene.emitters[i];
    const auto shines = std::ranges::count_if(sensors, [&](const renderer::Camera& camera) {
      return !renderer::IsOff(camera.lights_off, static_cast<int>(i));
    });
    lights.push_back({{"name", emitter.name},
                      {"kind", renderer::LightWord(emitter)},
                      {"frame", emitter.frame == LightFrame::kCamera ? "camera" : "world"},
                      {"place", PlaceOfLight(emitter, experiment.scene)},
                      {"photos", shines}});
  }
  Json parameters = Json::array();
  for (const ParameterSummary& parameter :
       SummarizeParameters(experiment.fit, experiment.scene, experiment.scene)) {
    parameters.push_back(ToJson(parameter));
  }
  Json views = Json::array();
  for (std::size_t i = 0; i < start.views.size(); ++i) {
    views.push_back(ViewJson(experiment, start, i));
  }
  return {{"check", std::move(summary)},
          {"name", config.name},
          {"config_path", config.path.string()},
          {"views", std::move(views)},
          {"lights", std::move(lights)},
          {"parameters", std::move(parameters)},
          {"attributions", experiment.attributions},
          {"config", config.given_text},
          {"environment", {{"initial", nullptr}, {"final", nullptr}}},
          {"model", ModelJson(experiment)}};
}

}  // namespace pathfit::app
