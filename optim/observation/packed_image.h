#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "renderer/image/image.h"

namespace pathfit::optim {

/// An image in few bytes, exactly: images from files of 8 or 16 bits and half floats have few
/// distinct numbers, and are kept as places in a table of them. Copies share their memory.
class PackedImage {
 public:
  PackedImage() = default;
  PackedImage(const renderer::Image& image);  // NOLINT(google-explicit-constructor): the same value

  /// An image of this size, not empty, that `read` gives when it is first needed; then it is kept.
  /// Throws what `read` throws, and renderer::IoError if that is of another size.
  static PackedImage Later(int width, int height, int channels, std::function<PackedImage()> read);

  [[nodiscard]] renderer::Image Unpack() const;
  [[nodiscard]] bool Empty() const { return pixels_ == nullptr && reading_ == nullptr; }
  /// False until an image that is read later was needed.
  [[nodiscard]] bool IsRead() const;
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int channels() const { return channels_; }
  [[nodiscard]] bool SharesPixels(const PackedImage& other) const {
    return pixels_ == other.pixels_ && reading_ == other.reading_;
  }
  /// Of what is read.
  [[nodiscard]] std::size_t MemoryBytes() const;

 private:
  /// All numbers are table[i] of one of the lists of places; with neither, all are table[0], or
  /// the table is the image.
  struct Pixels {
    std::vector<float> table;
    std::vector<std::uint8_t> narrow;
    std::vector<std::uint16_t> wide;
  };

  struct Reading {
    std::function<PackedImage()> read;
    std::once_flag once;
    std::shared_ptr<const Pixels> pixels;
  };
  [[nodiscard]] const std::shared_ptr<const Pixels>& Read() const;

  int width_ = 0, height_ = 0, channels_ = 0;
  std::shared_ptr<const Pixels> pixels_;  ///< null of those that are read later
  std::shared_ptr<Reading> reading_;
};

}  // namespace pathfit::optim
