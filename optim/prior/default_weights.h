#pragma once

namespace pathfit::optim {

/// Total variation of roughness that takes the place of a constant, without a word about it (of
/// colours: kDefaultTexelVariation). Photos say less of one texel's roughness than their noise: by
/// 24 photos of 64 pixels, with the weight of colours, a cow of roughness .25 to .5 has texels at
/// both bounds (rms .189, grey start .156), which cost its colours and held-out photos, too; .136
/// and 2 dB better with this one; with ten times that 12 rounds move nothing.
inline constexpr double kDefaultRoughnessVariation = 3e-3;

}  // namespace pathfit::optim
