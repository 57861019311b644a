#include "app/output/signed_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace pathfit::app {
namespace {

constexpr int kGlyphWidth = 3;
constexpr int kGlyphHeight = 5;
constexpr int kAdvance = kGlyphWidth + 1;
constexpr int kMargin = 2;
constexpr int kBarHeight = 3;
constexpr std::string_view kCharacters = "0123456789.e+-";
// Five rows of three bits each, the top row in the highest bits.
constexpr std::array<std::uint16_t, kCharacters.size()> kGlyphs = {0b111'101'101'101'111,
                                                                   0b010'110'010'010'111,
                                                                   0b111'001'111'100'111,
                                                                   0b111'001'111'001'111,
                                                                   0b101'101'111'001'001,
                                                                   0b111'100'111'001'111,
                                                                   0b111'100'111'101'111,
                                                                   0b111'001'001'010'010,
                                                                   0b111'101'111'101'111,
                                                                   0b111'101'111'001'111,
                                                                   0b000'000'000'000'010,
                                                                   0b000'111'111'100'111,
                                                                   0b000'010'111'010'000,
                                                                   0b000'000'111'000'000};

void Fill(renderer::Image& image, int x, int y, int width, int height, std::array<float, 3> color) {
  for (int j = std::max(0, y); j < std::min(image.height, y + height); ++j) {
    for (int i = std::max(0, x); i < std::min(image.width, x + width); ++i) {
      std::ranges::copy(color,
                        image.data.begin() + static_cast<std::ptrdiff_t>(image.Offset(i, j)));
    }
  }
}

/// Black text with its upper left corner at (x, y), each dot `size` pixels wide.
void Draw(renderer::Image& image, const std::string& text, int x, int y, int size) {
  for (const char c : text) {
    const std::size_t k = kCharacters.find(c);
    for (int bit = 0; k != std::string_view::npos && bit < kGlyphWidth * kGlyphHeight; ++bit) {
      if (((kGlyphs[k] >> (kGlyphWidth * kGlyphHeight - 1 - bit)) & 1) != 0) {
        Fill(image, x + bit % kGlyphWidth * size, y + bit / kGlyphWidth * size, size, size, {});
      }
    }
    x += kAdvance * size;
  }
}

/// -1 blue, 0 white, 1 red.
std::array<float, 3> SignedColor(double value) {
  const auto fade = static_cast<float>(1.0 - std::min(1.0, std::abs(value)));
  return {value < 0.0 ? fade : 1.0F, fade, value > 0.0 ? fade : 1.0F};
}

/// The image on a wider or equal canvas with its key below: the colours from -scale to +scale and
/// the numbers.
renderer::Image WithScaleBar(const renderer::Image& image, double scale) {
  const std::string high = fmt::format("+{:.2g}", scale);
  const std::string low = fmt::format("-{:.2g}", scale);
  const int size = std::max(1, image.width / 160);
  const int text_width = kAdvance * size * static_cast<int>(high.size());
  const int width = std::max(image.width, 2 * text_width + 3 * kMargin * size);
  const int bar_top = image.height + kMargin * size;
  const int text_top = bar_top + (kBarHeight + 1) * size;
  renderer::Image out(width, text_top + (kGlyphHeight + kMargin) * size, 3);
  Fill(out, 0, 0, out.width, out.height, {1.0F, 1.0F, 1.0F});
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        out.data[out.Offset(x, y) + static_cast<std::size_t>(c)] = image.At(x, y, c);
      }
    }
  }
  for (int x = 0; x < width; ++x) {
    Fill(out, x, bar_top, 1, kBarHeight * size, SignedColor((2.0 * x + 1.0) / width - 1.0));
  }
  Draw(out, low, kMargin * size, text_top, size);
  Draw(out, high, width - text_width - (kMargin - 1) * size, text_top, size);
  return out;
}

}  // namespace

double SignedScale(const renderer::Film& film) {
  std::vector<double> values;
  for (const renderer::Rgba& p : film.pixels) {
    values.push_back(std::abs(renderer::Luminance(p.Color())));
  }
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  const double percentile =
      values[static_cast<std::size_t>(0.995 * static_cast<double>(values.size() - 1))];
  return percentile > 0.0 ? percentile : values.back();
}

renderer::Image SignedImage(const renderer::Film& film, double scale) {
  renderer::Image image(film.width, film.height, 3);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const double value = scale > 0.0 ? renderer::Luminance(film.pixels[i].Color()) / scale : 0.0;
    const std::array<float, 3> color = SignedColor(value);
    std::ranges::copy(color, image.data.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  return WithScaleBar(image, scale);
}

}  // namespace pathfit::app
