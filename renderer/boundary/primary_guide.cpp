#include "renderer/boundary/primary_guide.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "renderer/core/check.h"
#include "renderer/core/parallel.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::renderer {
namespace {

constexpr std::int64_t kPilotsPerTask = 64;

// Grid.
constexpr double kPilotsPerGridCell = 4.0;
constexpr double kGridElongation = 32.0;  // cells along the first axis per cell along another
constexpr double kSlabPilots = 2.0;       // what the mean of a slab counts in each of its cells

// Adaptive.
constexpr int kNumRounds = 6;
constexpr double kFirstRound = 0.25;      // share of the pilots that is spread evenly
constexpr double kEvenShare = 0.4;        // of later rounds, over the cells
constexpr std::size_t kLeastPilots = 16;  // of a cell, on average over the halves of a split
constexpr double kParentPilots = 8.0;     // what the parent's mean square counts in a cell
constexpr std::size_t kMaxSlabs = 1024;   // looked at to choose an axis
constexpr double kLeastGain = 0.01;       // of a cell's root mean square by splitting it
constexpr double kNoiseFactor = 2.0;      // times the gain that noise alone is expected to feign

// Multiples of these fill the cube evenly: powers of the inverse of the root of x^4 = x + 1.
constexpr std::array<double, 3> kSteps = {
    0.8191725133961644, 0.6710436067037892, 0.5497004779019702};

struct PilotSample {
  std::array<double, 3> u{};
  double value = 0.0;
};

bool IsUsable(const PilotSample& p) { return std::isfinite(p.value * p.value); }

void Evaluate(const GuidePilot& pilot, std::int64_t first_index, std::span<PilotSample> samples) {
  const auto count = static_cast<std::int64_t>(samples.size());
  ParallelFor((count + kPilotsPerTask - 1) / kPilotsPerTask, [&](std::int64_t task) {
    const std::int64_t end = std::min(count, (task + 1) * kPilotsPerTask);
    for (std::int64_t i = task * kPilotsPerTask; i < end; ++i) {
      PilotSample& p = samples[static_cast<std::size_t>(i)];
      p.value = pilot(p.u, first_index + i);
    }
  });
}

/// Points spread evenly over a cell, shifted by random numbers keyed by `key`.
void Spread(const GuideCell& cell, std::uint64_t key, std::span<PilotSample> samples) {
  CounterRng rng(0, RandomDomain::kGuidePilots, 0, key);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double shift = rng.Next();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double x = shift + static_cast<double>(i) * kSteps[axis];
      samples[i].u[axis] =
          std::min(cell.low[axis] + cell.size[axis] * (x - std::floor(x)), 1.0 - 0x1.0p-53);
    }
  }
}

double SquareSum(std::span<const PilotSample> samples) {
  double sum = 0.0;
  for (const PilotSample& p : samples) {
    sum += p.value * p.value;
  }
  return sum;
}

/// A cell on its way down, with all pilots that fell into it.
struct Leaf {
  GuideCell cell;
  double prior = 0.0;  // mean square of the parent, or of its own while it has none
  std::vector<PilotSample> pilots;

  /// Mean square, the parent's counting as some pilots: a cell whose own are all zero is not empty.
  [[nodiscard]] double MeanSquare() const {
    return (SquareSum(pilots) + kParentPilots * prior) /
           (static_cast<double>(pilots.size()) + kParentPilots);
  }
};

/// How much smaller the mean of the root mean squares gets by cutting the leaf into slabs across an
/// axis: the best number of slabs, less what noise feigns.
double SplitGain(const Leaf& leaf, std::size_t axis) {
  const auto n = static_cast<double>(leaf.pilots.size());
  const double mean_square = leaf.MeanSquare();
  double fourth = 0.0;
  std::size_t slabs = 2;
  while (2 * slabs <= kMaxSlabs && 2 * slabs * kLeastPilots <= leaf.pilots.size()) {
    slabs *= 2;
  }
  std::vector<double> sums(slabs);
  std::vector<double> counts(slabs);
  const double scale = static_cast<double>(slabs) / leaf.cell.size[axis];
  for (const PilotSample& p : leaf.pilots) {
    const auto at = static_cast<std::size_t>((p.u[axis] - leaf.cell.low[axis]) * scale);
    const double square = p.value * p.value;
    sums[std::min(at, slabs - 1)] += square;
    counts[std::min(at, slabs - 1)] += 1.0;
    fourth += square * square / n;
  }
  const double variance = std::max(0.0, fourth / (mean_square * mean_square) - 1.0);
  double best = 0.0;
  for (; slabs >= 2; slabs /= 2) {
    double sum = 0.0;
    for (std::size_t i = 0; i < slabs; ++i) {
      sum += std::sqrt((sums[i] + kParentPilots * mean_square) / (counts[i] + kParentPilots));
    }
    const auto num_slabs = static_cast<double>(slabs);
    const double in_slab = n / num_slabs;
    const double weight = in_slab / (in_slab + kParentPilots);
    const double noise = variance / (8.0 * in_slab) * weight * weight;
    const double gain = 1.0 - sum / (num_slabs * std::sqrt(mean_square));
    best = std::max(best, gain - kNoiseFactor * noise);
    for (std::size_t i = 0; i < slabs / 2; ++i) {
      sums[i] = sums[2 * i] + sums[2 * i + 1];
      counts[i] = counts[2 * i] + counts[2 * i + 1];
    }
  }
  return best;
}

/// Appends the leaf or, in order, the parts into which it is split.
void SplitInto(Leaf leaf, int dimensions, std::vector<Leaf>& out) {
  const double mean_square = leaf.MeanSquare();
  double best = kLeastGain;
  int axis = -1;
  if (leaf.pilots.size() >= 2 * kLeastPilots && mean_square > 0.0) {
    for (int i = 0; i < dimensions; ++i) {
      const double gain = SplitGain(leaf, static_cast<std::size_t>(i));
      if (gain > best) {
        best = gain;
        axis = i;
      }
    }
  }
  if (axis < 0) {
    out.push_back(std::move(leaf));
    return;
  }
  const auto k = static_cast<std::size_t>(axis);
  std::array<Leaf, 2> halves;
  for (Leaf& half : halves) {
    half.cell = leaf.cell;
    half.cell.size[k] *= 0.5;
    half.prior = mean_square;
  }
  halves[1].cell.low[k] += halves[1].cell.size[k];
  for (const PilotSample& p : leaf.pilots) {
    halves[p.u[k] < halves[1].cell.low[k] ? 0 : 1].pilots.push_back(p);
  }
  leaf.pilots = {};
  for (Leaf& half : halves) {
    SplitInto(std::move(half), dimensions, out);
  }
}

/// How many of `budget` pilots each leaf gets.
std::vector<std::int64_t> Allot(const std::vector<Leaf>& leaves, std::int64_t budget) {
  double total = 0.0;
  std::vector<double> masses;
  for (const Leaf& leaf : leaves) {
    masses.push_back(leaf.cell.Volume() * std::sqrt(leaf.MeanSquare()));
    total += masses.back();
  }
  const double even = 1.0 / static_cast<double>(leaves.size());
  std::vector<std::int64_t> counts;
  double sum = 0.0;
  std::int64_t given = 0;
  for (const double mass : masses) {
    sum += total > 0.0 ? kEvenShare * even + (1.0 - kEvenShare) * mass / total : even;
    const auto until = static_cast<std::int64_t>(std::llround(sum * static_cast<double>(budget)));
    counts.push_back(std::max<std::int64_t>(0, std::min(until, budget) - given));
    given += counts.back();
  }
  return counts;
}

}  // namespace

std::vector<GuideCell> GridCells(int dimensions, std::int64_t num_pilots, const GuidePilot& pilot) {
  const double wanted = std::max(1.0, static_cast<double>(num_pilots) / kPilotsPerGridCell);
  std::array<std::size_t, 3> resolution = {1, 1, 1};
  double across = 1.0;
  for (int i = 1; i < dimensions; ++i) {
    const double side = std::pow(wanted / kGridElongation, 1.0 / dimensions);
    resolution[static_cast<std::size_t>(i)] = static_cast<std::size_t>(std::max(1.0, side));
    across *= static_cast<double>(resolution[static_cast<std::size_t>(i)]);
  }
  resolution[0] = static_cast<std::size_t>(std::max(1.0, wanted / across));
  const std::size_t in_slab = resolution[1] * resolution[2];
  std::vector<GuideCell> cells(resolution[0] * in_slab);
  const auto count = static_cast<std::size_t>(num_pilots);
  std::vector<PilotSample> samples(count);
  const auto first_of = [&](std::size_t cell) { return cell * count / cells.size(); };
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const std::array<std::size_t, 3> at = {
        c / in_slab, c / resolution[2] % resolution[1], c % resolution[2]};
    for (std::size_t i = 0; i < 3; ++i) {
      cells[c].size[i] = 1.0 / static_cast<double>(resolution[i]);
      cells[c].low[i] = static_cast<double>(at[i]) * cells[c].size[i];
    }
    Spread(cells[c], c, std::span(samples).subspan(first_of(c), first_of(c + 1) - first_of(c)));
  }
  Evaluate(pilot, 0, samples);
  const auto usable = [&](std::size_t first, std::size_t last) {
    std::vector<PilotSample> out;
    std::copy_if(samples.begin() + static_cast<std::ptrdiff_t>(first),
                 samples.begin() + static_cast<std::ptrdiff_t>(last),
                 std::back_inserter(out),
                 IsUsable);
    return out;
  };
  for (std::size_t slab = 0; slab < resolution[0]; ++slab) {
    const auto of_slab = usable(first_of(slab * in_slab), first_of((slab + 1) * in_slab));
    const double slab_square =
        SquareSum(of_slab) / static_cast<double>(std::max<std::size_t>(1, of_slab.size()));
    for (std::size_t c = slab * in_slab; c < (slab + 1) * in_slab; ++c) {
      const auto pilots = usable(first_of(c), first_of(c + 1));
      const auto n = static_cast<double>(pilots.size());
      for (const PilotSample& p : pilots) {
        cells[c].mean += p.value / n;
      }
      cells[c].mean_square = (SquareSum(pilots) + kSlabPilots * slab_square) / (n + kSlabPilots);
    }
  }
  return cells;
}

std::vector<GuideCell> AdaptiveCells(int dimensions,
                                     std::int64_t num_pilots,
                                     const GuidePilot& pilot) {
  std::vector<Leaf> leaves(1);
  std::int64_t done = 0;
  std::uint64_t key = 0;
  for (int round = 0; round < kNumRounds; ++round) {
    const double share = kFirstRound + (1.0 - kFirstRound) * round / (kNumRounds - 1);
    const auto until =
        std::max(done, static_cast<std::int64_t>(share * static_cast<double>(num_pilots)));
    const std::vector<std::int64_t> counts = Allot(leaves, until - done);
    std::vector<PilotSample> samples(static_cast<std::size_t>(until - done));
    std::size_t first = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      const auto count = static_cast<std::size_t>(counts[i]);
      Spread(leaves[i].cell, key++, std::span(samples).subspan(first, count));
      first += count;
    }
    Evaluate(pilot, done, samples);
    done = until;
    first = 0;
    std::vector<Leaf> next;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      const auto count = static_cast<std::size_t>(counts[i]);
      const auto fresh = std::span(samples).subspan(first, count);
      first += count;
      std::copy_if(fresh.begin(), fresh.end(), std::back_inserter(leaves[i].pilots), IsUsable);
      if (round == 0 && !leaves[i].pilots.empty()) {
        leaves[i].prior =
            SquareSum(leaves[i].pilots) / static_cast<double>(leaves[i].pilots.size());
      }
      SplitInto(std::move(leaves[i]), dimensions, next);
    }
    leaves = std::move(next);
  }
  std::vector<GuideCell> cells;
  for (const Leaf& leaf : leaves) {
    cells.push_back(leaf.cell);
    for (const PilotSample& p : leaf.pilots) {
      cells.back().mean += p.value / static_cast<double>(leaf.pilots.size());
    }
    cells.back().mean_square = leaf.MeanSquare();
  }
  return cells;
}

PrimaryGuide PrimaryGuide::Build(GuideKind kind,
                                 int dimensions,
                                 std::int64_t num_pilots,
                                 const GuidePilot& pilot) {
  PATHFIT_CHECK(dimensions >= 1 && dimensions <= 3);
  if (kind == GuideKind::kNone || num_pilots <= 0) {
    return {};
  }
  return PrimaryGuide(kind == GuideKind::kGrid ? GridCells(dimensions, num_pilots, pilot)
                                               : AdaptiveCells(dimensions, num_pilots, pilot));
}

PrimaryGuide::PrimaryGuide(std::span<const GuideCell> cells) {
  double total = 0.0;
  for (const GuideCell& cell : cells) {
    total += cell.Volume() * std::sqrt(cell.mean_square);
    mass_ += cell.Volume() * cell.mean;
  }
  if (!(total > 0.0) || !std::isfinite(total)) {
    return;
  }
  double sum = 0.0;
  for (const GuideCell& cell : cells) {
    const double pdf = kUniformShare + (1.0 - kUniformShare) * std::sqrt(cell.mean_square) / total;
    cells_.push_back({cell.low, cell.size, pdf});
    cumulative_.push_back(sum);
    sum += pdf * cell.Volume();
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {  // what rounding left of 1
    cells_[i].pdf /= sum;
    cumulative_[i] /= sum;
  }
}

PrimaryGuide::Draw PrimaryGuide::Sample(double u0, double u1, double u2) const {
  Draw draw{{u0, u1, u2}, 1.0};
  if (cells_.empty()) {
    return draw;
  }
  const auto above = std::upper_bound(cumulative_.begin() + 1, cumulative_.end(), u0);
  const auto index = static_cast<std::size_t>(above - cumulative_.begin()) - 1;
  const Cell& cell = cells_[index];
  const double end = index + 1 < cells_.size() ? cumulative_[index + 1] : 1.0;
  draw.u[0] = (u0 - cumulative_[index]) / (end - cumulative_[index]);
  for (std::size_t i = 0; i < 3; ++i) {
    draw.u[i] = std::clamp(cell.low[i] + cell.size[i] * draw.u[i], 0.0, 1.0 - 0x1.0p-53);
  }
  draw.pdf = cell.pdf;
  return draw;
}

GuideStore::GuideStore() : guides_(std::make_unique<Guides>()) {}
GuideStore::~GuideStore() = default;

void GuideStore::Clear() { guides_->of.clear(); }

}  // namespace pathfit::renderer
