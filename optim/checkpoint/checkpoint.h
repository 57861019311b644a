#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "optim/checkpoint/fit_state.h"
#include "optim/parameter/unknown_spec.h"

namespace pathfit::optim {

/// What states are stored relative to: the scene a fit began with and its unknowns. A state holds
/// the values of the unknowns that are not held, and shapes, where they differ from `start`;
/// everything else of its scenes is that of the reader's `start`, whose unknowns and triangles must
/// be the writer's (a checksum tells).
struct FitOrigin {
  const renderer::Scene& start;
  const std::vector<UnknownSpec>& unknowns;
};

/// Writes `folder`/state_NNNNNN.cbor (N = state.sequence) through a temporary name and removes all
/// but the two newest states. Throws renderer::IoError.
///
/// The file is CBOR (RFC 8949): {"format", "crc32c", "payload"}, the payload a byte string of CBOR
/// with the checksum. In it, arrays are byte strings of little-endian float64 or int32, each
/// content once.
void WriteCheckpoint(const std::filesystem::path& folder,
                     const FitOrigin& origin,
                     const FitState& state);

/// Keeps the scene that a stage ended with for as long as the folder: stage_NN.cbor, a state
/// without what rounds add to it. Throws renderer::IoError.
void WriteStageEnd(const std::filesystem::path& folder,
                   const FitOrigin& origin,
                   int stage,
                   const renderer::Scene& scene);
/// Empty if it is not there. Throws renderer::IoError if it is damaged or of another experiment.
std::optional<renderer::Scene> ReadStageEnd(const std::filesystem::path& folder,
                                            const FitOrigin& origin,
                                            int stage);

/// The same without a file: for other processes with the same origin.
std::vector<char> EncodeState(const FitOrigin& origin, const FitState& state);
FitState DecodeState(const FitOrigin& origin, const std::vector<char>& bytes);

struct NewestCheckpoint {
  std::optional<FitState> state;     ///< the newest that is whole; empty if there are no files
  std::vector<std::string> damaged;  ///< why newer ones cannot be read: file and reason
};
/// Throws renderer::IoError with every reason if there are states but none can be read: a flipped
/// bit, a missing end, another version, another
/// experiment.
NewestCheckpoint ReadNewestCheckpoint(const std::filesystem::path& folder, const FitOrigin& origin);

}  // namespace pathfit::optim
