#pragma once

#include "renderer/image/image.h"

namespace pathfit::renderer {

/// Pixels x0..x1 by y0..y1, all included; none if x1 < x0.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
};
/// Around the pixels whose first channel is above `level`.
PixelBox BoxAbove(const Image& image, float level);

/// Mean of a pixel's channels.
double MeanOfChannels(const Image& image, int x, int y);

/// Each pixel becomes the average of the source over the pixel's area, exactly, for shrinking and
/// growing alike. Fails: IoError when the image is empty or the new size is not positive.
Image ResizeArea(const Image& image, int width, int height);

/// Distance of each pixel centre to the boundary of `mask > 0.5`, in pixels, positive inside; 1
/// channel. Zero lies midway between pixels of the two kinds. The image's border is no boundary; a
/// mask of one kind is width + height away from one. Fails: IoError when the mask is empty or has
/// more than 1 channel.
Image SignedDistanceToMask(const Image& mask);

/// 1 where every pixel up to `px` pixels away (centre to centre) has mask > 0.5, otherwise 0; the
/// image's border erodes nothing. Fails: as SignedDistanceToMask, and when px is negative.
Image Erode(const Image& mask, int px);

}  // namespace pathfit::renderer
