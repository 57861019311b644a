#include "optim/problem/problem_size.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace pathfit::optim {
namespace {

constexpr double kMaxIndex = 2147483647.0;
constexpr double kBytesPerGroup = 600.0;      // solver's and our records of one residual block
constexpr double kBytesPerGroupBlock = 40.0;  // pointer, size, cell
constexpr double kFillPerUnknown =
    60.0;  // nonzeros of a surface mesh's factor per n log2 n, upper end measured
constexpr int kGramCopies = 40;  // partial sums, models, root, and the solver's own matrices

std::string Megabytes(double bytes) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%10.1f MB", bytes / 1e6);
  return text.data();
}

bool WithinIndices(const ProblemSize& size, LinearSolverKind kind) {
  if (kind == LinearSolverKind::kGram) {
    return true;
  }
  return size.jacobian_cells < kMaxIndex &&
         (kind == LinearSolverKind::kCgnr || size.product_cells < kMaxIndex);
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
  }
  return "";
}

ProblemSize ProblemSize::Extrapolated(std::size_t done, std::size_t total) const {
  const double factor = static_cast<double>(total) / static_cast<double>(done);
  ProblemSize size = *this;
  for (double* count : {&size.num_groups,
                        &size.num_rows,
                        &size.group_blocks,
                        &size.jacobian_cells,
                        &size.product_cells,
                        &size.product_flops}) {
    *count *= factor;
  }
  return size;
}

std::vector<MemoryItem> ForecastMemory(const ProblemSize& size, LinearSolverKind kind) {
  std::vector<MemoryItem> items = {{"images", size.images_bytes},
                                   {"sparse rows of one view", size.largest_view_bytes}};
  const double n = size.num_scalars;
  if (kind == LinearSolverKind::kGram) {
    items.push_back({"dense normal equations", 8.0 * n * n * kGramCopies});
    return items;
  }
  items.push_back({"Jacobian (float)", 4.0 * size.jacobian_cells});
  items.push_back({"residuals", 40.0 * size.num_rows});
  items.push_back({"residual blocks",
                   kBytesPerGroup * size.num_groups + kBytesPerGroupBlock * size.group_blocks});
  if (kind == LinearSolverKind::kCgnr) {
    items.push_back({"solver's Jacobian (double)", 8.0 * size.jacobian_cells});
    return items;
  }
  items.push_back({"solver's Jacobian (double, twice)", 16.0 * size.jacobian_cells});
  items.push_back({"product terms of J^T J", 12.0 * size.product_cells});
  const double fill = std::min(0.5 * n * n, kFillPerUnknown * n * std::log2(n + 2.0));
  items.push_back({"Cholesky factor", 16.0 * fill});
  return items;
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

void CheckFits(const ProblemSize& size, LinearSolverKind kind, double max_bytes) {
  if (Fits(size, kind, max_bytes)) {
    return;
  }
  std::vector<MemoryItem> items = ForecastMemory(size, kind);
  std::string text = "the solve (" + std::string(LinearSolverName(kind)) + ") needs about " +
                     Megabytes(TotalBytes(items));
  text += WithinIndices(size, kind) ? ", the limit is " + Megabytes(max_bytes)
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
  if (kind == LinearSolverKind::kCholesky) {
    text += ", linear_solver: cgnr";
  }
  throw MemoryError(text);
}

}  // namespace pathfit::optim
