#include "optim/problem/jacobian_sink.h"

#include <algorithm>
#include <cstddef>

#include "renderer/core/check.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

constexpr std::size_t kMergeSlack = 32;  // unmerged entries a pixel may hold before it is compacted

bool IsZero(const renderer::ParameterDerivative& derivative) {
  return std::all_of(derivative.d.begin(), derivative.d.end(), [](const renderer::Rgba& d) {
    return d.r == 0.0 && d.g == 0.0 && d.b == 0.0 && d.a == 0.0;
  });
}

}  // namespace

JacobianSink::JacobianSink(int width, int height)
    : width_(width),
      height_(height),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

void JacobianSink::Add(std::int64_t pixel,
                       std::span<const renderer::ParameterDerivative> derivatives) {
  PATHFIT_DCHECK(pixel >= 0 && static_cast<std::size_t>(pixel) < pixels_.size());
  PixelList& list = pixels_[static_cast<std::size_t>(pixel)];
  for (const renderer::ParameterDerivative& derivative : derivatives) {
    if (IsZero(derivative)) {
      continue;
    }
    PixelDerivative entry;
    entry.block = derivative.block;
    for (std::size_t component = 0; component < 3; ++component) {
      for (int channel = 0; channel < 4; ++channel) {
        entry.d[component * 4 + static_cast<std::size_t>(channel)] =
            static_cast<float>(derivative.d[component][channel]);
      }
    }
    list.entries.push_back(entry);
  }
  if (list.entries.size() > 2 * list.num_merged + kMergeSlack) {
    Merge(list);
  }
}

void JacobianSink::Add(const JacobianSink& other) {
  PATHFIT_CHECK(width_ == other.width_ && height_ == other.height_);
  renderer::ParallelFor(height_, [&](std::int64_t y) {
    for (int x = 0; x < width_; ++x) {
      const auto pixel = static_cast<std::size_t>(y * width_ + x);
      const auto& entries = other.pixels_[pixel].entries;
      pixels_[pixel].entries.insert(pixels_[pixel].entries.end(), entries.begin(), entries.end());
    }
  });
}

void JacobianSink::Merge(PixelList& list) {
  auto& entries = list.entries;
  // Stable: equal blocks keep the order of their calls, so sums are reproducible.
  std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
    return a.block < b.block;
  });
  std::size_t count = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (count > 0 && entries[count - 1].block == entries[i].block) {
      for (std::size_t k = 0; k < entries[i].d.size(); ++k) {
        entries[count - 1].d[k] += entries[i].d[k];
      }
    } else {
      entries[count++] = entries[i];
    }
  }
  entries.resize(count);
  list.num_merged = count;
}

void JacobianSink::Finish() {
  renderer::ParallelFor(height_, [&](std::int64_t y) {
    for (int x = 0; x < width_; ++x) {
      PixelList& list = pixels_[static_cast<std::size_t>(y * width_ + x)];
      if (list.num_merged != list.entries.size()) {
        Merge(list);
      }
      list.entries.shrink_to_fit();
    }
  });
}

std::size_t JacobianSink::MemoryBytes() const {
  std::size_t bytes = pixels_.size() * sizeof(PixelList);
  for (const PixelList& list : pixels_) {
    bytes += list.entries.capacity() * sizeof(PixelDerivative);
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

void TermSink::Finish() {
  for (std::optional<Part>& part : parts_) {
    if (part) {
      part->sink.Finish();
    }
  }
}

}  // namespace pathfit::optim
