#pragma once

#include <optional>

#include "app/command/command_line.h"
#include "renderer/core/parallel.h"

namespace pathfit::app {

/// While it lives, SIGINT and SIGTERM set a flag that long loops poll; a second SIGINT ends the
/// process at once (files on disk are consistent: they are only ever renamed into place). One at a
/// time.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  [[nodiscard]] renderer::CancelFlag& flag() const;
  /// kInterrupted after SIGINT, kStopped after SIGTERM, empty if neither came.
  [[nodiscard]] std::optional<ExitStatus> Received() const;
};

}  // namespace pathfit::app
