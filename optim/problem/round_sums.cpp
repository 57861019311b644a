#include "optim/problem/round_sums.h"

#include <algorithm>
#include <utility>

#include "optim/problem/fit_views.h"
#include "optim/problem/gram_system.h"
#include "optim/problem/pixel_rows.h"

namespace pathfit::optim {
namespace {

// Each round reads and writes them once, checkpoints included.
constexpr double kMaxBytes = 64e6;
constexpr double kMaxShareOfMemory = 0.1;  // there are copies

/// Of the rows' means, as one round.
QuadraticModel ModelOf(const RowHistory& rows, const ParameterSet& set) {
  QuadraticModel model(set.NumScalars());
  GradientSums sums(set.NumScalars());
  for (std::size_t view = 0; view < rows.views.size(); ++view) {
    const PixelRows means = rows.Means(view, set);
    model.AddRows(means, set);
    sums.Add(means, set);
  }
  model.HoldAxes(set);
  model.FinishRound(rows.theta, sums.gradient);
  return model;
}

}  // namespace

RoundSums RoundSums::Of(QuadraticModel model) {
  RoundSums sums;
  sums.apart = model;
  sums.model = std::move(model);
  return sums;
}

double RoundSums::BytesOfRows(const FitViews& views,
                              double share_of_pixels,
                              std::size_t num_scalars,
                              double max_memory_bytes) {
  double num_pixels = 0.0;
  for (const int view : views.fitted) {
    const renderer::Camera& camera = views.levels[static_cast<std::size_t>(view)].camera();
    num_pixels += share_of_pixels * camera.width * camera.height;
  }
  const double bytes = RowHistory::Bytes(num_pixels, num_scalars, views.silhouettes);
  const double most = max_memory_bytes > 0.0
                          ? std::min(kMaxBytes, kMaxShareOfMemory * max_memory_bytes)
                          : kMaxBytes;
  return bytes <= most ? bytes : 0.0;
}

void RoundSums::Add(const QuadraticModel& round,
                    const std::vector<PixelRows>& rows_of_round,
                    const std::vector<double>& theta,
                    double weight,
                    const ParameterSet& set) {
  const double kept = ShareAgreed(round, theta, model);
  Fade(kept, apart);
  rows.Fade(kept);
  if (rows_of_round.empty()) {
    AddRound(round, weight, apart);
    model = apart;
    return;
  }
  if (rows.Empty()) {
    rows = RowHistory(rows_of_round.size(), set.NumScalars());
  }
  rows.Add(rows_of_round, theta, weight, set);
  model = apart;
  AddRound(ModelOf(rows, set), rows.weight, model);
}

void RoundSums::Forget(const std::vector<double>& step) {
  const double kept = ShareThatHolds(step, model);
  Fade(kept, model);
  Fade(kept, apart);
  rows.Fade(kept);
}

}  // namespace pathfit::optim
