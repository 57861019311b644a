#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// What may be differentiated and fitted. All that there is to know of a kind stands in its row or
/// rows in parameter_kinds.cpp; the order is that of the groups in a fit.
enum class ParameterKind {
  kVertexPositions,       ///< one block per position, in the object's frame
  kVertexNormals,         ///< one block per normal, need not be unit
  kUvs,                   ///< one block per UV
  kVertexColors,          ///< one block per colour, linear
  kObjectTranslation,     ///< ObjectPose::translation
  kObjectRotation,        ///< ObjectPose::rotation
  kObjectScale,           ///< ObjectPose::scale
  kBaseColor,             ///< Material::base_color
  kRoughness,             ///< perceptual
  kMetallic,              ///< 0: dielectric, 1: metal
  kSpecular,              ///< factor of the dielectric's reflection
  kEta,                   ///< of metals per channel, of dielectrics one number
  kExtinction,            ///< k of metals
  kTextureTexels,         ///< one block per texel; of scalar textures one number
  kLightIntensity,        ///< LightIntensity
  kLightPosition,         ///< point, spot, projector, in the light's frame
  kLightRotation,         ///< Emitter::rotation
  kSpotAngles,            ///< inner, outer
  kEnvironmentTexels,     ///< one block per texel
  kExposure,              ///< Camera::gain
  kWhiteBalance,          ///< Camera::red and blue
  kCameraPosition,        ///< translation of Camera::world_from_camera
  kCameraRotation,        ///< Camera::rotation
  kFocal,                 ///< fx, fy
  kPrincipalPoint,        ///< cx, cy
  kRadialDistortion,      ///< k1, k2, k3
  kTangentialDistortion,  ///< p1, p2
  kVignetting,            ///< v1, v2, v3
  kCount                  ///< how many kinds there are, none itself
};

/// The list of the scene that an object belongs to.
enum class ObjectList { kMeshes, kMaterials, kTextures, kEmitters, kSensors };
/// Names of the objects of a list, in its order.
std::vector<std::string> ObjectNames(const Scene& scene, ObjectList list);
/// What people call an object of the list: "mesh", "material", "texture", "light", "sensor".
const char* ObjectWord(ObjectList list);

/// What changes place when a parameter changes; each includes what stands before it.
enum class Moves {
  kNothing,     ///< colours and strengths: the same paths carry more or less
  kDirections,  ///< normals and places in textures: paths bend, no edge moves
  kEdges,       ///< lights or the sensor: edges move against each other or in the image
  kMeshes,      ///< surfaces: acceleration structures are stale
};

/// The numbers of one object and kind inside a scene, without a copy: component c of block b is
/// first[b * stride + c]. Valid until the object is changed by other means.
template <class Number>
struct ParameterBlocks {
  Number* first = nullptr;  ///< null if there is no block
  std::int32_t num_blocks = 0;
  int block_size = 0;      ///< 1, 2 or 3
  std::size_t stride = 0;  ///< numbers from block to block, at least block_size

  [[nodiscard]] std::span<Number> operator[](std::int32_t block) const {
    return {first + static_cast<std::size_t>(block) * stride, static_cast<std::size_t>(block_size)};
  }
};

/// What is known of a kind, or of a kind for some of its objects: where what its numbers mean
/// depends on the object, a kind has several rows, and each object that has it fits one.
struct ParameterTraits {
  ParameterKind kind = ParameterKind::kCount;
  ObjectList list = ObjectList::kMeshes;
  const char* property = "";    ///< in OBJECT.PROPERTY
  const char* components = "";  ///< a letter each; empty: one number
  const char* unit = "1";
  Moves moves = Moves::kNothing;
  /// Which of the list's objects the row is for, for people: "conductor, mirror"; empty: all.
  const char* objects = "";

  /// Bounds if nothing else is asked for, and what bounds may be at all; there are none, and no
  /// logarithm either, unless `bounded`.
  bool bounded = false;
  double lower = 0.0, upper = 0.0;
  double smallest = 0.0, largest = 0.0;
  bool log = false;  ///< whether the logarithm is what moves, if not asked
  /// What images do with it holds for changes by this factor at most.
  double largest_factor = std::numeric_limits<double>::infinity();
  const char* bounds_advice = "";            ///< behind "bounds of PROPERTY are not supported"
  std::span<const char* const> priors = {};  ///< names of those that mean something

  /// Whether there are so many as the surface has vertices or texels, else a few of the object.
  bool of_surface = false;
  /// Of sensors: whether it is the lens, which one camera has in all its pictures.
  bool of_lens = false;
  /// Deviation of the belief around the start if no other is asked for; null: none is held.
  double (*believed)(const Scene&) = nullptr;

  /// Of materials: the partial by it, and what may stand in for the constant.
  Rgb MaterialPartials::*partial = nullptr;
  int Material::*texture = nullptr;
  bool by_vertex_colors = false;

  ParameterBlocks<const double> (*read)(const Scene&, int object) = nullptr;
  /// The blocks, to be written; lists that other scenes share are copied first.
  ParameterBlocks<double> (*edit)(Scene&, int object) = nullptr;
  /// Whether the row is for this object, which may lack the property all the same.
  bool (*is_for)(const Scene&, int object) = nullptr;
  /// Why an object has no such numbers or changing them is of no effect, behind its name; or empty.
  std::string (*lack)(const Scene&, int object) = nullptr;

  [[nodiscard]] int NumComponents() const;
  /// Whether the numbers say where something is: then the components of one block have no sum, and
  /// those of many objects no mean, that says something.
  [[nodiscard]] bool IsPlace() const;
  /// Whether the numbers are an object's pose.
  [[nodiscard]] bool IsPose() const { return list == ObjectList::kMeshes && !of_surface; }
  /// Of a property of materials: its texture in one of them, -1 without.
  [[nodiscard]] int TextureOf(const Material& material) const {
    return texture == nullptr ? -1 : material.*texture;
  }
  /// Whether the material has a number per vertex of it.
  [[nodiscard]] bool IsPerVertex(const Material& material) const {
    return by_vertex_colors && material.vertex_colors && TextureOf(material) < 0;
  }
  /// Whether the material's constant is what counts.
  [[nodiscard]] bool IsConstant(const Material& material) const {
    return TextureOf(material) < 0 && !IsPerVertex(material);
  }
};

/// All rows, ordered by kind.
std::span<const ParameterTraits> AllParameterTraits();
/// The first row of a kind: right for list, property and `moves`, which are the kind's.
const ParameterTraits& TraitsOf(ParameterKind kind);
/// The row of an object, which must exist.
const ParameterTraits& TraitsOf(ParameterKind kind, const Scene& scene, int object);

inline bool MovesGeometry(ParameterKind kind) { return TraitsOf(kind).moves != Moves::kNothing; }
inline bool MovesEdges(ParameterKind kind) { return TraitsOf(kind).moves >= Moves::kEdges; }
inline bool MovesMeshes(ParameterKind kind) { return TraitsOf(kind).moves == Moves::kMeshes; }
/// Whether what images show changes place, surfaces or the camera; lights move shadows only.
inline bool MovesInImages(ParameterKind kind) {
  return MovesMeshes(kind) || (MovesEdges(kind) && TraitsOf(kind).list == ObjectList::kSensors);
}

/// Stands for all sensors in names.
inline constexpr const char* kAllSensors = "camera";

/// One of the things a scene has that may change. Names: OBJECT.PROPERTY.
struct ParameterRef {
  ParameterKind kind = ParameterKind::kCount;
  int object = 0;  ///< into the kind's list; -1: every sensor
  friend bool operator==(const ParameterRef&, const ParameterRef&) = default;
};

}  // namespace pathfit::renderer
