#pragma once

#include <string>
#include <vector>

namespace pathfit::app {

/// A property that may be unknown: whose it is, what it can be, what is assumed. Several kinds may
/// share a property's name; the object that it is written with tells them apart.
struct UnknownKind {
  enum class Owner { kMesh, kMaterial, kTexture, kLight, kSensors };
  /// Which of its owner's objects have it.
  enum class Of {
    kAll,
    kPerVertexColor,
    kConstantColor,
    kConstantRoughness,
    kConstantMetallic,
    kMetal,
    kDielectric,
    kColorTexture,
    kLightTexture,
    kRoughnessTexture,
    kMetallicTexture,
    kEnvmap,
    kPlaced,    ///< point, spot, projector
    kOriented,  ///< all but point, area and constant
    kSpot,
    kPerspective,
    kExposure,
  };
  std::string property;
  Owner owner;
  Of of;
  std::string default_bounds;  ///< empty: has none, and no transform
  std::string bounds_advice;
  double smallest;  ///< what bounds may be at all
  double largest;
  bool default_log;
  int num_components;  ///< of a Gaussian prior's mean, besides one for all
  std::vector<std::string> priors;
};

const std::vector<UnknownKind>& UnknownKinds();

/// Who has the property, for the reference: "MATERIAL (conductor, mirror)".
std::string DescribeOwner(const UnknownKind& kind);

}  // namespace pathfit::app
