#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/derivative/derivative_sink.h"

namespace pathfit::renderer {

/// Sums the derivatives of one pixel over its samples, one entry per block, in order of first
/// appearance.
class DerivativeAccumulator {
 public:
  DerivativeAccumulator() : slots_(kInitialSlots, -1) {}

  /// The three components of a block, zero when first asked for. The reference holds until the next
  /// call.
  std::array<Rgba, 3>& Entry(std::int32_t block) {
    std::size_t slot = Slot(block);
    while (slots_[slot] >= 0) {
      ParameterDerivative& entry = entries_[static_cast<std::size_t>(slots_[slot])];
      if (entry.block == block) {
        return entry.d;
      }
      slot = (slot + 1) & (slots_.size() - 1);
    }
    if (2 * entries_.size() >= slots_.size()) {
      Grow();
      return Entry(block);
    }
    slots_[slot] = static_cast<std::int32_t>(entries_.size());
    used_.push_back(slot);
    entries_.push_back({block, {}});
    return entries_.back().d;
  }

  [[nodiscard]] std::span<ParameterDerivative> Entries() { return entries_; }

  void Clear() {
    for (const std::size_t slot : used_) {
      slots_[slot] = -1;
    }
    used_.clear();
    entries_.clear();
  }

 private:
  static constexpr std::size_t kInitialSlots = 64;

  [[nodiscard]] std::size_t Slot(std::int32_t block) const {
    return (static_cast<std::size_t>(block) * 0x9E3779B97F4A7C15ULL >> 20) & (slots_.size() - 1);
  }
  void Grow() {
    slots_.assign(2 * slots_.size(), -1);
    used_.clear();
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      std::size_t slot = Slot(entries_[i].block);
      while (slots_[slot] >= 0) {
        slot = (slot + 1) & (slots_.size() - 1);
      }
      slots_[slot] = static_cast<std::int32_t>(i);
      used_.push_back(slot);
    }
  }

  std::vector<std::int32_t> slots_;  // open addressing into entries_, -1 = free
  std::vector<std::size_t> used_;    // occupied slots
  std::vector<ParameterDerivative> entries_;
};

}  // namespace pathfit::renderer
