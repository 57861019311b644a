#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>

#include "renderer/sampler/counter_rng.h"

namespace pathfit::renderer {

/// How the direction at a vertex is drawn: by the BSDF, or as one of the two halves of an even
/// mixture of BSDF and uniform directions, which both divide by the mixture's density.
enum class DirectionDraw { kBsdf, kMixedBsdf, kMixedUniform };

/// Where the numbers of a path come from, each uniform in [0, 1).
template <class S>
concept PathSampler = requires(S& sampler, const S& constant, int bounce, int component) {
  { sampler.Next() } -> std::same_as<double>;
  /// For a choice on a light.
  { sampler.NextLight() } -> std::same_as<double>;
  /// As component 0 or 1 of the direction choice at a bounce (from 1).
  { sampler.NextDirection(bounce, component) } -> std::same_as<double>;
  { constant.DrawAt(bounce) } -> std::same_as<DirectionDraw>;
};

/// Uniform numbers without lattice.
class IndependentSampler {
 public:
  explicit IndependentSampler(CounterRng rng) : rng_(rng) {}
  double Next() { return rng_.Next(); }
  double NextDirection(int /*bounce*/, int /*component*/) { return Next(); }
  double NextLight() { return Next(); }
  static DirectionDraw DrawAt(int /*bounce*/) { return DirectionDraw::kBsdf; }

 private:
  CounterRng rng_;
};

/// Uniform numbers of one sample of a pixel. The first kDimensions (pixel position, first light and
/// direction choice) come from a rank-1 lattice shifted per pixel, so that the samples of one pixel
/// spread evenly; each alone is uniform. Later dimensions are independent.
class LatticeSampler {
 public:
  static constexpr int kDimensions = 7;

  /// The lattice of one pixel.
  class Shift {
   public:
    /// `numbers` must be independent between pixels.
    explicit Shift(CounterRng numbers) {
      for (double& by : by_) {
        by = numbers.Next();
      }
    }

    /// By how much a dimension is shifted, in [0, 1).
    [[nodiscard]] double Of(std::size_t dimension) const { return by_[dimension]; }

   private:
    std::array<double, kDimensions> by_{};
  };
  /// `shift`: that of all samples of the pixel; must outlive the sampler.
  LatticeSampler(const Shift& shift, CounterRng independent, std::uint64_t sample)
      : shift_(&shift), independent_(independent), sample_(static_cast<double>(sample)) {}

  LatticeSampler(Shift&& shift, CounterRng independent, std::uint64_t sample) = delete;

  static DirectionDraw DrawAt(int /*bounce*/) { return DirectionDraw::kBsdf; }
  /// Moves all numbers that choose points on lights: the second path of a pair, which shares the
  /// other numbers, should not sample the same lights again.
  void ShiftLights(double shift) { light_shift_ = shift; }
  /// The next number, for a choice on a light.
  double NextLight() {
    const double moved = Next() + light_shift_;
    return moved - std::floor(moved);
  }
  double NextDirection(int /*bounce*/, int /*component*/) { return Next(); }

  double Next() {
    if (dimension_ >= kDimensions) return independent_.Next();
    const auto i = static_cast<std::size_t>(dimension_++);
    const double x = shift_->Of(i) + sample_ * kAlpha[i];
    return x - std::floor(x);
  }

 private:
  // Powers of 1/phi_7, where phi_7 is the root of x^8 = x + 1: the generalised golden ratio of
  // seven dimensions.
  static constexpr double kInversePhi = 0.9115923534820549;
  static constexpr std::array<double, kDimensions> kAlpha = {
      kInversePhi,
      kInversePhi* kInversePhi,
      kInversePhi* kInversePhi* kInversePhi,
      kInversePhi* kInversePhi* kInversePhi* kInversePhi,
      kInversePhi* kInversePhi* kInversePhi* kInversePhi* kInversePhi,
      kInversePhi* kInversePhi* kInversePhi* kInversePhi* kInversePhi* kInversePhi,
      kInversePhi* kInversePhi* kInversePhi* kInversePhi* kInversePhi* kInversePhi* kInversePhi};
  const Shift* shift_;
  CounterRng independent_;
  double sample_;
  int dimension_ = 0;
  double light_shift_ = 0.0;
};

/// The same whose directions at some vertices are moved, or drawn in another way.
class ShiftedSampler : public LatticeSampler {
 public:
  explicit ShiftedSampler(const LatticeSampler& numbers) : LatticeSampler(numbers) {}

  static constexpr std::size_t kMaxShifts = 4;
  /// Moves the two numbers that choose the direction at the vertex of this bounce (from 1) around
  /// the unit square, and says how they choose it; for up to kMaxShifts different bounces.
  void ShiftDirection(int bounce, double shift0, double shift1, DirectionDraw draw) {
    shifts_[num_shifts_++] = {bounce, {shift0, shift1}, draw};
  }
  /// How the direction at the vertex of this bounce is drawn.
  [[nodiscard]] DirectionDraw DrawAt(int bounce) const {
    for (std::size_t i = 0; i < num_shifts_; ++i) {
      if (shifts_[i].bounce == bounce) return shifts_[i].draw;
    }
    return DirectionDraw::kBsdf;
  }
  [[nodiscard]] bool CanShift() const { return num_shifts_ < kMaxShifts; }
  /// The next number, as component 0 or 1 of the direction choice at a bounce.
  double NextDirection(int bounce, int component) {
    double x = Next();
    for (std::size_t i = 0; i < num_shifts_; ++i) {
      if (shifts_[i].bounce == bounce) {
        x += shifts_[i].by[static_cast<std::size_t>(component)];
        x -= std::floor(x);
      }
    }
    return x;
  }

 private:
  struct Shift {
    int bounce = 0;
    std::array<double, 2> by{};
    DirectionDraw draw = DirectionDraw::kBsdf;
  };
  std::array<Shift, kMaxShifts> shifts_{};
  std::size_t num_shifts_ = 0;
};

}  // namespace pathfit::renderer
