#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <ranges>
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

/// Entries, of which only what is not zero is kept: a colour changes its own channel alone, a place
/// inside an outline no coverage.
class PackedDerivatives {
 public:
  /// Reads entries one after another.
  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = PixelDerivative;
    using difference_type = std::ptrdiff_t;
    using pointer = const PixelDerivative*;
    using reference = PixelDerivative;

    Iterator() = default;
    Iterator(const PackedDerivatives& packed, std::size_t entry, std::size_t value)
        : packed_(&packed), entry_(entry), value_(value) {}

    [[nodiscard]] std::int32_t block() const { return packed_->blocks_[entry_]; }
    PixelDerivative operator*() const {
      PixelDerivative entry{block(), {}};
      AddTo(entry);
      return entry;
    }
    /// Adds the derivatives to those of `entry`.
    void AddTo(PixelDerivative& entry) const;
    Iterator& operator++() {
      value_ += static_cast<std::size_t>(std::popcount(packed_->masks_[entry_]));
      ++entry_;
      return *this;
    }
    Iterator operator++(int) {
      const Iterator before = *this;
      ++*this;
      return before;
    }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.entry_ == b.entry_; }

   private:
    const PackedDerivatives* packed_ = nullptr;
    std::size_t entry_ = 0, value_ = 0;
  };

  void Add(const PixelDerivative& entry);
  void Append(const PackedDerivatives& other);
  void Shrink();

  [[nodiscard]] std::size_t NumEntries() const { return blocks_.size(); }
  [[nodiscard]] std::size_t NumValues() const { return values_.size(); }
  [[nodiscard]] std::size_t MemoryBytes() const;

 private:
  std::vector<std::int32_t> blocks_;
  std::vector<std::uint16_t> masks_;  ///< bit k: d[k] is among the values
  std::vector<float> values_;
};

/// Collects the derivatives of one view as sparse rows, one list per pixel, blocks ascending and
/// merged. Pixels of different lines may be added from different threads at once. Sums are in the
/// order of the calls for a pixel, so the result does not depend on threads.
class JacobianSink : public renderer::DerivativeSink {
 public:
  /// Of one pixel.
  using Entries = std::ranges::subrange<PackedDerivatives::Iterator,
                                        PackedDerivatives::Iterator,
                                        std::ranges::subrange_kind::sized>;

  JacobianSink(int width, int height);

  void Add(std::int64_t pixel, std::span<const renderer::ParameterDerivative> derivatives) override;
  /// Adds all that another sink of the same size has collected, which is empty then.
  void Take(JacobianSink&& other);
  /// Merges what is still unmerged; call once after rendering.
  void Finish();

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Of what is merged.
  [[nodiscard]] Entries Pixel(std::size_t pixel) const;
  [[nodiscard]] std::size_t MemoryBytes() const;

 private:
  /// A place among entries.
  struct Place {
    std::uint32_t entry = 0, value = 0;
  };
  /// Entries of one pixel, one after another.
  struct Piece {
    std::uint32_t x, count;
    Place first;
  };
  struct Line {
    PackedDerivatives entries;
    std::vector<Place> firsts;  ///< of the merged entries, by pixel, and their end
    std::vector<Piece> pieces;  ///< what came since, in the order of calls
  };
  static Place EndOf(const Line& line);
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
