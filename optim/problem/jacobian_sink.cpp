#include "optim/problem/jacobian_sink.h"

#include <algorithm>
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

}  // namespace

JacobianSink::JacobianSink(int width, int height)
    : width_(width), height_(height), lines_(static_cast<std::size_t>(height)) {}

void JacobianSink::Add(std::int64_t pixel,
                       std::span<const renderer::ParameterDerivative> derivatives) {
  PATHFIT_DCHECK(pixel >= 0 && pixel < static_cast<std::int64_t>(width_) * height_);
  Line& line = lines_[static_cast<std::size_t>(pixel / width_)];
  const std::size_t first = line.entries.size();
  for (const renderer::ParameterDerivative& derivative : derivatives) {
    if (IsZero(derivative)) {
      continue;
    }
    PixelDerivative& entry = line.entries.emplace_back();
    entry.block = derivative.block;
    for (std::size_t component = 0; component < 3; ++component) {
      for (int channel = 0; channel < 4; ++channel) {
        entry.d[component * 4 + static_cast<std::size_t>(channel)] =
            static_cast<float>(derivative.d[component][channel]);
      }
    }
  }
  const std::size_t count = line.entries.size() - first;
  if (count == 0) {
    return;
  }
  line.pieces.push_back({static_cast<std::uint32_t>(pixel % width_),
                         static_cast<std::uint32_t>(first),
                         static_cast<std::uint32_t>(count)});
  const std::size_t merged = line.firsts.empty() ? 0 : line.firsts.back();
  if (line.entries.size() > 2 * merged + kMergeSlack * static_cast<std::size_t>(width_)) {
    Merge(line);
  }
}

void JacobianSink::Take(JacobianSink&& other) {
  PATHFIT_CHECK(width_ == other.width_ && height_ == other.height_);
  renderer::ParallelFor(height_, [&](std::int64_t y) {
    Line& line = lines_[static_cast<std::size_t>(y)];
    Line from = std::exchange(other.lines_[static_cast<std::size_t>(y)], {});
    other.Merge(from);
    if (line.entries.empty()) {
      line = std::move(from);
      return;
    }
    const std::size_t offset = line.entries.size();
    line.entries.insert(line.entries.end(), from.entries.begin(), from.entries.end());
    for (std::size_t x = 0; x + 1 < from.firsts.size(); ++x) {
      const std::uint32_t count = from.firsts[x + 1] - from.firsts[x];
      if (count > 0) {
        line.pieces.push_back({static_cast<std::uint32_t>(x),
                               static_cast<std::uint32_t>(offset + from.firsts[x]),
                               count});
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
  std::vector<PixelDerivative> merged;
  merged.reserve(line.entries.size());
  std::vector<std::uint32_t> firsts(width + 1);
  std::vector<std::uint64_t> order;  // blocks, and behind them the places of their entries
  const auto list = [&](std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) {
      order.push_back(static_cast<std::uint64_t>(line.entries[i].block) << 32 | i);
    }
  };
  for (std::size_t x = 0, next = 0; x < width; ++x) {
    order.clear();
    if (!line.firsts.empty()) {
      list(line.firsts[x], line.firsts[x + 1] - line.firsts[x]);
    }
    for (; next < ends[x]; ++next) {
      list(by_pixel[next].first, by_pixel[next].count);
    }
    // Equal blocks keep the order of their calls, so sums are reproducible.
    std::sort(order.begin(), order.end());
    for (const std::uint64_t key : order) {
      const PixelDerivative& entry = line.entries[key & 0xFFFFFFFFU];
      if (merged.size() > firsts[x] && merged.back().block == entry.block) {
        for (std::size_t k = 0; k < entry.d.size(); ++k) {
          merged.back().d[k] += entry.d[k];
        }
      } else {
        merged.push_back(entry);
      }
    }
    firsts[x + 1] = static_cast<std::uint32_t>(merged.size());
  }
  line.entries = std::move(merged);
  line.firsts = std::move(firsts);
  line.pieces.clear();
}

void JacobianSink::Finish() {
  renderer::ParallelFor(height_, [&](std::int64_t y) {
    Line& line = lines_[static_cast<std::size_t>(y)];
    Merge(line);
    line.entries.shrink_to_fit();
    line.pieces = {};
  });
}

std::size_t JacobianSink::MemoryBytes() const {
  std::size_t bytes = lines_.size() * sizeof(Line);
  for (const Line& line : lines_) {
    bytes += line.entries.capacity() * sizeof(PixelDerivative) +
             line.firsts.capacity() * sizeof(line.firsts[0]) +
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
