#include "optim/problem/fit_views.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/core/parallel.h"

namespace pathfit::optim {

FitViews ListViews(const ObservationSet& observations) {
  FitViews views;
  views.silhouettes = observations.mask_meaning == MaskMeaning::kSilhouette;
  for (std::size_t i = 0; i < observations.views.size(); ++i) {
    const View& view = observations.views[i];
    views.names.push_back(view.name);
    (view.validation ? views.validation : views.fitted).push_back(static_cast<int>(i));
  }
  return views;
}

FitViews MakeFitViews(const ObservationSet& observations,
                      double scale,
                      std::optional<double> num_channels) {
  FitViews views = ListViews(observations);
  struct Level {
    std::optional<PackedLevel> level;
    double weight = 0.0;
  };
  const auto make = [&](std::int64_t i, Level& made) {
    const View& view = observations.views[static_cast<std::size_t>(i)];
    made.level.emplace(view, observations, scale);
    if (view.validation || num_channels) return;
    for (const float w : made.level->ColorWeight().data) {
      made.weight += 3.0 * static_cast<double>(w);
    }
  };
  double weight = 0.0;
  const auto count = static_cast<std::int64_t>(observations.views.size());
  for (Level& made : renderer::ParallelParts<Level>(count, make)) {
    views.levels.push_back(std::move(*made.level));
    weight += made.weight;
  }
  views.num_channels = num_channels.value_or(std::max(1.0, weight));
  return views;
}

namespace {

double Denominator(const LossSpec& loss, double photo) {
  return loss.residual == ResidualKind::kRelative ? photo + loss.relative_floor : 1.0;
}

// Linear value that a clipped channel has at least (photo_file.cpp marks those near it, too).
constexpr double kLeastOfClipped = 0.58;
// Differences between the halves by which a rendering is surely darker than a clipped channel: one
// that the samples' noise made darker would pull upwards, and those it made brighter do nothing.
constexpr double kSurelyDarker = 1.5;

std::vector<unsigned char> CensoredChannels(const ViewLevel& level,
                                            const renderer::Film& a,
                                            const renderer::Film& b) {
  std::vector<unsigned char> censored(level.clipped.Empty() ? 0 : a.pixels.size());
  for (std::size_t p = 0; p < censored.size(); ++p) {
    const auto share = static_cast<double>(level.clipped.data[p]);
    for (std::size_t c = 0; c < 3 && share > 0.0; ++c) {
      const auto photo = static_cast<double>(level.photo.data[3 * p + c]);
      // Another channel is clipped there, not this one.
      if (photo < kLeastOfClipped * share) continue;
      const double of_a = a.pixels[p][static_cast<int>(c)], of_b = b.pixels[p][static_cast<int>(c)];
      if (0.5 * (of_a + of_b) + kSurelyDarker * std::abs(of_a - of_b) > photo) {
        censored[p] = static_cast<unsigned char>(censored[p] | (1U << c));
      }
    }
  }
  return censored;
}

constexpr double kTrustSteps = 255.0;

/// The root of min(1, huber / residual), never 0.
unsigned char HuberRoot(const ViewLevel& level,
                        const LossSpec& loss,
                        const renderer::Rgba& rendered,
                        std::size_t pixel,
                        unsigned censored) {
  double square = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    if ((censored >> c & 1U) != 0) continue;
    const auto photo = static_cast<double>(level.photo.data[3 * pixel + c]);
    const double r = (rendered[static_cast<int>(c)] - photo) / Denominator(loss, photo);
    square += r * r / 3.0;
  }
  const double residual = std::sqrt(square);
  if (!(residual > loss.robust_huber)) return static_cast<unsigned char>(kTrustSteps);
  return static_cast<unsigned char>(
      std::max(1.0, std::round(kTrustSteps * std::sqrt(loss.robust_huber / residual))));
}

}  // namespace

PixelTrust JudgePixels(const ViewLevel& level,
                       const LossSpec& loss,
                       const renderer::Film& a,
                       const renderer::Film& b) {
  PixelTrust trust{CensoredChannels(level, a, b), {}};
  if (loss.robust_huber <= 0.0) return trust;
  trust.huber.resize(a.pixels.size());
  for (std::size_t p = 0; p < trust.huber.size(); ++p) {
    const unsigned censored = trust.censored.empty() ? 0U : trust.censored[p];
    trust.huber[p] = HuberRoot(level, loss, (a.pixels[p] + b.pixels[p]) * 0.5, p, censored);
  }
  return trust;
}

RowScales MakeRowScales(const ViewLevel& level,
                        bool silhouettes,
                        const LossSpec& loss,
                        const PixelTrust& trust) {
  const bool has_mask = silhouettes && !level.mask.Empty();
  RowScales scales(level.color_weight.data.size());
  for (std::size_t p = 0; p < scales.size(); ++p) {
    const double root =
        std::sqrt(static_cast<double>(level.color_weight.data[p])) *
        (trust.huber.empty() ? 1.0 : static_cast<double>(trust.huber[p]) / kTrustSteps);
    const unsigned bits = trust.censored.empty() ? 0U : trust.censored[p];
    for (std::size_t c = 0; c < 3; ++c) {
      const auto photo = static_cast<double>(level.photo.data[3 * p + c]);
      scales[p][c] =
          (bits >> c & 1U) != 0 ? 0.0F : static_cast<float>(root / Denominator(loss, photo));
    }
    scales[p][3] = has_mask ? static_cast<float>(loss.silhouette_weight) : 0.0F;
  }
  return scales;
}

std::array<double, 4> PixelResidual(const ViewLevel& level,
                                    const std::array<float, 4>& scale,
                                    const renderer::Rgba& rendered,
                                    std::size_t pixel) {
  std::array<double, 4> r{};
  for (std::size_t c = 0; c < 3; ++c) {
    r[c] = static_cast<double>(scale[c]) *
           (rendered[static_cast<int>(c)] - static_cast<double>(level.photo.data[3 * pixel + c]));
  }
  if (scale[3] != 0.0F) {
    r[3] =
        static_cast<double>(scale[3]) * (rendered.a - static_cast<double>(level.mask.data[pixel]));
  }
  return r;
}

renderer::Film AverageFilm(const renderer::Film& a, const renderer::Film& b) {
  renderer::Film average(a.width, a.height);
  for (std::size_t i = 0; i < average.pixels.size(); ++i) {
    average.pixels[i] = (a.pixels[i] + b.pixels[i]) * 0.5;
  }
  return average;
}

}  // namespace pathfit::optim
