#pragma once

#include <string>

namespace pathfit::optim {

/// Version of the Ceres headers.
std::string CeresVersion();

}  // namespace pathfit::optim
