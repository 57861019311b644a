#pragma once

#include <cstdint>

#include "optim/problem/image_source.h"
#include "optim/round/fit_spec.h"

namespace pathfit::optim {

/// Why samples are drawn; each use of a round has its own stream.
enum class SampleUse : std::uint64_t { kFit = 0, kValidation = 1, kEvaluation = 2 };

/// Samples per pixel of both halves together in a round (from 1): spp * growth^(round - 1), even,
/// at most max_spp.
int SamplesOfRound(const StageSpec& stage, int round);

/// Two halves with seeds of (seed, stage, round, use, half); the budgets of `both` are of both
/// together, at least 1 interior sample each.
SampleHalves MakeHalves(
    std::uint64_t seed, int stage, int round, SampleUse use, const renderer::SampleBudget& both);

}  // namespace pathfit::optim
