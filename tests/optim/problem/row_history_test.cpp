// Sums of rows over rounds, by hand.
#include "optim/problem/row_history.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "optim/problem/gram_system.h"
#include "optim/problem/round_sums.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/optim/problem/linear_image_source.h"

namespace pathfit::row_history_test {
namespace {

using optim::PixelRows;
using optim::RowHistory;

/// A coverage row of one scalar with the halves' residuals and derivatives.
struct Row {
  std::int32_t pixel;
  double r_a, r_b, j_a, j_b;
};

class RowHistoryTest : public testing::Test {
 protected:
  [[nodiscard]] PixelRows RowsOf(const std::vector<Row>& rows) const {
    PixelRows result;
    for (const Row& row : rows) {
      optim::RowUnit unit;
      unit.pixel = row.pixel;
      unit.is_coverage = true;
      unit.first_entry = result.entries.size();
      unit.SetResiduals({row.r_a}, {row.r_b});
      optim::HalvesEntry halves{1, {}, {}};
      halves.a[0] = row.j_a;
      halves.b[0] = row.j_b;
      result.AddEntry(unit, halves, set_.BlockSize(1));
      unit.num_entries = static_cast<std::int32_t>(result.entries.size() - unit.first_entry);
      result.units.push_back(unit);
    }
    return result;
  }
  /// By the scalar, of means.
  [[nodiscard]] double Gradient(const RowHistory& history) const {
    optim::GradientSums sums(n_);
    sums.Add(history.Means(0, set_), set_);
    return sums.gradient[scalar_];
  }
  [[nodiscard]] double Product(const RowHistory& history) const {
    optim::QuadraticModel model(n_);
    model.AddRows(history.Means(0, set_), set_);
    return model.product[scalar_ * (n_ + 1)];
  }

  tests::LinearFit fit_ = tests::MakeLinearFit(32, 16, 2, 4);
  optim::ParameterSet set_{fit_.scene, fit_.unknowns, {0}, {}, {}};
  std::size_t n_ = set_.NumScalars();
  std::size_t scalar_ = set_.BlockOffset(1);
  RowHistory history_{1, n_};
};

TEST_F(RowHistoryTest, HalvesOfAllRoundsMeet) {
  std::vector<double> theta(n_, 0.0);
  history_.Add({RowsOf({{3, 1.0, 2.0, 5.0, 7.0}})}, theta, 1.0, set_);
  EXPECT_NEAR(Product(history_), 5.0 * 7.0, 1e-5);
  EXPECT_NEAR(Gradient(history_), 0.5 * (5.0 * 2.0 + 7.0 * 1.0), 1e-5);
  // At another point, three times the samples.
  theta[scalar_] = 0.5;
  history_.Add({RowsOf({{3, -1.0, 0.5, 6.0, 4.0}})}, theta, 3.0, set_);
  const double j_a = (5.0 + 3.0 * 6.0) / 4.0, j_b = (7.0 + 3.0 * 4.0) / 4.0;
  const double r_a = (1.0 + 0.5 * 5.0 + 3.0 * -1.0) / 4.0;
  const double r_b = (2.0 + 0.5 * 7.0 + 3.0 * 0.5) / 4.0;
  EXPECT_EQ(history_.weight, 4.0);
  EXPECT_NEAR(Product(history_), j_a * j_b, 1e-5);
  EXPECT_NEAR(Gradient(history_), 0.5 * (j_a * r_b + j_b * r_a), 1e-5);
  EXPECT_TRUE(history_.IsValid());
}

TEST_F(RowHistoryTest, PixelsThatOneRoundMissesCountAsNothingThere) {
  const std::vector<double> theta(n_, 0.0);
  history_.Add({RowsOf({{3, 1.0, 1.0, 2.0, 2.0}, {9, 4.0, 4.0, 8.0, 8.0}})}, theta, 1.0, set_);
  history_.Add({RowsOf({{1, 1.0, 1.0, 6.0, 6.0}, {9, 2.0, 2.0, 0.0, 0.0}})}, theta, 1.0, set_);
  EXPECT_EQ(history_.views[0].units, (std::vector<std::int32_t>{3, 7, 19}));
  EXPECT_NEAR(Product(history_), 1.0 + 9.0 + 16.0, 1e-5);
  EXPECT_NEAR(Gradient(history_), 0.5 + 1.5 + 4.0 * 3.0, 1e-5);
}

TEST_F(RowHistoryTest, FadedRoundsHaveTheWeightOfFewerSamples) {
  const std::vector<double> theta(n_, 0.0);
  const PixelRows first = RowsOf({{3, 1.0, 2.0, 5.0, 7.0}});
  const PixelRows second = RowsOf({{3, 3.0, 1.0, 2.0, 1.0}});
  history_.Add({first}, theta, 4.0, set_);
  history_.Fade(0.25);
  history_.Add({second}, theta, 1.0, set_);
  RowHistory fresh(1, n_);
  fresh.Add({first}, theta, 1.0, set_);
  fresh.Add({second}, theta, 1.0, set_);
  EXPECT_EQ(history_.weight, fresh.weight);
  EXPECT_NEAR(Product(history_), Product(fresh), 1e-5);
  EXPECT_NEAR(Gradient(history_), Gradient(fresh), 1e-5);
}

TEST_F(RowHistoryTest, TheNoiseOfDerivativesFallsWithTheNumberOfRounds) {
  // J is nearly all noise. 16 rounds: what it leaves has a 16th of the variance that the sum of the
  // rounds' own products has.
  constexpr int kFits = 40, kRounds = 16, kPixels = 100;
  constexpr double kNoiseOfJ = 10.0;
  const std::vector<double> theta(n_, 0.0);
  double together = 0.0, apart = 0.0, predicted = 0.0;
  for (std::uint64_t fit = 0; fit < kFits; ++fit) {
    RowHistory history(1, n_);
    double sum = 0.0;
    for (std::uint64_t round = 0; round < kRounds; ++round) {
      renderer::CounterRng rng(7, renderer::RandomDomain{1}, fit, round, 0);
      const auto noise = [&] { return std::sqrt(12.0) * (rng.Next() - 0.5); };
      std::vector<Row> rows;
      for (std::int32_t pixel = 0; pixel < kPixels; ++pixel) {
        rows.push_back(
            {pixel, noise(), noise(), 1.0 + kNoiseOfJ * noise(), 1.0 + kNoiseOfJ * noise()});
      }
      RowHistory one(1, n_);
      one.Add({RowsOf(rows)}, theta, 1.0, set_);
      sum += Gradient(one) / kRounds;
      history.Add({RowsOf(rows)}, theta, 1.0, set_);
    }
    apart += sum * sum / kFits;
    together += Gradient(history) * Gradient(history) / kFits;
    optim::QuadraticModel model(n_);
    model.AddRows(history.Means(0, set_), set_);
    predicted += model.covariance[scalar_ * (n_ + 1)] / kFits;
  }
  EXPECT_LT(together, apart / 6.0);
  EXPECT_NEAR(predicted / together, 1.0, 0.6);  // of 40 squares
}

TEST_F(RowHistoryTest, WhatIsDamagedIsSeen) {
  history_.Add({RowsOf({{3, 1.0, 2.0, 5.0, 7.0}})}, std::vector<double>(n_, 0.0), 1.0, set_);
  EXPECT_TRUE(RowHistory().IsValid());
  const auto is_seen = [&](const auto& damage) {
    RowHistory damaged = history_;
    damage(damaged);
    return !damaged.IsValid();
  };
  EXPECT_TRUE(is_seen([](RowHistory& h) { h.weight = -1.0; }));
  EXPECT_TRUE(is_seen([](RowHistory& h) { h.theta.push_back(0.0); }));
  EXPECT_TRUE(is_seen([](RowHistory& h) { h.views[0].units[0] = 4; })) << "three rows";
  EXPECT_TRUE(is_seen([](RowHistory& h) { h.views[0].units[0] = -5; }));
  EXPECT_TRUE(is_seen([](RowHistory& h) { h.views[0].jacobians.pop_back(); }));
  EXPECT_TRUE(is_seen(
      [](RowHistory& h) { h.views[0].residuals[0] = std::numeric_limits<double>::quiet_NaN(); }));
}

TEST_F(RowHistoryTest, RowsOfTooManyPixelsAreNotKept) {
  const double bytes = optim::RoundSums::BytesOfRows(fit_.views, 1.0, n_, 0.0);
  EXPECT_EQ(bytes, RowHistory::Bytes(2 * 32 * 16, n_, fit_.views.silhouettes));
  EXPECT_EQ(optim::RoundSums::BytesOfRows(fit_.views, 1e4, n_, 0.0), 0.0);
  EXPECT_EQ(optim::RoundSums::BytesOfRows(fit_.views, 1.0, n_, 100.0 * bytes), bytes);
  EXPECT_EQ(optim::RoundSums::BytesOfRows(fit_.views, 1.0, n_, 2.0 * bytes), 0.0);
}

}  // namespace
}  // namespace pathfit::row_history_test
