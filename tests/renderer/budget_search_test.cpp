#include "renderer/budget_search.h"

#include <array>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace pathfit::renderer::budget_search_test {
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

TEST_F(BudgetSearchTest, BoundariesCostNoMoreThanTheirShareOfAnImage) {
  struct Counter : DerivativeSink {
    std::array<double, kNumDerivativeTerms> cost{};
    void BeginTerm(DerivativeTerm term, std::int64_t num_samples) override {
      const auto t = static_cast<std::size_t>(term);
      cost[t] = kPathsPerSample[t] * static_cast<double>(num_samples);
    }
    void Add(std::int64_t, std::span<const ParameterDerivative>) override {}
  };
  for (const DerivativeForm form : {DerivativeForm::kImage, DerivativeForm::kMaterial}) {
    DerivativeChoice given;
    given.form = form;
    const RenderOptions chosen = Choose(given);
    Counter counter;
    renderer_.RenderDerivative(scene_.sensors[0], 0, chosen, layout_, counter);
    double boundaries = 0.0;
    for (std::size_t t = 1; t < counter.cost.size(); ++t) {
      if (chosen.Has(kDerivativeTerms[t].second)) {
        EXPECT_GT(counter.cost[t], 0.0) << NameOf(kDerivativeTerms[t].second);
      }
      boundaries += counter.cost[t];
    }
    const double image = 1.0 * chosen.spp * scene_.sensors[0].width * scene_.sensors[0].height;
    EXPECT_LT(boundaries, 1.05 * kMostBoundaryCost * image);  // whole samples
  }
}

}  // namespace
}  // namespace pathfit::renderer::budget_search_test
