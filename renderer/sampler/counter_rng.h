#pragma once

#include <cstddef>
#include <cstdint>

namespace pathfit::renderer {

/// What random numbers are drawn for: part of the key of every stream, so that no two uses share
/// numbers. All uses of the program stand here. A technique of boundaries has a stream per way: see
/// OfWay.
enum class RandomDomain : std::uint64_t {
  kOwnSeed = 0,  ///< the seed alone tells the streams apart
  kPixelShift = 1,
  kPixelSample = 2,
  kPrimaryShift = 8,
  kPrimaryPilot = 5,
  kPrimarySample = 3,
  kPixelBorderShift = 9,
  kPixelBorderPilot = 10,
  kPixelBorderSample = 7,
  kDirectShift = 104,
  kDirectPilot = 105,
  kDirectSample = 106,
  kIndirectShift = 204,
  kIndirectPilot = 205,
  kIndirectSample = 206,
  kGuidePilots = 0x67756964,  ///< places of pilots in the cells of a guide
  // The seeds of a fit's renderings, by what they are for.
  kFitSeed = 0x5EED,
  kValidationSeed = 0x5EEE,
  kEvaluationSeed = 0x5EEF,
  kBudgetSeed = 0x5EF2,  ///< of what is measured before a derivative image
  // Signs of shares of the gradient, for standard errors.
  kGradientSign = 0x5EF0,       ///< by pixel
  kPriorSign = 0x5EF1,          ///< by term
  kPhotoNoise = 0x70686f74,     ///< of synthetic photos
  kPhotoExposure = 0x70686f75,  ///< of synthetic photos
  kPhotoPose = 0x70686f76,      ///< what is believed of their cameras
  kFieldDirection = 100,        ///< directions of derivatives over whole fields
};

/// The domain of way 0, 1, ... of a boundary technique.
constexpr RandomDomain OfWay(RandomDomain domain, std::size_t way) {
  return RandomDomain{static_cast<std::uint64_t>(domain) + 1000 * way};
}

/// One sample's stream of uniform numbers, a pure function of its key: no state is shared, so
/// results do not depend on threads or order, and two streams with equal keys are equal (common
/// random numbers). The generator hashes (key, dimension) with the 64-bit finaliser of splitmix64
/// [Steele et al. 2014].
class CounterRng {
 public:
  /// What many streams have in common.
  class Family {
   public:
    explicit Family(std::uint64_t seed,
                    RandomDomain domain = RandomDomain::kOwnSeed,
                    std::uint64_t view = 0)
        : key_(Mix(Mix(seed + kGolden * (static_cast<std::uint64_t>(domain) + 1)) ^
                   (view + kGolden))) {}

   private:
    friend CounterRng;
    std::uint64_t key_;
  };
  /// `element` is a pixel or edge-sample index.
  CounterRng(const Family& family, std::uint64_t element, std::uint64_t sample)
      : state_(Mix(family.key_ ^ (element * kGolden + sample + 1))) {}
  explicit CounterRng(std::uint64_t seed,
                      RandomDomain domain = RandomDomain::kOwnSeed,
                      std::uint64_t view = 0,
                      std::uint64_t element = 0,
                      std::uint64_t sample = 0)
      : CounterRng(Family(seed, domain, view), element, sample) {}

  /// Uniform in [0, 1), the next dimension of the stream.
  double Next() { return static_cast<double>(NextInteger()) * 0x1.0p-53; }
  /// Uniform in [0, 2^53), the next dimension of the stream: bits, or the seed of other streams.
  std::uint64_t NextInteger() {
    state_ += kGolden;
    return Mix(state_) >> 11;
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
