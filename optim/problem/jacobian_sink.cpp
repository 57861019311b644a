#include "optim/problem/jacobian_sink.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>

#include "renderer/core/check.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

// Unmerged entries that a line may hold before it is merged, by pixel.
constexpr std::size_t kMergeSlack = 16;

bool IsZero(const renderer::ParameterDerivative& derivative) {
  return std::all_of(derivative.d.begin(), derivative.d.end(), [](const renderer::Rgba& d) {
    return d.r == 0.0 && d.g == 0.0 && d.b == 0.0 && d.a == 0.0;
  });
}

PixelDerivative InSinglePrecision(const renderer::ParameterDerivative& derivative) {
  PixelDerivative entry{derivative.block, {}};
  for (std::size_t component = 0; component < 3; ++component) {
    for (int channel = 0; channel < 4; ++channel) {
      entry.d[component * 4 + static_cast<std::size_t>(channel)] =
          static_cast<float>(derivative.d[component][channel]);
    }
  }
  return entry;
}

}  // namespace

void PackedDerivatives::Iterator::AddTo(PixelDerivative& entry) const {
  const float* value = packed_->values_.data() + value_;
  for (unsigned mask = packed_->masks_[entry_]; mask != 0; mask &= mask - 1) {
    entry.d[static_cast<std::size_t>(std::countr_zero(mask))] += *value++;
  }
}

void PackedDerivatives::Add(const PixelDerivative& entry) {
  unsigned mask = 0;
  for (std::size_t k = 0; k < entry.d.size(); ++k) {
    if (entry.d[k] != 0.0F) {
      mask |= 1U << k;
      values_.push_back(entry.d[k]);
    }
  }
  blocks_.push_back(entry.block);
  masks_.push_back(static_cast<std::uint16_t>(mask));
}

void PackedDerivatives::Append(const PackedDerivatives& other) {
  blocks_.insert(blocks_.end(), other.blocks_.begin(), other.blocks_.end());
  masks_.insert(masks_.end(), other.masks_.begin(), other.masks_.end());
  values_.insert(values_.end(), other.values_.begin(), other.values_.end());
}

void PackedDerivatives::Shrink() {
  blocks_.shrink_to_fit();
  masks_.shrink_to_fit();
  values_.shrink_to_fit();
}

std::size_t PackedDerivatives::MemoryBytes() const {
  return blocks_.capacity() * sizeof(blocks_[0]) + masks_.capacity() * sizeof(masks_[0]) +
         values_.capacity() * sizeof(values_[0]);
}

JacobianSink::JacobianSink(int width, int height)
    : width_(width), height_(height), lines_(static_cast<std::size_t>(height)) {}

void JacobianSink::Add(std::int64_t pixel,
                       std::span<const renderer::ParameterDerivative> derivatives) {
  PATHFIT_DCHECK(pixel >= 0 && pixel < static_cast<std::int64_t>(width_) * height_);
  Line& line = lines_[static_cast<std::size_t>(pixel / width_)];
  const Place first = EndOf(line);
  for (const renderer::ParameterDerivative& derivative : derivatives) {
    if (!IsZero(derivative)) {
      line.entries.Add(InSinglePrecision(derivative));
    }
  }
  const std::size_t count = line.entries.NumEntries() - first.entry;
  if (count == 0) {
    return;
  }
  line.pieces.push_back(
      {static_cast<std::uint32_t>(pixel % width_), static_cast<std::uint32_t>(count), first});
  const std::size_t merged = line.firsts.empty() ? 0 : line.firsts.back().entry;
  if (line.entries.NumEntries() > 2 * merged + kMergeSlack * static_cast<std::size_t>(width_)) {
    Merge(line);
  }
}

JacobianSink::Place JacobianSink::EndOf(const Line& line) {
  return {static_cast<std::uint32_t>(line.entries.NumEntries()),
          static_cast<std::uint32_t>(line.entries.NumValues())};
}

JacobianSink::Entries JacobianSink::Pixel(std::size_t pixel) const {
  const auto width = static_cast<std::size_t>(width_);
  const Line& line = lines_[pixel / width];
  if (line.firsts.empty()) {
    return {};
  }
  const Place first = line.firsts[pixel % width];
  const Place end = line.firsts[pixel % width + 1];
  using Iterator = PackedDerivatives::Iterator;
  return {Iterator(line.entries, first.entry, first.value),
          Iterator(line.entries, end.entry, end.value),
          end.entry - first.entry};
}

void JacobianSink::Take(JacobianSink&& other) {
  PATHFIT_CHECK(width_ == other.width_ && height_ == other.height_);
  renderer::ParallelFor(height_, [&](std::int64_t y) {
    Line& line = lines_[static_cast<std::size_t>(y)];
    Line from = std::exchange(other.lines_[static_cast<std::size_t>(y)], {});
    other.Merge(from);
    if (line.entries.NumEntries() == 0) {
      line = std::move(from);
      return;
    }
    const Place offset = EndOf(line);
    line.entries.Append(from.entries);
    for (std::size_t x = 0; x + 1 < from.firsts.size(); ++x) {
      const Place first = from.firsts[x];
      const std::uint32_t count = from.firsts[x + 1].entry - first.entry;
      if (count > 0) {
        line.pieces.push_back({static_cast<std::uint32_t>(x),
                               count,
                               {offset.entry + first.entry, offset.value + first.value}});
      }
    }
  });
}

void JacobianSink::Merge(Line& line) const {
  if (line.pieces.empty()) {
    return;
  }
  const auto width = static_cast<std::size_t>(width_);
  std::vector<std::uint32_t> ends(width + 1);  // of each pixel's pieces
  for (const Piece& piece : line.pieces) {
    ++ends[piece.x + 1];
  }
  for (std::size_t x = 0; x < width; ++x) {
    ends[x + 1] += ends[x];
  }
  std::vector<Piece> by_pixel(line.pieces.size());
  for (const Piece& piece : line.pieces) {
    by_pixel[ends[piece.x]++] = piece;
  }
  Line merged;
  merged.firsts.resize(width + 1);
  std::vector<PackedDerivatives::Iterator> entries;  // of a pixel, in the order of their calls
  std::vector<std::uint64_t> order;                  // blocks, and behind them places among those
  const auto list = [&](Place first, std::size_t count) {
    PackedDerivatives::Iterator entry(line.entries, first.entry, first.value);
    for (std::size_t i = 0; i < count; ++i, ++entry) {
      order.push_back(static_cast<std::uint64_t>(entry.block()) << 32 | entries.size());
      entries.push_back(entry);
    }
  };
  for (std::size_t x = 0, next = 0; x < width; ++x) {
    order.clear();
    entries.clear();
    if (!line.firsts.empty()) {
      list(line.firsts[x], line.firsts[x + 1].entry - line.firsts[x].entry);
    }
    for (; next < ends[x]; ++next) {
      list(by_pixel[next].first, by_pixel[next].count);
    }
    // Equal blocks keep the order of their calls, so sums are reproducible.
    std::sort(order.begin(), order.end());
    for (std::size_t k = 0; k < order.size();) {
      PixelDerivative sum{static_cast<std::int32_t>(order[k] >> 32), {}};
      for (; k < order.size() && static_cast<std::int32_t>(order[k] >> 32) == sum.block; ++k) {
        entries[order[k] & 0xFFFFFFFFU].AddTo(sum);
      }
      merged.entries.Add(sum);
    }
    merged.firsts[x + 1] = EndOf(merged);
  }
  line = std::move(merged);
}

void JacobianSink::Finish() {
  renderer::ParallelFor(height_, [&](std::int64_t y) {
    Line& line = lines_[static_cast<std::size_t>(y)];
    Merge(line);
    line.entries.Shrink();
  });
}

std::size_t JacobianSink::MemoryBytes() const {
  std::size_t bytes = lines_.size() * sizeof(Line);
  for (const Line& line : lines_) {
    bytes += line.entries.MemoryBytes() + line.firsts.capacity() * sizeof(line.firsts[0]) +
             line.pieces.capacity() * sizeof(Piece);
  }
  return bytes;
}

TermSink::TermSink(int width, int height) : width_(width), height_(height) {}

void TermSink::BeginTerm(renderer::DerivativeTerm term, std::int64_t num_samples) {
  current_ = static_cast<std::size_t>(term);
  parts_[current_].emplace(width_, height_, num_samples);
}

void TermSink::Add(std::int64_t pixel, std::span<const renderer::ParameterDerivative> derivatives) {
  PATHFIT_DCHECK(parts_[current_]);
  parts_[current_]->sink.Add(pixel, derivatives);
}

std::size_t TermSink::MemoryBytes() const {
  std::size_t bytes = 0;
  for (const std::optional<Part>& part : parts_) {
    bytes += part ? part->sink.MemoryBytes() : 0;
  }
  return bytes;
}

void TermSink::MoveTo(JacobianSink& sink) {
  for (std::optional<Part>& part : parts_) {
    if (part) {
      sink.Take(std::move(part->sink));
    }
  }
  sink.Finish();
}

void TermSink::Finish() {
  for (std::optional<Part>& part : parts_) {
    if (part) {
      part->sink.Finish();
    }
  }
}

}  // namespace pathfit::optim
