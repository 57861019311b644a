#include "optim/problem/quadratic_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/pixel_rows.h"
#include "optim/problem/shares.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstMatrix = Eigen::Map<const RowMajorMatrix>;
using ConstVector = Eigen::Map<const Eigen::VectorXd>;

// Rows are summed in so many parts whatever the number of threads.
constexpr int kNumParts = 8;
// Of the mean diagonal: makes roots of matrices exist.
constexpr double kRelativeShift = 1e-10;
// In units of the scalars' own curvatures: a direction has none below it, and what of a direction
// is rounding.
constexpr double kNoCurvature = 1e-8;
constexpr double kPartOfDirection = 1e-3;
constexpr double kNoShare = 1e-4;  // rounding, where there is nothing
// A quadratic model is wrong by this share of a step that is taken from its point.
constexpr double kErrorOfStep = 0.25;
constexpr double kSigmas = 2.0;        // that chance is given
constexpr double kUnknownNoise = 2.0;  // variance over what the covariance knows

struct Sums {
  std::vector<double> product, square, covariance, scatter, variance;
};

/// What a unit says of the scalars that it depends on, side by side, in their order.
class UnitColumns {
 public:
  void Fill(const PixelRows& rows, const RowUnit& unit, const ParameterSet& set) {
    for (std::vector<double>* column : All()) column->clear();
    scalars_.clear();
    const auto num_rows = static_cast<std::size_t>(unit.NumRows());
    for (std::int32_t e = 0; e < unit.num_entries; ++e) {
      const std::size_t at = unit.first_entry + static_cast<std::size_t>(e);
      const RowEntry& entry = rows.entries[at];
      const EntrySpread& spread = rows.spreads[at];
      const auto size = static_cast<std::size_t>(set.BlockSize(entry.block));
      for (std::size_t c = 0; c < size; ++c) {
        scalars_.push_back(set.BlockOffset(entry.block) + c);
        for (std::size_t row = 0; row < kRows; ++row) {
          const std::size_t cell = row * size + c;
          const bool is_there = row < num_rows;
          mean_[row].push_back(is_there ? static_cast<double>(entry.jacobian[cell]) : 0.0);
          difference_[row].push_back(is_there ? static_cast<double>(spread.jacobian[cell]) : 0.0);
        }
        spread_.push_back(static_cast<double>(spread.gradient[c]));
        gradient_.push_back(static_cast<double>(spread.mean_gradient[c]));
      }
    }
    // Runs of scalars that follow each other, from the last one on.
    ends_.resize(scalars_.size());
    for (std::size_t i = scalars_.size(); i-- > 0;) {
      const bool goes_on = i + 1 < scalars_.size() && scalars_[i + 1] == scalars_[i] + 1;
      ends_[i] = goes_on ? ends_[i + 1] : i + 1;
    }
  }

  /// Adds the products to the upper triangles of matrices of n columns.
  void AddTo(std::size_t n, Sums& sums) const {
    for (std::size_t i = 0; i < scalars_.size(); ++i) {
      double mixed = 0.0;
      for (std::size_t row = 0; row < kRows; ++row) {
        mixed += mean_[row][i] * difference_[row][i];
      }
      // (m + d)(m - d) has the variance of 2 m d, whatever m is.
      sums.variance[scalars_[i]] += 4.0 * mixed * mixed;
      for (std::size_t first = i; first < scalars_.size(); first = ends_[first]) {
        const std::size_t cell = scalars_[i] * n + scalars_[first];
        AddRun(i,
               first,
               ends_[first] - first,
               &sums.product[cell],
               &sums.square[cell],
               &sums.covariance[cell],
               &sums.scatter[cell]);
      }
    }
  }

 private:
  static constexpr std::size_t kRows = 3;  // of a unit with fewer the rest is zero

  /// One row of the matrices by a run of columns, as vector code: none of the arrays overlap.
  void AddRun(std::size_t i,
              std::size_t first,
              std::size_t count,
              double* __restrict product,
              double* __restrict square,
              double* __restrict covariance,
              double* __restrict scatter) const {
    const double* const m0 = &mean_[0][first];
    const double* const m1 = &mean_[1][first];
    const double* const m2 = &mean_[2][first];
    const double* const d0 = &difference_[0][first];
    const double* const d1 = &difference_[1][first];
    const double* const d2 = &difference_[2][first];
    const double* const spread = &spread_[first];
    const double* const gradient = &gradient_[first];
    const std::array<double, kRows> m = {mean_[0][i], mean_[1][i], mean_[2][i]};
    const std::array<double, kRows> d = {difference_[0][i], difference_[1][i], difference_[2][i]};
    const double own_spread = spread_[i];
    const double own_gradient = gradient_[i];
    for (std::size_t k = 0; k < count; ++k) {
      const double of_means = m[0] * m0[k] + m[1] * m1[k] + m[2] * m2[k];
      const double of_noise = own_spread * spread[k];
      product[k] += of_means - (d[0] * d0[k] + d[1] * d1[k] + d[2] * d2[k]);
      square[k] += of_means;
      covariance[k] += of_noise;
      scatter[k] += own_gradient * gradient[k] - of_noise;
    }
  }

  std::array<std::vector<double>*, 2 * kRows + 2> All() {
    return {&mean_[0],
            &mean_[1],
            &mean_[2],
            &difference_[0],
            &difference_[1],
            &difference_[2],
            &spread_,
            &gradient_};
  }

  std::vector<std::size_t> scalars_, ends_;
  std::array<std::vector<double>, kRows> mean_, difference_;
  std::vector<double> spread_, gradient_;  ///< EntrySpread::gradient, mean_gradient
};

void AddScaled(const std::vector<double>& from, double factor, std::vector<double>& to) {
  for (std::size_t i = 0; i < to.size(); ++i) {
    to[i] += factor * from[i];
  }
}

void Scale(double factor, std::vector<double>& values) {
  for (double& x : values) {
    x *= factor;
  }
}

ConstMatrix AsMatrix(const std::vector<double>& values, std::size_t n) {
  return {values.data(), static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n)};
}

ConstVector AsVector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

/// d^T C^-1 d / n; scalars without variance do not count.
double Contradiction(const Eigen::VectorXd& difference, const RowMajorMatrix& covariance) {
  std::vector<Eigen::Index> used;
  for (Eigen::Index i = 0; i < difference.size(); ++i) {
    if (covariance(i, i) > 0.0) {
      used.push_back(i);
    }
  }
  if (used.empty()) {
    return 0.0;
  }
  const auto n = static_cast<Eigen::Index>(used.size());
  Eigen::MatrixXd c(n, n);
  Eigen::VectorXd d(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index a = used[static_cast<std::size_t>(i)];
    d(i) = difference(a) / std::sqrt(covariance(a, a));
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::Index b = used[static_cast<std::size_t>(k)];
      c(i, k) = covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
    }
    c(i, i) += 1e-6;
  }
  return d.dot(c.ldlt().solve(d)) / static_cast<double>(n);
}

/// What a mean square of n standard normal numbers hardly exceeds.
double LargestByChance(std::size_t n) {
  return 1.0 + kSigmas * std::sqrt(2.0 / static_cast<double>(n));
}

/// By scalar: variance of the product over square and noise (square - product), whose factors are
/// 4 / the number of rows that count. Zero without noise.
Eigen::VectorXd ScatterOfShares(const QuadraticModel& model) {
  const std::size_t n = model.NumScalars();
  Eigen::VectorXd scatter = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    const double square = model.square[i * (n + 1)];
    const double noise = square - model.product[i * (n + 1)];
    if (noise > kRelativeShift * square) {
      scatter(static_cast<Eigen::Index>(i)) = model.variance[i] / (square * noise);
    }
  }
  return scatter;
}

/// Of a direction's share of its square that is not noise, by the scatter of its scalars.
double VarianceOfShare(double share, double scatter) {
  return std::max(0.0, 1.0 - share) * scatter;
}

/// Directions of scalars that photos or priors tell from standing still, in units of each scalar's
/// own curvature. Scalars without any are left out.
struct ToldPart {
  std::vector<Eigen::Index> scalars;
  Eigen::VectorXd unit;
  Eigen::MatrixXd hessian;     ///< of photos and priors
  Eigen::MatrixXd by_photos;   ///< columns: directions that the photos tell
  Eigen::MatrixXd directions;  ///< orthonormal columns
  Eigen::VectorXd inverse;     ///< of their curvatures, 0: nothing tells the direction
  bool is_hidden = false;      ///< StandardErrors::is_hidden

  [[nodiscard]] std::size_t Scalar(Eigen::Index i) const {
    return static_cast<std::size_t>(scalars[static_cast<std::size_t>(i)]);
  }
  [[nodiscard]] Eigen::MatrixXd InUnits(const std::vector<double>& matrix, std::size_t n) const {
    return unit.asDiagonal() * AsMatrix(matrix, n)(scalars, scalars) * unit.asDiagonal();
  }
  [[nodiscard]] Eigen::MatrixXd Solve() const {
    return directions * inverse.asDiagonal() * directions.transpose();
  }
};

ToldPart FindToldPart(const QuadraticModel& model,
                      const std::vector<double>& prior_hessian,
                      const std::vector<bool>& free) {
  const std::size_t n = model.NumScalars();
  const double scale = 1.0 / model.weight;
  ToldPart told;
  for (std::size_t i = 0; i < n; ++i) {
    if (free[i] && (model.square[i * (n + 1)] > 0.0 || prior_hessian[i * (n + 1)] > 0.0)) {
      told.scalars.push_back(static_cast<Eigen::Index>(i));
    }
  }
  const auto size = static_cast<Eigen::Index>(told.scalars.size());
  told.unit.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const std::size_t cell = told.Scalar(i) * (n + 1);
    told.unit(i) = 1.0 / std::sqrt(model.square[cell] * scale + prior_hessian[cell]);
  }
  Eigen::MatrixXd square = told.InUnits(model.square, n) * scale;
  square.diagonal().array() += kRelativeShift;
  told.directions = Eigen::MatrixXd::Identity(size, size);
  told.inverse = Eigen::VectorXd::Zero(size);
  if (size == 0) {
    return told;
  }
  const std::optional<Shares> shares = SharesOf(told.InUnits(model.product, n) * scale, square);
  if (!shares) {
    return told;
  }
  // What of a direction's square is not noise is itself known as well as the product is. A floor
  // for it, as steps have, would claim to know what nothing tells.
  const Eigen::MatrixXd of_priors = told.InUnits(prior_hessian, n);
  const Eigen::VectorXd scatter_of_scalars = ScatterOfShares(model)(told.scalars);
  Eigen::VectorXd share = shares->eigenvalues();
  for (Eigen::Index k = 0; k < size; ++k) {
    const Eigen::VectorXd weights =
        shares->eigenvectors().col(k).cwiseAbs2().cwiseProduct(square.diagonal());
    const double scatter = weights.dot(scatter_of_scalars) / weights.sum();
    const double least = kSigmas * std::sqrt(VarianceOfShare(share(k), scatter));
    if (share(k) <= std::max(least, kNoShare)) {
      const Eigen::VectorXd direction = shares->eigenvectors().col(k);
      told.is_hidden |= direction.dot(of_priors * direction) < least;
      share(k) = 0.0;
    }
  }
  const Eigen::MatrixXd dual = square * shares->eigenvectors();
  told.hessian = dual * share.cwiseMin(1.0).asDiagonal() * dual.transpose() + of_priors;
  std::vector<Eigen::Index> by_photos;
  for (Eigen::Index k = 0; k < size; ++k) {
    if (share(k) > 0.0) by_photos.push_back(k);
  }
  told.by_photos = shares->eigenvectors()(Eigen::all, by_photos);
  const auto eigen = DirectionsOf(told.hessian);
  if (eigen.info() != Eigen::Success) {
    return told;
  }
  told.directions = eigen.eigenvectors();
  for (Eigen::Index k = 0; k < size; ++k) {
    const double curvature = eigen.eigenvalues()(k);
    told.inverse(k) = curvature > kNoCurvature ? 1.0 / curvature : 0.0;
  }
  return told;
}

}  // namespace

QuadraticModel::QuadraticModel(std::size_t num_scalars)
    : product(num_scalars * num_scalars),
      square(num_scalars * num_scalars),
      covariance(num_scalars * num_scalars),
      scatter(num_scalars * num_scalars),
      linear(num_scalars),
      variance(num_scalars) {}

void QuadraticModel::AddRows(const PixelRows& rows, const ParameterSet& set) {
  std::array<Sums, kNumParts> parts;
  renderer::ParallelFor(kNumParts, [&](std::int64_t part) {
    Sums& sums = parts[static_cast<std::size_t>(part)];
    sums.product.assign(product.size(), 0.0);
    sums.square.assign(product.size(), 0.0);
    sums.covariance.assign(product.size(), 0.0);
    sums.scatter.assign(product.size(), 0.0);
    sums.variance.assign(variance.size(), 0.0);
    const std::size_t count = rows.units.size();
    const std::size_t first = count * static_cast<std::size_t>(part) / kNumParts;
    const std::size_t end = count * static_cast<std::size_t>(part + 1) / kNumParts;
    UnitColumns columns;
    for (std::size_t i = first; i < end; ++i) {
      columns.Fill(rows, rows.units[i], set);
      columns.AddTo(NumScalars(), sums);
    }
  });
  for (const Sums& part : parts) {
    AddScaled(part.product, 1.0, product);
    AddScaled(part.square, 1.0, square);
    AddScaled(part.covariance, 1.0, covariance);
    AddScaled(part.scatter, 1.0, scatter);
    AddScaled(part.variance, 1.0, variance);
  }
}

void QuadraticModel::AddViews(const QuadraticModel& other) {
  for (const auto values : kSums) {
    AddScaled(other.*values, 1.0, this->*values);
  }
}

void QuadraticModel::HoldAxes(const ParameterSet& set) {
  const std::size_t n = NumScalars();
  for (const ParameterSet::Turn& turn : set.turns()) {
    const std::array<double, 3> axis = {turn.axis.x, turn.axis.y, turn.axis.z};
    const std::size_t first = set.BlockOffset(turn.block);
    double told = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      told += square[(first + c) * (n + 1)];
    }
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        const std::size_t cell = (first + a) * n + first + b;
        product[cell] += told * axis[a] * axis[b];
        square[cell] += told * axis[a] * axis[b];
      }
    }
  }
}

void QuadraticModel::FinishRound(const std::vector<double>& theta,
                                 const std::vector<double>& gradient) {
  const std::size_t n = NumScalars();
  for (std::vector<double>* matrix : {&product, &square, &covariance, &scatter}) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        (*matrix)[j * n + i] = (*matrix)[i * n + j];
      }
    }
  }
  const Eigen::VectorXd at = AsMatrix(product, n) * AsVector(theta) - AsVector(gradient);
  std::copy(at.begin(), at.end(), linear.begin());
  weight = 1.0;
}

void Fade(double kept, QuadraticModel& model) {
  for (std::vector<double>* values :
       {&model.product, &model.square, &model.scatter, &model.linear}) {
    Scale(kept, *values);
  }
  // Of means, covariance / weight^2, that is 1 / kept times as much.
  Scale(kept, model.covariance);
  Scale(kept, model.variance);
  model.weight *= kept;
}

double ShareAgreed(const QuadraticModel& round,
                   const std::vector<double>& theta,
                   const QuadraticModel& earlier) {
  if (earlier.Empty()) {
    return 1.0;
  }
  const std::size_t n = round.NumScalars();
  const Eigen::VectorXd x = AsVector(theta);
  const Eigen::VectorXd fresh = AsMatrix(round.product, n) * x - AsVector(round.linear);
  const Eigen::VectorXd expected =
      (AsMatrix(earlier.product, n) * x - AsVector(earlier.linear)) / earlier.weight;
  const RowMajorMatrix covariance =
      AsMatrix(round.covariance, n) +
      AsMatrix(earlier.covariance, n) / (earlier.weight * earlier.weight);
  const double contradiction = Contradiction(fresh - expected, covariance);
  // The noise of the earlier rounds' curvature, times the way since, is not in the covariance.
  const double allowed = kUnknownNoise * LargestByChance(n);
  return contradiction > allowed ? allowed / contradiction : 1.0;
}

void AddRound(const QuadraticModel& round, double weight, QuadraticModel& model) {
  if (model.Empty()) {
    model = QuadraticModel(round.NumScalars());
  }
  AddScaled(round.product, weight, model.product);
  AddScaled(round.square, weight, model.square);
  AddScaled(round.scatter, weight, model.scatter);
  AddScaled(round.linear, weight, model.linear);
  AddScaled(round.covariance, weight * weight, model.covariance);
  AddScaled(round.variance, weight * weight, model.variance);
  model.weight += weight;
}

void CarryToPhotosOfMorePixels(double ratio, QuadraticModel& model) {
  // Of the sums over rounds: their means over the weight grow with the pixels, the errors of the
  // mean gradient with their square.
  Scale(ratio, model.scatter);
  model.weight /= ratio;
}

double SignificanceOfStep(const std::vector<double>& step, const QuadraticModel& model) {
  if (model.Empty()) {
    return 0.0;
  }
  const std::size_t n = model.NumScalars();
  const Eigen::VectorXd change = AsMatrix(model.product, n) * AsVector(step) / model.weight;
  const RowMajorMatrix covariance = AsMatrix(model.covariance, n) / (model.weight * model.weight);
  return Contradiction(change, covariance);
}

double LargestStepByChance(std::size_t num_scalars) {
  // Between two estimates, each with an error of its own.
  return 2.0 * LargestByChance(num_scalars);
}

double ShareThatHolds(const std::vector<double>& step, const QuadraticModel& model) {
  if (model.Empty()) {
    return 1.0;
  }
  const std::size_t n = model.NumScalars();
  const double significance =
      std::max(0.0, SignificanceOfStep(step, model) - LargestStepByChance(n)) *
      static_cast<double>(n);
  return 1.0 / (1.0 + kErrorOfStep * kErrorOfStep * significance);
}

StandardErrors EstimateErrors(const QuadraticModel& model,
                              const std::vector<double>& prior_hessian,
                              const std::vector<double>& belief_covariance,
                              const std::vector<double>& ranges) {
  const std::size_t n = model.NumScalars();
  const double scale = 1.0 / model.weight;
  const double deviation = 1.0 / std::sqrt(12.0);  // of a uniform distribution
  StandardErrors errors{std::vector<double>(n),
                        std::vector<double>(n),
                        std::vector<double>(n),
                        std::vector<double>(n)};
  const ToldPart told = FindToldPart(model, prior_hessian, std::vector<bool>(n, true));
  errors.is_hidden = told.is_hidden;
  const auto size = static_cast<Eigen::Index>(told.scalars.size());
  std::vector<bool> is_told(n, false);
  for (const Eigen::Index scalar : told.scalars) {
    is_told[static_cast<std::size_t>(scalar)] = true;
  }
  for (std::size_t i = 0; i < n; ++i) {
    errors.of_ranges[i] = is_told[i] ? 0.0 : deviation * ranges[i];
  }
  for (Eigen::Index k = 0; k < size; ++k) {
    if (told.inverse(k) > 0.0) {
      continue;
    }
    const Eigen::VectorXd direction = told.directions.col(k);
    // Anywhere between the bounds that are met first.
    double reach = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < size; ++i) {
      reach = std::min(reach, ranges[told.Scalar(i)] / std::abs(direction(i) * told.unit(i)));
    }
    for (Eigen::Index i = 0; i < size; ++i) {
      if (std::isfinite(reach) || std::abs(direction(i)) > kPartOfDirection) {
        double& error = errors.of_ranges[told.Scalar(i)];
        error = std::hypot(error, deviation * reach * direction(i) * told.unit(i));
      }
    }
  }
  const Eigen::MatrixXd solve = told.Solve();
  const auto deviations =
      [&](const std::vector<double>& matrix, double factor, std::vector<double>& result) {
        const Eigen::MatrixXd covariance = told.InUnits(matrix, n) * factor;
        for (Eigen::Index i = 0; i < size; ++i) {
          const auto row = solve.row(i);
          result[told.Scalar(i)] =
              told.unit(i) * std::sqrt(std::max(0.0, row.dot(covariance * row.transpose())));
        }
      };
  deviations(model.covariance, scale * scale, errors.of_rendering);
  deviations(model.scatter, scale, errors.of_photos);
  deviations(belief_covariance, 1.0, errors.of_beliefs);
  return errors;
}

ToMinimum FindMinimum(const QuadraticModel& model,
                      const std::vector<double>& theta,
                      const std::vector<double>& prior_hessian,
                      const std::vector<double>& prior_gradient,
                      const std::vector<bool>& free) {
  const std::size_t n = model.NumScalars();
  ToMinimum to{std::vector<double>(n), 0.0};
  const ToldPart told = FindToldPart(model, prior_hessian, free);
  if (told.by_photos.cols() == 0) {
    return to;
  }
  const Eigen::VectorXd gradient =
      (AsMatrix(model.product, n) * AsVector(theta) - AsVector(model.linear)) / model.weight +
      AsVector(prior_gradient);
  const Eigen::VectorXd slope =
      told.by_photos.transpose() * gradient(told.scalars).cwiseProduct(told.unit);
  const Eigen::MatrixXd hessian = told.by_photos.transpose() * told.hessian * told.by_photos;
  const Eigen::VectorXd along = -hessian.ldlt().solve(slope);
  to.decrease = -0.5 * slope.dot(along);
  const Eigen::VectorXd taken = told.by_photos * along;
  for (Eigen::Index i = 0; i < taken.size(); ++i) {
    to.step[told.Scalar(i)] = told.unit(i) * taken(i);
  }
  return to;
}

ModelAtPoint MakeModelAtPoint(const QuadraticModel& model,
                              const std::vector<double>& theta,
                              const std::vector<bool>& is_log) {
  const std::size_t n = model.NumScalars();
  const auto size = static_cast<Eigen::Index>(n);
  const double scale = 1.0 / model.weight;
  RowMajorMatrix square = AsMatrix(model.square, n) * scale;
  square.diagonal().array() += kRelativeShift * square.trace() / static_cast<double>(n) + 1e-300;
  const RowMajorMatrix product = AsMatrix(model.product, n) * scale;
  const Eigen::VectorXd gradient =
      (AsMatrix(model.product, n) * AsVector(theta) - AsVector(model.linear)) * scale;
  ModelAtPoint result;
  result.hessian.assign(square.data(), square.data() + n * n);
  result.gradient.assign(gradient.begin(), gradient.end());

  // In units of the square of J, a direction's product is the share of it that is not noise.
  const std::optional<Shares> shares = SharesOf(product, square);
  if (!shares) {
    return result;
  }
  const Eigen::VectorXd share = shares->eigenvalues().cwiseMax(kLeastTrueShare).cwiseMin(1.0);
  const Eigen::MatrixXd dual = square * shares->eigenvectors();  // inverse transpose of the basis
  const RowMajorMatrix hessian = dual * share.asDiagonal() * dual.transpose();

  // Directions that are independent of each other in the step and in its error.
  const RowMajorMatrix covariance = AsMatrix(model.covariance, n) * (scale * scale);
  const std::optional<Shares> errors = SharesOf(covariance, hessian);
  result.hessian.assign(hessian.data(), hessian.data() + n * n);
  if (!errors) {
    return result;
  }
  Eigen::VectorXd steps = errors->eigenvectors().transpose() * gradient;
  const Eigen::VectorXd scatter_of_scalars = ScatterOfShares(model);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Eigen::VectorXd direction = errors->eigenvectors().col(i);
    // Errors are independent in units of the hessian: that of a direction is 1.
    const double true_share = 1.0 / direction.dot(square * direction);
    const Eigen::VectorXd weights = direction.cwiseAbs2().cwiseProduct(square.diagonal());
    double scatter_of_logs = 0.0;
    for (Eigen::Index k = 0; k < size; ++k) {
      scatter_of_logs +=
          is_log[static_cast<std::size_t>(k)] ? weights(k) * scatter_of_scalars(k) : 0.0;
    }
    scatter_of_logs *= 1.0 / weights.sum();
    const double square_of_step = steps(i) * steps(i);
    const double variance =
        std::max(errors->eigenvalues()(i), 0.0) +
        VarianceOfShare(true_share, scatter_of_logs) / (true_share * true_share) * square_of_step;
    steps(i) *= square_of_step > 0.0 ? square_of_step / (square_of_step + variance) : 0.0;
  }
  const Eigen::VectorXd significant = hessian * (errors->eigenvectors() * steps);
  result.gradient.assign(significant.begin(), significant.end());
  return result;
}

}  // namespace pathfit::optim
