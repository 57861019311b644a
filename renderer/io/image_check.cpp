#include "renderer/io/image_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>

#include <zlib.h>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

constexpr std::int64_t kMaxPixels = std::int64_t{1} << 28;

/// What a byte of a file can hold at most. PNG: deflate makes 1032 bytes of one, of 8 pixels each.
/// JPEG: a bit per block of 64 pixels, twice that for arithmetic coding. HDR: runs of 127 in 2
/// bytes for each of 4 channels. EXR and TIFF know codes that say a row in a bit.
std::int64_t MostPixelsPerByte(ImageKind kind) {
  switch (kind) {
    case ImageKind::kJpeg:
      return 1024;
    case ImageKind::kPng:
      return 8256;
    case ImageKind::kHdr:
      return 16;
    default:
      return 65536;
  }
}

// Signatures hold zero bytes, hence the lengths.
constexpr std::string_view kTiffLittleEndian("II*\0", 4);
constexpr std::string_view kTiffBigEndian("MM\0*", 4);
constexpr std::string_view kExif("Exif\0\0", 6);

constexpr std::uint16_t kTiffWidth = 0x0100;
constexpr std::uint16_t kTiffHeight = 0x0101;
constexpr std::uint16_t kTiffOrientation = 0x0112;
constexpr std::uint16_t kTiffProfile = 0x8773;
constexpr std::string_view kIccProfile("ICC_PROFILE\0", 12);
constexpr uLong kMostProfileBytes = 1 << 24;

/// Unsigned integers of a byte string at any offset; empty beyond its end.
class ByteReader {
 public:
  ByteReader(std::string_view bytes, bool is_big_endian)
      : bytes_(bytes), is_big_endian_(is_big_endian) {}

  [[nodiscard]] std::optional<std::uint32_t> Uint(std::size_t offset, std::size_t size) const {
    if (offset > bytes_.size() || size > bytes_.size() - offset) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t place = is_big_endian_ ? offset + i : offset + size - 1 - i;
      value = value << 8 | static_cast<unsigned char>(bytes_[place]);
    }
    return value;
  }

 private:
  std::string_view bytes_;
  bool is_big_endian_;
};

/// The first directory of a TIFF structure.
class TiffDirectory {
 public:
  explicit TiffDirectory(std::string_view bytes)
      : bytes_(bytes), reader_(bytes, bytes.starts_with(kTiffBigEndian)) {
    if (bytes.starts_with(kTiffBigEndian) || bytes.starts_with(kTiffLittleEndian)) {
      begin_ = reader_.Uint(4, 4);
    }
  }

  /// Value of a SHORT or LONG tag with one entry. Empty when absent or malformed.
  [[nodiscard]] std::optional<std::uint32_t> Number(std::uint16_t tag) const {
    const std::optional<std::size_t> entry = Find(tag);
    if (!entry || reader_.Uint(*entry + 4, 4) != 1U) return std::nullopt;
    const std::optional<std::uint32_t> type = reader_.Uint(*entry + 2, 2);
    if (type == 3U) return reader_.Uint(*entry + 8, 2);
    if (type == 4U) return reader_.Uint(*entry + 8, 4);
    return std::nullopt;
  }
  /// What a tag of more than 4 bytes points to.
  [[nodiscard]] std::string_view Bytes(std::uint16_t tag) const {
    const std::optional<std::size_t> entry = Find(tag);
    if (!entry) return {};
    const std::uint32_t count = reader_.Uint(*entry + 4, 4).value_or(0);
    const std::uint32_t offset = reader_.Uint(*entry + 8, 4).value_or(0);
    if (count <= 4 || offset > bytes_.size() || count > bytes_.size() - offset) return {};
    return bytes_.substr(offset, count);
  }

 private:
  [[nodiscard]] std::optional<std::size_t> Find(std::uint16_t tag) const {
    if (!begin_) return std::nullopt;
    const std::optional<std::uint32_t> num_entries = reader_.Uint(*begin_, 2);
    for (std::uint32_t i = 0; i < num_entries.value_or(0); ++i) {
      const std::size_t entry = std::size_t{*begin_} + 2 + std::size_t{12} * i;
      if (reader_.Uint(entry, 2) == tag) return entry;
    }
    return std::nullopt;
  }

  std::string_view bytes_;
  ByteReader reader_;
  std::optional<std::uint32_t> begin_;
};

/// A marker with its segment (without the length field), or one without: restart marks and the two
/// ends.
struct JpegSegment {
  unsigned marker = 0;
  std::string_view payload;
};

/// Walks the markers of a JPEG file, passing over entropy coded data.
class JpegSegments {
 public:
  explicit JpegSegments(std::string_view bytes) : bytes_(bytes), offset_(2) {}

  /// Empty when the file ends before another whole segment.
  std::optional<JpegSegment> Next() {
    while (offset_ + 1 < bytes_.size()) {
      const std::size_t begin = bytes_.find('\xff', offset_);
      if (begin == std::string_view::npos || begin + 1 >= bytes_.size()) return std::nullopt;
      const unsigned marker = static_cast<unsigned char>(bytes_[begin + 1]);
      offset_ = begin + 1;
      if (marker == 0xff) continue;  // fill byte
      ++offset_;
      const bool is_data = marker == 0x00 || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
      if (is_data) continue;
      if (marker == 0xd9) return JpegSegment{marker, {}};
      const std::optional<std::uint32_t> length = ByteReader(bytes_, true).Uint(offset_, 2);
      if (!length || *length < 2 || *length > bytes_.size() - offset_) return std::nullopt;
      const std::string_view payload = bytes_.substr(offset_ + 2, *length - 2);
      offset_ += *length;
      return JpegSegment{marker, payload};
    }
    return std::nullopt;
  }

 private:
  std::string_view bytes_;
  std::size_t offset_;
};

bool IsFrameHeader(unsigned marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

std::string ProfileOfJpeg(std::string_view bytes) {
  JpegSegments segments(bytes);
  std::map<unsigned char, std::string_view> parts;  // by their number
  while (const std::optional<JpegSegment> segment = segments.Next()) {
    if (segment->marker == 0xda || segment->marker == 0xd9) break;
    const std::size_t head = kIccProfile.size() + 2;  // the part, of how many
    if (segment->marker != 0xe2 || !segment->payload.starts_with(kIccProfile)) continue;
    if (segment->payload.size() < head) continue;
    parts[static_cast<unsigned char>(segment->payload[head - 2])] = segment->payload.substr(head);
  }
  std::string profile;
  for (const auto& [number, part] : parts) profile += part;
  return profile;
}

std::string ProfileOfPng(std::string_view bytes) {
  const ByteReader reader(bytes, true);
  for (std::size_t chunk = 8; const auto length = reader.Uint(chunk, 4);) {
    const std::string_view rest = bytes.substr(std::min(bytes.size(), chunk + 8));
    if (*length > rest.size() || rest.empty()) return {};
    const std::string_view kind = bytes.substr(chunk + 4, 4);
    if (kind == "IDAT") return {};
    if (kind == "iCCP") {
      const std::string_view data = rest.substr(0, *length);
      const std::size_t name_end = data.find('\0');
      if (name_end == std::string_view::npos || name_end + 2 > data.size()) return {};
      const std::string_view packed = data.substr(name_end + 2);  // past the method
      std::string profile;
      for (uLong room = 1 << 16; room <= kMostProfileBytes; room *= 4) {
        profile.resize(room);
        uLongf size = room;
        const int status = uncompress(reinterpret_cast<Bytef*>(profile.data()),
                                      &size,
                                      reinterpret_cast<const Bytef*>(packed.data()),
                                      static_cast<uLong>(packed.size()));
        if (status == Z_BUF_ERROR) continue;
        if (status != Z_OK) return {};
        profile.resize(size);
        return profile;
      }
      return {};
    }
    chunk += std::size_t{12} + *length;
  }
  return {};
}

void CheckJpeg(std::string_view bytes, const std::string& name) {
  JpegSegments segments(bytes);
  bool has_frame = false;
  while (const std::optional<JpegSegment> segment = segments.Next()) {
    if (IsFrameHeader(segment->marker)) {
      const ByteReader reader(segment->payload, true);
      // What printers mix is told by a profile alone, and the library's guess is a level too
      // bright.
      constexpr std::uint64_t kCmyk = 4;
      if (reader.Uint(5, 1).value_or(0) == kCmyk) {
        throw IoError(name + ": the JPEG file is of four inks (CMYK); store it as RGB");
      }
      CheckClaimedSize(reader.Uint(3, 2).value_or(0),
                       reader.Uint(1, 2).value_or(0),
                       ImageKind::kJpeg,
                       bytes.size(),
                       name);
      has_frame = true;
    }
    if (segment->marker != 0xd9) continue;
    if (!has_frame) throw IoError(name + ": the JPEG file has no image");
    return;
  }
  throw IoError(name + ": the JPEG file is cut off");
}

}  // namespace

void CheckImageSize(std::int64_t width, std::int64_t height, const std::string& name) {
  if (width <= 0 || height <= 0 || width > kMaxPixels || height > kMaxPixels / width) {
    throw IoError(name + ": image size " + std::to_string(width) + " x " + std::to_string(height) +
                  " is not allowed, at most " + std::to_string(kMaxPixels) + " pixels");
  }
}

void CheckClaimedSize(std::int64_t width,
                      std::int64_t height,
                      ImageKind kind,
                      std::uintmax_t file_bytes,
                      const std::string& name) {
  CheckImageSize(width, height, name);
  const std::int64_t pixels = width * height, each = MostPixelsPerByte(kind);
  const auto least = static_cast<std::uintmax_t>((pixels + each - 1) / each);
  if (file_bytes >= least) return;
  constexpr std::int64_t kPixelBytes = 3 * sizeof(float);
  constexpr std::int64_t kMegabyte = 1000000;
  throw IoError(name + ": claims " + std::to_string(width) + " x " + std::to_string(height) +
                " pixels (" + std::to_string((pixels * kPixelBytes + kMegabyte - 1) / kMegabyte) +
                " MB in memory), which no file of " + std::to_string(file_bytes) +
                " bytes holds (at least " + std::to_string(least) + "); it is damaged or cut off");
}

std::string FirstNonFinite(const Image& image) {
  const auto place = std::ranges::find_if(image.data, [](float v) { return !std::isfinite(v); });
  if (place == image.data.end()) return "";
  const std::ptrdiff_t pixel = (place - image.data.begin()) / image.channels;
  return "pixel (" + std::to_string(pixel % image.width) + ", " +
         std::to_string(pixel / image.width) + ")";
}

void CheckWritable(const Image& image,
                   std::initializer_list<int> allowed_channels,
                   const std::filesystem::path& path) {
  const bool is_allowed =
      std::ranges::find(allowed_channels, image.channels) != allowed_channels.end();
  if (image.Empty() || !is_allowed) {
    throw IoError(path.string() + ": an image of " + std::to_string(image.width) + " x " +
                  std::to_string(image.height) + " with " + std::to_string(image.channels) +
                  " channels cannot be written in this format");
  }
  if (const std::string place = FirstNonFinite(image); !place.empty()) {
    throw NumericalError(path.string() + ": " + place + " is not finite");
  }
}

ImageKind KindOfImage(std::string_view bytes) {
  if (bytes.starts_with("\xff\xd8\xff")) return ImageKind::kJpeg;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return ImageKind::kPng;
  if (bytes.starts_with(kTiffLittleEndian) || bytes.starts_with(kTiffBigEndian))
    return ImageKind::kTiff;
  if (bytes.starts_with("\x76\x2f\x31\x01")) return ImageKind::kExr;
  if (bytes.starts_with("#?")) return ImageKind::kHdr;
  return ImageKind::kUnknown;
}

std::string_view ExifOfJpeg(std::string_view bytes) {
  if (KindOfImage(bytes) != ImageKind::kJpeg) return {};
  JpegSegments segments(bytes);
  while (const std::optional<JpegSegment> segment = segments.Next()) {
    // Metadata stands before the first scan.
    if (segment->marker == 0xda || segment->marker == 0xd9) return {};
    if (segment->marker != 0xe1 || !segment->payload.starts_with(kExif)) continue;
    return segment->payload.substr(kExif.size());
  }
  return {};
}

std::string IccProfileOf(std::string_view bytes, ImageKind kind) {
  if (kind == ImageKind::kJpeg) return ProfileOfJpeg(bytes);
  if (kind == ImageKind::kPng) return ProfileOfPng(bytes);
  if (kind == ImageKind::kTiff) return std::string(TiffDirectory(bytes).Bytes(kTiffProfile));
  return {};
}

int OrientationOfExif(std::string_view exif) {
  const std::uint32_t value = TiffDirectory(exif).Number(kTiffOrientation).value_or(1);
  return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
}

void CheckContainer(std::string_view bytes, ImageKind kind, const std::string& name) {
  if (kind == ImageKind::kJpeg) CheckJpeg(bytes, name);
  if (kind == ImageKind::kPng) {
    const ByteReader reader(bytes, true);
    CheckClaimedSize(
        reader.Uint(16, 4).value_or(0), reader.Uint(20, 4).value_or(0), kind, bytes.size(), name);
  }
  if (kind == ImageKind::kTiff) {
    const TiffDirectory directory(bytes);
    CheckClaimedSize(directory.Number(kTiffWidth).value_or(0),
                     directory.Number(kTiffHeight).value_or(0),
                     kind,
                     bytes.size(),
                     name);
  }
}

}  // namespace pathfit::renderer
