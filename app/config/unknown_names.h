#pragma once

#include <string>
#include <vector>

#include "app/config/read_config.h"

namespace pathfit::app {

/// A property that may be unknown: whose it is, what it can be, what is assumed.
struct UnknownKind {
  enum class Owner { kMesh, kMaterial, kLight, kPhotos };
  std::string property;
  Owner owner;
  std::string default_bounds;  ///< empty: has none, and no transform
  std::string bounds_advice;
  double smallest;  ///< what bounds may be at all
  double largest;
  bool default_log;
  bool has_channels;  ///< red, green, blue
  std::vector<std::string> priors;
};

const std::vector<UnknownKind>& UnknownKinds();
const UnknownKind* FindUnknownKind(const std::string& property);

/// Why `name` names nothing in the scene that could be unknown, with a hint; empty if it does. Says
/// nothing about objects when the scene's list of them is missing (reported elsewhere).
std::string UnknownNameProblem(const std::string& name, const ConfigReading& reading);

}  // namespace pathfit::app
