#pragma once

#include <chrono>
#include <cstddef>
#include <ctime>
#include <map>
#include <utility>
#include <vector>

#include "optim/ranks/byte_stream.h"
#include "optim/ranks/ranks.h"
#include "renderer/core/clock.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {

/// What an item of a loop has taken, in seconds: where it was made, and where the first rank took
/// it.
struct ItemCost {
  double making = 0.0, taking = 0.0;
};

/// What the first rank knows of loops: processor seconds of all ranks' making and of its own
/// taking, seconds in which it waited for others, and what came from them.
struct DivisionTimes {
  double making = 0.0, taking = 0.0, waiting = 0.0;
  double bytes = 0.0;
};

/// Deals items to ranks so that all end at about the same time: the rank of each item. The first
/// rank takes results in the order of items, and makes the first items itself, so that it holds
/// nothing back. `homes`, unless empty: the rank beside the first on which an item was before, 0 if
/// on none; it stays there unless that rank would have clearly more to do than another.
std::vector<int> Deal(const std::vector<ItemCost>& costs,
                      int num_ranks,
                      const std::vector<int>& homes = {});

/// Divides loops over items, such as views, among ranks. What is taken, and in which order, does
/// not depend on the number of ranks, so neither do its bits. Every rank calls the same loops in
/// the same order.
class Division {
 public:
  /// Among none: all on this process.
  Division() = default;
  /// Both may be null, and must outlive it.
  Division(Ranks* ranks, const renderer::CancelFlag* cancel) : ranks_(ranks), cancel_(cancel) {}

  [[nodiscard]] bool IsFirst() const { return ranks_ == nullptr || ranks_->IsFirst(); }
  [[nodiscard]] bool IsAlone() const { return ranks_ == nullptr || ranks_->IsAlone(); }

  [[nodiscard]] int NumRanks() const { return IsAlone() ? 1 : ranks_->count(); }
  /// Since the last call.
  DivisionTimes TakeTimes() { return std::exchange(times_, {}); }

  /// What items cost is remembered by kind of loop: next time they cost alike.
  enum class Kind { kDerivative, kTrial, kValidation, kComparison, kReport };

  /// The ranks of items 0, 1, ...; on every rank. With `things` (by item: what it needs, such as a
  /// view's photo), items of the same thing stay on one rank beside the first where that costs
  /// little, whatever the loop.
  std::vector<int> DealItems(Kind kind, std::size_t count);
  std::vector<int> DealItems(Kind kind, const std::vector<int>& things);

  /// make(i, give) on the rank of item i gives any number of parts; take(i, part) takes them on the
  /// first rank, in order of items. Parts travel as byte_stream.h says. An
  /// exception of either ends the loop on all ranks: it reaches the caller of the first, the
  /// others' get RanksStopped.
  template <class Part, class Make, class Take>
  void ForEach(Kind kind, const std::vector<int>& rank_of, const Make& make, const Take& take);
  template <class Part, class Make, class Take>
  void ForEach(Kind kind, std::size_t count, const Make& make, const Take& take) {
    ForEach<Part>(kind, DealItems(kind, count), make, take);
  }
  template <class Part, class Make, class Take>
  void ForEachThing(Kind kind, const std::vector<int>& things, const Make& make, const Take& take) {
    ForEach<Part>(kind, DealItems(kind, things), make, take);
  }

  /// The first rank's value, on every rank.
  template <class T>
  T Share(T value) {
    if (IsAlone()) return value;
    if (IsFirst()) {
      ranks_->CheckOthers();
      ByteWriter writer;
      writer.Put(value);
      ranks_->Tell(writer.Take());
    } else {
      const Bytes order = ranks_->Hear(cancel_);
      ByteReader(order).Get(value);
    }
    return value;
  }

 private:
  static double ProcessorSeconds() {
    return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
  }
  /// Runs the body of an item on a rank that is not the first.
  template <class Body>
  void MakeForFirst(const Body& body);

  Ranks* ranks_ = nullptr;
  const renderer::CancelFlag* cancel_ = nullptr;
  std::map<Kind, std::vector<ItemCost>> costs_;  ///< on the first rank, by item
  std::map<int, int> homes_;                     ///< on the first rank: of things, the others' rank
  DivisionTimes times_;
};

template <class Body>
void Division::MakeForFirst(const Body& body) {
  try {
    body();
  } catch (const RanksStopped&) {
    throw;
  } catch (...) {
    ranks_->ReportException();
    for (;;) ranks_->Hear(nullptr);  // until the first ends it
  }
}

template <class Part, class Make, class Take>
void Division::ForEach(Kind kind,
                       const std::vector<int>& rank_of,
                       const Make& make,
                       const Take& take) {
  if (!IsFirst()) {
    for (std::size_t i = 0; i < rank_of.size(); ++i) {
      if (rank_of[i] != ranks_->index()) continue;
      ranks_->CheckFirst();
      MakeForFirst([&] {
        const auto start = renderer::Clock::now();
        const double cpu = ProcessorSeconds();
        make(i, [&](const Part& part) {
          ByteWriter writer;
          writer.Put(true);
          writer.Put(part);
          ranks_->Return(writer.Take());
        });
        ByteWriter end;
        end.Put(false);
        end.Put(renderer::SecondsSince(start));
        end.Put(ProcessorSeconds() - cpu);
        ranks_->Return(end.Take());
      });
    }
    return;
  }
  std::vector<ItemCost>& costs = costs_[kind];
  const bool is_again = costs.size() == rank_of.size();
  if (!is_again) costs.assign(rank_of.size(), {});
  for (std::size_t i = 0; i < rank_of.size(); ++i) {
    const auto start = renderer::Clock::now();
    ItemCost cost, cpu;
    const double cpu_start = ProcessorSeconds();
    // Also what it takes to unpack a part that was sent.
    const auto timed = [&](const auto& body) {
      const auto begin = renderer::Clock::now();
      const double cpu_begin = ProcessorSeconds();
      body();
      cost.taking += renderer::SecondsSince(begin);
      cpu.taking += ProcessorSeconds() - cpu_begin;
    };
    if (rank_of[i] == 0) {
      make(i, [&](const Part& part) { timed([&] { take(i, part); }); });
      cost.making = renderer::SecondsSince(start) - cost.taking;
      cpu.making = ProcessorSeconds() - cpu_start - cpu.taking;
    } else {
      for (;;) {
        const auto begin = renderer::Clock::now();
        const Bytes result = ranks_->Await(rank_of[i], cancel_);
        times_.waiting += renderer::SecondsSince(begin);
        times_.bytes += static_cast<double>(result.size());
        ByteReader reader(result);
        bool has_part = false;
        reader.Get(has_part);
        if (!has_part) {
          reader.Get(cost.making);
          reader.Get(cpu.making);
          break;
        }
        timed([&] {
          Part part;
          reader.Get(part);
          take(i, std::move(part));
        });
      }
    }
    // Single times are noise to a degree that would move items to and fro.
    costs[i] = is_again ? ItemCost{0.5 * (costs[i].making + cost.making),
                                   0.5 * (costs[i].taking + cost.taking)}
                        : cost;
    times_.making += cpu.making;
    times_.taking += cpu.taking;
  }
}

}  // namespace pathfit::optim
