#include "optim/observation/packed_image.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>
#include <utility>

#include "renderer/core/error.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

constexpr std::size_t kMaxDistinct = 1 << 16;
constexpr std::size_t kSlots = 4 * kMaxDistinct;

/// Places of numbers in the table of all that differ in a bit; found by their bits.
class Table {
 public:
  Table() : places_(kSlots, kNone) {}

  /// Of a new number its place is the next one. Beyond the largest table there is none.
  std::uint32_t Add(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    std::size_t slot = (bits * 2654435761U) >> 14U;
    for (; places_[slot] != kNone; slot = (slot + 1) % kSlots) {
      if (std::bit_cast<std::uint32_t>(numbers[places_[slot]]) == bits) {
        return places_[slot];
      }
    }
    if (numbers.size() == kMaxDistinct) {
      return kNone;
    }
    places_[slot] = static_cast<std::uint32_t>(numbers.size());
    numbers.push_back(value);
    return places_[slot];
  }

  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<float> numbers;

 private:
  std::vector<std::uint32_t> places_;
};

template <class Place>
void LookUp(const std::vector<float>& table,
            const std::vector<Place>& places,
            std::span<float> out) {
  constexpr std::size_t kPieces = 16;  // that are looked up at once
  renderer::ParallelFor(kPieces, [&](std::int64_t piece) {
    const auto i = static_cast<std::size_t>(piece);
    const std::size_t end = (i + 1) * places.size() / kPieces;
    for (std::size_t k = i * places.size() / kPieces; k < end; ++k) out[k] = table[places[k]];
  });
}

}  // namespace

PackedImage::PackedImage(const renderer::Image& image)
    : width_(image.width), height_(image.height), channels_(image.channels) {
  if (image.Empty()) {
    return;
  }
  Pixels pixels;
  Table table;
  std::vector<std::uint16_t> places(image.data.size());
  bool fits = true;
  for (std::size_t i = 0; fits && i < places.size(); ++i) {
    const std::uint32_t place = table.Add(image.data[i]);
    fits = place != Table::kNone;
    places[i] = static_cast<std::uint16_t>(place);
  }
  if (fits && table.numbers.size() <= 256) {
    pixels.table = table.numbers;
    if (table.numbers.size() > 1) {
      pixels.narrow.assign(places.begin(), places.end());
    }
  } else if (fits && 2 * places.size() + 4 * table.numbers.size() < 4 * places.size()) {
    pixels.table = table.numbers;
    pixels.wide = std::move(places);
  } else {
    pixels.table = image.data;
  }
  pixels.table.shrink_to_fit();
  pixels_ = std::make_shared<const Pixels>(std::move(pixels));
}

PackedImage PackedImage::Later(int width,
                               int height,
                               int channels,
                               std::function<PackedImage()> read) {
  PackedImage image;
  image.width_ = width;
  image.height_ = height;
  image.channels_ = channels;
  image.reading_ = std::make_shared<Reading>();
  image.reading_->read = std::move(read);
  return image;
}

const std::shared_ptr<const PackedImage::Pixels>& PackedImage::Read() const {
  if (reading_ == nullptr) return pixels_;
  std::call_once(reading_->once, [this] {
    const PackedImage image = reading_->read();
    if (image.Empty() || image.width_ != width_ || image.height_ != height_ ||
        image.channels_ != channels_) {
      throw renderer::IoError("an image has changed since its size was read");
    }
    reading_->pixels = image.Read();
    reading_->read = nullptr;
  });
  return reading_->pixels;
}

bool PackedImage::IsRead() const { return reading_ == nullptr || reading_->pixels != nullptr; }

renderer::Image PackedImage::Unpack() const {
  renderer::Image image(width_, height_, channels_);
  if (Empty()) {
    return image;
  }
  const Pixels& pixels = *Read();
  if (!pixels.narrow.empty()) {
    LookUp(pixels.table, pixels.narrow, image.data);
  } else if (!pixels.wide.empty()) {
    LookUp(pixels.table, pixels.wide, image.data);
  } else if (pixels.table.size() == image.data.size()) {
    image.data = pixels.table;
  } else {
    std::ranges::fill(image.data, pixels.table.front());
  }
  return image;
}

std::size_t PackedImage::MemoryBytes() const {
  if (Empty() || !IsRead()) return 0;
  const Pixels& pixels = *Read();
  return 4 * pixels.table.size() + pixels.narrow.size() + 2 * pixels.wide.size();
}

}  // namespace pathfit::optim
