#include "renderer/io/exr_file.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_check.h"

namespace pathfit::renderer {
namespace {

constexpr int kMaxSide = 65536;
/// Rows are read in blocks, so that a cut file fails before memory for all of it is taken.
constexpr int kBlockRows = 64;

/// Channels of the file that fill `Image` channels in order.
std::vector<std::string> ColorChannels(const Imf::ChannelList& channels, const std::string& path) {
  const auto has = [&channels](const char* name) { return channels.findChannel(name) != nullptr; };
  if (has("R") && has("G") && has("B")) return {"R", "G", "B"};
  if (has("Y") && !has("RY") && !has("BY")) return {"Y"};
  throw IoError(path + ": allowed channels are R G B or Y, with or without A");
}

void CheckChannel(const Imf::Channel& channel, const std::string& path) {
  if (channel.type != Imf::HALF && channel.type != Imf::FLOAT) {
    throw IoError(path + ": channels must be half or float");
  }
  if (channel.xSampling != 1 || channel.ySampling != 1) {
    throw IoError(path + ": subsampled channels are not supported");
  }
}

/// A file that says its colours belong to other primaries would be read with a cast.
void CheckColorSpace(const Imf::Header& header, const std::string& path) {
  if (!Imf::hasChromaticities(header)) return;
  constexpr float kTolerance = 0.01F;  // wider gamuts differ by three times that and more
  const Imf::Chromaticities& own = Imf::chromaticities(header);
  const Imf::Chromaticities rec709;
  for (const auto point : {&Imf::Chromaticities::red,
                           &Imf::Chromaticities::green,
                           &Imf::Chromaticities::blue,
                           &Imf::Chromaticities::white}) {
    const Imath::V2f difference = own.*point - rec709.*point;
    if (std::abs(difference.x) <= kTolerance && std::abs(difference.y) <= kTolerance) continue;
    throw IoError(path + ": its chromaticities (red " + std::to_string(own.red.x) + " " +
                  std::to_string(own.red.y) + ", white " + std::to_string(own.white.x) + " " +
                  std::to_string(own.white.y) +
                  ") are not those of Rec.709; convert its colours to linear Rec.709");
  }
}

/// The named channels of the data window, interleaved.
Image ReadChannels(Imf::InputFile& file,
                   const std::vector<std::string>& names,
                   const std::string& path) {
  const Imath::Box2i window = file.header().dataWindow();
  Image image;
  image.width = window.max.x - window.min.x + 1;
  image.height = window.max.y - window.min.y + 1;
  image.channels = static_cast<int>(names.size());
  CheckClaimedSize(
      image.width, image.height, ImageKind::kExr, std::filesystem::file_size(path), path);
  for (const std::string& name : names) {
    CheckChannel(*file.header().channels().findChannel(name), path);
  }
  const std::size_t pixel_bytes = names.size() * sizeof(float);
  const std::size_t row_floats = static_cast<std::size_t>(image.width) * names.size();
  for (int row = 0; row < image.height; row += kBlockRows) {
    const int num_rows = std::min(kBlockRows, image.height - row);
    const std::size_t begin = image.data.size();
    image.data.resize(begin + row_floats * static_cast<std::size_t>(num_rows));
    const Imath::Box2i block({window.min.x, window.min.y + row},
                             {window.max.x, window.min.y + row + num_rows - 1});
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < names.size(); ++c) {
      buffer.insert(names[c],
                    Imf::Slice::Make(Imf::FLOAT,
                                     image.data.data() + begin + c,
                                     block,
                                     pixel_bytes,
                                     row_floats * sizeof(float)));
    }
    file.setFrameBuffer(buffer);
    file.readPixels(block.min.y, block.max.y);
  }
  return image;
}

Image ThreeChannels(Image image) {
  if (image.channels == 3) return image;
  Image color(image.width, image.height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    std::fill_n(color.data.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, image.data[i]);
  }
  return color;
}

}  // namespace

Image ReadExr(const std::filesystem::path& path, Image* alpha) {
  const std::string name = path.string();
  CheckRegularFile(path);
  static std::once_flag limits_are_set;
  std::call_once(limits_are_set, [] {
    Imf::Header::setMaxImageSize(kMaxSide, kMaxSide);
    Imf::Header::setMaxTileSize(kMaxSide, kMaxSide);
  });
  Image color;
  Image coverage;
  try {
    Imf::InputFile file(name.c_str());
    const Imf::ChannelList& channels = file.header().channels();
    const std::vector<std::string> names = ColorChannels(channels, name);
    if (names.size() == 3) CheckColorSpace(file.header(), name);
    color = ThreeChannels(ReadChannels(file, names, name));
    if (alpha != nullptr && channels.findChannel("A") != nullptr) {
      coverage = ReadChannels(file, {"A"}, name);
    }
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(name + ": not a readable EXR file: " + error.what());
  }
  if (const std::string place = FirstNonFinite(color); !place.empty()) {
    throw IoError(name + ": " + place + " is not finite");
  }
  if (const std::string place = FirstNonFinite(coverage); !place.empty()) {
    throw IoError(name + ": alpha of " + place + " is not finite");
  }
  if (alpha != nullptr) *alpha = std::move(coverage);
  return color;
}

void WriteExr(const std::filesystem::path& path, const Image& image) {
  CheckWritable(image, {1, 3, 4}, path);
  const std::vector<std::string> names = image.channels == 1
                                             ? std::vector<std::string>{"Y"}
                                             : std::vector<std::string>{"R", "G", "B", "A"};
  WriteThroughTemporary(path, [&](const std::filesystem::path& temporary) {
    try {
      Imf::Header header(image.width, image.height);
      header.compression() = Imf::ZIP_COMPRESSION;
      Imf::FrameBuffer buffer;
      const std::size_t pixel_bytes = static_cast<std::size_t>(image.channels) * sizeof(float);
      const std::size_t row_bytes = pixel_bytes * static_cast<std::size_t>(image.width);
      // The library's slices are for reading and writing, hence not const.
      std::vector<float> pixels = image.data;
      for (std::size_t c = 0; c < static_cast<std::size_t>(image.channels); ++c) {
        header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
        buffer.insert(
            names[c],
            Imf::Slice::Make(
                Imf::FLOAT, pixels.data() + c, header.dataWindow(), pixel_bytes, row_bytes));
      }
      Imf::OutputFile file(temporary.string().c_str(), header);
      file.setFrameBuffer(buffer);
      file.writePixels(image.height);
    } catch (const std::exception& error) {
      throw IoError(path.string() + ": cannot be written: " + error.what());
    }
  });
}

}  // namespace pathfit::renderer
