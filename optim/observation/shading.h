#pragma once

#include <vector>

#include "renderer/image/image.h"
#include "renderer/math/vector.h"

namespace pathfit::optim {

/// What photos of a matt surface, each under one far lamp, say without its shape: of every pixel a
/// normal times an albedo, by least squares [Woodham1980].
struct ShadingFit {
  std::vector<double> strengths;  ///< of the lamps, mean 1
  double brightness = 0.0;        ///< median value of a surface that faces a lamp of strength 1
  double residual = 0.0;          ///< rms of what normals do not explain, over that of the values
  /// How the normals lie along the mask's rim, where they point out of it if the lamps' directions
  /// are right: their correlation with the way out by x (right) and by y (up), from -1 to 1.
  renderer::Vec2 outward;
  bool has_rim = false;        ///< whether enough of the rim was seen to tell
  bool strengths_told = true;  ///< known, or told by the shading: by none that is flat
};

/// `photos`: linear, all of the size of `mask` (1 channel, 1 = object), channels are averaged.
/// `towards`: unit vectors to their lamps; x right, y up, z to the viewer. `strengths`: relative
/// ones where they are known, else empty: then they are fitted, too, or where the shading does not
/// tell them those by which a surface that faces the viewer is as bright as the photos. Pixels that
/// some lamp leaves dark are left out where there are others. Throws SceneError unless all sizes
/// agree, there are three photos whose lamps span space, and the mask holds some pixels that are
/// not black.
ShadingFit FitShading(const std::vector<renderer::Image>& photos,
                      const renderer::Image& mask,
                      const std::vector<renderer::Vec3>& towards,
                      const std::vector<double>& strengths);

}  // namespace pathfit::optim
