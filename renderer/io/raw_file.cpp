#include "renderer/io/raw_file.h"

#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"

#if PATHFIT_RAW
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include <libraw/libraw.h>

#include "renderer/io/atomic_file.h"
#include "renderer/io/image_check.h"
#include "renderer/io/image_file.h"
#endif

namespace pathfit::renderer {

const std::set<std::string>& RawExtensions() {
  static const std::set<std::string> kExtensions = {
      ".3fr", ".arw", ".cr2", ".cr3", ".crw", ".dcr", ".dng", ".erf", ".fff",
      ".iiq", ".kdc", ".mef", ".mos", ".mrw", ".nef", ".nrw", ".orf", ".pef",
      ".raf", ".raw", ".rw2", ".rwl", ".sr2", ".srf", ".srw", ".x3f"};
  return kExtensions;
}

bool HasRawExtension(const std::filesystem::path& path) {
  return RawExtensions().contains(LowerCase(path.extension().string()));
}

#if PATHFIT_RAW
namespace {

constexpr double kFull = 65535.0;  // of the library's numbers
// Bytes behind the end of a whole file that a decoder may ask for.
constexpr std::uint64_t kReadAhead = 1024;
// Values pile up where the sensor is full, and cameras often fill up below what their files or the
// library's tables say. A pile is within this share of the range below the brightest value, has so
// many pixels, and so many times those of the share below it.
constexpr double kPileWidth = 0.02;
constexpr std::int64_t kLeastPile = 32;
constexpr std::int64_t kPileFactor = 4;
// Of the range, that a pile must be above.
constexpr double kLeastFull = 0.75;
// Rows of a Bayer filter are told by bits; this word stands for a pattern of 6 x 6.
constexpr unsigned kXTrans = 9;
constexpr unsigned kLeastBayer = 1000;

/// What the library says with a code; 0 is success.
void Require(int code, const std::string& name) {
  if (code == LIBRAW_SUCCESS) return;
  // It reads from memory, so that reading fails where the file ends.
  throw IoError(name + ": cannot be read as a RAW photo: " +
                (code == LIBRAW_IO_ERROR ? "it is cut off" : LibRaw::strerror(code)));
}

/// A file in memory that counts what is read behind its end: not every decoder of the library
/// notices.
class CountingStream : public LibRaw_buffer_datastream {
 public:
  explicit CountingStream(std::string& bytes)
      : LibRaw_buffer_datastream(bytes.data(), bytes.size()) {}

  int read(void* to, std::size_t size, std::size_t count) override {
    Count(static_cast<std::uint64_t>(size) * count);
    return LibRaw_buffer_datastream::read(to, size, count);
  }
  int get_char() override {
    Count(1);
    return LibRaw_buffer_datastream::get_char();
  }

  void ForgetMissing() { missing_ = 0; }
  /// Bytes; beyond kReadAhead only that there are more.
  [[nodiscard]] std::uint64_t missing() const { return missing_; }

 private:
  /// No more than matters, so that no sum overflows.
  void Count(std::uint64_t wanted) {
    const auto left = static_cast<std::uint64_t>(std::max<std::int64_t>(0, size() - tell()));
    if (wanted <= left || missing_ > kReadAhead) return;
    missing_ += std::min(wanted - left, kReadAhead + 1);
  }
  std::uint64_t missing_ = 0;
};

/// Stored as the camera's flips and turns, which EXIF numbers otherwise.
int OrientationOf(int flip) {
  constexpr std::array<int, 8> kOrientations = {1, 2, 4, 3, 5, 8, 6, 7};
  return kOrientations[static_cast<std::size_t>(flip) & 7U];
}

/// The library, with one file in it.
class Developer {
 public:
  Developer(const std::filesystem::path& path, const RawOptions& options)
      : name_(path.string()),
        options_(options),
        bytes_(ReadWholeFile(path)),
        stream_(bytes_),
        raw_(std::make_unique<LibRaw>()) {
    raw_->set_dataerror_handler(nullptr, nullptr);  // it would print; error_count() says it, too
    SetParameters();
  }

  RawPhoto Run() {
    Require(raw_->open_datastream(&stream_), name_);
    const auto& sizes = raw_->imgdata.sizes;
    CheckImageSize(sizes.raw_width, sizes.raw_height, name_);
    stream_.ForgetMissing();
    Require(raw_->unpack(), name_);
    if (raw_->error_count() > 0 || stream_.missing() > kReadAhead) {
      throw IoError(name_ + ": the RAW photo is damaged or cut off");
    }
    RawPhoto photo;
    if (options_.clip_above < 1.0) {
      Require(raw_->raw2image(), name_);
      photo.clipped = Clipped();
    }
    const int width = sizes.width;
    const int height = sizes.height;
    Require(raw_->dcraw_process(), name_);
    if (sizes.iwidth != width || sizes.iheight != height) {
      throw IoError(name_ +
                    ": its pixels are turned by 45 degrees or not square; such sensors are not "
                    "read");
    }
    Describe(photo);
    photo.image = Developed();
    if (options_.apply_orientation && photo.exif_orientation != 1) {
      photo.image = ApplyOrientation(photo.image, photo.exif_orientation);
      if (!photo.clipped.Empty()) {
        photo.clipped = ApplyOrientation(photo.clipped, photo.exif_orientation);
      }
    }
    return photo;
  }

 private:
  /// Its image is taken before the library's curve and brightness, which hold for files alone.
  void SetParameters() {
    auto& parameters = raw_->imgdata.params;
    parameters.use_camera_wb = options_.white_balance == RawWhiteBalance::kCamera ? 1 : 0;
    if (options_.white_balance == RawWhiteBalance::kNone) {
      std::ranges::fill(parameters.user_mul, 1.0F);
    }
    parameters.output_color = 0;           // the camera's: the matrix is applied without clipping
    parameters.highlight = 1;              // no channel is cut where another is full
    parameters.adjust_maximum_thr = 0.0F;  // full is the same in all photos, whatever they show
  }

  /// The middle of what piles up at the bright end of a photo.
  static std::optional<double> PileOf(std::span<const std::uint16_t[4]> values, double maximum) {
    std::vector<std::int64_t> counts(std::size_t{1} << 16U);
    for (const auto& value : values) ++counts[std::ranges::max(value)];
    const auto count = [&](std::size_t first, std::size_t end) {
      return std::accumulate(counts.begin() + static_cast<std::ptrdiff_t>(first),
                             counts.begin() + static_cast<std::ptrdiff_t>(end),
                             std::int64_t{0});
    };
    std::size_t brightest = counts.size() - 1;
    while (brightest > 0 && counts[brightest] == 0) --brightest;
    const auto width = static_cast<std::size_t>(kPileWidth * maximum);
    if (brightest < 2 * width) return {};
    const std::size_t first = brightest - width;
    const std::int64_t piled = count(first, brightest + 1);
    if (piled < std::max(kLeastPile, kPileFactor * count(first - width, first))) return {};
    std::size_t middle = first;
    while (2 * count(first, middle + 1) < piled) ++middle;
    return static_cast<double>(middle);
  }

  /// Of the mosaic: what neighbours are made of it, too.
  [[nodiscard]] Image Clipped() const {
    const auto& sizes = raw_->imgdata.sizes;
    const auto& color = raw_->imgdata.color;
    const std::span values(raw_->imgdata.image,
                           static_cast<std::size_t>(sizes.iwidth) * sizes.iheight);
    const std::optional<double> pile = PileOf(values, static_cast<double>(color.maximum));
    std::array<double, 4> levels{};
    for (std::size_t c = 0; c < levels.size(); ++c) {
      const double black = static_cast<double>(color.black) + color.cblack[c];
      auto full = static_cast<double>(color.maximum);
      if (pile && *pile > black + kLeastFull * (full - black)) full = std::min(full, *pile);
      // Where the camera says that values are not proportional beyond; rarely too low to be true.
      const auto linear = static_cast<double>(color.linear_max[c]);
      if (linear > 0.5 * full) full = std::min(full, linear);
      levels[c] = black + options_.clip_above * (full - black);
    }
    const unsigned filters = raw_->imgdata.idata.filters;
    const int reach = filters >= kLeastBayer ? 1 : filters == kXTrans ? 2 : 0;
    Image clipped(sizes.iwidth, sizes.iheight, 1);
    bool any = false;
    for (int y = 0; y < clipped.height; ++y) {
      for (int x = 0; x < clipped.width; ++x) {
        const std::size_t row = static_cast<std::size_t>(y) * sizes.iwidth;
        const auto& value = values[row + static_cast<std::size_t>(x)];
        bool full = false;
        for (std::size_t c = 0; c < levels.size(); ++c) full = full || value[c] >= levels[c];
        if (!full) continue;
        any = true;
        for (int v = std::max(0, y - reach); v <= std::min(clipped.height - 1, y + reach); ++v) {
          for (int u = std::max(0, x - reach); u <= std::min(clipped.width - 1, x + reach); ++u) {
            clipped.At(u, v, 0) = 1.0F;
          }
        }
      }
    }
    return any ? clipped : Image();
  }

  void Describe(RawPhoto& photo) const {
    const auto& data = raw_->imgdata;
    photo.exif_orientation = OrientationOf(data.sizes.flip);
    const double green = static_cast<double>(data.color.pre_mul[1]);
    photo.multipliers = {static_cast<double>(data.color.pre_mul[0]) / green,
                         1.0,
                         static_cast<double>(data.color.pre_mul[2]) / green};
    photo.white_balance = options_.white_balance;
    if (photo.white_balance == RawWhiteBalance::kCamera &&
        (data.process_warnings & LIBRAW_WARN_BAD_CAMERA_WB) != 0) {
      photo.white_balance = RawWhiteBalance::kDaylight;
    }
    photo.has_color_matrix = data.idata.colors == 1 || !IsIdentity();
    photo.time_s = static_cast<double>(data.other.shutter);
    photo.f_number = static_cast<double>(data.other.aperture);
    photo.iso = static_cast<double>(data.other.iso_speed);
    photo.flash = (std::lround(data.color.flash_used) & 1) != 0;
  }

  [[nodiscard]] bool IsIdentity() const {
    const auto& matrix = raw_->imgdata.color.rgb_cam;
    for (int to = 0; to < 3; ++to) {
      for (int from = 0; from < raw_->imgdata.idata.colors; ++from) {
        if (matrix[to][from] != (to == from ? 1.0F : 0.0F)) return false;
      }
    }
    return true;
  }

  /// The camera's colours by its matrix, 1 where green is full.
  [[nodiscard]] Image Developed() const {
    const auto& data = raw_->imgdata;
    const int colors = data.idata.colors;
    const double scale = 1.0 / (kFull * static_cast<double>(data.color.pre_mul[1]));
    std::array<std::array<double, 4>, 3> matrix{};
    for (std::size_t to = 0; to < 3; ++to) {
      for (std::size_t from = 0; from < static_cast<std::size_t>(colors); ++from) {
        // Without colours every channel shows the one there is.
        matrix[to][from] =
            scale * (colors == 1 ? 1.0 : static_cast<double>(data.color.rgb_cam[to][from]));
      }
    }
    Image image(data.sizes.iwidth, data.sizes.iheight, 3);
    for (std::size_t i = 0; i < image.data.size() / 3; ++i) {
      const auto& values = data.image[i];
      for (std::size_t to = 0; to < 3; ++to) {
        double sum = 0.0;
        for (std::size_t from = 0; from < 4; ++from) sum += matrix[to][from] * values[from];
        image.data[3 * i + to] = static_cast<float>(std::max(0.0, sum));
      }
    }
    return image;
  }

  std::string name_;
  RawOptions options_;
  std::string bytes_;
  CountingStream stream_;
  std::unique_ptr<LibRaw> raw_;  // too large for the stack
};

}  // namespace

std::string LibRawVersion() { return LibRaw::version(); }

RawPhoto ReadRawFile(const std::filesystem::path& path, const RawOptions& options) {
  return Developer(path, options).Run();
}

#else

std::string LibRawVersion() { return {}; }

RawPhoto ReadRawFile(const std::filesystem::path& path, const RawOptions& /*options*/) {
  throw IoError(path.string() +
                ": is a RAW photo, and this build is without LibRaw; install it (Debian: apt "
                "install libraw-dev), configure and build again, or convert the photos to 16-bit "
                "TIFF or EXR");
}

#endif

}  // namespace pathfit::renderer
