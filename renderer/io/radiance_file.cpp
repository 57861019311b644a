#include "renderer/io/radiance_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_check.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::renderer {
namespace {

/// Scan lines outside these widths are never run-length coded.
constexpr std::int64_t kMinCodedWidth = 8;
constexpr std::int64_t kMaxCodedWidth = 32767;
constexpr int kExponentBias = 128 + 8;

using Rgbe = std::array<unsigned char, 4>;

/// Scan lines run along the second axis of the resolution line; a flipped axis has the other sign
/// than in "-Y h +X w".
struct Layout {
  int width = 0;
  int height = 0;
  bool is_column_major = false;
  bool flip_x = false;
  bool flip_y = false;
};

class HdrDecoder {
 public:
  HdrDecoder(std::string_view bytes, const std::filesystem::path& name)
      : name_(name), lines_(bytes) {}

  Image Decode() {
    ParseHeader();
    const Layout layout = ParseResolution();
    data_ = lines_.Rest();
    const int length = layout.is_column_major ? layout.height : layout.width;
    const int count = layout.is_column_major ? layout.width : layout.height;
    // A coded scan line takes at least its 4-byte mark and 2 bytes for 127 values of each
    // component.
    const std::int64_t min_bytes = 4 + 4 * 2 * ((std::int64_t{length} + 126) / 127);
    const std::int64_t line_bytes = std::min<std::int64_t>(min_bytes, 4 * std::int64_t{length});
    if (count > static_cast<std::int64_t>(data_.size()) / line_bytes)
      Fail("the file ends too early");
    Image image(layout.width, layout.height, 3);
    std::vector<Rgbe> scan_line(static_cast<std::size_t>(length));
    for (int i = 0; i < count; ++i) {
      ReadScanLine(scan_line);
      for (int k = 0; k < length; ++k) {
        int x = layout.is_column_major ? i : k;
        int y = layout.is_column_major ? k : i;
        if (layout.flip_x) x = layout.width - 1 - x;
        if (layout.flip_y) y = layout.height - 1 - y;
        StorePixel(scan_line[static_cast<std::size_t>(k)], x, y, image);
      }
    }
    return image;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw IoError(name_.string() + ": not a readable HDR file: " + what);
  }

  void ParseHeader() {
    std::string_view line;
    if (!lines_.Next(line) || !line.starts_with("#?")) Fail("it must begin with '#?RADIANCE'");
    while (lines_.Next(line)) {
      if (line.empty()) return;
      if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe") {
        Fail("the only known format is 32-bit_rle_rgbe");
      }
      if (!line.starts_with("EXPOSURE=")) continue;
      line.remove_prefix(9);
      const std::optional<double> exposure = ParseReal(NextToken(line));
      if (!exposure || *exposure <= 0.0) Fail("EXPOSURE must be positive");
      exposure_ *= *exposure;
    }
    Fail("the header has no end");
  }

  /// "-Y height +X width" and its seven turned forms.
  Layout ParseResolution() {
    std::string_view line;
    if (!lines_.Next(line)) Fail("the size is missing");
    Layout layout;
    std::array<std::string_view, 2> axes;
    std::array<std::int64_t, 2> sizes = {0, 0};
    for (std::size_t i = 0; i < 2; ++i) {
      axes[i] = NextToken(line);
      const std::optional<std::int64_t> size = ParseInteger(NextToken(line));
      if (!size) Fail("the size must look like '-Y 512 +X 1024'");
      sizes[i] = *size;
    }
    const auto is_axis = [](std::string_view token, char letter) {
      return token.size() == 2 && (token[0] == '+' || token[0] == '-') && token[1] == letter;
    };
    layout.is_column_major = is_axis(axes[0], 'X');
    const std::size_t x = layout.is_column_major ? 0 : 1;
    if (!is_axis(axes[x], 'X') || !is_axis(axes[1 - x], 'Y')) {
      Fail("the size must look like '-Y 512 +X 1024'");
    }
    CheckImageSize(sizes[x], sizes[1 - x], name_.string());
    layout.width = static_cast<int>(sizes[x]);
    layout.height = static_cast<int>(sizes[1 - x]);
    layout.flip_x = axes[x][0] == '-';
    layout.flip_y = axes[1 - x][0] == '+';
    return layout;
  }

  unsigned char NextByte() {
    if (data_.empty()) Fail("the file ends too early");
    const auto byte = static_cast<unsigned char>(data_.front());
    data_.remove_prefix(1);
    return byte;
  }

  void ReadScanLine(std::vector<Rgbe>& scan_line) {
    const auto length = static_cast<std::int64_t>(scan_line.size());
    const auto byte = [this](std::size_t i) { return static_cast<unsigned char>(data_[i]); };
    const bool is_coded = length >= kMinCodedWidth && length <= kMaxCodedWidth &&
                          data_.size() >= 4 && byte(0) == 2 && byte(1) == 2 && byte(2) < 128;
    if (!is_coded) {
      ReadFlatScanLine(scan_line);
      return;
    }
    if ((byte(2) << 8 | byte(3)) != length) Fail("a scan line has another length than the image");
    data_.remove_prefix(4);
    for (std::size_t component = 0; component < 4; ++component) {
      for (std::size_t x = 0; x < scan_line.size();) {
        const unsigned char code = NextByte();
        const bool is_run = code > 128;
        const std::size_t count = is_run ? code - 128U : code;
        if (count == 0 || count > scan_line.size() - x) Fail("a run does not fit its scan line");
        unsigned char value = is_run ? NextByte() : static_cast<unsigned char>(0);
        for (std::size_t k = 0; k < count; ++k) {
          if (!is_run) value = NextByte();
          scan_line[x++][component] = value;
        }
      }
    }
  }

  void ReadFlatScanLine(std::vector<Rgbe>& scan_line) {
    for (Rgbe& pixel : scan_line) {
      pixel = {NextByte(), NextByte(), NextByte(), NextByte()};
      if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
        Fail("the run-length coding from before 1991 is not supported");
      }
    }
  }

  void StorePixel(const Rgbe& pixel, int x, int y, Image& image) const {
    if (pixel[3] == 0) return;
    const double scale = std::ldexp(1.0, pixel[3] - kExponentBias) / exposure_;
    for (int c = 0; c < 3; ++c) {
      const auto value = static_cast<float>(pixel[static_cast<std::size_t>(c)] * scale);
      if (!std::isfinite(value)) Fail("a pixel is too large");
      image.At(x, y, c) = value;
    }
  }

  const std::filesystem::path& name_;
  LineReader lines_;
  std::string_view data_;
  double exposure_ = 1.0;
};

Rgbe EncodePixel(const Rgb& color, const std::filesystem::path& path) {
  if (std::min({color.r, color.g, color.b}) < 0.0) {
    throw IoError(path.string() + ": an HDR file cannot hold negative values");
  }
  if (IsBlack(color)) return {0, 0, 0, 0};
  int exponent = 0;
  const double mantissa = std::frexp(MaxChannel(color), &exponent);
  // Rounding to the nearest could carry the largest component to 256.
  if (mantissa * 256.0 >= 255.5) ++exponent;
  if (exponent + 128 <= 0) return {0, 0, 0, 0};
  if (exponent + 128 > 255) throw IoError(path.string() + ": a value is too large for an HDR file");
  Rgbe pixel = {0, 0, 0, static_cast<unsigned char>(exponent + 128)};
  for (int c = 0; c < 3; ++c) {
    pixel[static_cast<std::size_t>(c)] =
        static_cast<unsigned char>(std::lround(std::ldexp(color[c], 8 - exponent)));
  }
  return pixel;
}

/// Runs of 4 and more equal bytes, literals otherwise.
void AppendCoded(const std::vector<unsigned char>& values, std::string& bytes) {
  constexpr std::size_t kMinRun = 4;
  const auto run_length = [&values](std::size_t begin) {
    std::size_t end = begin + 1;
    while (end < values.size() && end - begin < 127 && values[end] == values[begin]) ++end;
    return end - begin;
  };
  for (std::size_t x = 0; x < values.size();) {
    const std::size_t run = run_length(x);
    if (run >= kMinRun) {
      bytes.push_back(static_cast<char>(static_cast<unsigned char>(128 + run)));
      bytes.push_back(static_cast<char>(values[x]));
      x += run;
      continue;
    }
    std::size_t end = x + run;
    while (end < values.size() && end - x < 128 && run_length(end) < kMinRun) ++end;
    bytes.push_back(static_cast<char>(static_cast<unsigned char>(end - x)));
    for (; x < end; ++x) bytes.push_back(static_cast<char>(values[x]));
  }
}

}  // namespace

Image DecodeHdr(std::string_view bytes, const std::filesystem::path& name) {
  return HdrDecoder(bytes, name).Decode();
}

void WriteHdr(const std::filesystem::path& path, const Image& image) {
  CheckWritable(image, {3}, path);
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(image.height) +
                      " +X " + std::to_string(image.width) + "\n";
  const bool is_coded = image.width >= kMinCodedWidth && image.width <= kMaxCodedWidth;
  std::array<std::vector<unsigned char>, 4> components;
  for (int y = 0; y < image.height; ++y) {
    for (auto& component : components) component.clear();
    for (int x = 0; x < image.width; ++x) {
      const Rgbe pixel = EncodePixel(image.ColorAt(x, y), path);
      for (std::size_t c = 0; c < 4; ++c) {
        components[c].push_back(pixel[c]);
        if (!is_coded) bytes.push_back(static_cast<char>(pixel[c]));
      }
    }
    if (!is_coded) continue;
    bytes.append({2, 2, static_cast<char>(image.width >> 8), static_cast<char>(image.width & 255)});
    for (const auto& component : components) AppendCoded(component, bytes);
  }
  WriteFileAtomically(path, bytes);
}

}  // namespace pathfit::renderer
