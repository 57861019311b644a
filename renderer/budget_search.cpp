#include "renderer/budget_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/sampler/counter_rng.h"
#include "renderer/scene/parameter_kinds.h"

namespace pathfit::renderer {
namespace {

// One of how many interior samples is measured first, in both forms, and then in the better one.
constexpr int kFirstShare = 64, kSecondShare = 32;
// What a measurement begins with, per interior sample: little where edges may tell nothing.
constexpr SampleBudget kStart{
    .spp = 1, .sppe = 0.5, .spp_direct = 0.25, .spp_indirect = 0.25, .spp_pixel = 0.5};
constexpr double kMostOfMean = 25.0;
// Cost of a boundary term over that of the costliest: enough to be seen when it matters.
constexpr double kLeastShare = 0.05;

/// Derivative images by terms, in all directions.
class TermFilms : public DerivativeSink {
 public:
  explicit TermFilms(const DerivativeImages& images) : images_(images) {}

  void BeginTerm(DerivativeTerm term, std::int64_t num_samples) override {
    current_ = static_cast<std::size_t>(term);
    num_samples_[current_] = static_cast<double>(num_samples);
    films_[current_].emplace(
        images_.layout, images_.directions, images_.camera.width, images_.camera.height);
  }
  void Add(std::int64_t pixel, std::span<const ParameterDerivative> derivatives) override {
    films_[current_]->Add(pixel, derivatives);
  }
  [[nodiscard]] double NumSamples(std::size_t term) const { return num_samples_[term]; }
  /// Null: the term has no samples.
  [[nodiscard]] const Film* Of(std::size_t term, std::size_t direction) const {
    return films_[term] ? &films_[term]->film(direction) : nullptr;
  }

 private:
  const DerivativeImages& images_;
  std::size_t current_ = 0;
  std::array<std::optional<FilmSinks>, kNumDerivativeTerms> films_;
  std::array<double, kNumDerivativeTerms> num_samples_{};
};

/// Sum over pixels and channels. One of the rare samples that are worth hundreds would decide
/// alone: what is far above the mean counts as kMostOfMean times that.
double SquaredDifference(const Film& a, const Film& b) {
  const auto sum_of = [&](double most, double& count) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const double difference = a.pixels[i][c] - b.pixels[i][c];
        sum += std::min(most, difference * difference);
        count += difference != 0.0 ? 1.0 : 0.0;
      }
    }
    return sum;
  };
  double count = 0.0;
  const double sum = sum_of(std::numeric_limits<double>::infinity(), count);
  return count > 0.0 ? sum_of(kMostOfMean * sum / count, count) : 0.0;
}

using ByTerm = std::array<double, kNumDerivativeTerms>;

/// Finds the budgets of one form.
class Search {
 public:
  /// `scales`: of the squared errors of directions; those that are missing are measured.
  Search(const Renderer& renderer,
         const DerivativeImages& images,
         const RenderOptions& options,
         std::vector<double>& scales,
         const CancelFlag* cancel)
      : renderer_(renderer),
        images_(images),
        options_(options),
        scales_(scales),
        cancel_(cancel),
        measured_(options) {
    measured_.with_image = false;
    static_cast<SampleBudget&>(measured_) = kStart;
  }

  /// Measures with one sample of `share`, and improves the budgets.
  void Step(int share) {
    const double spp = std::max(1.0, std::floor(static_cast<double>(options_.spp) / share));
    static_cast<SampleBudget&>(measured_) = measured_.Scaled(spp / measured_.spp);
    Improve(Measure());
  }

  /// For options.spp.
  [[nodiscard]] RenderOptions Found() const {
    RenderOptions found = options_;
    static_cast<SampleBudget&>(found) =
        measured_.Scaled(static_cast<double>(options_.spp) / measured_.spp);
    found.spp = options_.spp;
    return found;
  }
  /// Root of squared error times cost with the best budgets.
  [[nodiscard]] double Inefficiency() const { return inefficiency_; }

 private:
  struct Measurement {
    ByTerm variance{}, cost{};
  };

  Measurement Measure() {
    std::array<std::unique_ptr<TermFilms>, 2> halves;
    for (auto& half : halves) {
      // Apart from those that replicates of the derivative have, which follow each other.
      measured_.seed = NextSeed();
      half = std::make_unique<TermFilms>(images_);
      renderer_.RenderDerivative(
          images_.camera, images_.sensor, measured_, images_.layout, *half, {.cancel = cancel_});
    }
    Measurement m;
    for (std::size_t d = 0; d < images_.directions.size(); ++d) {
      ByTerm of_terms{};
      double total = 0.0;
      for (std::size_t t = 0; t < kNumDerivativeTerms; ++t) {
        const Film* a = halves[0]->Of(t, d);
        const Film* b = halves[1]->Of(t, d);
        if (a == nullptr || b == nullptr) continue;
        of_terms[t] = SquaredDifference(*a, *b);
        total += of_terms[t];
      }
      // Each direction in units of its own noise.
      if (d == scales_.size()) scales_.push_back(total > 0.0 ? 1.0 / total : 1.0);
      for (std::size_t t = 0; t < kNumDerivativeTerms; ++t) {
        m.variance[t] += scales_[d] * of_terms[t];
      }
    }
    for (std::size_t t = 0; t < kNumDerivativeTerms; ++t) {
      m.cost[t] = kPathsPerSample[t] * halves[0]->NumSamples(t);
    }
    return m;
  }

  /// Best costs of the terms are as the roots of variance times cost (Neyman's allocation).
  void Improve(const Measurement& m) {
    ByTerm best{};
    for (std::size_t t = 0; t < best.size(); ++t) best[t] = std::sqrt(m.variance[t] * m.cost[t]);
    inefficiency_ = std::accumulate(best.begin(), best.end(), 0.0);
    const double least = kLeastShare * std::ranges::max(best);
    double boundaries = 0.0;
    for (std::size_t t = 1; t < best.size(); ++t) {
      best[t] = m.cost[t] > 0.0 ? std::max(best[t], least) : 0.0;
      boundaries += best[t];
    }
    const double most = kMostBoundaryCost * measured_.spp *
                        static_cast<double>(images_.camera.width) * images_.camera.height;
    const double wanted =
        boundaries * m.cost[0] < most * best[0] ? boundaries * m.cost[0] / best[0] : most;
    for (std::size_t t = 1; t < best.size(); ++t) {
      if (best[t] > 0.0) {
        measured_.*kBoundaryBudgets[t - 1] *= wanted * best[t] / (boundaries * m.cost[t]);
      }
    }
  }

  std::uint64_t NextSeed() {
    return CounterRng(options_.seed, RandomDomain::kBudgetSeed, options_.view, num_seeds_++)
        .NextInteger();
  }

  const Renderer& renderer_;
  const DerivativeImages& images_;
  const RenderOptions& options_;
  std::vector<double>& scales_;
  const CancelFlag* cancel_;
  RenderOptions measured_;
  std::uint64_t num_seeds_ = 0;
  double inefficiency_ = 0.0;
};

/// Whether the scene's derivative can be taken in that form.
bool Allows(const Renderer& renderer, const ParameterLayout& layout, const RenderOptions& options) {
  try {
    CheckDerivative(renderer.scene(), layout, options);
    return true;
  } catch (const SceneError&) {
    return false;
  }
}

}  // namespace

RenderOptions ChooseDerivative(const Renderer& renderer,
                               const DerivativeImages& images,
                               const RenderOptions& options,
                               const DerivativeChoice& given,
                               const CancelFlag* cancel) {
  DerivativeChoice choice = given;
  if (!choice.form && DefaultForm(renderer.scene(), images.layout) == DerivativeForm::kMaterial) {
    choice.form = DerivativeForm::kMaterial;
  }
  RenderOptions found = options;
  choice.ApplyTo(found);
  if ((choice.HasAll() && choice.form) || !images.layout.AnyKind(MovesGeometry)) {
    return found;
  }
  RenderOptions other = found;
  other.form = DerivativeForm::kMaterial;
  std::vector<double> scales;
  Search search(renderer, images, found, scales, cancel);
  Search of_other(renderer, images, other, scales, cancel);
  Search* best = &search;
  search.Step(kFirstShare);
  if (!choice.form && Allows(renderer, images.layout, other)) {
    of_other.Step(kFirstShare);
    if (of_other.Inefficiency() < search.Inefficiency()) best = &of_other;
  }
  best->Step(kSecondShare);
  found = best->Found();
  choice.BoundaryBudgets::ApplyTo(found);
  return found;
}

}  // namespace pathfit::renderer
