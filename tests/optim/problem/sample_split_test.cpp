#include "optim/problem/sample_split.h"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "tests/optim/problem/linear_image_source.h"

namespace pathfit::sample_split_test {
namespace {

using optim::SplitMeter;
using optim::TermSink;
using renderer::DerivativeTerm;
using renderer::SampleBudget;

constexpr SampleBudget kStart{.spp = 1, .sppe = 0.5, .spp_direct = 0.1};
constexpr int kWidth = 8, kHeight = 4;
constexpr double kNumInterior = 1000.0;

/// Both halves' derivatives of every pixel by one coordinate: `mean` plus and minus `noise`.
void AddTerm(
    DerivativeTerm term, double num_samples, double mean, double noise, TermSink& a, TermSink& b) {
  for (const double sign : {1.0, -1.0}) {
    TermSink& sink = sign > 0.0 ? a : b;
    sink.BeginTerm(term, static_cast<std::int64_t>(std::lround(num_samples)));
    for (int pixel = 0; pixel < kWidth * kHeight; ++pixel) {
      renderer::ParameterDerivative d;
      d.block = 7;
      d.d[1] = renderer::Rgba(mean + sign * noise, 0.0, 0.0, 0.0);
      sink.Add(pixel, {&d, 1});
    }
  }
}

/// Where rounds end up whose direct term has `variance` times the interior's per sample; per
/// interior sample.
SampleBudget SplitInTheEnd(double variance, const std::optional<SampleBudget>& at_cost_of = {}) {
  const tests::LinearFit fit = tests::MakeLinearFit(kWidth, kHeight, 1, 1);
  const optim::ParameterSet set(fit.scene, fit.unknowns, {0}, {}, {});
  const optim::ViewLevel level = fit.views.levels[0].Unpack();
  renderer::Film film(kWidth, kHeight);
  for (std::size_t p = 0; p < film.pixels.size(); ++p) {
    film.pixels[p] = renderer::Rgba(static_cast<double>(level.photo.data[3 * p]) + 1.0, 0, 0, 1);
  }
  const optim::RowScales scales = optim::MakeRowScales(level, false, {}, {});
  SampleBudget split = kStart;
  for (int round = 0; round < 40; ++round) {
    const double num_direct = kNumInterior * split.spp_direct;
    TermSink a(kWidth, kHeight), b(kWidth, kHeight);
    AddTerm(DerivativeTerm::kInterior, kNumInterior, 1.0, 1.0 / std::sqrt(kNumInterior), a, b);
    AddTerm(DerivativeTerm::kDirect, num_direct, 0.0, std::sqrt(variance / num_direct), a, b);
    a.Finish();
    b.Finish();
    SplitMeter meter(set);
    meter.AddTerms({film, film, a, b, level, scales, fit.truth, "photo"});
    const auto& interior_a = *a.parts()[0];
    const auto& interior_b = *b.parts()[0];
    optim::PixelRows rows;
    optim::HalvesMerger(
        {film, film, interior_a.sink, interior_b.sink}, level, scales, set, fit.truth, "photo")
        .Next(rows);
    meter.AddRows(rows);
    split = meter.Improve(split, at_cost_of);
  }
  return split;
}

TEST(SplitMeterTest, SamplesGoAsTheRootOfVarianceOverCost) {
  const SampleBudget split = SplitInTheEnd(4.0);
  EXPECT_NEAR(split.spp_direct, std::sqrt(4.0 / 1.5), 0.01);  // a sample of edges costs 1.5 paths
  EXPECT_EQ(split.sppe, kStart.sppe);                         // without samples: as it was
  EXPECT_EQ(split.spp, 1);
}

TEST(SplitMeterTest, CostStaysWithinItsBounds) {
  EXPECT_NEAR(SplitInTheEnd(1e6).spp_direct, 3.0 / 1.5, 0.01);
  EXPECT_NEAR(SplitInTheEnd(0.0).spp_direct, 0.05 / 1.5, 0.001);
  // The only boundary term has what the boundaries together may cost.
  EXPECT_NEAR(SplitInTheEnd(1e6, kStart).spp_direct, kStart.spp_direct, 1e-9);
}

}  // namespace
}  // namespace pathfit::sample_split_test
