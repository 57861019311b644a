#pragma once

#include <filesystem>
#include <optional>

#include "optim/checkpoint/fit_state.h"

namespace pathfit::optim {

/// Writes `folder`/state_NNNNNN (state.json and .npy arrays) under a temporary name, renames it,
/// and removes all but the two newest states. A state that is there is complete. Throws
/// renderer::IoError.
void WriteCheckpoint(const std::filesystem::path& folder, const FitState& state);

/// The newest readable state; empty if the folder has none or does not exist. Throws
/// renderer::IoError if there are states but none can be read.
std::optional<FitState> ReadNewestCheckpoint(const std::filesystem::path& folder);

}  // namespace pathfit::optim
