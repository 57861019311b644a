#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/experiment/experiment.h"
#include "optim/observation/visual_hull.h"
#include "renderer/core/error.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_file.h"

namespace pathfit::app {
namespace {

using renderer::Mat3;
using renderer::Mesh;
using renderer::Rgb;
using renderer::SceneError;
using renderer::Vec3;

Vec3 ToVec3(const Triple& t) { return {t[0], t[1], t[2]}; }
Rgb ToRgb(const Triple& t) { return {t[0], t[1], t[2]}; }

Mat3 Rotation(const Triple& axis, double angle) {
  return renderer::RotationAboutAxis(renderer::Normalized(ToVec3(axis)), angle);
}

Mesh MakeInline(const InlineGeometry& g, const std::string& name) {
  Mesh mesh;
  std::transform(g.vertices.begin(), g.vertices.end(), std::back_inserter(mesh.positions), ToVec3);
  std::transform(g.colors.begin(), g.colors.end(), std::back_inserter(mesh.colors), ToRgb);
  const int count = static_cast<int>(g.vertices.size());
  for (const auto& t : g.triangles) {
    if (std::any_of(t.begin(), t.end(), [&](int i) { return i < 0 || i >= count; })) {
      throw SceneError("geometry '" + name + "': a triangle has a vertex index outside 0.." +
                       std::to_string(count - 1));
    }
    mesh.triangles.push_back({t[0], t[1], t[2]});
  }
  if (!mesh.colors.empty()) {
    mesh.color_triangles = mesh.triangles;
  }
  renderer::WeldPositions(mesh);
  return mesh;
}

/// The mesh of one geometry entry, before its transform.
class MeshMaker {
 public:
  MeshMaker(const GeometryConfig& config,
            const optim::ObservationSet& observations,
            std::vector<std::filesystem::path>& files)
      : config_(config), observations_(observations), files_(files) {}

  Mesh operator()(const FileGeometry& g) const {
    files_.push_back(g.path);
    return renderer::ReadMesh(g.path);
  }
  Mesh operator()(const SphereGeometry& g) const {
    return renderer::MakeIcosphere(g.subdivisions, g.radius);
  }
  Mesh operator()(const RectangleGeometry&) const { return renderer::MakeRectangle(); }
  Mesh operator()(const CubeGeometry&) const { return renderer::MakeCube(); }
  Mesh operator()(const InlineGeometry& g) const { return MakeInline(g, config_.name); }
  Mesh operator()(const VisualHullGeometry& g) const {
    return optim::CarveVisualHull(observations_, {.resolution = g.resolution});
  }

 private:
  const GeometryConfig& config_;
  const optim::ObservationSet& observations_;
  std::vector<std::filesystem::path>& files_;
};

Mesh BuildMesh(const GeometryConfig& config,
               const MaterialConfig& material,
               const optim::ObservationSet& observations,
               std::vector<std::filesystem::path>& files) {
  Mesh mesh = std::visit(MeshMaker(config, observations, files), config.geometry);
  const TransformConfig& t = config.transform;
  const Mat3 rotation = Rotation(t.axis, t.angle);
  const Mat3 linear{rotation.x * t.scale[0], rotation.y * t.scale[1], rotation.z * t.scale[2]};
  renderer::ApplyTransform({linear, ToVec3(t.translate)}, mesh);
  using Source = MaterialConfig::BaseColor;
  if (material.base_color_source == Source::kVertexConstant) {
    renderer::SetUniformVertexColors(ToRgb(material.base_color), mesh);
  } else if (material.base_color_source == Source::kVertexOfMesh && !mesh.HasColors()) {
    throw SceneError("geometry '" + config.name + "': material '" + material.name +
                     "' takes the mesh's own vertex colours, but it has none; give base_color: "
                     "{vertex: [r, g, b]}");
  }
  return mesh;
}

renderer::Material BuildMaterial(const MaterialConfig& config) {
  renderer::Material material;
  material.name = config.name;
  if (config.metallic_roughness) {
    material.bsdf = renderer::MetallicRoughnessBsdf{config.roughness, config.metallic};
  }
  material.base_color = ToRgb(config.base_color);
  material.vertex_colors = config.base_color_source != MaterialConfig::BaseColor::kConstant;
  material.two_sided = config.two_sided;
  return material;
}

renderer::EnvironmentEmitter BuildEnvironment(const LightConfig& config,
                                              std::vector<std::filesystem::path>& files) {
  renderer::EnvironmentEmitter light;
  light.frame_from_light = Rotation(config.axis, config.angle);
  light.intensity = ToRgb(config.intensity);
  if (config.type == LightConfig::Type::kConstant) {
    light.texels = {ToRgb(config.init)};
  } else if (config.file.empty()) {
    light.width = config.size_px[0];
    light.height = config.size_px[1];
    light.texels.assign(
        static_cast<std::size_t>(light.width) * static_cast<std::size_t>(light.height),
        ToRgb(config.init));
  } else {
    files.push_back(config.file);
    const renderer::DecodedImage decoded = renderer::ReadImageFile(config.file, false);
    if (!decoded.linear) {
      throw SceneError(
          "light '" + config.name + "': " + config.file.string() +
          " is an 8- or 16-bit picture; an environment needs linear radiance (.exr or .hdr)");
    }
    light.width = decoded.image.width;
    light.height = decoded.image.height;
    light.texels.clear();
    for (int y = 0; y < light.height; ++y) {
      for (int x = 0; x < light.width; ++x) {
        light.texels.push_back(decoded.image.ColorAt(x, y));
      }
    }
  }
  return light;
}

renderer::Emitter BuildEmitter(const LightConfig& config,
                               std::vector<std::filesystem::path>& files) {
  renderer::Emitter emitter;
  emitter.name = config.name;
  emitter.frame =
      config.camera_frame ? renderer::LightFrame::kCamera : renderer::LightFrame::kWorld;
  switch (config.type) {
    case LightConfig::Type::kEnvironment:
    case LightConfig::Type::kConstant:
      emitter.light = BuildEnvironment(config, files);
      break;
    case LightConfig::Type::kPoint:
      emitter.light = renderer::PointEmitter{ToVec3(config.position), ToRgb(config.intensity)};
      break;
    case LightConfig::Type::kDirectional:
      emitter.light = renderer::DirectionalEmitter{renderer::Normalized(ToVec3(config.direction)),
                                                   ToRgb(config.intensity)};
      break;
  }
  return emitter;
}

renderer::PerspectiveCamera BuildSensor(const SensorConfig& config) {
  renderer::PerspectiveCamera camera;
  camera.name = config.name;
  camera.width = config.size_px[0];
  camera.height = config.size_px[1];
  camera.fx = config.focal_px[0];
  camera.fy = config.focal_px[1];
  camera.cx = config.principal_point_px[0];
  camera.cy = config.principal_point_px[1];
  camera.distortion = {config.k1, config.k2, config.k3, config.p1, config.p2};
  camera.gain = std::exp2(config.exposure_ev);
  if (config.look_at) {
    try {
      camera.world_from_camera =
          renderer::LookAt(ToVec3(config.origin), ToVec3(config.target), ToVec3(config.up));
    } catch (const std::invalid_argument& e) {
      throw SceneError("sensor '" + config.name + "': " + e.what());
    }
  } else {
    const auto& m = config.world_from_camera;
    const auto column = [&](std::size_t j) { return Vec3{m[0][j], m[1][j], m[2][j]}; };
    camera.world_from_camera = {{column(0), column(1), column(2)}, column(3)};
  }
  if (config.crop_px) {
    const auto& c = *config.crop_px;
    camera = renderer::CroppedCamera(camera, c[0], c[1], c[2], c[3]);
  }
  return camera;
}

}  // namespace

renderer::Scene BuildScene(const ExperimentConfig& config,
                           const optim::ObservationSet& observations,
                           std::vector<std::filesystem::path>& input_files) {
  renderer::Scene scene;
  for (const MaterialConfig& material : config.materials) {
    scene.materials.push_back(BuildMaterial(material));
  }
  for (const GeometryConfig& geometry : config.geometry) {
    const auto material = std::find_if(config.materials.begin(),
                                       config.materials.end(),
                                       [&](const auto& m) { return m.name == geometry.material; });
    scene.meshes.push_back({geometry.name,
                            BuildMesh(geometry, *material, observations, input_files),
                            static_cast<int>(material - config.materials.begin())});
  }
  for (const LightConfig& light : config.lights) {
    scene.emitters.push_back(BuildEmitter(light, input_files));
    if (light.type == LightConfig::Type::kEnvironment ||
        light.type == LightConfig::Type::kConstant) {
      scene.environment_visible = light.visible;
    }
  }
  if (observations.views.empty()) {
    for (const SensorConfig& sensor : config.sensors) {
      scene.sensors.push_back(BuildSensor(sensor));
    }
  }
  for (const optim::View& view : observations.views) {
    scene.sensors.push_back(view.camera);
    scene.sensors.back().name = view.name;
  }
  renderer::ValidateScene(scene);
  return scene;
}

}  // namespace pathfit::app
