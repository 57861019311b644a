#include "renderer/io/hdr_file.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/io/image_check.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::renderer {
namespace {

/// Whether pixels of an HDR file hold runs as before 1991: a pixel (1, 1, 1, n) that repeats the
/// one before. Read otherwise they are colours. Rows of new runs come first, which begin with
/// (2, 2, below 128); from the first row without on pixels are plain.
bool HasOldRuns(std::string_view bytes, std::int64_t width, std::int64_t height) {
  const auto byte = [bytes](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  std::size_t at = 0;
  for (; height > 0 && width >= 8 && width <= 0x7fff; --height) {
    if (bytes.size() < at + 4 || byte(at) != 2 || byte(at + 1) != 2 || byte(at + 2) >= 128) break;
    at += 4;
    for (std::int64_t left = 4 * width; left > 0;) {
      if (at >= bytes.size()) return false;  // cut off
      const int count = byte(at);
      left -= count > 128 ? count - 128 : count;
      at += count > 128 ? 2 : 1 + static_cast<std::size_t>(count);
    }
  }
  for (std::int64_t left = width * height; left > 0 && at + 4 <= bytes.size(); --left, at += 4) {
    if (bytes.substr(at, 3) == "\1\1\1") return true;
  }
  return false;
}

}  // namespace

namespace {

struct HdrHeader {
  std::int64_t width = 0, height = 0;
  double exposure = 1.0;
  std::string_view pixels;  ///< what follows
};

HdrHeader ReadHeader(std::string_view bytes, const std::string& name) {
  const auto require = [&name](bool condition, const char* what) {
    if (!condition) throw IoError(name + ": not a readable HDR file: " + what);
  };
  // Readers of other programs cut longer lines in two, and take a zero byte for an empty line.
  const auto check_line = [&require](std::string_view text) {
    require(text.size() < 127, "a line of the header is longer than 126 bytes");
    require(!text.starts_with('\0'), "a line of the header begins with a zero byte");
  };
  LineReader lines(bytes);
  std::string_view line;
  double exposure = 1.0;
  bool has_format = false;
  for (bool has_line = lines.Next(line); !line.empty(); has_line = lines.Next(line)) {
    require(has_line, "the header has no end");
    check_line(line);
    has_format = has_format || line == "FORMAT=32-bit_rle_rgbe";
    if (!line.starts_with("EXPOSURE=")) continue;
    line.remove_prefix(9);
    const std::optional<double> factor = ParseReal(NextToken(line));
    require(factor && *factor > 0.0, "EXPOSURE must be positive");
    exposure *= *factor;
  }
  require(has_format, "the header has no line FORMAT=32-bit_rle_rgbe");
  require(lines.Next(line), "the size is missing");
  check_line(line);
  require(bytes.substr(0, bytes.size() - lines.Rest().size()).find('\r') == std::string_view::npos,
          "lines of the header end with a carriage return");
  const std::string_view rows = NextToken(line);
  const std::optional<std::int64_t> height = ParseInteger(NextToken(line));
  const std::string_view columns = NextToken(line);
  const std::optional<std::int64_t> width = ParseInteger(NextToken(line));
  require(
      rows == "-Y" && columns == "+X" && height && width,
      "the size must look like '-Y 512 +X 1024'; images stored turned or mirrored are not read");
  CheckClaimedSize(*width, *height, ImageKind::kHdr, bytes.size(), name);
  require(!HasOldRuns(lines.Rest(), *width, *height),
          "its pixels are run-length coded as before 1991; write it anew");
  return {*width, *height, exposure, lines.Rest()};
}

/// Bytes of the pixels, four each, as they come.
class PixelBytes {
 public:
  PixelBytes(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  /// A row, `Of(pixel, channel)` of which is then known: of runs while rows have them, else plain.
  void ReadRow(std::int64_t width) {
    row_.resize(4 * static_cast<std::size_t>(width));
    has_runs_ = has_runs_ && width >= 8 && width <= 0x7fff && bytes_.size() >= 4 &&
                bytes_.starts_with("\2\2") && Byte(2) < 128;
    if (!has_runs_) {
      Require(bytes_.size() >= row_.size(), "it is cut off");
      for (std::size_t i = 0; i < row_.size(); ++i) row_[i] = Byte(i);
      bytes_.remove_prefix(row_.size());
      return;
    }
    Require(Byte(2) << 8 | Byte(3), width);
    bytes_.remove_prefix(4);
    for (std::size_t channel = 0; channel < 4; ++channel) {
      for (std::int64_t x = 0; x < width;) {
        Require(bytes_.size() >= 2, "it is cut off");
        const bool is_run = Byte(0) > 128;
        const int count = is_run ? Byte(0) - 128 : Byte(0);
        const std::size_t taken = is_run ? 2 : 1 + static_cast<std::size_t>(count);
        Require(count > 0 && count <= width - x, "a run does not fit into its row");
        Require(bytes_.size() >= taken, "it is cut off");
        for (int i = 0; i < count; ++i, ++x) {
          row_[4 * static_cast<std::size_t>(x) + channel] =
              Byte(is_run ? 1 : 1 + static_cast<std::size_t>(i));
        }
        bytes_.remove_prefix(taken);
      }
    }
  }
  [[nodiscard]] const int* Pixel(int x) const { return &row_[4 * static_cast<std::size_t>(x)]; }

 private:
  [[nodiscard]] int Byte(std::size_t i) const { return static_cast<unsigned char>(bytes_[i]); }
  void Require(bool condition, const char* what) const {
    if (!condition) throw IoError(name_ + ": not a readable HDR file: " + what);
  }
  void Require(int stated, std::int64_t width) const {
    Require(stated == width, "a row has another width than the picture");
  }

  std::string_view bytes_;
  std::string name_;
  std::vector<int> row_;
  bool has_runs_ = true;
};

}  // namespace

Image ReadHdr(std::string_view bytes, const std::string& name) {
  const HdrHeader header = ReadHeader(bytes, name);
  Image image(static_cast<int>(header.width), static_cast<int>(header.height), 3);
  PixelBytes pixels(header.pixels, name);
  for (int y = 0; y < image.height; ++y) {
    pixels.ReadRow(header.width);
    for (int x = 0; x < image.width; ++x) {
      const int* pixel = pixels.Pixel(x);
      const double step = pixel[3] == 0 ? 0.0 : std::ldexp(1.0, pixel[3] - (128 + 8));
      for (int c = 0; c < 3; ++c) {
        image.At(x, y, c) = static_cast<float>(step * pixel[c] / header.exposure);
      }
    }
  }
  return image;
}

}  // namespace pathfit::renderer
