#include "renderer/scene/parameter_values.h"

namespace pathfit::renderer {
namespace {

using Scalars = std::vector<double*>;

Scalars Of(Vec3& v) { return {&v.x, &v.y, &v.z}; }
Scalars Of(Rgb& c) { return {&c.r, &c.g, &c.b}; }

template <class List>
Scalars OfAll(List& list) {
  Scalars all;
  all.reserve(3 * list.size());
  for (auto& item : list) {
    for (int c = 0; c < 3; ++c) {
      all.push_back(&item[c]);
    }
  }
  return all;
}

Scalars OfUvs(std::vector<Vec2>& uvs) {
  Scalars all;
  all.reserve(2 * uvs.size());
  for (Vec2& uv : uvs) {
    all.push_back(&uv.x);
    all.push_back(&uv.y);
  }
  return all;
}

Scalars OfTexels(Texture& texture) {
  if (!texture.scalar) {
    return OfAll(texture.texels);
  }
  Scalars all;
  all.reserve(texture.texels.size());
  for (Rgb& texel : texture.texels) {
    all.push_back(&texel.r);
  }
  return all;
}

Scalars OfMesh(SceneMesh& mesh, ParameterKind kind) {
  switch (kind) {
    case ParameterKind::kVertexPositions:
      return OfAll(mesh.mesh.positions);
    case ParameterKind::kVertexNormals:
      return OfAll(mesh.mesh.normals);
    case ParameterKind::kUvs:
      return OfUvs(mesh.mesh.uvs);
    case ParameterKind::kVertexColors:
      return OfAll(mesh.mesh.colors);
    case ParameterKind::kObjectTranslation:
      return Of(mesh.pose.translation);
    case ParameterKind::kObjectRotation:
      return Of(mesh.pose.rotation);
    case ParameterKind::kObjectScale:
      return {&mesh.pose.scale};
    default:
      return {};
  }
}

Scalars OfMaterial(Material& material, ParameterKind kind) {
  auto* rough = std::get_if<MetallicRoughnessBsdf>(&material.bsdf);
  auto* conductor = std::get_if<RoughConductorBsdf>(&material.bsdf);
  auto* dielectric = std::get_if<RoughDielectricBsdf>(&material.bsdf);
  auto* mirror = std::get_if<MirrorBsdf>(&material.bsdf);
  auto* glass = std::get_if<SmoothDielectricBsdf>(&material.bsdf);
  switch (kind) {
    case ParameterKind::kBaseColor:
      return Of(material.base_color);
    case ParameterKind::kRoughness:
      if (rough != nullptr) return {&rough->roughness};
      if (conductor != nullptr) return {&conductor->roughness};
      if (dielectric != nullptr) return {&dielectric->roughness};
      return {};
    case ParameterKind::kMetallic:
      return rough != nullptr ? Scalars{&rough->metallic} : Scalars{};
    case ParameterKind::kEta:
      if (conductor != nullptr) return Of(conductor->eta);
      if (mirror != nullptr) return Of(mirror->eta);
      if (dielectric != nullptr) return {&dielectric->eta};
      if (glass != nullptr) return {&glass->eta};
      return {};
    case ParameterKind::kExtinction:
      if (conductor != nullptr) return Of(conductor->k);
      if (mirror != nullptr) return Of(mirror->k);
      return {};
    default:
      return {};
  }
}

Scalars OfEmitter(Emitter& emitter, ParameterKind kind) {
  auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light);
  auto* point = std::get_if<PointEmitter>(&emitter.light);
  auto* spot = std::get_if<SpotEmitter>(&emitter.light);
  auto* projector = std::get_if<ProjectorEmitter>(&emitter.light);
  switch (kind) {
    case ParameterKind::kLightIntensity:
      return Of(LightIntensity(emitter));
    case ParameterKind::kLightPosition:
      if (point != nullptr) return Of(point->position);
      if (spot != nullptr) return Of(spot->position);
      if (projector != nullptr) return Of(projector->position);
      return {};
    case ParameterKind::kLightRotation:
      return point != nullptr || std::holds_alternative<AreaEmitter>(emitter.light)
                 ? Scalars{}
                 : Of(emitter.rotation);
    case ParameterKind::kSpotAngles:
      return spot != nullptr ? Scalars{&spot->inner_angle, &spot->outer_angle} : Scalars{};
    case ParameterKind::kEnvironmentTexels:
      return environment != nullptr ? OfAll(environment->texels) : Scalars{};
    default:
      return {};
  }
}

Scalars OfSensor(Camera& camera, ParameterKind kind) {
  const bool perspective = camera.projection == ProjectionKind::kPerspective;
  LensDistortion& lens = camera.distortion;
  switch (kind) {
    case ParameterKind::kExposure:
      return {&camera.gain};
    case ParameterKind::kCameraPosition:
      return Of(camera.world_from_camera.translation);
    case ParameterKind::kCameraRotation:
      return Of(camera.rotation);
    case ParameterKind::kFocal:
      return {&camera.fx, &camera.fy};
    case ParameterKind::kPrincipalPoint:
      return {&camera.cx, &camera.cy};
    case ParameterKind::kRadialDistortion:
      return perspective ? Scalars{&lens.k1, &lens.k2, &lens.k3} : Scalars{};
    case ParameterKind::kTangentialDistortion:
      return perspective ? Scalars{&lens.p1, &lens.p2} : Scalars{};
    default:
      return {};
  }
}

}  // namespace

std::vector<double*> ParameterScalars(Scene& scene, ParameterKind kind, int object) {
  const auto i = static_cast<std::size_t>(object);
  switch (ObjectListOf(kind)) {
    case ObjectList::kMeshes:
      return OfMesh(scene.meshes[i], kind);
    case ObjectList::kMaterials:
      return OfMaterial(scene.materials[i], kind);
    case ObjectList::kTextures:
      return OfTexels(scene.textures[i]);
    case ObjectList::kEmitters:
      return OfEmitter(scene.emitters[i], kind);
    case ObjectList::kSensors:
      return OfSensor(scene.sensors[i], kind);
  }
  return {};
}

}  // namespace pathfit::renderer
