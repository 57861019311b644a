#pragma once

#include <array>
#include <cstdint>
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

}  // namespace pathfit::optim
