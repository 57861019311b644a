#pragma once

namespace pathfit::optim {

/// Residual of a colour: (rendered - photo), or that divided by (photo + noise floor).
enum class ResidualKind { kLinear, kRelative };

struct LossSpec {
  ResidualKind residual = ResidualKind::kLinear;
  double relative_floor = 0.05;
  double silhouette_weight = 1.0;  ///< of coverage residuals against colour residuals
  /// Root mean square over a pixel's channels from which its colour counts by that, no longer by
  /// its square (Huber); 0 = none.
  double robust_huber = 0.0;
};

enum class LinearSolverChoice { kAuto, kGram, kCholesky, kCgnr, kSparseGram };

}  // namespace pathfit::optim
