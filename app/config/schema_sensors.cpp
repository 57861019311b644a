#include <algorithm>
#include <cmath>

#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"
#include "app/config/schema_parts.h"

namespace pathfit::app {
namespace {

// Rows of a pose may be rounded by whoever wrote them.
constexpr double kRotationTolerance = 1e-4;
using Shape = renderer::PixelFilter::Shape;

void CheckLookAt(SensorConfig& sensor, const CheckedMap& map) {
  if (map.Find("origin_m") == nullptr || map.Find("target_m") == nullptr) return;
  const Triple view = Minus(sensor.target, sensor.origin);
  if (IsZero(view)) {
    map.Report("target_m", "the target is where the camera stands");
  } else if (AreParallel(view, sensor.up)) {
    const YamlNode* up = map.Find("up");
    const bool given = up != nullptr && up->place.source != Place::Source::kDefault;
    map.Report("up", given ? *up : map.node, "up must not be zero or along the viewing direction");
  }
}

void CheckPose(SensorConfig& sensor, const CheckedMap& map) {
  sensor.look_at = map.Find("world_from_camera") == nullptr || map.Find("look_at") != nullptr;
  if (sensor.look_at) return;
  const auto& m = sensor.world_from_camera;
  double error = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double dot =
          m[0].at(i) * m[0].at(j) + m[1].at(i) * m[1].at(j) + m[2].at(i) * m[2].at(j);
      error = std::max(error, std::abs(dot - (i == j ? 1.0 : 0.0)));
    }
  }
  const Triple z = Cross({m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]});
  const bool mirrored = z[0] * m[0][2] + z[1] * m[1][2] + z[2] * m[2][2] < 0.0;
  const bool last_row = m[3] == std::array<double, 4>{0.0, 0.0, 0.0, 1.0};
  if (error <= kRotationTolerance && !mirrored && last_row) return;
  map.Report("world_from_camera",
             "the first three columns must be a rotation (no scale, no mirror) and the last row "
             "[0, 0, 0, 1]");
}

SchemaNode PoseSchema() {
  return Map("pose",
             {Map("look_at",
                  {Point("origin_m", &SensorConfig::origin) | Doc("Place of the camera.") |
                       Required(),
                   Point("target_m", &SensorConfig::target) |
                       Doc("What is in the middle of the picture.") | Required(),
                   Key("up", &SensorConfig::up) | Doc("What is up in the picture.")}) |
                  Doc("Pose by what is looked at.") | OneOf("pose") | Check(CheckLookAt),
              Key("world_from_camera", &SensorConfig::world_from_camera) |
                  Doc("4 rows of a rigid transform; camera: x right, y up, looking along -z.") |
                  From(-kMaxLength, kMaxLength) | OneOf("pose")}) |
         Doc("Where the camera is.") | Required() | Check(CheckPose);
}

SchemaNode FilterSchema() {
  constexpr double kMaxRadius = 16.0;
  constexpr auto kFilter = &SensorConfig::filter;
  const auto shapes = [](const char* key) {
    return Choice(key,
                  {{"box", Shape::kBox}, {"tent", Shape::kTent}, {"gaussian", Shape::kGaussian}},
                  kFilter,
                  &renderer::PixelFilter::shape);
  };
  return Either("filter",
                {shapes(""),
                 Map("",
                     {shapes("type") | Doc("Shape.") | Required(),
                      Key("radius_px", kFilter, &renderer::PixelFilter::radius) |
                          Doc("Half its width.") | From(0.5, kMaxRadius) | Unit("pixels") |
                          DefaultIs("1 for a tent, 2 for a Gaussian") |
                          When("type", {"tent", "gaussian"}),
                      Key("sigma_px", kFilter, &renderer::PixelFilter::sigma) |
                          Doc("Standard deviation; it is cut at the radius.") |
                          From(0.1, kMaxRadius) | Unit("pixels") | When("type", {"gaussian"})})}) |
         Doc("How samples become pixels: `box` is the mean over the pixel, `tent` and `gaussian` "
             "reach into its neighbours. A name, or a map of the following.") |
         Default("box");
}

SchemaNode DistortionSchema() {
  const auto coefficient = [](const char* key, double renderer::LensDistortion::*value) {
    return Key(key, value) | Doc("Coefficient of OpenCV's model.");
  };
  return MapOf("distortion",
               {coefficient("k1", &renderer::LensDistortion::k1),
                coefficient("k2", &renderer::LensDistortion::k2),
                coefficient("k3", &renderer::LensDistortion::k3),
                coefficient("p1", &renderer::LensDistortion::p1),
                coefficient("p2", &renderer::LensDistortion::p2)},
               &SensorConfig::distortion) |
         Doc("Brown's lens distortion.") | Always() | When("type", {"perspective"});
}

SchemaNode VignettingSchema() {
  const auto coefficient = [](const char* key, double renderer::Vignetting::*value) {
    return Key(key, value) | Doc("Of the 2nd, 4th or 6th power of the distance from the principal "
                                 "point; -0.3 darkens the corners by 26 %.");
  };
  return MapOf("vignetting",
               {coefficient("v1", &renderer::Vignetting::v1),
                coefficient("v2", &renderer::Vignetting::v2),
                coefficient("v3", &renderer::Vignetting::v3)},
               &SensorConfig::vignetting) |
         Doc("How the lens darkens its pictures: times exp(v1 r^2 + v2 r^4 + v3 r^6), where r is "
             "1 in the corners and 0 at the principal point. It belongs to the whole picture, "
             "before `crop_px`.") |
         Always();
}

void CompleteIntrinsics(SensorConfig& sensor, const CheckedMap& map) {
  const double width = sensor.size_px[0];
  const double height = sensor.size_px[1];
  if (map.Find("fov_deg") != nullptr) {
    const double length = FocalLength(sensor.fov, sensor.fov_axis, width, height);
    sensor.focal_px = {length, length};
  } else if (map.Find("height_m") != nullptr) {
    sensor.focal_px = {height / sensor.height_m, height / sensor.height_m};
  }
  if (map.Find("principal_point_px") == nullptr && map.Find("size_px") != nullptr) {
    sensor.principal_point_px = {0.5 * width, 0.5 * height};
    SetDefault(map.node, "principal_point_px", binding::Write(sensor.principal_point_px));
  }
}

void CompleteFilter(SensorConfig& sensor, const CheckedMap& map) {
  YamlNode* filter = map.Find("filter");
  if (filter == nullptr || sensor.filter.shape == Shape::kBox) return;
  if (filter->IsMap() && filter->Find("radius_px") != nullptr) return;
  sensor.filter.radius = sensor.filter.shape == Shape::kTent ? 1.0 : 2.0;
  if (filter->IsMap()) SetDefault(*filter, "radius_px", binding::Write(sensor.filter.radius));
}

void CheckCrop(const SensorConfig& sensor, const CheckedMap& map) {
  if (!sensor.crop_px) return;
  const std::array<int, 4>& c = *sensor.crop_px;
  const bool empty = c[2] < 1 || c[3] < 1;
  const bool outside = c[0] + c[2] > sensor.size_px[0] || c[1] + c[3] > sensor.size_px[1];
  if (!empty && (map.Find("size_px") == nullptr || !outside)) return;
  map.Report(
      "crop_px",
      fmt::format(
          "the part [x, y, width, height] must not be empty and must lie inside the {}x{} picture",
          sensor.size_px[0],
          sensor.size_px[1]));
}

void CheckSensor(SensorConfig& sensor, const CheckedMap& map) {
  CompleteIntrinsics(sensor, map);
  CompleteFilter(sensor, map);
  CheckCrop(sensor, map);
}

}  // namespace

SchemaNode SensorsSchema() {
  return NamedMap(
             "sensors",
             "SENSOR",
             Map("",
                 {Choice("type",
                         {{"perspective", renderer::ProjectionKind::kPerspective},
                          {"orthographic", renderer::ProjectionKind::kOrthographic}},
                         &SensorConfig::projection) |
                      Doc("`orthographic`: parallel rays from the plane of the camera."),
                  Size("size_px", &SensorConfig::size_px) | Doc("Size of the whole picture.") |
                      Required(),
                  Key("focal_px", &SensorConfig::focal_px) |
                      Doc("Focal length, or one for x and one for y.") | Above(0.0) | OrOne() |
                      Unit("pixels") | OneOf("focal") | When("type", {"perspective"}),
                  Degrees("fov_deg", &SensorConfig::fov) | Doc("Angle of view.") |
                      Between(0.0, 180.0) | OneOf("focal") | When("type", {"perspective"}),
                  Choice("fov_axis", FovAxes(), &SensorConfig::fov_axis) |
                      Doc("Along which side of the picture `fov_deg` is measured.") |
                      Needs("fov_deg") | When("type", {"perspective"}),
                  Key("height_m", &SensorConfig::height_m) |
                      Doc("Height of what is seen; pixels are square.") | Above(0.0) |
                      Unit("metres") | Required() | When("type", {"orthographic"}),
                  Key("principal_point_px", &SensorConfig::principal_point_px) |
                      Doc("From the top-left corner of the picture; the first pixel's centre is "
                          "0.5, 0.5.") |
                      Unit("pixels") | DefaultIs("middle of the picture"),
                  DistortionSchema(),
                  VignettingSchema(),
                  PoseSchema(),
                  Key("crop_px", &SensorConfig::crop_px) |
                      Doc("Part to render: x, y, width, height.") | From(0, 32768) |
                      Unit("pixels") | DefaultIs("the whole picture"),
                  FilterSchema(),
                  Key("exposure_ev", &SensorConfig::exposure_ev) |
                      Doc("Brightness factor as a power of two.") | From(-20, 20) | Unit("EV")}) |
                 Check(CheckSensor),
             &ExperimentConfig::sensors) |
         Doc("Cameras of a scene without photos.");
}

}  // namespace pathfit::app
