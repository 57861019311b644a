#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace pathfit::optim {

enum class LinearSolverKind { kGram, kCholesky, kCgnr };
const char* LinearSolverName(LinearSolverKind kind);

/// A solve would need more memory, or larger indices, than there are. The message says what takes
/// it and what helps.
class MemoryError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Counts that decide what a solve costs; summed over the groups of all views.
struct ProblemSize {
  double num_scalars = 0.0;
  double num_groups = 0.0;
  double num_rows = 0.0;
  double group_blocks = 0.0;        ///< sum over groups of their blocks
  double jacobian_cells = 0.0;      ///< with noise rows
  double product_cells = 0.0;       ///< sum over groups of blocks^2 / 2: terms of J^T J
  double product_flops = 0.0;       ///< sum over groups of rows * columns^2
  double largest_view_bytes = 0.0;  ///< sparse rows of one view before grouping
  double images_bytes = 0.0;

  /// The size if `done` of `total` views gave these counts.
  [[nodiscard]] ProblemSize Extrapolated(std::size_t done, std::size_t total) const;
};

struct MemoryItem {
  std::string what;
  double bytes = 0.0;
};

/// Peak memory of a solve by what takes it. Measured laws: float copy + double copy of the cells
/// for conjugate gradients; two double copies, product terms and the factor for Cholesky.
std::vector<MemoryItem> ForecastMemory(const ProblemSize& size, LinearSolverKind kind);
double TotalBytes(const std::vector<MemoryItem>& items);

/// Throws MemoryError with a table if the forecast exceeds `max_bytes` (0 = no limit) or the
/// solver's 32-bit indices.
void CheckFits(const ProblemSize& size, LinearSolverKind kind, double max_bytes);
bool Fits(const ProblemSize& size, LinearSolverKind kind, double max_bytes);

}  // namespace pathfit::optim
