#pragma once

#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "renderer/math/box.h"

namespace pathfit::app {

/// A piece of the line between what is in a picture and what is not: pixel coordinates.
struct OutlinePiece {
  renderer::Vec2 from, to;
};
/// Where an image of one channel passes 1/2, closed along its border, by linear interpolation
/// between the centres of pixels.
std::vector<OutlinePiece> Outline(const renderer::Image& image);

/// One photo and the scene a fit begins with, at low resolution.
struct ViewStart {
  std::string name;
  bool validation = false;
  double covered = 0.0;               ///< share of the picture in which the scene's meshes are seen
  double masked = 0.0;                ///< share of the picture that is mask; NaN without one
  double evidence = 0.0;              ///< share of the picture whose colours are compared
  double iou = 0.0;                   ///< of silhouette and mask; NaN unless masks are silhouettes
  int width = 0, height = 0;          ///< of the low resolution
  std::vector<OutlinePiece> outline;  ///< of the scene's meshes
  std::vector<OutlinePiece> mask_outline;  ///< of the mask, whatever it means
};

struct StartCheck {
  std::vector<ViewStart> views;       ///< in the order of the observations
  std::vector<std::string> warnings;  ///< what makes a good fit unlikely, with the likely reason
  renderer::Box box;                  ///< around all meshes
};

/// Looks at the photos beside renderings of the start. Empty without photos. Throws what leaves
/// nothing to fit: ObservationError (all masks are black), ConfigError (nothing is left of them
/// inside the eroded rim), SceneError (no fitted photo shows any mesh).
StartCheck CheckStart(const ExperimentConfig& config, const Experiment& experiment);

/// Share of a mask's border pixels that are white; of an inverted mask more than kWhiteBorder.
double WhiteBorder(const renderer::Image& mask);
inline constexpr double kWhiteBorder = 0.7;

}  // namespace pathfit::app
