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
/// merged. Different pixels may be added from different threads at once. Sums are in the order of
/// the calls for a pixel, so the result does not depend on threads.
class JacobianSink : public renderer::DerivativeSink {
 public:
  JacobianSink(int width, int height);

  void Add(std::int64_t pixel, std::span<const renderer::ParameterDerivative> derivatives) override;
  /// Adds all that another sink of the same size has collected.
  void Add(const JacobianSink& other);
  /// Merges what is still unmerged; call once after rendering.
  void Finish();

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::span<const PixelDerivative> Pixel(std::size_t pixel) const {
    return pixels_[pixel].entries;
  }
  [[nodiscard]] std::size_t MemoryBytes() const;

 private:
  struct PixelList {
    std::vector<PixelDerivative> entries;
    std::size_t num_merged = 0;  ///< the first entries are sorted and distinct
  };
  static void Merge(PixelList& list);

  int width_, height_;
  std::vector<PixelList> pixels_;
};

/// The same by terms of the derivative.
class TermSink : public renderer::DerivativeSink {
 public:
  TermSink(int width, int height);

  void BeginTerm(renderer::DerivativeTerm term, std::int64_t num_samples) override;
  void Add(std::int64_t pixel, std::span<const renderer::ParameterDerivative> derivatives) override;
  void Finish();

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
