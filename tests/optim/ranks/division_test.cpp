#include "optim/ranks/division.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"

namespace pathfit::optim::division_test {
namespace {

std::vector<ItemCost> Equal(std::size_t count, double taking = 0.0) {
  return std::vector<ItemCost>(count, {1.0, taking});
}

TEST(ByteStream, ReadsWhatWasWritten) {
  ByteWriter writer;
  writer.Put(3.5);
  writer.Put(std::vector<int>{1, 2, 3});
  writer.Put(std::string("text"));
  writer.Put(std::vector<double>());
  const Bytes bytes = writer.Take();
  ByteReader reader(bytes);
  double number = 0.0;
  std::vector<int> list;
  std::string text;
  std::vector<double> empty{1.0};
  reader.Get(number);
  reader.Get(list);
  reader.Get(text);
  reader.Get(empty);
  EXPECT_EQ(number, 3.5);
  EXPECT_EQ(list, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(text, "text");
  EXPECT_TRUE(empty.empty());
  EXPECT_THROW(reader.Get(number), renderer::IoError);
}

/// A type that says its parts once.
struct Parcel {
  std::vector<std::pair<std::string, std::vector<int>>> lists;
  std::optional<std::string> label;
  std::optional<std::vector<double>> weights;
  std::array<std::string, 2> ends;
  double value = 0.0;

  static void VisitParts(auto& parcel, const auto& visit) {
    visit(parcel.lists);
    visit(parcel.label);
    visit(parcel.weights);
    visit(parcel.ends);
    visit(parcel.value);
  }
};

TEST(ByteStream, ReadsThePartsOfATypeAsTheyWereWritten) {
  ByteWriter writer;
  writer.Put(std::vector<Parcel>{{{{"a", {1, 2}}, {"", {}}}, "to you", {}, {"here", "there"}, 2.5},
                                 Parcel()});
  const Bytes bytes = writer.Take();
  ByteReader reader(bytes);
  std::vector<Parcel> read(5);
  read[0].weights = {1.0};
  reader.Get(read);
  ASSERT_EQ(read.size(), 2U);
  ASSERT_EQ(read[0].lists.size(), 2U);
  EXPECT_EQ(read[0].lists[0].first, "a");
  EXPECT_EQ(read[0].lists[0].second, (std::vector<int>{1, 2}));
  EXPECT_EQ(read[0].label, "to you");
  EXPECT_FALSE(read[0].weights);
  EXPECT_EQ(read[0].ends[1], "there");
  EXPECT_EQ(read[0].value, 2.5);
  EXPECT_TRUE(read[1].lists.empty());
  EXPECT_FALSE(read[1].label);
  const Bytes half(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2));
  ByteReader of_half(half);
  EXPECT_THROW(of_half.Get(read), renderer::IoError);
}

TEST(ByteStream, RefusesACountBeyondTheEnd) {
  ByteWriter writer;
  writer.Put(std::size_t{1} << 62);
  const Bytes bytes = writer.Take();
  ByteReader reader(bytes);
  std::vector<double> list;
  EXPECT_THROW(reader.Get(list), renderer::IoError);
}

TEST(Deal, GivesEachRankAsMuchAndTheFirstTheFirstItems) {
  const std::vector<int> dealt = Deal(Equal(8), 4);
  EXPECT_EQ(dealt[0], 0);
  EXPECT_EQ(dealt[1], 0);
  for (int rank = 0; rank < 4; ++rank) EXPECT_EQ(std::ranges::count(dealt, rank), 2);
  EXPECT_EQ(Deal(Equal(3), 1), (std::vector<int>{0, 0, 0}));
}

TEST(Deal, LeavesMakingToOthersAsFarAsTheFirstIsBusyTaking) {
  // Ten views of which taking costs a fifth of making: 12 in all, 4 for each of three ranks.
  const std::vector<int> dealt = Deal(Equal(10, 0.2), 3);
  EXPECT_EQ(std::ranges::count(dealt, 0), 2);
  EXPECT_EQ(std::ranges::count(dealt, 1), 4);
}

TEST(Deal, GoesByWhatItemsCost) {
  std::vector<ItemCost> costs = Equal(7);
  costs[6].making = 6.0;
  const std::vector<int> dealt = Deal(costs, 2);
  EXPECT_EQ(std::ranges::count(dealt, 0), 6);
  EXPECT_EQ(dealt[6], 1);
}

TEST(Deal, KeepsItemsWhereTheyWereUnlessThatCosts) {
  std::vector<ItemCost> costs = Equal(24);
  const std::vector<int> before = Deal(costs, 4);
  std::vector<int> homes = before;
  // Times are never quite the same.
  for (std::size_t i = 0; i < costs.size(); ++i)
    costs[i].making += 0.01 * static_cast<double>(i % 5);
  EXPECT_EQ(Deal(costs, 4, homes), before);
  // One rank holds all: the others take from it what evens out.
  std::ranges::fill(homes, 2);
  const std::vector<int> evened = Deal(Equal(24), 4, homes);
  for (int rank = 0; rank < 4; ++rank) EXPECT_EQ(std::ranges::count(evened, rank), 6);
}

TEST(Division, AloneTakesPartsInOrder) {
  Division alone;
  std::vector<int> taken;
  alone.ForEach<int>(
      Division::Kind::kTrial,
      3,
      [](std::size_t i, const auto& give) {
        give(static_cast<int>(2 * i));
        give(static_cast<int>(2 * i + 1));
      },
      [&](std::size_t i, int part) {
        EXPECT_EQ(static_cast<std::size_t>(part) / 2, i);
        taken.push_back(part);
      });
  EXPECT_EQ(taken, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(alone.Share(7), 7);
}

}  // namespace
}  // namespace pathfit::optim::division_test
