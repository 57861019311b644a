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

class GroupCostFunction : public ceres::CostFunction {
 public:
  GroupCostFunction(const ImageProblem& problem,
                    const EvaluationState& state,
                    std::size_t view,
                    std::size_t group)
      : problem_(problem), state_(state), view_(view), group_(group) {
    const ResidualGroups& groups = problem.view_groups()[view];
    const ResidualGroup& g = groups.groups()[group];
    set_num_residuals(g.num_rows + 1);
    auto& sizes = *mutable_parameter_block_sizes();
    sizes.reserve(static_cast<std::size_t>(g.num_blocks));
    for (std::size_t k = 0; k < static_cast<std::size_t>(g.num_blocks); ++k) {
      sizes.push_back(problem.set().BlockSize(groups.blocks()[g.first_block + k]));
    }
  }

  bool Evaluate(double const* const* /*parameters*/,
                double* residuals,
                double** jacobians) const override {
    if (state_.refused) {
      return false;
    }
    const ResidualGroups& groups = problem_.view_groups()[view_];
    const ResidualGroup& group = groups.groups()[group_];
    const auto num_rows = static_cast<std::size_t>(group.num_rows);
    double v2 = 0.0;
    for (std::size_t row = 0; row < num_rows; ++row) {
      residuals[row] = groups.u[group.first_row + row];
      const double v = groups.v[group.first_row + row];
      v2 += v * v;
    }
    if (v2 >= group.offset_squared) {
      return false;
    }
    const double rho = std::sqrt(group.offset_squared - v2);
    residuals[num_rows] = rho;
    if (jacobians != nullptr) {
      CopyJacobians(groups, group, rho, jacobians);
    }
    return true;
  }

 private:
  void CopyJacobians(const ResidualGroups& groups,
                     const ResidualGroup& group,
                     double rho,
                     double** jacobians) const {
    const float* cell = groups.cells().data() + group.first_cell;
    for (std::size_t k = 0; k < static_cast<std::size_t>(group.num_blocks); ++k) {
      const auto size = static_cast<std::size_t>(parameter_block_sizes()[k]);
      const std::size_t count = static_cast<std::size_t>(group.num_rows) * size;
      double* target = jacobians[k];
      if (state_.zero_jacobians) {
        FillZero(target, count + size);
      } else if (target != nullptr) {
        std::copy_n(cell, count, target);
        for (std::size_t c = 0; c < size; ++c) {
          target[count + c] = -static_cast<double>(cell[count + c]) / rho;
        }
      }
      cell += count + size;
    }
  }

  const ImageProblem& problem_;
  const EvaluationState& state_;
  std::size_t view_, group_;
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
    const double square = 2.0 * problem_.costs().rest + problem_.rest_offset_squared();
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

std::unique_ptr<ceres::CostFunction> MakeGroupCostFunction(const ImageProblem& problem,
                                                           const EvaluationState& state,
                                                           std::size_t view,
                                                           std::size_t group) {
  return std::make_unique<GroupCostFunction>(problem, state, view, group);
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
