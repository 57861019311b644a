#pragma once

#include "renderer/core/error.h"

namespace pathfit::renderer {

/// There is no room for what is to be written. What was there before is kept.
class DiskFullError : public IoError {
 public:
  using IoError::IoError;
};

}  // namespace pathfit::renderer
