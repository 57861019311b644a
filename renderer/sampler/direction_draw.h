#pragma once

namespace pathfit::renderer {

/// How the direction at a vertex is drawn: by the BSDF, or as one of the two halves of an even
/// mixture of BSDF and uniform directions, which both divide by the mixture's density.
enum class DirectionDraw { kBsdf, kMixedBsdf, kMixedUniform };

}  // namespace pathfit::renderer
