#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/image/image.h"

namespace pathfit::optim {

/// An image in few bytes, exactly: images from files of 8 or 16 bits and half floats have few
/// distinct numbers, and are kept as places in a table of them. Copies share their memory.
class PackedImage {
 public:
  PackedImage() = default;
  PackedImage(const renderer::Image& image);  // NOLINT(google-explicit-constructor): the same value

  [[nodiscard]] renderer::Image Unpack() const;
  [[nodiscard]] bool Empty() const { return pixels_ == nullptr; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool SharesPixels(const PackedImage& other) const {
    return pixels_ == other.pixels_;
  }
  [[nodiscard]] std::size_t MemoryBytes() const;

 private:
  /// All numbers are table[i] of one of the lists of places; with neither, all are table[0], or
  /// the table is the image.
  struct Pixels {
    std::vector<float> table;
    std::vector<std::uint8_t> narrow;
    std::vector<std::uint16_t> wide;
  };

  int width_ = 0, height_ = 0, channels_ = 0;
  std::shared_ptr<const Pixels> pixels_;
};

}  // namespace pathfit::optim
