#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "renderer/scene/scene.h"

namespace ceres {
class CostFunction;
class LossFunction;
}  // namespace ceres

namespace pathfit::optim {

/// One prior residual of one or more groups of rows, each of as many rows as its blocks have
/// components. With K = blocks.size(), row c of group g is
///   r_gc = sum_k weights[g K + k] y_k,c - offset_c,   y = x (units of the scene), or theta if
/// `in_theta`; with `neutral`, y_k,c is replaced by its distance from the mean of the block's
/// components; with `binary`, by y (1 - y). The cost is rho(|r|^2) / 2 with rho(s) = s, or, if
/// `edge` e is not zero, rho(s) = 2 e (sqrt(s + e^2) - e): s where |r| is well below e, 2 e |r| far
/// above.
struct PriorTerm {
  std::vector<std::int32_t> blocks;
  std::vector<double> weights;
  std::array<double, 3> offset{};
  bool in_theta = false;
  bool neutral = false;
  bool binary = false;
  double edge = 0.0;
  double belief = 0.0;  ///< its residual is believed to be normal with this deviation; 0: no belief

  [[nodiscard]] std::size_t NumGroups() const { return weights.size() / blocks.size(); }
};

/// A prior of one weight. A new one is its row and formula in prior_terms.cpp, its member of
/// UnknownSpec and the kinds that it suits (renderer/scene/parameter_kinds.cpp).
struct WeightedPrior {
  const char* name;  ///< in the config, and in ParameterTraits::priors
  const char* doc;   ///< for the config's reference
  double UnknownSpec::*weight;
};
std::vector<WeightedPrior> WeightedPriors();

/// Noise of a good photo's pixel-channel: a belief weighed by more drags what photos do tell.
inline constexpr double kGaussianResidual = 0.02;

/// Prior terms of the active unknowns. `run_start` has the values of Gaussian priors around the
/// start, `scene` everything else. `num_channels` is the solver's unit of cost
/// (problem/fit_views.h): the photos cost the sum over valid pixel-channels of half the squared
/// residual there, and reports divide by num_channels. In reported units the weights w mean
///   Laplacian:  w/2 * mean over vertices of |x - mean of neighbours|^2 / edge^2, edge = the mesh's
///               mean edge length in `scene`;
///   smooth:     w/2 * mean over neighbouring texels (or mesh edges) of |difference|^2, channels
///               summed; an environment's pairs count by the cosine of their latitude, its rows
///               wrap around; those of a texture wrap around in both directions if it repeats;
///   total variation: w * mean over texels of sqrt(|d|^2 + e^2) - e, d the differences to the right
///               and the lower neighbour in all channels, e = kTotalVariationEdge; neighbours and
///               weights as for smooth;
///   both of a texture whose UVs are an atlas (renderer::IsAtlas): means over the surface instead,
///               d the slope there times the side of the mean texel (half of |d|^2 for smooth,
///               whose pairs are two for a texel); jumps across seams count as slopes over that
///               side, texels that no lookup uses do not;
///   log smooth: the differences of neighbours' theta (logarithms) are believed to be normal with
///               the standard deviation 1 / sqrt(w), as by Gaussian priors below, but with
///               `unexplained` for kGaussianResidual;
///   neutral:    w/2 * mean over texels of |texel - its grey|^2;
///   binary:     w/2 * mean over numbers of (x (1 - x))^2, the squared distance near 0 and near 1;
///   Gaussian:   (x - mean)/sigma = 1 costs as much as one pixel-channel with residual
///               kGaussianResidual, so that it decides only what the photos leave open. The gains'
///               prior is of this kind, on log2 gain; where a light is known, on the distance from
///               their mean, and that of the mean is ExposurePrior::max_ev: in what unit photos
///               measure the light is another question than how alike they are.
/// `unexplained`: what the scene leaves of a pixel-channel (UnexplainedResidual).
std::vector<PriorTerm> BuildPriorTerms(const renderer::Scene& run_start,
                                       const renderer::Scene& scene,
                                       const std::vector<UnknownSpec>& unknowns,
                                       const ParameterSet& set,
                                       const ExposureModel& exposure,
                                       double num_channels,
                                       double unexplained = kGaussianResidual);

/// In units of the texels: differences well below it are smoothed as by `smooth`, those well above
/// cost by their size only.
inline constexpr double kTotalVariationEdge = 0.01;
inline constexpr std::size_t kMaxPriorRows = 6;

/// Step control, not belief: sqrt(mu) (I + lambda L)(x - x_round) for every vertex group with
/// lambda > 0, L the graph Laplacian (degree minus adjacency) [Nicolet et al. 2021]. `values`:
/// x_round.
std::vector<PriorTerm> BuildProximalTerms(const renderer::Scene& scene,
                                          const std::vector<UnknownSpec>& unknowns,
                                          const ParameterSet& set,
                                          const std::vector<double>& values,
                                          double mu);

/// Residual of a term (NumGroups() times components, group by group) and, where `jacobians` and its
/// entries are not null, d r / d theta of each block (rows x components, row-major).
/// `theta_blocks[k]` points to the unknowns of term.blocks[k].
void EvalPrior(const PriorTerm& term,
               const ParameterSet& set,
               double const* const* theta_blocks,
               double* residual,
               double** jacobians);

/// EvalPrior for the solver. `term` and `set` must outlive it.
std::unique_ptr<ceres::CostFunction> MakePriorCostFunction(const PriorTerm& term,
                                                           const ParameterSet& set);
/// rho of a term for the solver; null where it is the identity.
std::unique_ptr<ceres::LossFunction> MakePriorLossFunction(const PriorTerm& term);

/// Receives a product of two blocks' derivatives, row-major.
using BlockProductSink = std::function<void(std::int32_t, std::int32_t, std::span<const double>)>;

/// Adds the terms' gradient by theta to `gradient`, and gives their Gauss-Newton matrix to `add` as
/// products of each pair of a term's blocks, in both orders.
void LinearizePriors(const std::vector<PriorTerm>& terms,
                     const ParameterSet& set,
                     const std::vector<double>& theta,
                     std::vector<double>& gradient,
                     const BlockProductSink& add);

/// Adds to each of the draws the gradient that the terms would have if each row's residual were
/// `residual` (of beliefs what they say) with a random sign. Their covariance is the
/// uncertainty that terms bring which are as wrong as that; together with draws of the photos',
/// divided by the whole matrix, they are draws of the unknowns.
void DrawPriorGradients(const std::vector<PriorTerm>& terms,
                        const ParameterSet& set,
                        const std::vector<double>& theta,
                        double residual,
                        std::uint64_t seed,
                        std::vector<std::vector<double>>& draws);

/// Second derivatives of the terms' costs by theta (Gauss-Newton, NumScalars^2, row-major).
std::vector<double> PriorHessian(const std::vector<PriorTerm>& terms,
                                 const ParameterSet& set,
                                 const std::vector<double>& theta);

/// First derivatives of the terms' costs by theta.
std::vector<double> PriorGradient(const std::vector<PriorTerm>& terms,
                                  const ParameterSet& set,
                                  const std::vector<double>& theta);

/// Covariance of the gradient by theta that beliefs bring if they are as wrong as they say.
std::vector<double> BeliefCovariance(const std::vector<PriorTerm>& terms,
                                     const ParameterSet& set,
                                     const std::vector<double>& theta);

/// Sum of the terms' costs.
double PriorCost(const std::vector<PriorTerm>& terms,
                 const ParameterSet& set,
                 const std::vector<double>& theta);

}  // namespace pathfit::optim
