#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "optim/problem/support_roots.h"

namespace pathfit::optim {

/// kSparseGram: conjugate gradients on J^T J, which is kept instead of rows.
enum class LinearSolverKind { kGram, kCholesky, kCgnr, kSparseGram };
const char* LinearSolverName(LinearSolverKind kind);

/// A solve would need more memory, or larger indices, than there are. The message says what takes
/// it and what helps.
class MemoryError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Counts that decide what a solve costs.
struct ProblemSize {
  double num_scalars = 0.0;
  RootSize roots;
  double num_spread_scalars = 0.0;  ///< of them, those of spread blocks (PairedBlocks)
  double row_history_bytes = 0.0;   ///< of few unknowns, where rows are kept
  double sparse_gram_empty = 0.0;   ///< bytes before any row comes
  double sparse_gram_bytes = 0.0;   ///< of what is seen
  double sparse_gram_seen = 0.0;    ///< blocks in it
  double largest_view_bytes = 0.0;  ///< derivatives and rows of one view
  double images_bytes = 0.0;
  double num_prior_terms = 0.0;
  double prior_blocks = 0.0;  ///< sum over terms of their blocks
};

struct MemoryItem {
  std::string what;
  double bytes = 0.0;
};

/// Peak memory of a round by what takes it then: while photos are linearised, or while the roots
/// are solved. Measured laws: a double copy of the cells for conjugate gradients; two, product
/// terms and the factor for Cholesky.
std::vector<MemoryItem> ForecastMemory(const ProblemSize& size, LinearSolverKind kind);
double TotalBytes(const std::vector<MemoryItem>& items);

/// What is kept of all photos' derivatives.
double JacobianBytes(const ProblemSize& size, bool uses_gram);

/// Of the Cholesky factor of a surface mesh's unknowns.
double FactorCells(double num_scalars);

/// `what` ("the solve") takes too much: with a table of the items, the largest first, and what
/// helps.
MemoryError MemoryErrorOf(const std::string& what,
                          LinearSolverKind kind,
                          std::vector<MemoryItem> items,
                          double max_bytes);

/// Throws MemoryError with a table if the forecast exceeds `max_bytes` (0 = no limit) or the
/// solver's 32-bit indices.
void CheckFits(const ProblemSize& size, LinearSolverKind kind, double max_bytes);
bool Fits(const ProblemSize& size, LinearSolverKind kind, double max_bytes);

}  // namespace pathfit::optim
