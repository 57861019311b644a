#include "app/config/unknown_kinds.h"

#include <limits>
#include <utility>

namespace pathfit::app {
namespace {

using Owner = UnknownKind::Owner;
using Of = UnknownKind::Of;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr const char* kFree = "[-.inf, .inf]";
constexpr const char* kColor = "[0.01, 0.99]";
constexpr const char* kLight = "[1e-4, .inf]";
constexpr const char* kIndex = "[0.02, 20]";

UnknownKind Without(const char* property, Owner owner, Of of, std::vector<std::string> priors) {
  return {property, owner, of, "", "", 0.0, 0.0, false, 3, std::move(priors)};
}

// Without a range of its own: metres, radians, pixels.
UnknownKind Free(const char* property, Owner owner, Of of, int num_components = 3) {
  return {
      property, owner, of, kFree, "", -kInfinity, kInfinity, false, num_components, {"gaussian"}};
}

UnknownKind Bounded(const char* property,
                    Owner owner,
                    Of of,
                    const char* bounds,
                    double smallest,
                    double largest,
                    int num_components) {
  return {property, owner, of, bounds, "", smallest, largest, false, num_components, {"gaussian"}};
}

UnknownKind Log(UnknownKind kind) {
  kind.default_log = true;
  return kind;
}

UnknownKind WithPriors(UnknownKind kind, std::vector<std::string> priors) {
  kind.priors = std::move(priors);
  return kind;
}

UnknownKind Texels(Of of, const char* bounds, double smallest, double largest, int num_components) {
  return WithPriors(
      Bounded("texels", Owner::kTexture, of, bounds, smallest, largest, num_components),
      {"smooth", "gaussian"});
}

std::vector<UnknownKind> AllKinds() {
  constexpr double kMinRoughness = 0.1;
  constexpr double kMinIor = 1.001;
  UnknownKind exposure = Without("exposure", Owner::kSensors, Of::kExposure, {});
  exposure.bounds_advice = "; write input.exposure.max_ev";
  UnknownKind angles = Without("angles", Owner::kLight, Of::kSpot, {});
  angles.bounds_advice = "; inner stays below outer, and outer below a right angle";
  return {
      Without("vertices", Owner::kMesh, Of::kAll, {"laplacian"}),
      Without("normals", Owner::kMesh, Of::kAll, {}),
      Without("uvs", Owner::kMesh, Of::kAll, {}),
      WithPriors(Bounded("colors", Owner::kMesh, Of::kPerVertexColor, kColor, 0.0, 1.0, 3),
                 {"smooth"}),
      Free("translation", Owner::kMesh, Of::kAll),
      Free("rotation", Owner::kMesh, Of::kAll),
      Log(Bounded("scale", Owner::kMesh, Of::kAll, "[1e-3, .inf]", 0.0, kInfinity, 1)),
      Bounded("base_color", Owner::kMaterial, Of::kConstantColor, kColor, 0.0, 1.0, 3),
      Bounded(
          "roughness", Owner::kMaterial, Of::kConstantRoughness, "[0.1, 1]", kMinRoughness, 1.0, 1),
      Bounded("metallic", Owner::kMaterial, Of::kConstantMetallic, "[0, 1]", 0.0, 1.0, 1),
      Log(Bounded("eta", Owner::kMaterial, Of::kMetal, kIndex, 0.0, kInfinity, 3)),
      Log(Bounded("eta", Owner::kMaterial, Of::kDielectric, "[1.01, 3]", kMinIor, kInfinity, 1)),
      Log(Bounded("k", Owner::kMaterial, Of::kMetal, kIndex, 0.0, kInfinity, 3)),
      Texels(Of::kColorTexture, kColor, 0.0, 1.0, 3),
      Log(Texels(Of::kLightTexture, kLight, 0.0, kInfinity, 3)),
      Texels(Of::kRoughnessTexture, "[0.1, 1]", kMinRoughness, 1.0, 1),
      Texels(Of::kMetallicTexture, "[0, 1]", 0.0, 1.0, 1),
      Log(Bounded("intensity", Owner::kLight, Of::kAll, kLight, 0.0, kInfinity, 3)),
      WithPriors(Log(Bounded("texels", Owner::kLight, Of::kEnvmap, kLight, 0.0, kInfinity, 3)),
                 {"smooth", "neutral"}),
      Free("position", Owner::kLight, Of::kPlaced),
      Free("rotation", Owner::kLight, Of::kOriented),
      angles,
      exposure,
      Free("position", Owner::kSensors, Of::kAll),
      Free("rotation", Owner::kSensors, Of::kAll),
      Bounded("focal", Owner::kSensors, Of::kAll, "[1, .inf]", 0.0, kInfinity, 2),
      Free("principal_point", Owner::kSensors, Of::kAll, 2),
      Free("distortion", Owner::kSensors, Of::kPerspective),
      Free("tangential", Owner::kSensors, Of::kPerspective, 2),
  };
}

const char* Word(Owner owner) {
  switch (owner) {
    case Owner::kMesh:
      return "MESH";
    case Owner::kMaterial:
      return "MATERIAL";
    case Owner::kTexture:
      return "TEXTURE";
    case Owner::kLight:
      return "LIGHT";
    case Owner::kSensors:
      return "camera";
  }
  return "";
}

const char* Restriction(Of of) {
  switch (of) {
    case Of::kAll:
    case Of::kExposure:
      return "";
    case Of::kPerVertexColor:
      return "`base_color: {vertex: …}`";
    case Of::kConstantColor:
    case Of::kConstantRoughness:
    case Of::kConstantMetallic:
      return "`{constant: …}`";
    case Of::kMetal:
      return "conductor, mirror";
    case Of::kDielectric:
      return "dielectric, glass";
    case Of::kColorTexture:
      return "of a base colour";
    case Of::kLightTexture:
      return "of a light";
    case Of::kRoughnessTexture:
      return "of roughness";
    case Of::kMetallicTexture:
      return "of metallic";
    case Of::kEnvmap:
      return "envmap";
    case Of::kPlaced:
      return "point, spot, projector";
    case Of::kOriented:
      return "envmap, directional, spot, projector";
    case Of::kSpot:
      return "spot";
    case Of::kPerspective:
      return "perspective";
  }
  return "";
}

}  // namespace

const std::vector<UnknownKind>& UnknownKinds() {
  static const std::vector<UnknownKind> kinds = AllKinds();
  return kinds;
}

std::string DescribeOwner(const UnknownKind& kind) {
  if (kind.of == Of::kExposure) return "`exposure`";
  const std::string restriction = Restriction(kind.of);
  const std::string name = "`" + std::string(Word(kind.owner)) + "." + kind.property + "`";
  return restriction.empty() ? name : name + ", " + restriction;
}

}  // namespace pathfit::app
