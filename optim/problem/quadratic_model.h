#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace pathfit::optim {

class ParameterSet;
struct PixelRows;

/// Quadratic model of the photos' cost by few parameters (theta), summed over rounds, each about
/// its own point; with what is known of its noise. Matrices are row-major, num_scalars^2. Empty:
/// no round yet. With J_a, J_b and r_a, r_b the halves' Jacobians and residuals, a round adds
///   product    (J_a^T J_b + J_b^T J_a) / 2: unbiased, symmetric, not always positive;
///   square     J^T J of the mean J, which the noise of J inflates: a bound from above;
///   linear     product theta - gradient, theta the round's point: the minimum of the sum of all
///              rounds is where product x = linear;
///   covariance of the gradient by the renderings' noise, from the halves pixel by pixel;
///   scatter    of the pixels' shares of the gradient: at a minimum, its covariance by what of the
///              photos no parameters explain (their noise, errors of the scene);
///   variance   of the product's diagonal by the renderings' noise (num_scalars).
struct QuadraticModel {
  double weight = 0.0;  ///< of the rounds together
  std::vector<double> product, square, covariance, scatter, linear, variance;

  /// What rows add to.
  static constexpr std::array kSums = {&QuadraticModel::product,
                                       &QuadraticModel::square,
                                       &QuadraticModel::covariance,
                                       &QuadraticModel::scatter,
                                       &QuadraticModel::variance};

  /// Of one view, which has no more.
  static void VisitParts(auto& model, const auto& visit) {
    for (const auto values : kSums) visit(model.*values);
  }

  explicit QuadraticModel(std::size_t num_scalars = 0);
  [[nodiscard]] std::size_t NumScalars() const { return linear.size(); }
  [[nodiscard]] bool Empty() const { return weight == 0.0; }

  /// Adds rows of one view (with spreads) to the matrices; their lower triangles are wrong
  /// until FinishRound. Same bits for any number of threads.
  void AddRows(const PixelRows& rows, const ParameterSet& set);
  /// Adds the rows that another model has got.
  void AddViews(const QuadraticModel& other);
  /// Makes the axes of turns, which no row tells, hold as firmly as what rows tell of the others.
  void HoldAxes(const ParameterSet& set);
  /// Completes a round of rows about `theta`.
  void FinishRound(const std::vector<double>& theta, const std::vector<double>& gradient);
};

/// Share of their weight that earlier rounds keep beside a round finished at `theta`: as far as its
/// gradient does not contradict them. They were taken elsewhere, where the cost curved otherwise.
double ShareAgreed(const QuadraticModel& round,
                   const std::vector<double>& theta,
                   const QuadraticModel& earlier);

/// All rounds as if they had had that share of their samples.
void Fade(double kept, QuadraticModel& model);

/// Adds a round to a model of the same scalars (or an empty one). `weight`: proportional to its
/// samples.
void AddRound(const QuadraticModel& round, double weight, QuadraticModel& model);

/// Makes of a model by small photos one by the same photos with `ratio` times as many pixels, which
/// weigh as much each: the same minimum with the same error.
void CarryToPhotosOfMorePixels(double ratio, QuadraticModel& model);

/// Share of their weight that rounds keep after a step: points that lie behind lose it as far as
/// the step stands out of the error of the model's minimum, since their quadratic form holds near
/// them only.
double ShareThatHolds(const std::vector<double>& step, const QuadraticModel& model);

/// Mean square, in units of its error, of a step from one estimate of the minimum to the next;
/// about at most LargestStepByChance if there is nothing in it. 0 without a model.
double SignificanceOfStep(const std::vector<double>& step, const QuadraticModel& model);
double LargestStepByChance(std::size_t num_scalars);

/// Standard errors of the minimum by theta: by the noise of the renderings, by what of the photos
/// stays unexplained, by beliefs, and, in directions that neither photos nor priors tell from
/// standing still, by what `ranges` (of theta, infinite without bounds) leave open. Of what is
/// added to the photos' cost, num_scalars^2: `prior_hessian`, its second derivatives, and
/// `belief_covariance`, the uncertainty of its gradient.
struct StandardErrors {
  std::vector<double> of_rendering, of_photos, of_beliefs, of_ranges;
  /// The renderings' noise hides whether the photos tell some direction: more samples would say.
  bool is_hidden = false;
};
StandardErrors EstimateErrors(const QuadraticModel& model,
                              const std::vector<double>& prior_hessian,
                              const std::vector<double>& belief_covariance,
                              const std::vector<double>& ranges);

/// The way from `theta` to the minimum of the model and of what is added to it, whole:
/// MakeModelAtPoint damps what drowns in its error, so that rounds end on the side that they come
/// from. Scalars that are not `free` stay, and so do directions that the photos do not tell, or
/// noise hides whether they do (EstimateErrors): there the gradient is noise, which a weak prior
/// would turn into a long step.
struct ToMinimum {
  std::vector<double> step;
  double decrease = 0.0;  ///< of both, per round
};
ToMinimum FindMinimum(const QuadraticModel& model,
                      const std::vector<double>& theta,
                      const std::vector<double>& prior_hessian,
                      const std::vector<double>& prior_gradient,
                      const std::vector<bool>& free);

/// The model about a point, per round, made fit for a step.
struct ModelAtPoint {
  std::vector<double> hessian;   ///< row-major, positive semidefinite
  std::vector<double> gradient;  ///< damped where the step that it asks for drowns in its error
};
/// `is_log`: by scalar. Steps of logarithms are damped, too, where the curvature is not told: what
/// they multiply by chance, such as a texel that hardly anything shows, outshines all else.
ModelAtPoint MakeModelAtPoint(const QuadraticModel& model,
                              const std::vector<double>& theta,
                              const std::vector<bool>& is_log);

}  // namespace pathfit::optim
