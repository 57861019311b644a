#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "renderer/sampler/counter_rng.h"

namespace pathfit::renderer {

/// Uniform numbers of one sample of a pixel. The first kDimensions (pixel position, first light and
/// direction choice) come from a rank-1 lattice shifted per pixel, so that the samples of one pixel
/// spread evenly; each alone is uniform. Later dimensions are independent.
class LatticeSampler {
 public:
  static constexpr int kDimensions = 7;

  /// `shift` must be equal for all samples of a pixel and independent between pixels.
  LatticeSampler(CounterRng shift, CounterRng independent, std::uint64_t sample)
      : shift_(shift), independent_(independent), sample_(static_cast<double>(sample)) {}

  double Next() {
    if (dimension_ >= kDimensions) {
      return independent_.Next();
    }
    const double x = shift_.Next() + sample_ * kAlpha[static_cast<std::size_t>(dimension_++)];
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
  CounterRng shift_, independent_;
  double sample_;
  int dimension_ = 0;
};

}  // namespace pathfit::renderer
