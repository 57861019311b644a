#include "renderer/scene/parameter_kinds.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "renderer/core/check.h"
#include "renderer/scene/texture_surface.h"

namespace pathfit::renderer {
namespace {

using Kind = ParameterKind;

// The numbers of one block stand side by side.
static_assert(sizeof(Vec2) == 2 * sizeof(double) && sizeof(Vec3) == 3 * sizeof(double) &&
              sizeof(Rgb) == 3 * sizeof(double));

template <class Number>
using Blocks = ParameterBlocks<Number>;

/// `double` as constant as T.
template <class T>
using NumberOf = std::conditional_t<std::is_const_v<T>, const double, double>;

/// Blocks of an object: as constant as the reference to it.
template <class Reference>
using BlocksIn = Blocks<NumberOf<std::remove_reference_t<Reference>>>;

template <class T>
NumberOf<T>* FirstOf(T& v) {
  if constexpr (std::is_same_v<std::remove_const_t<T>, Rgb>) {
    return &v.r;
  } else if constexpr (std::is_same_v<std::remove_const_t<T>, double>) {
    return &v;
  } else {
    return &v.x;
  }
}

/// One block of `size` numbers from `first` on, which stand side by side.
template <class Number>
Blocks<Number> One(Number& first, int size) {
  return {&first, 1, size, static_cast<std::size_t>(size)};
}
template <class T>
Blocks<NumberOf<T>> One(T& v) {
  constexpr int kSize = static_cast<int>(sizeof(T) / sizeof(double));
  return {FirstOf(v), 1, kSize, kSize};
}
/// A block for each item of a list; the first `size` numbers of each.
template <class List>
auto Each(List& list, int size) {
  using Item = std::remove_reference_t<decltype(*list.begin())>;
  Blocks<NumberOf<Item>> out;
  if (!std::as_const(list).empty()) {
    out = {FirstOf(*list.begin()),
           static_cast<std::int32_t>(list.size()),
           size,
           sizeof(Item) / sizeof(double)};
  }
  return out;
}

template <ObjectList list, class S>
auto& ObjectOf(S& scene, int object) {
  const auto i = static_cast<std::size_t>(object);
  if constexpr (list == ObjectList::kMeshes) {
    return scene.meshes[i];
  } else if constexpr (list == ObjectList::kMaterials) {
    return scene.materials[i];
  } else if constexpr (list == ObjectList::kTextures) {
    return scene.textures[i];
  } else if constexpr (list == ObjectList::kEmitters) {
    return scene.emitters[i];
  } else {
    return scene.sensors[i];
  }
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr const char* kLaplacian[] = {"laplacian"};
constexpr const char* kSmooth[] = {"smooth"};
constexpr const char* kGaussian[] = {"gaussian"};
constexpr const char* kTexelPriors[] = {"smooth", "total_variation", "gaussian"};
constexpr const char* kMetallicPriors[] = {"gaussian", "binary"};
constexpr const char* kMetallicTexelPriors[] = {"smooth", "total_variation", "gaussian", "binary"};
constexpr const char* kEnvironmentPriors[] = {"smooth", "total_variation", "log_smooth", "neutral"};

/// A row, filled by steps. `Get` maps an object, constant or not, to its blocks, none if it lacks
/// the property.
struct Row : ParameterTraits {
  template <class Get>
  static Row Meshes(Kind kind, const char* property, const char* components, Get) {
    return Make<ObjectList::kMeshes, Get>(kind, property, components);
  }
  template <class Get>
  static Row Materials(Kind kind,
                       const char* property,
                       const char* components,
                       Rgb MaterialPartials::*partial,
                       Get) {
    Row row = Make<ObjectList::kMaterials, Get>(kind, property, components);
    row.partial = partial;
    return row;
  }
  template <class Get>
  static Row Textures(Kind kind, const char* property, const char* components, Get) {
    return Make<ObjectList::kTextures, Get>(kind, property, components);
  }
  template <class Get>
  static Row Emitters(Kind kind, const char* property, const char* components, Get) {
    return Make<ObjectList::kEmitters, Get>(kind, property, components);
  }
  template <class Get>
  static Row Sensors(Kind kind, const char* property, const char* components, Get) {
    return Make<ObjectList::kSensors, Get>(kind, property, components);
  }

  Row& Measured(const char* in) {
    unit = in;
    return *this;
  }
  Row& Moving(Moves what) {
    moves = what;
    return *this;
  }
  /// For some objects only; `is` may be left out where the others have no blocks.
  Row& Of(const char* which, bool (*is)(const Scene&, int) = nullptr) {
    objects = which;
    if (is != nullptr) is_for = is;
    return *this;
  }
  Row& OfSurface() {
    of_surface = true;
    return *this;
  }
  /// A texture may stand in for the constant.
  Row& Textured(int Material::*slot) {
    texture = slot;
    return *this;
  }
  Row& OrByVertexColors() {
    by_vertex_colors = true;
    return *this;
  }
  Row& OfLens() {
    of_lens = true;
    return *this;
  }
  Row& Around(double (*deviation)(const Scene&)) {
    believed = deviation;
    return *this;
  }
  Row& Lacking(std::string (*why)(const Scene&, int)) {
    lack = why;
    return *this;
  }
  Row& Bounded(double low, double high, double least, double most) {
    bounded = true;
    lower = low;
    upper = high;
    smallest = least;
    largest = most;
    priors = kGaussian;
    return *this;
  }
  Row& Free() { return Bounded(-kInfinity, kInfinity, -kInfinity, kInfinity); }
  Row& Unbounded(const char* advice = "") {
    bounds_advice = advice;
    return *this;
  }
  Row& Log() {
    log = true;
    return *this;
  }
  Row& LinearWithin(double factor) {
    largest_factor = factor;
    return *this;
  }
  Row& Priors(std::span<const char* const> names) {
    priors = names;
    return *this;
  }

 private:
  template <ObjectList which, class Get>
  static Row Make(Kind kind, const char* property, const char* components) {
    Row row;
    row.kind = kind;
    row.list = which;
    row.property = property;
    row.components = components;
    row.read = [](const Scene& scene, int object) -> Blocks<const double> {
      return Get{}(ObjectOf<which>(scene, object));
    };
    row.edit = [](Scene& scene, int object) -> Blocks<double> {
      return Get{}(ObjectOf<which>(scene, object));
    };
    row.is_for = [](const Scene&, int) { return true; };
    row.lack = [](const Scene&, int) { return std::string(); };
    return row;
  }
};

/// The alternative of a variant as constant as the object, null if it is another.
template <class Model, class Variant>
auto* As(Variant& variant) {
  return std::get_if<Model>(&variant);
}

// Roles of textures, by what uses them.
bool IsUsedAs(int Material::*role, const Scene& scene, int texture) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [&](const Material& m) {
    return m.*role == texture;
  });
}
bool IsMetallic(const Scene& scene, int texture) {
  return IsUsedAs(&Material::metallic_texture, scene, texture) &&
         !IsUsedAs(&Material::roughness_texture, scene, texture);
}
bool IsSeenOnSurfaces(const Scene& scene, int texture) {
  return IsUsedAs(&Material::base_color_texture, scene, texture);
}
bool IsScalar(const Scene& scene, int texture) {
  return scene.textures[static_cast<std::size_t>(texture)].scalar;
}
std::string LackOfUse(const Scene& scene, int texture) {
  if (IsUsedAs(&Material::normal_texture, scene, texture)) {
    return " is a normal texture, which cannot be unknown";
  }
  const bool used = IsSeenOnSurfaces(scene, texture) || IsTextureOfLight(scene, texture) ||
                    IsUsedAs(&Material::roughness_texture, scene, texture) ||
                    IsUsedAs(&Material::metallic_texture, scene, texture);
  return used ? "" : " is used by no material and no light";
}

// Of cameras: what is believed of angles and shares of lengths.
constexpr double kCameraShare = 0.02;

template <class Number>
double MeanOf(const Scene& scene, const Number& number) {
  double sum = 0.0;
  for (const Camera& sensor : scene.sensors) sum += number(sensor);
  return sum / static_cast<double>(scene.sensors.size());
}

double MeanDistanceToObjects(const Scene& scene) {
  Vec3 middle;
  double count = 0.0;
  for (const Mesh& mesh : WorldMeshes(scene)) {
    for (const Vec3& p : mesh.positions) {
      middle += p;
      count += 1.0;
    }
  }
  middle *= 1.0 / std::max(1.0, count);
  double distance = 0.0;
  for (const Camera& sensor : scene.sensors) {
    distance +=
        Norm(CameraPose(sensor).translation - middle) / static_cast<double>(scene.sensors.size());
  }
  return distance;
}

const Material& MaterialAt(const Scene& scene, int material) {
  return scene.materials[static_cast<std::size_t>(material)];
}
std::string LackOfConstant(const Scene& scene, int texture) {
  return texture < 0 ? ""
                     : " is a texture; write " +
                           scene.textures[static_cast<std::size_t>(texture)].name + ".texels";
}
const Emitter& EmitterAt(const Scene& scene, int emitter) {
  return scene.emitters[static_cast<std::size_t>(emitter)];
}
template <class Light>
bool Is(const Scene& scene, int emitter) {
  return std::holds_alternative<Light>(EmitterAt(scene, emitter).light);
}
/// An environment of one texel has neither a picture nor a direction.
bool IsConstant(const Emitter& emitter) {
  const auto* environment = As<EnvironmentEmitter>(emitter.light);
  return environment != nullptr && environment->texels.size() <= 1;
}

std::vector<ParameterTraits> MakeRows() {
  const auto positions = [](auto& m) { return Each(m.mesh.positions, 3); };
  const auto intensity = [](auto& e) { return One(LightIntensity(e)); };
  const auto texels = [](auto& t) { return Each(t.texels, t.scalar ? 1 : 3); };
  const auto is_metal_with_index = [](const Scene& scene, int i) {
    const auto* mirror = As<MirrorBsdf>(MaterialAt(scene, i).bsdf);
    return std::string(mirror != nullptr && IsBlack(mirror->eta) && IsBlack(mirror->k)
                           ? " needs a mirror with metal, or eta and k"
                           : "");
  };
  return {
      Row::Meshes(Kind::kVertexPositions, "vertices", "xyz", positions)
          .Measured("m")
          .Moving(Moves::kMeshes)
          .OfSurface()
          .Priors(kLaplacian),
      Row::Meshes(
          Kind::kVertexNormals, "normals", "xyz", [](auto& m) { return Each(m.mesh.normals, 3); })
          .Moving(Moves::kDirections)
          .OfSurface()
          .Of("normals"),
      Row::Meshes(Kind::kUvs, "uvs", "uv", [](auto& m) { return Each(m.mesh.uvs, 2); })
          .Moving(Moves::kDirections)
          .OfSurface()
          .Of("texture coordinates"),
      Row::Meshes(
          Kind::kVertexColors, "colors", "rgb", [](auto& m) { return Each(m.mesh.colors, 3); })
          .OfSurface()
          .Of("a material with base_color: {vertex: …}")
          .Lacking([](const Scene& scene, int i) {
            const Material& m =
                MaterialAt(scene, scene.meshes[static_cast<std::size_t>(i)].material);
            return m.vertex_colors
                       ? std::string()
                       : " needs a material with base_color: {vertex: …}; '" + m.name +
                             (m.base_color_texture >= 0 ? "' has a texture"
                                                        : "' has one colour everywhere");
          })
          .Bounded(0.01, 0.99, 0.0, 1.0)
          .Priors(kSmooth),
      Row::Meshes(Kind::kObjectTranslation,
                  "translation",
                  "xyz",
                  [](auto& m) { return One(m.pose.translation); })
          .Measured("m")
          .Moving(Moves::kMeshes)
          .Free(),
      Row::Meshes(
          Kind::kObjectRotation, "rotation", "xyz", [](auto& m) { return One(m.pose.rotation); })
          .Measured("rad")
          .Moving(Moves::kMeshes)
          .Free(),
      Row::Meshes(Kind::kObjectScale, "scale", "", [](auto& m) { return One(m.pose.scale); })
          .Moving(Moves::kMeshes)
          .Bounded(1e-3, kInfinity, 0.0, kInfinity)
          .Log(),
      Row::Materials(Kind::kBaseColor,
                     "base_color",
                     "rgb",
                     &MaterialPartials::d_base_color,
                     [](auto& m) { return One(m.base_color); })
          .Textured(&Material::base_color_texture)
          .OrByVertexColors()
          .Lacking([](const Scene& scene, int i) {
            const Material& m = MaterialAt(scene, i);
            return m.vertex_colors ? " needs base_color: {constant: …}; this one is per vertex, "
                                     "write MESH.colors"
                                   : LackOfConstant(scene, m.base_color_texture);
          })
          .Bounded(0.01, 0.99, 0.0, 1.0),
      Row::Materials(Kind::kRoughness,
                     "roughness",
                     "",
                     &MaterialPartials::d_roughness,
                     [](auto& m) -> BlocksIn<decltype(m)> {
                       if (auto* b = As<MetallicRoughnessBsdf>(m.bsdf)) return One(b->roughness);
                       if (auto* b = As<RoughConductorBsdf>(m.bsdf)) return One(b->roughness);
                       if (auto* b = As<RoughDielectricBsdf>(m.bsdf)) return One(b->roughness);
                       return {};
                     })
          .Of("metallic_roughness, conductor, dielectric")
          .Textured(&Material::roughness_texture)
          .Lacking([](const Scene& scene, int i) {
            return LackOfConstant(scene, MaterialAt(scene, i).roughness_texture);
          })
          .Bounded(kMinRoughness, 1.0, kMinRoughness, 1.0)
          .LinearWithin(2.0),
      Row::Materials(Kind::kMetallic,
                     "metallic",
                     "",
                     &MaterialPartials::d_metallic,
                     [](auto& m) -> BlocksIn<decltype(m)> {
                       if (auto* b = As<MetallicRoughnessBsdf>(m.bsdf)) return One(b->metallic);
                       return {};
                     })
          .Of("metallic_roughness")
          .Textured(&Material::metallic_texture)
          .Lacking([](const Scene& scene, int i) {
            return LackOfConstant(scene, MaterialAt(scene, i).metallic_texture);
          })
          .Bounded(0.0, 1.0, 0.0, 1.0)
          .Priors(kMetallicPriors),
      Row::Materials(Kind::kSpecular,
                     "specular",
                     "",
                     &MaterialPartials::d_specular,
                     [](auto& m) -> BlocksIn<decltype(m)> {
                       if (auto* b = As<MetallicRoughnessBsdf>(m.bsdf)) return One(b->specular);
                       return {};
                     })
          .Of("metallic_roughness")
          .Bounded(0.0, 1.0, 0.0, 1.0),
      Row::Materials(Kind::kEta,
                     "eta",
                     "rgb",
                     &MaterialPartials::d_eta,
                     [](auto& m) -> BlocksIn<decltype(m)> {
                       if (auto* b = As<RoughConductorBsdf>(m.bsdf)) return One(b->eta);
                       if (auto* b = As<MirrorBsdf>(m.bsdf)) return One(b->eta);
                       return {};
                     })
          .Of("conductor, mirror",
              [](const Scene& scene, int i) { return !IsTransmissive(MaterialAt(scene, i).bsdf); })
          .Lacking(is_metal_with_index)
          .Bounded(0.02, 20.0, 0.0, kInfinity)
          .Log(),
      Row::Materials(Kind::kEta,
                     "eta",
                     "",
                     &MaterialPartials::d_eta,
                     [](auto& m) -> BlocksIn<decltype(m)> {
                       if (auto* b = As<RoughDielectricBsdf>(m.bsdf)) return One(b->eta);
                       if (auto* b = As<SmoothDielectricBsdf>(m.bsdf)) return One(b->eta);
                       return {};
                     })
          .Of("dielectric, glass",
              [](const Scene& scene, int i) { return IsTransmissive(MaterialAt(scene, i).bsdf); })
          .Lacking([](const Scene& scene, int i) {
            const Bsdf& bsdf = MaterialAt(scene, i).bsdf;
            const auto* rough = As<RoughDielectricBsdf>(bsdf);
            const double eta =
                rough != nullptr ? rough->eta : std::get<SmoothDielectricBsdf>(bsdf).eta;
            return std::string(eta > 1.0 ? "" : " needs an ior above 1; turn the mesh inside out");
          })
          .Bounded(1.01, 3.0, 1.001, kInfinity)
          .Log(),
      Row::Materials(Kind::kExtinction,
                     "k",
                     "rgb",
                     &MaterialPartials::d_k,
                     [](auto& m) -> BlocksIn<decltype(m)> {
                       if (auto* b = As<RoughConductorBsdf>(m.bsdf)) return One(b->k);
                       if (auto* b = As<MirrorBsdf>(m.bsdf)) return One(b->k);
                       return {};
                     })
          .Of("conductor, mirror")
          .Lacking(is_metal_with_index)
          .Bounded(0.02, 20.0, 0.0, kInfinity)
          .Log(),
      Row::Textures(Kind::kTextureTexels, "texels", "rgb", texels)
          .OfSurface()
          .Of("of a base colour",
              [](const Scene& scene, int i) {
                return !IsScalar(scene, i) &&
                       (IsSeenOnSurfaces(scene, i) || !IsTextureOfLight(scene, i));
              })
          .Lacking(LackOfUse)
          .Bounded(0.01, 0.99, 0.0, 1.0)
          .Priors(kTexelPriors),
      Row::Textures(Kind::kTextureTexels, "texels", "rgb", texels)
          .OfSurface()
          .Of("of a light",
              [](const Scene& scene, int i) {
                return !IsScalar(scene, i) && !IsSeenOnSurfaces(scene, i) &&
                       IsTextureOfLight(scene, i);
              })
          .Bounded(1e-4, kInfinity, 0.0, kInfinity)
          .Log()
          .Priors(kTexelPriors),
      Row::Textures(Kind::kTextureTexels, "texels", "", texels)
          .OfSurface()
          .Of("of roughness",
              [](const Scene& scene, int i) { return IsScalar(scene, i) && !IsMetallic(scene, i); })
          .Lacking(LackOfUse)
          .Bounded(kMinRoughness, 1.0, kMinRoughness, 1.0)
          .Priors(kTexelPriors),
      Row::Textures(Kind::kTextureTexels, "texels", "", texels)
          .OfSurface()
          .Of("of metallic",
              [](const Scene& scene, int i) { return IsScalar(scene, i) && IsMetallic(scene, i); })
          .Bounded(0.0, 1.0, 0.0, 1.0)
          .Priors(kMetallicTexelPriors),
      Row::Emitters(Kind::kLightIntensity, "intensity", "rgb", intensity)
          .Measured("W/sr")
          .Of("point, spot",
              [](const Scene& scene, int i) {
                return Is<PointEmitter>(scene, i) || Is<SpotEmitter>(scene, i);
              })
          .Bounded(1e-4, kInfinity, 0.0, kInfinity)
          .Log(),
      Row::Emitters(Kind::kLightIntensity, "intensity", "rgb", intensity)
          .Measured("W/m²")
          .Of("directional", Is<DirectionalEmitter>)
          .Bounded(1e-4, kInfinity, 0.0, kInfinity)
          .Log(),
      Row::Emitters(Kind::kLightIntensity, "intensity", "rgb", intensity)
          .Of("projector, envmap",
              [](const Scene& scene, int i) {
                return Is<ProjectorEmitter>(scene, i) ||
                       (Is<EnvironmentEmitter>(scene, i) && !IsConstant(EmitterAt(scene, i)));
              })
          .Bounded(1e-4, kInfinity, 0.0, kInfinity)
          .Log(),
      Row::Emitters(Kind::kLightIntensity, "intensity", "rgb", intensity)
          .Measured("W/(sr m²)")
          .Of("constant, area, rectangle",
              [](const Scene& scene, int i) {
                return Is<AreaEmitter>(scene, i) || IsConstant(EmitterAt(scene, i));
              })
          .Bounded(1e-4, kInfinity, 0.0, kInfinity)
          .Log(),
      Row::Emitters(Kind::kLightPosition,
                    "position",
                    "xyz",
                    [](auto& e) -> BlocksIn<decltype(e)> {
                      if (auto* l = As<PointEmitter>(e.light)) return One(l->position);
                      if (auto* l = As<SpotEmitter>(e.light)) return One(l->position);
                      if (auto* l = As<ProjectorEmitter>(e.light)) return One(l->position);
                      return {};
                    })
          .Measured("m")
          .Moving(Moves::kEdges)
          .Of("point, spot, projector")
          .Free(),
      Row::Emitters(Kind::kLightRotation,
                    "rotation",
                    "xyz",
                    [](auto& e) -> BlocksIn<decltype(e)> {
                      if (As<PointEmitter>(e.light) != nullptr ||
                          As<AreaEmitter>(e.light) != nullptr) {
                        return {};
                      }
                      return One(e.rotation);
                    })
          .Measured("rad")
          .Moving(Moves::kEdges)
          .Of("envmap, directional, spot, projector")
          .Lacking([](const Scene& scene, int i) {
            return std::string(IsConstant(EmitterAt(scene, i))
                                   ? " needs a light of type envmap, directional, spot or projector"
                                   : "");
          })
          .Free(),
      Row::Emitters(Kind::kSpotAngles,
                    "angles",
                    "io",
                    [](auto& e) -> BlocksIn<decltype(e)> {
                      if (auto* l = As<SpotEmitter>(e.light)) return One(l->inner_angle, 2);
                      return {};
                    })
          .Measured("rad")
          .Of("spot")
          .Unbounded("; inner stays below outer, and outer below a right angle"),
      Row::Emitters(Kind::kEnvironmentTexels,
                    "texels",
                    "rgb",
                    [](auto& e) -> BlocksIn<decltype(e)> {
                      if (auto* l = As<EnvironmentEmitter>(e.light)) return Each(l->texels, 3);
                      return {};
                    })
          .Of("envmap")
          .Lacking([](const Scene& scene, int i) {
            const Emitter& e = EmitterAt(scene, i);
            return IsConstant(e) || !Is<EnvironmentEmitter>(scene, i)
                       ? " needs a light of type envmap; write " + e.name + ".intensity"
                       : std::string();
          })
          .Bounded(1e-4, kInfinity, 0.0, kInfinity)
          .Log()
          .Priors(kEnvironmentPriors),
      Row::Sensors(Kind::kExposure, "exposure", "", [](auto& s) { return One(s.gain); })
          .Measured("gain")
          .Unbounded("; write input.exposure.max_ev"),
      Row::Sensors(
          Kind::kWhiteBalance, "white_balance", "rb", [](auto& s) { return One(s.red, 2); })
          .Measured("gain")
          .Unbounded("; write input.exposure.max_ev"),
      Row::Sensors(Kind::kCameraPosition,
                   "position",
                   "xyz",
                   [](auto& s) { return One(s.world_from_camera.translation); })
          .Measured("m")
          .Moving(Moves::kEdges)
          .Around([](const Scene& scene) {
            return std::max(1e-9, kCameraShare * MeanDistanceToObjects(scene));
          })
          .Free(),
      Row::Sensors(
          Kind::kCameraRotation, "rotation", "xyz", [](auto& s) { return One(s.rotation); })
          .Measured("rad")
          .Moving(Moves::kEdges)
          .Around([](const Scene&) { return kCameraShare; })
          .Free(),
      Row::Sensors(Kind::kFocal, "focal", "xy", [](auto& s) { return One(s.fx, 2); })
          .Measured("px")
          .Moving(Moves::kEdges)
          .OfLens()
          .Around([](const Scene& scene) {
            return kCameraShare * MeanOf(scene, [](const Camera& s) { return s.fx; });
          })
          .Bounded(1.0, kInfinity, 0.0, kInfinity),
      Row::Sensors(
          Kind::kPrincipalPoint, "principal_point", "xy", [](auto& s) { return One(s.cx, 2); })
          .Measured("px")
          .Moving(Moves::kEdges)
          .OfLens()
          .Around([](const Scene& scene) {
            return 0.01 * MeanOf(scene, [](const Camera& s) { return s.width; });
          })
          .Free(),
      Row::Sensors(Kind::kRadialDistortion,
                   "distortion",
                   "123",
                   [](auto& s) -> BlocksIn<decltype(s)> {
                     if (s.projection != ProjectionKind::kPerspective) return {};
                     return One(s.distortion.k1, 3);
                   })
          .Moving(Moves::kEdges)
          .OfLens()
          .Around([](const Scene&) { return 0.05; })
          .Of("perspective")
          .Free(),
      Row::Sensors(Kind::kTangentialDistortion,
                   "tangential",
                   "12",
                   [](auto& s) -> BlocksIn<decltype(s)> {
                     if (s.projection != ProjectionKind::kPerspective) return {};
                     return One(s.distortion.p1, 2);
                   })
          .Moving(Moves::kEdges)
          .OfLens()
          .Around([](const Scene&) { return 0.01; })
          .Of("perspective")
          .Free(),
      Row::Sensors(
          Kind::kVignetting, "vignetting", "123", [](auto& s) { return One(s.vignetting.v1, 3); })
          .OfLens()
          .Around([](const Scene&) { return 0.3; })
          .Free(),
  };
}

// Numbers that are one block above must stand side by side.
static_assert(offsetof(LensDistortion, k3) == offsetof(LensDistortion, k1) + 2 * sizeof(double) &&
              offsetof(Vignetting, v3) == offsetof(Vignetting, v1) + 2 * sizeof(double) &&
              offsetof(LensDistortion, p2) == offsetof(LensDistortion, p1) + sizeof(double) &&
              offsetof(SpotEmitter, outer_angle) ==
                  offsetof(SpotEmitter, inner_angle) + sizeof(double));

template <class List>
std::vector<std::string> NamesOf(const List& list) {
  std::vector<std::string> names;
  names.reserve(list.size());
  for (const auto& item : list) names.push_back(item.name);
  return names;
}

}  // namespace

std::vector<std::string> ObjectNames(const Scene& scene, ObjectList list) {
  switch (list) {
    case ObjectList::kMeshes:
      return NamesOf(scene.meshes);
    case ObjectList::kMaterials:
      return NamesOf(scene.materials);
    case ObjectList::kTextures:
      return NamesOf(scene.textures);
    case ObjectList::kEmitters:
      return NamesOf(scene.emitters);
    case ObjectList::kSensors:
      return NamesOf(scene.sensors);
  }
  return {};
}

const char* ObjectWord(ObjectList list) {
  constexpr std::array kWords = {"mesh", "material", "texture", "light", "sensor"};
  return kWords.at(static_cast<std::size_t>(list));
}

int ParameterTraits::NumComponents() const {
  return std::max(1, static_cast<int>(std::strlen(components)));
}

bool ParameterTraits::IsPlace() const {
  return std::strcmp(components, "xyz") == 0 || std::strcmp(components, "uv") == 0;
}

std::span<const ParameterTraits> AllParameterTraits() {
  static const std::vector<ParameterTraits> rows = MakeRows();
  return rows;
}

const ParameterTraits& TraitsOf(ParameterKind kind) {
  static const auto first = [] {
    std::array<const ParameterTraits*, static_cast<std::size_t>(ParameterKind::kCount)> rows{};
    for (const ParameterTraits& row : AllParameterTraits()) {
      auto& slot = rows.at(static_cast<std::size_t>(row.kind));
      slot = slot == nullptr ? &row : slot;
    }
    return rows;
  }();
  const ParameterTraits* row = first.at(static_cast<std::size_t>(kind));
  PATHFIT_CHECK(row != nullptr);
  return *row;
}

const ParameterTraits& TraitsOf(ParameterKind kind, const Scene& scene, int object) {
  const ParameterTraits* row = &TraitsOf(kind);
  const std::span<const ParameterTraits> all = AllParameterTraits();
  while (!row->is_for(scene, object)) {
    ++row;
    PATHFIT_CHECK(row != all.data() + all.size() && row->kind == kind);
  }
  return *row;
}

}  // namespace pathfit::renderer
