#include "optim/problem/image_cost_functions.h"

#include <algorithm>
#include <cmath>

#include <ceres/cost_function.h>

namespace pathfit::optim {
namespace {

void FillZero(double* jacobian, std::size_t count) {
  if (jacobian != nullptr) {
    std::fill_n(jacobian, count, 0.0);
  }
}

class PanelCostFunction : public ceres::CostFunction {
 public:
  PanelCostFunction(const ImageProblem& problem, const EvaluationState& state, std::size_t panel)
      : roots_(problem.roots()), state_(state), panel_(panel) {
    const RootPanel& p = roots_.panels()[panel];
    set_num_residuals(p.num_rows + (p.has_noise_row ? 1 : 0));
    auto& sizes = *mutable_parameter_block_sizes();
    sizes.reserve(static_cast<std::size_t>(p.num_blocks));
    for (std::int32_t k = 0; k < p.num_blocks; ++k) {
      sizes.push_back(problem.set().BlockSize(
          SupportOf(p).blocks[static_cast<std::size_t>(p.first_block + k)]));
    }
  }

  bool Evaluate(double const* const* /*parameters*/,
                double* residuals,
                double** jacobians) const override {
    if (state_.refused) {
      return false;
    }
    const RootPanel& panel = roots_.panels()[panel_];
    const Support& support = SupportOf(panel);
    const double rho = std::sqrt(support.offset_squared);
    if (state_.at_start) {
      std::copy_n(support.residual.begin() + panel.first_row, panel.num_rows, residuals);
      if (panel.has_noise_row) {
        residuals[panel.num_rows] = rho;
      }
    } else {
      std::fill_n(residuals, num_residuals(), 0.0);
    }
    if (jacobians != nullptr) {
      CopyJacobians(panel, support, rho, jacobians);
    }
    return true;
  }

 private:
  [[nodiscard]] const Support& SupportOf(const RootPanel& panel) const {
    return roots_.supports()[static_cast<std::size_t>(panel.support)];
  }

  void CopyJacobians(const RootPanel& panel,
                     const Support& support,
                     double rho,
                     double** jacobians) const {
    const auto num_rows = static_cast<std::size_t>(panel.num_rows);
    auto column = static_cast<std::size_t>(panel.first_column);
    for (std::size_t k = 0; k < parameter_block_sizes().size(); ++k) {
      const auto size = static_cast<std::size_t>(parameter_block_sizes()[k]);
      double* target = jacobians[k];
      FillZero(target, static_cast<std::size_t>(num_residuals()) * size);
      if (target != nullptr && !state_.zero_jacobians) {
        for (std::size_t r = 0; r < num_rows; ++r) {
          const std::size_t row = static_cast<std::size_t>(panel.first_row) + r;
          const float* cells = support.rows.data() + support.RowOffset(row);
          const std::size_t first = support.is_root ? std::max(row, column) : column;
          for (std::size_t c = first; c < column + size; ++c) {
            target[r * size + c - column] = static_cast<double>(cells[c]);
          }
        }
        if (panel.has_noise_row && column < support.num_local_columns) {
          for (std::size_t c = 0; c < size; ++c) {
            target[num_rows * size + c] = support.noise[column + c] / rho;
          }
        }
      }
      column += size;
    }
  }

  const SupportRoots& roots_;
  const EvaluationState& state_;
  std::size_t panel_;
};

class GramCostFunction : public ceres::CostFunction {
 public:
  GramCostFunction(const ImageProblem& problem, const EvaluationState& state)
      : problem_(problem), state_(state) {
    set_num_residuals(static_cast<int>(problem.gram().residual.size()));
    for (std::size_t b = 0; b < problem.set().NumBlocks(); ++b) {
      mutable_parameter_block_sizes()->push_back(
          problem.set().BlockSize(static_cast<std::int32_t>(b)));
    }
  }

  bool Evaluate(double const* const* /*parameters*/,
                double* residuals,
                double** jacobians) const override {
    if (state_.refused) {
      return false;
    }
    const GramRoot& root = problem_.gram();
    if (state_.at_start) {
      std::copy(root.residual.begin(), root.residual.end(), residuals);
    } else {
      const ImageCosts& costs = problem_.costs();
      const double square = costs.signal_squared - costs.noise_squared + root.offset_squared;
      if (square < 0.0) {
        return false;
      }
      std::fill_n(residuals, root.residual.size(), 0.0);
      residuals[root.residual.size() - 1] = std::sqrt(square);
    }
    if (jacobians != nullptr) {
      CopyJacobians(root, jacobians);
    }
    return true;
  }

 private:
  void CopyJacobians(const GramRoot& root, double** jacobians) const {
    const std::size_t n = root.residual.size() - 1;
    std::size_t column = 0;
    for (std::size_t k = 0; k < parameter_block_sizes().size(); ++k) {
      const auto size = static_cast<std::size_t>(parameter_block_sizes()[k]);
      FillZero(jacobians[k], (n + 1) * size);
      if (jacobians[k] != nullptr && !state_.zero_jacobians) {
        for (std::size_t row = 0; row < n; ++row) {
          std::copy_n(root.upper.data() + row * n + column, size, jacobians[k] + row * size);
        }
      }
      column += size;
    }
  }

  const ImageProblem& problem_;
  const EvaluationState& state_;
};

class RestCostFunction : public ceres::CostFunction {
 public:
  RestCostFunction(const ImageProblem& problem, const EvaluationState& state, std::int32_t block)
      : problem_(problem), state_(state) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(problem.set().BlockSize(block));
  }

  bool Evaluate(double const* const* /*parameters*/,
                double* residuals,
                double** jacobians) const override {
    const ImageCosts& costs = problem_.costs();
    double square = costs.signal_squared - costs.noise_squared + problem_.offset_squared();
    if (state_.at_start) {
      square -= problem_.roots().residual_squared();
    }
    if (state_.refused || square < 0.0) {
      return false;
    }
    residuals[0] = std::sqrt(square);
    if (jacobians != nullptr) {
      FillZero(jacobians[0], static_cast<std::size_t>(parameter_block_sizes()[0]));
    }
    return true;
  }

 private:
  const ImageProblem& problem_;
  const EvaluationState& state_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> MakePanelCostFunction(const ImageProblem& problem,
                                                           const EvaluationState& state,
                                                           std::size_t panel) {
  return std::make_unique<PanelCostFunction>(problem, state, panel);
}

std::unique_ptr<ceres::CostFunction> MakeGramCostFunction(const ImageProblem& problem,
                                                          const EvaluationState& state) {
  return std::make_unique<GramCostFunction>(problem, state);
}

std::unique_ptr<ceres::CostFunction> MakeRestCostFunction(const ImageProblem& problem,
                                                          const EvaluationState& state,
                                                          std::int32_t block) {
  return std::make_unique<RestCostFunction>(problem, state, block);
}

}  // namespace pathfit::optim
