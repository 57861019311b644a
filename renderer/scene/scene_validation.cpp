#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/geometry/ray.h"
#include "renderer/scene/parameter_kinds.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {
namespace {

void Require(bool condition, const std::string& where, const std::string& what) {
  if (!condition) {
    throw SceneError(where + ": " + what);
  }
}

bool InRange(double v, double low, double high) { return v >= low && v <= high; }
bool InRange(const Rgb& c, double low, double high) {
  return InRange(c.r, low, high) && InRange(c.g, low, high) && InRange(c.b, low, high);
}
bool InRange(const std::vector<Rgb>& values, double low, double high) {
  return std::all_of(
      values.begin(), values.end(), [&](const Rgb& c) { return InRange(c, low, high); });
}

std::string TextOf(double v) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), v).ptr};
}

bool IsRotation(const Mat3& m) {
  const Mat3 product = Transposed(m) * m;
  constexpr double kTolerance = 1e-6;
  const auto is_near = [](const Vec3& a, const Vec3& b) { return Norm(a - b) < kTolerance; };
  return is_near(product.x, {1, 0, 0}) && is_near(product.y, {0, 1, 0}) &&
         is_near(product.z, {0, 0, 1}) && Determinant(m) > 0.0;
}

/// Whether the texel count is width times height, both positive, and addressable by int.
bool SizeFits(int width, int height, std::size_t count) {
  return width > 0 && height > 0 &&
         static_cast<std::int64_t>(width) * height <= std::numeric_limits<int>::max() &&
         count == static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

void ValidateTexture(const Texture& texture) {
  const std::string where = "texture '" + texture.name + "'";
  Require(SizeFits(texture.width, texture.height, texture.texels.size()),
          where,
          "texels do not match width and height");
  Require(InRange(texture.texels, 0.0, 1e30), where, "texels must be finite and not negative");
  Require(!texture.scalar || std::all_of(texture.texels.begin(),
                                         texture.texels.end(),
                                         [](const Rgb& t) { return t.r == t.g && t.r == t.b; }),
          where,
          "a scalar texture must have equal channels");
}

/// The model's indices of refraction.
class BsdfValidator {
 public:
  explicit BsdfValidator(const std::string& where) : where_(where) {}

  void operator()(const LambertBsdf&) const {}
  void operator()(const MetallicRoughnessBsdf&) const {}
  void operator()(const RoughConductorBsdf& m) const { CheckComplexIndex(m.eta, m.k); }
  void operator()(const RoughDielectricBsdf& m) const { CheckIndex(m.eta); }
  void operator()(const MirrorBsdf& m) const { CheckComplexIndex(m.eta, m.k); }
  void operator()(const SmoothDielectricBsdf& m) const { CheckIndex(m.eta); }

 private:
  void CheckComplexIndex(const Rgb& eta, const Rgb& k) const {
    Require(
        InRange(eta, 0.0, 1e3) && InRange(k, 0.0, 1e3), where_, "eta and k must lie in [0, 1e3]");
  }
  void CheckIndex(double eta) const {
    Require(InRange(eta, 1e-3, 1e3) && eta != 1.0, where_, "eta must lie in [1e-3, 1e3], not at 1");
  }

  const std::string& where_;
};

class SceneValidator {
 public:
  explicit SceneValidator(const Scene& scene)
      : scene_(scene), num_area_lights_(scene.meshes.size(), 0) {}

  void CheckAll() {
    std::for_each(scene_.textures.begin(), scene_.textures.end(), ValidateTexture);
    for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
      CheckMaterial(scene_.materials[i]);
      CheckShares(static_cast<int>(i));
    }
    for (const SceneMesh& mesh : scene_.meshes) {
      CheckMesh(mesh);
    }
    for (const Emitter& emitter : scene_.emitters) {
      CheckEmitter(emitter);
    }
    const auto environments =
        std::count_if(scene_.emitters.begin(), scene_.emitters.end(), [](const Emitter& e) {
          return std::holds_alternative<EnvironmentEmitter>(e.light);
        });
    Require(environments <= 1, "lights", "at most one environment is possible");
    for (const Camera& camera : scene_.sensors) {
      const CameraModel model(camera);  // validates
      CheckLightsOff(camera);
    }
  }

 private:
  void CheckLightsOff(const Camera& camera) const {
    const std::vector<int>& off = camera.lights_off;
    const auto count = static_cast<int>(scene_.emitters.size());
    Require(off.empty() || (off.front() >= 0 && off.back() < count &&
                            std::is_sorted(off.begin(), off.end(), std::less_equal<>())),
            "sensor '" + camera.name + "'",
            "the lights that are off must exist, in ascending order");
  }

  /// The texture of that index; nullptr if the index is -1.
  const Texture* FindTexture(int index, const std::string& where, const std::string& role) const {
    Require(index >= -1 && index < static_cast<int>(scene_.textures.size()),
            where,
            "its " + role + " texture does not exist");
    return index < 0 ? nullptr : &scene_.textures[static_cast<std::size_t>(index)];
  }

  void CheckMaterial(const Material& material) const {
    const std::string where = "material '" + material.name + "'";
    Require(InRange(material.base_color, 0.0, 1e6),
            where,
            "base_color must be finite and not negative");
    std::visit(BsdfValidator(where), material.bsdf);
    if (const Texture* texture = FindTexture(material.base_color_texture, where, "base colour")) {
      Require(!material.vertex_colors,
              where,
              "the base colour comes either from vertex colours or from a texture");
      Require(InRange(texture->texels, 0.0, 1e6),
              where,
              "texture '" + texture->name + "' is too bright for a base colour");
    }
    const auto check_scalar = [&](int index, const std::string& role, bool fits_model, double low) {
      const Texture* texture = FindTexture(index, where, role);
      if (texture == nullptr) return;
      Require(fits_model, where, "its model has no " + role + " that a texture could replace");
      Require(texture->scalar, where, "its " + role + " texture must be a scalar one");
      Require(
          InRange(texture->texels, low, 1.0),
          where,
          "the " + role + " texture '" + texture->name + "' must lie in [" + TextOf(low) + ", 1]");
    };
    check_scalar(
        material.roughness_texture, "roughness", HasRoughness(material.bsdf), kMinRoughness);
    check_scalar(material.metallic_texture,
                 "metallic",
                 std::holds_alternative<MetallicRoughnessBsdf>(material.bsdf),
                 0.0);
    if (const Texture* texture = FindTexture(material.normal_texture, where, "normal")) {
      Require(InRange(texture->texels, 0.0, 1.0),
              where,
              "the normal texture '" + texture->name + "' must lie in [0, 1]");
    }
    Require(InRange(material.normal_scale, -1e6, 1e6), where, "normal_scale must be finite");
  }

  /// The numbers of a material that have a range of their own: roughness and the like.
  void CheckShares(int material) const {
    for (const ParameterTraits& row : AllParameterTraits()) {
      if (row.list != ObjectList::kMaterials || row.NumComponents() > 1 ||
          !std::isfinite(row.largest) || !row.is_for(scene_, material)) {
        continue;
      }
      const auto blocks = row.read(scene_, material);
      Require(blocks.num_blocks == 0 || InRange(*blocks.first, row.smallest, row.largest),
              "material '" + scene_.materials[static_cast<std::size_t>(material)].name + "'",
              std::string(row.property) + " must lie in [" + TextOf(row.smallest) + ", " +
                  TextOf(row.largest) + "]");
    }
  }

  void CheckMesh(const SceneMesh& m) const {
    const std::string where = "mesh '" + m.name + "'";
    ValidateMesh(m.mesh, m.name);
    Require(m.material >= 0 && static_cast<std::size_t>(m.material) < scene_.materials.size(),
            where,
            "its material does not exist");
    const Material& material = scene_.materials[static_cast<std::size_t>(m.material)];
    Require(!material.vertex_colors || m.mesh.HasColors(),
            where,
            "its material takes vertex colours, the mesh has none");
    Require(!material.IsTextured() || !m.mesh.uv_triangles.empty(),
            where,
            "its material has a texture, the mesh has no UVs");
    Require(material.normal_texture < 0 || !m.mesh.normal_triangles.empty(),
            where,
            "its material has a normal texture, the mesh has no normals");
    Require(InRange(m.mesh.colors, 0.0, 1e6), where, "colours must be finite and not negative");
    const ObjectPose& pose = m.pose;
    Require(IsFinite(pose.pivot) && IsFinite(pose.translation) && IsFinite(pose.rotation),
            where,
            "pivot, translation and rotation of its pose must be finite");
    Require(InRange(pose.scale, std::numeric_limits<double>::min(), 1e30),
            where,
            "the scale of its pose must be positive and finite");
    double farthest = 0.0;
    for (const Vec3& x : m.mesh.positions) farthest = std::max(farthest, Norm(x - pose.pivot));
    const Vec3 middle = pose.pivot + pose.translation;
    const double reach = pose.scale * farthest;
    Require(
        IsWithinBounds(
            {std::abs(middle.x) + reach, std::abs(middle.y) + reach, std::abs(middle.z) + reach}),
        where,
        "its pose must not lead beyond 1e12 metres");
  }

  void CheckEmitter(const Emitter& emitter) {
    where_ = "light '" + emitter.name + "'";
    Require(InRange(LightIntensity(emitter), 0.0, 1e30),
            where_,
            "intensity must be finite and not negative");
    Require(IsFinite(emitter.rotation), where_, "rotation must be finite");
    const bool has_frame = !std::holds_alternative<AreaEmitter>(emitter.light);
    Require(has_frame || emitter.frame == LightFrame::kWorld,
            where_,
            "an area light stands in the world; move its mesh");
    Require((has_frame && !std::holds_alternative<PointEmitter>(emitter.light)) ||
                emitter.rotation == Vec3{},
            where_,
            "point and area lights have no rotation");
    std::visit([this](const auto& light) { CheckLight(light); }, emitter.light);
  }

  void CheckLight(const EnvironmentEmitter& light) const {
    Require(SizeFits(light.width, light.height, light.texels.size()),
            where_,
            "texels do not match width and height");
    Require(InRange(light.texels, 0.0, 1e30), where_, "texels must be finite and not negative");
    CheckFrame(light.frame_from_light);
  }

  void CheckLight(const PointEmitter& light) const { CheckPosition(light.position); }

  void CheckLight(const DirectionalEmitter& light) const {
    Require(
        std::abs(Norm(light.direction) - 1.0) < 1e-9, where_, "direction must be a unit vector");
  }

  void CheckLight(const SpotEmitter& light) const {
    CheckPosition(light.position);
    CheckFrame(light.frame_from_light);
    Require(light.inner_angle >= 0.0 && light.inner_angle < light.outer_angle &&
                light.outer_angle < 0.5 * std::numbers::pi,
            where_,
            "angles must satisfy 0 <= inner < outer < pi / 2");
  }

  void CheckLight(const ProjectorEmitter& light) const {
    CheckPosition(light.position);
    CheckFrame(light.frame_from_light);
    Require(InRange(light.tan_half_width, 1e-6, 1e6) && InRange(light.tan_half_height, 1e-6, 1e6),
            where_,
            "half the width and height at depth 1 must lie in [1e-6, 1e6]");
    FindTexture(light.texture, where_, "projected");
  }

  void CheckLight(const AreaEmitter& light) {
    Require(light.mesh >= 0 && static_cast<std::size_t>(light.mesh) < scene_.meshes.size(),
            where_,
            "its mesh does not exist");
    const SceneMesh& mesh = scene_.meshes[static_cast<std::size_t>(light.mesh)];
    Require(++num_area_lights_[static_cast<std::size_t>(light.mesh)] == 1,
            where_,
            "mesh '" + mesh.name + "' shines by another area light already");
    Require(FindTexture(light.texture, where_, "radiance") == nullptr ||
                !mesh.mesh.uv_triangles.empty(),
            where_,
            "it has a texture, mesh '" + mesh.name + "' has no UVs");
  }

  void CheckPosition(const Vec3& position) const {
    Require(IsWithinBounds(position), where_, "position must be within 1e12 metres");
  }
  void CheckFrame(const Mat3& frame_from_light) const {
    Require(IsRotation(frame_from_light), where_, "its frame must be a rotation");
  }

  const Scene& scene_;
  std::vector<int> num_area_lights_;  ///< per mesh
  std::string where_;                 ///< the light being checked
};

}  // namespace

void ValidateScene(const Scene& scene) { SceneValidator(scene).CheckAll(); }

}  // namespace pathfit::renderer
