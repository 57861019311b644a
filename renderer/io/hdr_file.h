#pragma once

#include <string>
#include <string_view>

#include "renderer/image/image.h"

namespace pathfit::renderer {

/// Three channels of a Radiance HDR file in memory, divided by its EXPOSURE. Fails: IoError naming
/// `name`, also for rows that are not stored from the top and from the left, and for run lengths as
/// before 1991.
Image ReadHdr(std::string_view bytes, const std::string& name);

}  // namespace pathfit::renderer
