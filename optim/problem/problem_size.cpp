#include "optim/problem/problem_size.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "optim/problem/gradient_draws.h"

namespace pathfit::optim {
namespace {

constexpr double kMaxIndex = 2147483647.0;
constexpr double kBytesPerPanel = 600.0;      // solver's and our records of one residual block
constexpr double kBytesPerPanelBlock = 40.0;  // pointer, size, cell
constexpr double kFillPerUnknown =
    60.0;  // nonzeros of a surface mesh's factor per n log2 n, upper end measured
constexpr double kBytesPerTerm = 200.0;      // with what the heap adds
constexpr double kBytesPerTermBlock = 12.0;  // place and weight
constexpr int kSparseVectors = 14;           // iterates, sums of pieces, inverses of blocks
constexpr int kFullVectors = 10;             // points, gradient and step, also of spread unknowns
constexpr int kRowHistoryCopies = 4;         // the last round's and this one's, and its own rows
constexpr int kGramCopies = 40;  // partial sums, models, root, and the solver's own matrices

std::string Megabytes(double bytes) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%10.1f MB", bytes / 1e6);
  return text.data();
}

bool WithinIndices(const ProblemSize& size, LinearSolverKind kind) {
  if (kind == LinearSolverKind::kGram || kind == LinearSolverKind::kSparseGram) {
    return true;
  }
  return size.roots.jacobian_cells < kMaxIndex &&
         (kind == LinearSolverKind::kCgnr || size.roots.product_cells < kMaxIndex);
}

}  // namespace

const char* LinearSolverName(LinearSolverKind kind) {
  switch (kind) {
    case LinearSolverKind::kGram:
      return "gram";
    case LinearSolverKind::kCholesky:
      return "cholesky";
    case LinearSolverKind::kCgnr:
      return "cgnr";
    case LinearSolverKind::kSparseGram:
      return "sparse_gram";
  }
  return "";
}

std::vector<MemoryItem> ForecastMemory(const ProblemSize& size, LinearSolverKind kind) {
  const MemoryItem images = {"images", size.images_bytes};
  const MemoryItem view = {"derivatives of one view", size.largest_view_bytes};
  const double n = size.num_scalars;
  const MemoryItem priors = {
      "priors", kBytesPerTerm * size.num_prior_terms + kBytesPerTermBlock * size.prior_blocks};
  if (kind == LinearSolverKind::kGram) {
    return {images,
            view,
            {"dense normal equations", 8.0 * n * n * kGramCopies},
            {"rows of all rounds", kRowHistoryCopies * size.row_history_bytes}};
  }
  if (kind == LinearSolverKind::kSparseGram) {
    const int draws = size.num_spread_scalars > 0.0 ? 0 : GradientDraws::kCount;
    return {
        images,
        view,
        {"sparse normal equations", size.sparse_gram_empty + size.sparse_gram_bytes},
        priors,
        {"vectors of unknowns", 8.0 * n * (kFullVectors + draws)},
        {"vectors of conjugate gradients", 8.0 * (n - size.num_spread_scalars) * kSparseVectors}};
  }
  const RootSize& roots = size.roots;
  const std::vector<MemoryItem> linearising = {
      images, view, {"normal equations of supports", roots.gathered_bytes}};
  std::vector<MemoryItem> solving = {
      images,
      {"roots of supports", roots.kept_bytes},
      {"residual blocks",
       kBytesPerPanel * (roots.num_panels + size.num_prior_terms) +
           kBytesPerPanelBlock * (roots.panel_blocks + size.prior_blocks)}};
  if (size.num_prior_terms > 0.0) {
    // Of 3 rows by 3 columns, in doubles.
    solving.push_back({priors.what, priors.bytes + 72.0 * size.prior_blocks});
  }
  if (kind == LinearSolverKind::kCgnr) {
    solving.push_back({"solver's Jacobian (double)", 8.0 * roots.jacobian_cells});
  } else {
    solving.push_back({"solver's Jacobian (double, twice)", 16.0 * roots.jacobian_cells});
    solving.push_back({"product terms of J^T J", 12.0 * roots.product_cells});
    solving.push_back({"Cholesky factor", 16.0 * FactorCells(n)});
  }
  return TotalBytes(linearising) > TotalBytes(solving) ? linearising : solving;
}

double JacobianBytes(const ProblemSize& size, bool uses_gram) {
  return size.roots.kept_bytes + size.sparse_gram_empty + size.sparse_gram_bytes +
         size.row_history_bytes + (uses_gram ? 8.0 * size.num_scalars * size.num_scalars : 0.0);
}

double FactorCells(double num_scalars) {
  return std::min(0.5 * num_scalars * num_scalars,
                  kFillPerUnknown * num_scalars * std::log2(num_scalars + 2.0));
}

double TotalBytes(const std::vector<MemoryItem>& items) {
  double total = 0.0;
  for (const MemoryItem& item : items) {
    total += item.bytes;
  }
  return total;
}

bool Fits(const ProblemSize& size, LinearSolverKind kind, double max_bytes) {
  return WithinIndices(size, kind) &&
         (max_bytes <= 0.0 || TotalBytes(ForecastMemory(size, kind)) <= max_bytes);
}

MemoryError MemoryErrorOf(const std::string& what,
                          LinearSolverKind kind,
                          std::vector<MemoryItem> items,
                          double max_bytes) {
  const double total = TotalBytes(items);
  std::string text = what + " needs about " + Megabytes(total);
  text += max_bytes > 0.0 && total > max_bytes
              ? ", the limit is " + Megabytes(max_bytes)
              : " and more than 2^31 entries, which the solver cannot index";
  std::stable_sort(items.begin(), items.end(), [](const MemoryItem& a, const MemoryItem& b) {
    return a.bytes > b.bytes;
  });
  for (const MemoryItem& item : items) {
    text += "\n  " + Megabytes(item.bytes) + "  " + item.what;
  }
  text +=
      "\nWhat helps: a smaller image_scale (quarters the Jacobian when halved), fewer views, fewer "
      "free\n"
      "unknowns or a coarser mesh or environment in this stage, a larger memory limit";
  if (kind == LinearSolverKind::kGram) {
    text += ", linear_solver: auto";
  } else if (kind == LinearSolverKind::kCholesky) {
    text += ", linear_solver: cgnr";
  } else if (kind == LinearSolverKind::kCgnr) {
    text += ", linear_solver: sparse_gram";
  }
  return MemoryError(text);
}

void CheckFits(const ProblemSize& size, LinearSolverKind kind, double max_bytes) {
  if (Fits(size, kind, max_bytes)) {
    return;
  }
  throw MemoryErrorOf("the solve (" + std::string(LinearSolverName(kind)) + ")",
                      kind,
                      ForecastMemory(size, kind),
                      WithinIndices(size, kind) ? max_bytes : 0.0);
}

}  // namespace pathfit::optim
