#include "optim/round/seed_policy.h"

#include <algorithm>
#include <cmath>

#include "renderer/sampler/counter_rng.h"

namespace pathfit::optim {
namespace {

std::uint64_t MakeSeed(
    std::uint64_t seed, int stage, int round, SampleUse use, std::uint64_t half) {
  renderer::CounterRng rng(
      seed,
      renderer::RandomDomain{static_cast<std::uint64_t>(renderer::RandomDomain::kSeedOfRender) +
                             static_cast<std::uint64_t>(use)},
      static_cast<std::uint64_t>(stage),
      static_cast<std::uint64_t>(round),
      half);
  return static_cast<std::uint64_t>(rng.Next() * 0x1.0p53);
}

}  // namespace

int SamplesOfRound(const StageSpec& stage, int round) {
  const double grown = stage.samples.spp * std::pow(std::max(1.0, stage.spp_growth), round - 1);
  const double limited =
      std::min(grown, static_cast<double>(std::max(stage.samples.spp, stage.max_spp)));
  return std::max(2, 2 * static_cast<int>(std::lround(0.5 * limited)));
}

SampleHalves MakeHalves(
    std::uint64_t seed, int stage, int round, SampleUse use, const renderer::SampleBudget& both) {
  const renderer::SampleBudget half = both.Scaled(0.5);
  return {{half, MakeSeed(seed, stage, round, use, 0)},
          {half, MakeSeed(seed, stage, round, use, 1)}};
}

}  // namespace pathfit::optim
