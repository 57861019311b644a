#pragma once

#include <vector>

#include "renderer/image/image.h"

namespace pathfit::renderer {

/// What is known of a pixel before its colour is looked at.
enum class ObjectHint : unsigned char { kBackground, kMaybeBackground, kMaybeObject, kObject };

/// Tells an object from its background by their colours: two mixtures of Gaussians and the cut of
/// least cost between them, in turns ("GrabCut" [Rother2004]). `encoded`: 3
/// channels, 0..1 as the eye sees them; `hints`: one per pixel, row by row. 1 channel, 1 = object;
/// where the hints leave only one kind, that kind everywhere. Same result for any number of
/// threads. Fails: IoError when the image is empty or has other channels.
Image SegmentByColor(const Image& encoded, const std::vector<ObjectHint>& hints, int num_turns);

/// The largest of the parts of `mask > 0.5` whose pixels share sides, as 1 among 0, without its
/// holes of up to `hole` times as many pixels.
Image LargestPart(const Image& mask, double hole);

/// So with the other parts of at least a twentieth of its pixels that lie mostly where `expected`
/// is above 0.5. Fails: IoError when that has another size.
Image PartsWithin(const Image& mask, const Image& expected, double hole);

}  // namespace pathfit::renderer
