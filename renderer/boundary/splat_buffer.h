#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/derivative/derivative_sink.h"
#include "renderer/derivative/motion_adjoint.h"
#include "renderer/render_stats.h"
#include "renderer/sensor/pixel_filter.h"

namespace pathfit::renderer {

/// Gradient of one scalar (a normal velocity) by parameter blocks: the target of
/// MotionAdjoint<Vec3>. A boundary segment moves with about ten vertices, so a linear search is the
/// fastest map.
class MotionRow {
 public:
  struct Entry {
    std::int32_t block;
    Vec3 d;
  };
  void Clear() { entries_.clear(); }
  void Add(std::int32_t block, const Vec3& d) { At(block) += d; }
  void AddScalar(std::int32_t block, int component, double d) { At(block)[component] += d; }
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] bool Empty() const { return entries_.empty(); }

 private:
  Vec3& At(std::int32_t block) {
    for (Entry& e : entries_) {
      if (e.block == block) {
        return e.d;
      }
    }
    entries_.push_back({block, {}});
    return entries_.back().d;
  }
  std::vector<Entry> entries_;
};

/// Collects what boundary samples add to pixels and statistics, so that sampling runs in parallel
/// and the sink is fed in a fixed order.
class SplatBuffer {
 public:
  /// Every pixel under the filter at image point (u, v) gains color * row * its filter weight.
  void Splat(const Camera& camera, double u, double v, const Rgba& color, const MotionRow& row) {
    ForEachCoveringPixel(
        camera.filter, u, v, camera.width, camera.height, [&](int x, int y, double weight) {
          AddToPixel(static_cast<std::int64_t>(y) * camera.width + x, color * weight, row);
        });
  }
  void AddToPixel(std::int64_t pixel, const Rgba& color, const MotionRow& row) {
    splats_.push_back({pixel, entries_.size(), row.entries().size()});
    for (const MotionRow::Entry& e : row.entries()) {
      ParameterDerivative d;
      d.block = e.block;
      for (int i = 0; i < 3; ++i) {
        d.d[static_cast<std::size_t>(i)] = color * e.d[i];
      }
      entries_.push_back(d);
    }
  }
  /// Once, after all samples: colours times the gains of their pixels.
  void ApplyGains(const Camera& camera) {
    Rgb gains = camera.ChannelGains();
    for (const Entry& s : splats_) {
      if (!camera.vignetting.IsNone()) {
        gains = camera.PixelGains(static_cast<int>(s.pixel % camera.width),
                                  static_cast<int>(s.pixel / camera.width));
      }
      for (ParameterDerivative& e : std::span(entries_).subspan(s.first, s.count)) {
        for (Rgba& d : e.d) {
          d = Rgba(d.Color() * gains, d.a);
        }
      }
    }
  }
  /// Feeds the sink with what pixels in [first, end) gain.
  void Feed(std::int64_t first, std::int64_t end, DerivativeSink& sink) const {
    for (const Entry& s : splats_) {
      if (s.pixel >= first && s.pixel < end) {
        sink.Add(s.pixel, std::span(entries_).subspan(s.first, s.count));
      }
    }
  }
  struct Mark {
    std::size_t splats = 0, entries = 0;
  };
  [[nodiscard]] Mark Position() const { return {splats_.size(), entries_.size()}; }
  /// Forgets what was added after `mark`.
  void Rewind(const Mark& mark) {
    splats_.resize(mark.splats);
    entries_.resize(mark.entries);
  }
  /// Sum of the absolute values added after `mark`: what guides learn. Not finite if one is not.
  [[nodiscard]] double MagnitudeSince(const Mark& mark) const {
    return MagnitudeOf(mark.entries, entries_.size());
  }

  RenderStats stats;

 private:
  [[nodiscard]] double MagnitudeOf(std::size_t first, std::size_t end) const {
    double sum = 0.0;
    for (std::size_t i = first; i < end; ++i) {
      for (const Rgba& d : entries_[i].d) {
        sum += std::abs(d.r) + std::abs(d.g) + std::abs(d.b);
      }
    }
    return sum;
  }

  struct Entry {
    std::int64_t pixel;
    std::size_t first, count;  // into entries_
  };
  std::vector<Entry> splats_;
  std::vector<ParameterDerivative> entries_;
};

}  // namespace pathfit::renderer
