#pragma once

#include <cstdint>

namespace pathfit::renderer {

/// One sample's stream of uniform numbers, a pure function of its key: no state is shared, so
/// results do not depend on threads or order, and two streams with equal keys are equal (common
/// random numbers). The generator hashes (key, dimension) with the 64-bit finaliser of splitmix64
/// [Steele et al. 2014].
class CounterRng {
 public:
  /// `domain` separates the uses (interior, primary boundary, ...); `element` is a pixel or
  /// edge-sample index.
  CounterRng(std::uint64_t seed,
             std::uint64_t domain,
             std::uint64_t view,
             std::uint64_t element,
             std::uint64_t sample)
      : state_(Mix(Mix(Mix(seed + kGolden * (domain + 1)) ^ (view + kGolden)) ^
                   (element * kGolden + sample + 1))) {}

  /// Uniform in [0, 1), the next dimension of the stream.
  double Next() {
    state_ += kGolden;
    return static_cast<double>(Mix(state_) >> 11) * 0x1.0p-53;
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15ULL;
  static std::uint64_t Mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace pathfit::renderer
