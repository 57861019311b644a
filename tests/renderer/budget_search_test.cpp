#include "renderer/budget_search.h"

#include <array>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/derivative/film_sink.h"
#include "renderer/math/median.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer {
namespace {

class BudgetSearchTest : public testing::Test {
 protected:
  BudgetSearchTest() {
    layout_.Add(ParameterKind::kVertexPositions, 0);
    // Everything of the ball along x.
    direction_.assign(static_cast<std::size_t>(layout_.NumScalars()), 0.0);
    for (std::size_t i = 0; i < direction_.size(); i += 3) direction_[i] = 1.0;
    options_.spp = 32;
    options_.max_bounces = 1;
    options_.seed = 3;
  }

  [[nodiscard]] RenderOptions Choose(const DerivativeChoice& given) const {
    const std::vector<std::vector<double>> directions = {direction_};
    return ChooseDerivative(
        renderer_, {scene_.sensors[0], 0, layout_, directions}, options_, given);
  }
  /// Squared difference of two derivative images, the median of pairs: few of them hold a sample
  /// that is worth more than all others.
  [[nodiscard]] double VarianceWith(RenderOptions options) const {
    constexpr int kPairs = 15;
    std::vector<double> sums;
    options.with_image = false;
    for (int i = 0; i < kPairs; ++i) {
      std::array<Film, 2> films;
      for (Film& film : films) {
        options.seed += 100;
        FilmSink sink(layout_, direction_, scene_.sensors[0].width, scene_.sensors[0].height);
        renderer_.RenderDerivative(scene_.sensors[0], 0, options, layout_, sink);
        film = sink.film();
      }
      double sum = 0.0;
      for (std::size_t p = 0; p < films[0].pixels.size(); ++p) {
        const double d = films[0].pixels[p].g - films[1].pixels[p].g;
        sum += d * d;
      }
      sums.push_back(sum);
    }
    return Median(sums);
  }

  Scene scene_ = tests::BallAndWall();
  Renderer renderer_{scene_};
  ParameterLayout layout_{scene_};
  std::vector<double> direction_;
  RenderOptions options_;
};

TEST_F(BudgetSearchTest, WhatIsGivenStays) {
  DerivativeChoice given;
  given.sppe = 3.0;
  given.form = DerivativeForm::kImage;
  const RenderOptions some = Choose(given);
  EXPECT_EQ(some.sppe, 3.0);
  EXPECT_EQ(some.form, DerivativeForm::kImage);
  EXPECT_EQ(some.spp, options_.spp);
  EXPECT_EQ(some.seed, options_.seed);
  given.spp_direct = given.spp_indirect = given.spp_pixel = 5.0;
  EXPECT_EQ(Choose(given).spp_direct, 5.0);
}

TEST_F(BudgetSearchTest, NothingIsMeasuredWhereNothingMoves) {
  layout_ = ParameterLayout(scene_);
  layout_.Add(ParameterKind::kBaseColor, 1);
  direction_.assign(static_cast<std::size_t>(layout_.NumScalars()), 1.0);
  const RenderOptions chosen = Choose({});
  EXPECT_EQ(chosen.sppe, options_.sppe);
  EXPECT_EQ(chosen.spp_direct, options_.spp_direct);
}

TEST_F(BudgetSearchTest, IsAFunctionOfItsArguments) {
  const RenderOptions chosen = Choose({});
  const ThreadLimit limit(1);
  const RenderOptions again = Choose({});
  EXPECT_EQ(chosen.form, again.form);
  for (const auto budget : kBoundaryBudgets) EXPECT_EQ(chosen.*budget, again.*budget);
}

TEST_F(BudgetSearchTest, ErrorTimesCostIsBelowThatOfAnyFixedSplit) {
  DerivativeChoice given;
  given.form = DerivativeForm::kImage;
  const auto cost_of = [&](const RenderOptions& options) {
    struct Counter : DerivativeSink {
      double cost = 0.0;
      void BeginTerm(DerivativeTerm term, std::int64_t num_samples) override {
        cost += kPathsPerSample[static_cast<std::size_t>(term)] * static_cast<double>(num_samples);
      }
      void Add(std::int64_t, std::span<const ParameterDerivative>) override {}
    } counter;
    renderer_.RenderDerivative(scene_.sensors[0], 0, options, layout_, counter);
    return counter.cost;
  };
  const RenderOptions chosen = Choose(given);
  const double found = VarianceWith(chosen) * cost_of(chosen);
  for (const auto budget : {&SampleBudget::sppe, &SampleBudget::spp_direct}) {
    for (const double factor : {0.1, 10.0}) {
      RenderOptions other = chosen;
      other.*budget *= factor;
      const double changed = VarianceWith(other) * cost_of(other);
      EXPECT_LT(found, 1.1 * changed) << factor;
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer
