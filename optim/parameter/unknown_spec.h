#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "renderer/scene/parameter_layout.h"

namespace pathfit::optim {

/// How an unknown's scalars are mapped to what the solver moves: theta = x, or theta = log x (x >
/// 0). Gains are always logarithmic. Spot angles are always (u_inner / u_outer, outer) with u = 1 -
/// cos: the inner one stays below, and what the light does is smooth in the ratio.
enum class Parameterization { kIdentity, kLog };

/// Vertices: whether a stage keeps the mesh that it begins with, or takes one of the detail that
/// its images resolve (round/mesh_levels.h).
enum class MeshDetail { kKeep, kLevels };

/// A constant of a material that vertex colours or texels of the unknown take the place of, once a
/// stage frees them (round/surface_levels.h).
struct Promotion {
  renderer::ParameterKind property =
      renderer::ParameterKind::kBaseColor;  ///< kRoughness, kMetallic
  int material = 0;
  friend bool operator==(const Promotion&, const Promotion&) = default;
};

struct GaussianPriorSpec {
  /// One value for all components, or one per component; empty: the values that the run began with.
  std::vector<double> mean;
  double sigma = 1.0;  ///< in units of the parameter
};

/// Of each photo's log2 gain, over that it began with.
struct ExposurePrior {
  double sigma_ev = 0.3;  ///< of their differences, where a light is known (prior/prior_terms.h)
  double max_ev = 3.0;    ///< bound of its magnitude
};

/// Whether it is a gain of photos: their exposures and white balances.
constexpr bool IsOfExposure(renderer::ParameterKind kind) {
  return kind == renderer::ParameterKind::kExposure ||
         kind == renderer::ParameterKind::kWhiteBalance;
}

/// Of vertices that are free without a word about them. Photos leave single vertices undetermined:
/// steps without a metric are refused as folds until nothing moves at all. The weight by distance
/// to the true surface: random scenes (5e-4 to 2e-3 are alike, 2e-2 is too much), Suzanne from a
/// sphere (3e-3; 3e-4 folds).
inline constexpr double kDefaultLargeSteps = 19.0;
inline constexpr double kDefaultLaplacian = 2e-3;

/// Total variation of texels that take the place of a constant, without a word about them.
inline constexpr double kDefaultTexelVariation = 3e-4;
/// Of roughness. Photos say less of one texel's roughness than their noise: by 24 photos of 64
/// pixels, with the weight of colours, a cow of roughness .25 to .5 has texels at both bounds. By
/// photos of 256 pixels its roughness is .073 off after 5 minutes with this weight, held-out photos
/// of 128 pixels 38.6 dB; with three times it .089 and 35.9, with .4 times .077 and 38.3. By photos
/// of 64 pixels three times it is a little better (.125 instead of .131; grey start .156).
inline constexpr double kDefaultRoughnessVariation = 1e-3;

/// Of vertex colours, without a word about them: those that hardly any photo sees followed the
/// renderings' noise to the bounds. A stool's seat from below, 3 of 21 photos of 100 pixels: held
/// out 17.2 dB without, 21.8 with; an axe the same either way.
inline constexpr double kDefaultColorSmooth = 3e-4;

/// Of the texels of a map of the surroundings, without a word about them: neighbours are believed
/// to be alike within the root of a factor of e. Those that nothing tells took steps of several
/// such factors in each round for ever.
inline constexpr double kDefaultLogSmooth = 4.0;

/// Prior beliefs and step control of one unknown; weight 0 or empty = absent. Only those that fit
/// the kind may be set. How the weights compare with the photos: optim/prior/prior_terms.h.
struct UnknownSpec {
  std::string name;  ///< "axe.vertices", "sky.texels", "exposure", "camera.position"
  renderer::ParameterKind kind = renderer::ParameterKind::kVertexPositions;
  int object = 0;  ///< -1 for what sensors have: each of them
  /// Of all sensors: by sensor the first one that has the same numbers, such as the lens of one
  /// camera; empty: each has its own.
  std::vector<int> sharing;
  Parameterization parameterization = Parameterization::kIdentity;
  double lower =
      -std::numeric_limits<double>::infinity();  ///< per scalar, in units of the parameter
  double upper = std::numeric_limits<double>::infinity();
  bool hold = false;  ///< known to the program, never freed

  MeshDetail mesh_detail = MeshDetail::kKeep;
  std::optional<Promotion> promotion;  ///< of vertex colours and texels

  double laplacian_weight = 0.0;        ///< vertices: weight of |x - mean of neighbours|^2 / edge^2
  double large_steps_lambda = 0.0;      ///< vertices: metric I + lambda L of the proximal damping
  double smooth_weight = 0.0;           ///< texels, vertex colours: differences of neighbours
  double total_variation_weight = 0.0;  ///< texels: size of the slope, which spares edges
  double log_smooth_weight = 0.0;  ///< environment texels: logarithms' differences of neighbours
  double neutral_weight = 0.0;     ///< environment texels: distance of each texel from its own grey
  double binary_weight = 0.0;      ///< metallic: distance from 0 or 1
  std::optional<GaussianPriorSpec> gaussian;
};

}  // namespace pathfit::optim
