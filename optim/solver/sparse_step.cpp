#include "optim/solver/sparse_step.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>

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
    for (int i = 0; i <= kMaxRejections && !outcome.accepted; ++i) {
      outcome.radius = radius;
      const double predicted = FindStep(radius);
      if (predicted > 0.0) {
        is_positive = true;
        ++outcome.trials;
        const double decrease = Try(cost, outcome.theta);
        outcome.relative_decrease = decrease / predicted;
        outcome.accepted = outcome.relative_decrease > kLeastRelativeDecrease;
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

  /// Into step_; returns by how much the quadratic model falls, which is not positive if there is
  /// none.
  double FindStep(double radius) {
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
      return 0.0;
    }
    Vector product;
    matrix_.Multiply(step, product);
    double linear = Dot(gradient, step), square = Dot(step, product);
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
        linear += gradient_[i] * step_[i];
        square += diagonal * step_[i] * step_[i];
      }
    });
    return -linear - 0.5 * square;
  }

  /// What is added to a cell of the diagonal.
  static double Damping(double square, double radius) {
    const double scale = 1.0 / (1.0 + std::sqrt(square));
    return std::clamp(square * scale * scale, kLeastDamping, kLargestDamping) /
           (radius * scale * scale);
  }

  /// The fall of the cost by the step within the bounds, and the point that was rendered; negative
  /// if it may not be.
  double Try(double cost, Vector& trial) {
    trial = theta_;
    for (std::size_t i = 0; i < trial.size(); ++i) {
      const auto [lower, upper] = BoundsOfStep(set_, theta_, i);
      trial[i] = std::clamp(trial[i] + step_[i], lower, upper);
    }
    const auto start = renderer::Clock::now();
    double decrease = -1.0;
    try {
      Vector values = set_.ValuesFromTheta(trial);
      const Vector wanted = values;
      if (!options_.restrain || options_.restrain(values)) {
        problem_.EvalTrial(values);
        decrease = cost - Cost(trial);
        if (values != wanted) {
          trial = set_.ThetaFromValues(values);
        }
      }
    } catch (const renderer::SceneError&) {
      // The step leads out of what can be rendered.
    }
    render_s_ += renderer::SecondsSince(start);
    return decrease;
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
