#include "optim/solver/sparse_step.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include <Eigen/Dense>

#include "optim/problem/sparse_gram.h"
#include "optim/solver/step_bounds.h"
#include "renderer/core/clock.h"
#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

// As the solver of rows has them.
constexpr double kLeastDamping = 1e-6;  // of a scaled diagonal, over the radius
constexpr double kLargestDamping = 1e32;
constexpr double kLeastRelativeDecrease = 1e-3;

// A part of a step that lowers the cost most is worth another trial below this, and taken as no
// less than that.
constexpr double kWorthATrial = 0.7;
constexpr double kLeastPart = 0.1;
constexpr double kLeastShare = 0.1;  // that rounds begin with

// Groups of more blocks are of a surface or a picture, whose texels noise may move far.
constexpr std::int32_t kMaxSharedBlocks = 8;

// Of standard errors. All draws together must not take longer than a round.
constexpr double kEtaOfErrors = 1e-2;
constexpr int kMaxIterationsOfErrors = 20;
constexpr double kSigmas = 2.0;              // that chance is given
constexpr double kSmallestShare = 1e-9;      // of the diagonal: keeps the matrix positive
constexpr std::uint64_t kPriorDrawSeed = 1;  // there is no other draw of priors

using Vector = std::vector<double>;

double Dot(const Vector& a, const Vector& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// a + factor * b into a.
void AddScaled(double factor, const Vector& b, Vector& a) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] += factor * b[i];
  }
}

/// Inverses of the damped blocks on the diagonal, for short vectors.
class BlockJacobi {
 public:
  BlockJacobi(const SparseGram& matrix, const Vector& damping) {
    std::size_t offset = 0;
    for (std::size_t b = 0; b < matrix.paired().NumBlocks(); ++b) {
      const auto cells = matrix.Diagonal(b);
      const std::size_t size = cells.size() / SparseGram::kStride;
      Eigen::Matrix3d full = Eigen::Matrix3d::Identity();
      for (std::size_t p = 0; p < size; ++p) {
        for (std::size_t q = 0; q < size; ++q) {
          full(static_cast<int>(p), static_cast<int>(q)) = cells[p * SparseGram::kStride + q];
        }
        full(static_cast<int>(p), static_cast<int>(p)) += damping[offset + p];
      }
      inverses_.push_back(full.inverse());
      sizes_.push_back(static_cast<std::uint8_t>(size));
      offset += size;
    }
  }

  void Apply(const Vector& x, Vector& y) const {
    std::size_t offset = 0;
    for (std::size_t b = 0; b < inverses_.size(); offset += sizes_[b++]) {
      const std::size_t size = sizes_[b];
      for (std::size_t p = 0; p < size; ++p) {
        double sum = 0.0;
        for (std::size_t q = 0; q < size; ++q) {
          sum += inverses_[b](static_cast<int>(p), static_cast<int>(q)) * x[offset + q];
        }
        y[offset + p] = sum;
      }
    }
  }

 private:
  std::vector<Eigen::Matrix3d> inverses_;
  std::vector<std::uint8_t> sizes_;
};

/// The short step that (matrix + damping) step = -gradient, until an iteration adds less than the
/// share `eta` of the mean iteration's decrease [Nash and Sofer 1990], in `most` iterations. False
/// where the matrix is not positive.
bool SolveByConjugateGradients(const SparseGram& matrix,
                               const Vector& damping,
                               const BlockJacobi& preconditioner,
                               const Vector& gradient,
                               double eta,
                               int most,
                               Vector& step) {
  const std::size_t n = gradient.size();
  Vector residual(n), direction(n), product(n), preconditioned(n);
  std::ranges::transform(gradient, residual.begin(), std::negate<>());
  step.assign(n, 0.0);
  double rho = 1.0, decrease = 0.0;
  for (int i = 1; i <= most; ++i) {
    preconditioner.Apply(residual, preconditioned);
    const double last_rho = rho;
    rho = Dot(residual, preconditioned);
    if (rho == 0.0) {
      return true;
    }
    for (std::size_t k = 0; k < n; ++k) {
      direction[k] = preconditioned[k] + (i == 1 ? 0.0 : rho / last_rho * direction[k]);
    }
    matrix.Multiply(direction, product);
    for (std::size_t k = 0; k < n; ++k) {
      product[k] += damping[k] * direction[k];
    }
    const double curvature = Dot(direction, product);
    if (!(curvature > 0.0) || !std::isfinite(curvature) || !std::isfinite(rho)) {
      return false;
    }
    const double alpha = rho / curvature;
    AddScaled(alpha, direction, step);
    AddScaled(-alpha, product, residual);
    // The quadratic form at the step, from its residual b - A x.
    double form = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      form -= step[k] * (residual[k] - gradient[k]);
    }
    if (i * (form - decrease) / form < eta) {
      return true;
    }
    decrease = form;
  }
  return true;
}

/// By block, of the radius. Gains multiply what lights and colours say, which are damped: whole
/// steps of theirs would lead off what they make together.
Vector RadiusFactors(const ParameterSet& set, const SolveOptions& options) {
  Vector factors(set.NumBlocks(), 1.0);
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (group.num_blocks <= kMaxSharedBlocks && !IsOfExposure(group.kind)) {
      std::fill_n(
          factors.begin() + group.first_block, group.num_blocks, options.shared_radius_factor);
    }
  }
  return factors;
}

class SparseRound {
 public:
  SparseRound(ImageProblem& problem,
              const std::vector<PriorTerm>& priors,
              const std::vector<PriorTerm>& proximal,
              const Vector& theta,
              const SolveOptions& options)
      : problem_(problem),
        set_(problem.set()),
        priors_(priors),
        proximal_(proximal),
        theta_(theta),
        options_(options),
        matrix_(problem.TakeSparseGram()),
        gradient_(problem.TakeGradient()),
        factors_(RadiusFactors(set_, options)) {}

  SolveOutcome Solve() {
    const auto start = renderer::Clock::now();
    for (const auto* terms : {&priors_, &proximal_}) {
      LinearizePriors(*terms,
                      set_,
                      theta_,
                      gradient_,
                      [&](std::int32_t row, std::int32_t column, std::span<const double> product) {
                        if (row <= column) {
                          matrix_.Add(row, column, product);
                        }
                      });
    }
    const double cost = Cost(theta_);
    if (!std::isfinite(cost) || !std::isfinite(Dot(gradient_, gradient_))) {
      throw renderer::NumericalError(
          "the solver cannot begin a round: residual and Jacobian evaluation failed");
    }
    SolveOutcome outcome;
    outcome.theta = theta_;
    double radius = options_.radius;
    double divisor = 2.0;
    bool is_positive = false;
    outcome.step_share = options_.step_share;
    for (int i = 0; i <= kMaxRejections && !outcome.accepted; ++i) {
      outcome.radius = radius;
      if (FindStep(radius)) {
        is_positive = true;
        ++outcome.trials;
        Trial trial = TryShares(cost, outcome.step_share);
        outcome.relative_decrease = trial.RelativeDecrease();
        outcome.accepted = IsGood(trial);
        outcome.theta = std::move(trial.theta);
      }
      radius /= divisor;
      divisor *= 2.0;
    }
    if (!outcome.accepted) {
      outcome.theta = theta_;
      outcome.relative_decrease = 0.0;
    }
    if (!is_positive) {
      outcome.failure = "no step lowers the quadratic model";
    }
    outcome.render_s = render_s_;
    outcome.linear_s = renderer::SecondsSince(start) - render_s_;
    return outcome;
  }

 private:
  [[nodiscard]] double Cost(const Vector& theta) const {
    return problem_.costs().Total() + PriorCost(priors_, set_, theta) +
           PriorCost(proximal_, set_, theta);
  }

  /// What the quadratic model says of a way from the start: a share t of it changes the cost by
  /// t * linear + t^2 / 2 * square.
  struct WayModel {
    double linear = 0.0, square = 0.0;
    [[nodiscard]] double Decrease() const { return -linear - 0.5 * square; }
  };
  struct Trial {
    bool is_rendered = false;
    Vector theta;           ///< where it led, as it was restrained
    double decrease = 0.0;  ///< of the cost
    WayModel model;         ///< of the way there
    [[nodiscard]] double RelativeDecrease() const {
      return is_rendered && model.Decrease() > 0.0 ? decrease / model.Decrease() : -1.0;
    }
    /// Of the way, to the minimum of the parabola with the model's slope and the trial's cost: the
    /// slope is exact, and the matrix lacks what noise it hides.
    [[nodiscard]] double BestShare() const {
      const double half_square = -model.linear - decrease;
      return is_rendered && model.linear < 0.0 && half_square > 0.0
                 ? -0.5 * model.linear / half_square
                 : 1.0;
    }
  };

  static bool IsGood(const Trial& trial) {
    return trial.RelativeDecrease() > kLeastRelativeDecrease;
  }

  /// Into step_; false if there is none that lowers the quadratic model. Conjugate gradients lower
  /// the damped one, and so this one where the step goes down at all.
  bool FindStep(double radius) {
    const PairedBlocks& paired = matrix_.paired();
    Vector damping, gradient = paired.Shorten(gradient_), step;
    damping.reserve(paired.NumScalars());
    for (std::size_t b = 0; b < paired.NumBlocks(); ++b) {
      const auto cells = matrix_.Diagonal(b);
      const double factor = factors_[static_cast<std::size_t>(paired.BlockOf(b))];
      for (std::size_t p = 0; p * SparseGram::kStride < cells.size(); ++p) {
        damping.push_back(Damping(cells[p * SparseGram::kStride + p], radius * factor));
      }
    }
    if (paired.NumScalars() > 0 && !SolveByConjugateGradients(matrix_,
                                                              damping,
                                                              BlockJacobi(matrix_, damping),
                                                              gradient,
                                                              options_.eta,
                                                              kMaxConjugateSteps,
                                                              step)) {
      return false;
    }
    step_.assign(gradient_.size(), 0.0);
    auto next = step.begin();
    paired.ForPaired([&](std::size_t first, std::size_t end) {
      const auto count = static_cast<std::ptrdiff_t>(end - first);
      std::copy_n(next, count, step_.begin() + static_cast<std::ptrdiff_t>(first));
      next += count;
    });
    paired.ForSpread([&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) {
        const double diagonal = matrix_.spread_diagonal()[i];
        step_[i] = -gradient_[i] / (diagonal + Damping(diagonal, radius));
      }
    });
    return Dot(gradient_, step_) < 0.0;
  }

  [[nodiscard]] WayModel ModelOfWayTo(const Vector& theta) const {
    const auto way = [&](std::size_t i) { return theta[i] - theta_[i]; };
    const PairedBlocks& paired = matrix_.paired();
    WayModel model;
    Vector short_way, product;
    short_way.reserve(paired.NumScalars());
    paired.ForPaired([&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) {
        short_way.push_back(way(i));
        model.linear += gradient_[i] * short_way.back();
      }
    });
    matrix_.Multiply(short_way, product);
    model.square = Dot(short_way, product);
    paired.ForSpread([&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) {
        const double x = way(i);
        model.linear += gradient_[i] * x;
        model.square += matrix_.spread_diagonal()[i] * x * x;
      }
    });
    return model;
  }

  /// What is added to a cell of the diagonal.
  static double Damping(double square, double radius) {
    const double scale = 1.0 / (1.0 + std::sqrt(square));
    return std::clamp(square * scale * scale, kLeastDamping, kLargestDamping) /
           (radius * scale * scale);
  }

  /// By `share` of the step, and where the cost says that much less is better, by that. Leaves in
  /// `share` what would have been best.
  Trial TryShares(double cost, double& share) {
    Trial trial = Try(cost, share);
    if (trial.BestShare() < kWorthATrial) {
      const double first = share;
      const double decrease = trial.decrease;
      const bool is_good = IsGood(trial);
      share *= std::max(kLeastPart, trial.BestShare());
      trial = {};  // its memory, before the next one
      trial = Try(cost, share);
      if (is_good && !(trial.decrease >= decrease)) {
        share = first;  // again: what is rendered last is what the problem knows
        trial = {};
        trial = Try(cost, share);
      }
    }
    share = std::clamp(share * trial.BestShare(), kLeastShare, 1.0);
    return trial;
  }

  /// By a share of the step within the bounds.
  Trial Try(double cost, double share) {
    Trial trial;
    trial.theta = theta_;
    for (std::size_t i = 0; i < theta_.size(); ++i) {
      const auto [lower, upper] = BoundsOfStep(set_, theta_, i);
      trial.theta[i] = std::clamp(theta_[i] + share * step_[i], lower, upper);
    }
    const auto start = renderer::Clock::now();
    try {
      Vector values = set_.ValuesFromTheta(trial.theta);
      const Vector wanted = values;
      if (!options_.restrain || options_.restrain(values)) {
        if (values != wanted) {
          trial.theta = set_.ThetaFromValues(values);
        }
        problem_.EvalTrial(values);
        trial.decrease = cost - Cost(trial.theta);
        trial.is_rendered = true;
      }
    } catch (const renderer::SceneError&) {
      // The step leads out of what can be rendered.
    }
    render_s_ += renderer::SecondsSince(start);
    if (trial.is_rendered) {
      trial.model = ModelOfWayTo(trial.theta);
    }
    return trial;
  }

  ImageProblem& problem_;
  const ParameterSet& set_;
  const std::vector<PriorTerm>& priors_;
  const std::vector<PriorTerm>& proximal_;
  const Vector& theta_;
  const SolveOptions& options_;
  SparseGram matrix_;
  Vector gradient_;
  Vector factors_;
  Vector step_;
  double render_s_ = 0.0;
};

}  // namespace

SolveOutcome SolveSparseRound(ImageProblem& problem,
                              const std::vector<PriorTerm>& priors,
                              const std::vector<PriorTerm>& proximal,
                              const std::vector<double>& theta,
                              const SolveOptions& options) {
  return SparseRound(problem, priors, proximal, theta, options).Solve();
}

StandardErrors EstimateErrorsOfMany(ImageProblem& problem,
                                    const std::vector<PriorTerm>& priors,
                                    const std::vector<double>& theta,
                                    double residual) {
  const ParameterSet& set = problem.set();
  const std::size_t n = theta.size();
  SparseGram matrix = problem.TakeSparseGram();
  Vector gradient = problem.TakeGradient();
  LinearizePriors(priors,
                  set,
                  theta,
                  gradient,
                  [&](std::int32_t row, std::int32_t column, std::span<const double> product) {
                    if (row <= column) matrix.Add(row, column, product);
                  });
  std::vector<Vector> draws = problem.TakeGradientDraws();
  DrawPriorGradients(priors, set, theta, residual, kPriorDrawSeed, draws);
  Vector damping;
  for (std::size_t b = 0; b < matrix.paired().NumBlocks(); ++b) {
    const auto cells = matrix.Diagonal(b);
    for (std::size_t p = 0; p * SparseGram::kStride < cells.size(); ++p) {
      const double square = cells[p * SparseGram::kStride + p];
      damping.push_back(square > 0.0 ? kSmallestShare * square : 1.0);
    }
  }
  const BlockJacobi preconditioner(matrix, damping);
  const auto solve = [&](const Vector& of, double otherwise) {
    Vector step;
    if (!SolveByConjugateGradients(
            matrix, damping, preconditioner, of, kEtaOfErrors, kMaxIterationsOfErrors, step)) {
      step.assign(n, otherwise);
    }
    return step;
  };
  // One after the other: each takes as much memory as a round's step.
  for (Vector& draw : draws) draw = solve(draw, std::numeric_limits<double>::quiet_NaN());
  const Vector rest = solve(gradient, 0.0);  // of the way to the minimum
  StandardErrors errors{Vector(n), Vector(n), Vector(n), Vector(n)};
  for (std::size_t i = 0; i < n; ++i) {
    for (const Vector& draw : draws) {
      errors.of_photos[i] += draw[i] * draw[i] / static_cast<double>(draws.size());
    }
    const double variance = errors.of_photos[i];
    const double unlikely = std::max(0.0, rest[i] * rest[i] - kSigmas * kSigmas * variance);
    errors.of_photos[i] = std::sqrt(variance + unlikely);
    if (problem.sums().diagonal[i] == 0.0) {
      errors.of_ranges[i] = std::numeric_limits<double>::infinity();
    }
  }
  return errors;
}

}  // namespace pathfit::optim
