#include "optim/prior/prior_cost_function.h"

#include <array>
#include <cmath>
#include <cstddef>

#include <ceres/cost_function.h>

namespace pathfit::optim {
namespace {

class PriorCostFunction : public ceres::CostFunction {
 public:
  PriorCostFunction(const PriorTerm& term, const ParameterSet& set) : term_(term), set_(set) {
    set_num_residuals(set.BlockSize(term.blocks.front()));
    for (const std::int32_t block : term.blocks) {
      mutable_parameter_block_sizes()->push_back(set.BlockSize(block));
    }
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    EvalPrior(term_, set_, parameters, residuals, jacobians);
    return true;
  }

 private:
  const PriorTerm& term_;
  const ParameterSet& set_;
};

}  // namespace

void EvalPrior(const PriorTerm& term,
               const ParameterSet& set,
               double const* const* theta_blocks,
               double* residual,
               double** jacobians) {
  const auto size = static_cast<std::size_t>(set.BlockSize(term.blocks.front()));
  for (std::size_t c = 0; c < size; ++c) {
    residual[c] = -term.offset[c];
  }
  for (std::size_t k = 0; k < term.blocks.size(); ++k) {
    const std::size_t offset = set.BlockOffset(term.blocks[k]);
    std::array<double, 3> y{};
    std::array<double, 3> slope{1.0, 1.0, 1.0};
    double mean = 0.0;
    for (std::size_t c = 0; c < size; ++c) {
      y[c] = theta_blocks[k][c];
      if (!term.in_theta && set.IsLog(offset + c)) {
        y[c] = std::exp(y[c]);
        slope[c] = y[c];
      }
      mean += y[c] / static_cast<double>(size);
    }
    for (std::size_t c = 0; c < size; ++c) {
      residual[c] += term.weights[k] * (term.neutral ? y[c] - mean : y[c]);
    }
    if (jacobians == nullptr || jacobians[k] == nullptr) {
      continue;
    }
    for (std::size_t row = 0; row < size; ++row) {
      for (std::size_t c = 0; c < size; ++c) {
        double d = row == c ? 1.0 : 0.0;
        if (term.neutral) {
          d -= 1.0 / static_cast<double>(size);
        }
        jacobians[k][row * size + c] = term.weights[k] * d * slope[c];
      }
    }
  }
}

std::unique_ptr<ceres::CostFunction> MakePriorCostFunction(const PriorTerm& term,
                                                           const ParameterSet& set) {
  return std::make_unique<PriorCostFunction>(term, set);
}

}  // namespace pathfit::optim
