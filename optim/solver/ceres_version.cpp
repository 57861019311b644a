#include "optim/solver/ceres_version.h"

#include <ceres/version.h>

namespace pathfit::optim {

std::string CeresVersion() { return CERES_VERSION_STRING; }

}  // namespace pathfit::optim
