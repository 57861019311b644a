#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/derivative/derivative_sink.h"

namespace pathfit::optim {

/// Derivative of a pixel by one parameter block: d[component * 4 + channel], channels r, g, b,
/// coverage.
struct PixelDerivative {
  std::int32_t block = -1;
  std::array<float, 12> d{};
};

/// Collects the derivatives of one view as sparse rows, one list per pixel, blocks ascending and
/// merged. Pixels of different lines may be added from different threads at once. Sums are in the
/// order of the calls for a pixel, so the result does not depend on threads.
class JacobianSink : public renderer::DerivativeSink {
 public:
  JacobianSink(int width, int height);

  void Add(std::int64_t pixel, std::span<const renderer::ParameterDerivative> derivatives) override;
  /// Adds all that another sink of the same size has collected, which is empty then.
  void Take(JacobianSink&& other);
  /// Merges what is still unmerged; call once after rendering.
  void Finish();

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Of what is merged.
  [[nodiscard]] std::span<const PixelDerivative> Pixel(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(width_);
    const Line& line = lines_[pixel / width];
    if (line.firsts.empty()) return {};
    const std::size_t x = pixel % width;
    return std::span(line.entries).subspan(line.firsts[x], line.firsts[x + 1] - line.firsts[x]);
  }
  [[nodiscard]] std::size_t MemoryBytes() const;

 private:
  /// Entries of one pixel, one after another.
  struct Piece {
    std::uint32_t x, first, count;
  };
  struct Line {
    std::vector<PixelDerivative> entries;
    std::vector<std::uint32_t> firsts;  ///< of the merged entries, by pixel, and their end
    std::vector<Piece> pieces;          ///< what came since, in the order of calls
  };
  void Merge(Line& line) const;

  int width_, height_;
  std::vector<Line> lines_;
};

/// The same by terms of the derivative.
class TermSink : public renderer::DerivativeSink {
 public:
  TermSink(int width, int height);

  void BeginTerm(renderer::DerivativeTerm term, std::int64_t num_samples) override;
  void Add(std::int64_t pixel, std::span<const renderer::ParameterDerivative> derivatives) override;
  void Finish();
  /// Adds all terms to `sink`, which is finished then; the parts are empty.
  void MoveTo(JacobianSink& sink);

  [[nodiscard]] std::size_t MemoryBytes() const;

  struct Part {
    Part(int width, int height, std::int64_t samples) : sink(width, height), num_samples(samples) {}
    JacobianSink sink;
    std::int64_t num_samples;
  };
  /// By DerivativeTerm; empty where nothing was drawn.
  [[nodiscard]] const std::array<std::optional<Part>, renderer::kNumDerivativeTerms>& parts()
      const {
    return parts_;
  }

 private:
  int width_, height_;
  std::array<std::optional<Part>, renderer::kNumDerivativeTerms> parts_;
  std::size_t current_ = 0;
};

}  // namespace pathfit::optim
