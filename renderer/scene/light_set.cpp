#include "renderer/scene/light_set.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/check.h"
#include "renderer/emitter/projector_kernel.h"
#include "renderer/emitter/spot_kernel.h"
#include "renderer/scene/world.h"

namespace pathfit::renderer {
namespace {

// Rows of lookups per triangle when a texture is averaged over it, and texels between them.
constexpr double kMaxLookupRows = 16.0;
constexpr double kTexelsPerLookup = 2.0;

const Texture* TextureAt(const Scene& scene, int index) {
  return index < 0 ? nullptr : &scene.textures[static_cast<std::size_t>(index)];
}

struct TriangleUv {
  Vec2 uv0, by_b1, by_b2;
  [[nodiscard]] Vec2 At(double b1, double b2) const { return uv0 + by_b1 * b1 + by_b2 * b2; }
};
TriangleUv UvOf(const Mesh& mesh, std::int32_t triangle) {
  const Triangle& t = mesh.uv_triangles[static_cast<std::size_t>(triangle)];
  const Vec2 uv0 = mesh.uvs[static_cast<std::size_t>(t[0])];
  return {uv0,
          mesh.uvs[static_cast<std::size_t>(t[1])] - uv0,
          mesh.uvs[static_cast<std::size_t>(t[2])] - uv0};
}

// Mean luminance of intensity * texture over a triangle, by lookups at the middles of equal small
// triangles.
double MeanLuminance(const Texture& texture, const Rgb& intensity, const TriangleUv& uv) {
  const double extent_u = std::max(std::abs(uv.by_b1.x), std::abs(uv.by_b2.x)) * texture.width;
  const double extent_v = std::max(std::abs(uv.by_b1.y), std::abs(uv.by_b2.y)) * texture.height;
  const int rows = static_cast<int>(
      std::clamp(std::ceil(std::max(extent_u, extent_v) / kTexelsPerLookup), 1.0, kMaxLookupRows));
  double sum = 0.0;
  const auto add = [&](double b1, double b2) {
    const Rgb radiance = intensity * TextureValue(texture, uv.At(b1 / rows, b2 / rows));
    sum += std::max(0.0, Luminance(radiance));
  };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; i + j < rows; ++j) {
      add(i + 1.0 / 3.0, j + 1.0 / 3.0);
      if (i + j + 1 < rows) {
        add(i + 2.0 / 3.0, j + 2.0 / 3.0);
      }
    }
  }
  return sum / (rows * rows);
}

std::vector<double> TriangleBrightness(const World& world, const AreaEmitter& light) {
  const Mesh& mesh = world.mesh(light.mesh);
  const double sides = light.two_sided ? 2.0 : 1.0;
  const Texture* texture = TextureAt(world.scene(), light.texture);
  std::vector<double> brightness(mesh.triangles.size(), sides * Luminance(light.intensity));
  if (texture != nullptr) {
    for (std::size_t i = 0; i < brightness.size(); ++i) {
      const TriangleUv uv = UvOf(mesh, static_cast<std::int32_t>(i));
      brightness[i] = sides * MeanLuminance(*texture, light.intensity, uv);
    }
  }
  return brightness;
}

// Adds the lights of a scene to a set, one kind each.
struct LightAdder {
  const World& world;
  const Emitter& emitter;
  int index;
  Transform world_from_frame;
  Mat3 turn;  // world_from_frame times the emitter's rotation
  LightSet& set;

  void operator()(const EnvironmentEmitter& light) const {
    const auto& sampler = world.light_samplers().environment();
    PATHFIT_CHECK(sampler.has_value());
    const Mat3 world_from_light = turn * light.frame_from_light;
    set.environment = LightSet::Environment{
        index, &light, &*sampler, world_from_light, Transposed(world_from_light)};
  }
  void operator()(const PointEmitter& light) const {
    AddPoint(light.position, world_from_frame.linear, nullptr);
  }
  void operator()(const DirectionalEmitter& light) const {
    set.directionals.push_back({index, -(turn * light.direction), light.irradiance});
  }
  void operator()(const SpotEmitter& light) const {
    AddPoint(light.position, turn * light.frame_from_light, nullptr);
  }
  void operator()(const ProjectorEmitter& light) const {
    AddPoint(
        light.position, turn * light.frame_from_light, TextureAt(world.scene(), light.texture));
  }
  void operator()(const AreaEmitter& light) const {
    set.area_of_mesh[static_cast<std::size_t>(light.mesh)] = static_cast<int>(set.areas.size());
    set.areas.push_back(
        {index, &light, TextureAt(world.scene(), light.texture), &world.mesh(light.mesh)});
  }

 private:
  void AddPoint(const Vec3& position, const Mat3& world_from_light, const Texture* texture) const {
    set.points.push_back({index,
                          world_from_frame.Point(position),
                          world_from_light,
                          Transposed(world_from_light),
                          &emitter,
                          texture});
  }
};

// Rays are tested against the boxes of so many lights, and against one of all otherwise.
constexpr std::size_t kFewAreas = 8;

/// Boxes for LightSet::MayMeetArea: wider than what the ray caster rounds there.
std::vector<Box> BoxesOf(const std::vector<LightSet::AreaLight>& areas, const RayCaster& caster) {
  std::vector<Box> boxes;
  for (const LightSet::AreaLight& area : areas) {
    Box box = caster.Bounds(area.light->mesh);
    const double far = 2.0 * box.HalfDiagonal() + Norm(box.low - caster.Center());
    const double offset = std::max(RayCaster::kRayOffset * far, caster.Offset(box.low));
    box.low -= Vec3{1, 1, 1} * offset;
    box.high += Vec3{1, 1, 1} * offset;
    if (boxes.empty() || areas.size() <= kFewAreas) {
      boxes.push_back(box);
    } else {
      boxes.front().Include(box);
    }
  }
  return boxes;
}

// The texture's value everywhere for lights without one.
TextureLookup WhiteLookup() {
  TextureLookup lookup;
  lookup.value = {1.0, 1.0, 1.0};
  return lookup;
}

// Cosine between a direction in the light's own frame and its axis -z.
double AxisCosine(const LightSet::PointLight& light, const Vec3& w) {
  return -Dot(light.world_from_light.z, w);
}

IntensityPartials SpotDerivative(const LightSet::PointLight& light,
                                 const SpotEmitter& spot,
                                 const Vec3& w) {
  const double cos_axis = AxisCosine(light, w);
  const SpotFalloffPartials falloff =
      SpotFalloffDerivative(cos_axis, spot.inner_angle, spot.outer_angle);
  IntensityPartials out;
  out.value = spot.intensity * falloff.value;
  out.factor = Rgb::Constant(falloff.value);
  const Vec3 d_w = -(light.world_from_light.z + w * cos_axis) * falloff.d_cos;
  for (int c = 0; c < 3; ++c) {
    out.d_w[static_cast<std::size_t>(c)] = d_w * spot.intensity[c];
  }
  out.d_inner = spot.intensity * falloff.d_inner;
  out.d_outer = spot.intensity * falloff.d_outer;
  return out;
}

IntensityPartials ProjectedDerivative(const LightSet::PointLight& light,
                                      const ProjectorEmitter& projector,
                                      const Vec3& w) {
  IntensityPartials out;
  const ProjectorPartials p = ProjectorDerivative(
      light.light_from_world * w, projector.tan_half_width, projector.tan_half_height);
  if (!p.point.inside) {
    return out;
  }
  out.lookup = light.texture != nullptr ? LookUpTexture(*light.texture, {p.point.u, p.point.v})
                                        : WhiteLookup();
  out.texture_scale = p.point.scale;
  out.factor = out.lookup.value * p.point.scale;
  out.value = projector.intensity * out.factor;
  for (int c = 0; c < 3; ++c) {
    const Vec3 in_light = p.d_scale * out.lookup.value[c] +
                          (p.d_u * out.lookup.du[c] + p.d_v * out.lookup.dv[c]) * p.point.scale;
    out.d_w[static_cast<std::size_t>(c)] =
        light.world_from_light * (in_light * projector.intensity[c]);
  }
  return out;
}

}  // namespace

void LightSamplers::Reset(const World& world) {
  environment_.reset();
  areas_.clear();
  for (const Emitter& emitter : world.scene().emitters) {
    if (const auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light)) {
      environment_.emplace(*environment);
    }
  }
}

const AreaSampler& LightSamplers::AreasOf(const World& world,
                                          const std::vector<int>& emitters) const {
  const std::lock_guard lock(mutex_);
  const auto [entry, is_new] = areas_.try_emplace(emitters);
  if (is_new) {
    for (const int index : emitters) {
      const Emitter& emitter = world.scene().emitters[static_cast<std::size_t>(index)];
      const auto& area = std::get<AreaEmitter>(emitter.light);
      entry->second.AddMesh(
          area.mesh, world.mesh(area.mesh), TriangleBrightness(world, area), area.two_sided);
    }
    entry->second.Finish();
  }
  return entry->second;
}

LightSet LightSet::Make(const World& world,
                        const Transform& world_from_camera,
                        const std::vector<int>& lights_off) {
  const Scene& scene = world.scene();
  LightSet set;
  set.environment_visible = scene.environment_visible;
  set.area_of_mesh.assign(scene.meshes.size(), -1);
  for (int i = 0; i < static_cast<int>(scene.emitters.size()); ++i) {
    if (IsOff(lights_off, i)) {
      continue;
    }
    const Emitter& emitter = scene.emitters[static_cast<std::size_t>(i)];
    const Transform world_from_frame =
        emitter.frame == LightFrame::kCamera ? world_from_camera : Transform{};
    std::visit(LightAdder{world,
                          emitter,
                          i,
                          world_from_frame,
                          world_from_frame.linear * RotationFromVector(emitter.rotation),
                          set},
               emitter.light);
  }
  if (!set.areas.empty()) {
    std::vector<int> emitters;
    for (const AreaLight& area : set.areas) {
      emitters.push_back(area.emitter);
    }
    const AreaSampler& areas = world.light_samplers().AreasOf(world, emitters);
    set.area_sampler = areas.Empty() ? nullptr : &areas;
    set.area_boxes = BoxesOf(set.areas, world.caster());
  }
  return set;
}

Rgb AreaRadiance(
    const LightSet::AreaLight& light, std::int32_t triangle, double b1, double b2, double side) {
  if (!(side > 0.0) && !light.light->two_sided) {
    return {};
  }
  if (light.texture == nullptr) {
    return light.light->intensity;
  }
  return light.light->intensity *
         TextureValue(*light.texture, UvOf(*light.mesh, triangle).At(b1, b2));
}

AreaRadiancePartials AreaRadianceDerivative(
    const LightSet::AreaLight& light, std::int32_t triangle, double b1, double b2, double side) {
  AreaRadiancePartials out;
  if (!(side > 0.0) && !light.light->two_sided) {
    return out;
  }
  if (light.texture == nullptr) {
    out.lookup = WhiteLookup();
  } else {
    out.lookup = LookUpTexture(*light.texture, UvOf(*light.mesh, triangle).At(b1, b2));
  }
  out.factor = out.lookup.value;
  out.value = light.light->intensity * out.factor;
  return out;
}

Rgb IntensityTowards(const LightSet::PointLight& light, const Vec3& w) {
  if (const auto* spot = std::get_if<SpotEmitter>(&light.light->light)) {
    return spot->intensity *
           SpotFalloff(AxisCosine(light, w), spot->inner_angle, spot->outer_angle);
  }
  if (const auto* projector = std::get_if<ProjectorEmitter>(&light.light->light)) {
    const ProjectorPoint<double> point = ProjectorPointTowards(
        light.light_from_world * w, projector->tan_half_width, projector->tan_half_height);
    if (!point.inside) {
      return {};
    }
    const Rgb picture = light.texture != nullptr ? TextureValue(*light.texture, {point.u, point.v})
                                                 : Rgb{1.0, 1.0, 1.0};
    return projector->intensity * picture * point.scale;
  }
  return std::get<PointEmitter>(light.light->light).intensity;
}

IntensityPartials IntensityDerivative(const LightSet::PointLight& light, const Vec3& w) {
  if (const auto* spot = std::get_if<SpotEmitter>(&light.light->light)) {
    return SpotDerivative(light, *spot, w);
  }
  if (const auto* projector = std::get_if<ProjectorEmitter>(&light.light->light)) {
    return ProjectedDerivative(light, *projector, w);
  }
  IntensityPartials out;
  out.value = std::get<PointEmitter>(light.light->light).intensity;
  out.factor = {1.0, 1.0, 1.0};
  return out;
}

}  // namespace pathfit::renderer
