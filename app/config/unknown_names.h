#pragma once

#include <string>

#include "app/config/read_config.h"
#include "app/config/unknown_kinds.h"

namespace pathfit::app {

/// What the name of an unknown stands for.
struct UnknownName {
  const UnknownKind* kind = nullptr;  ///< also if only the object is wrong; null if nothing has it
  std::string problem;                ///< why it names nothing that could be unknown; or empty
};

/// Looks a name up in the scene, with a hint where there is no such thing. Says nothing about
/// objects when the scene's list of them is missing (reported elsewhere).
UnknownName FindUnknown(const std::string& name, const ConfigReading& reading);

}  // namespace pathfit::app
