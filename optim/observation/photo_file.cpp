#include "optim/observation/photo_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <system_error>

#include "renderer/core/lower_case.h"
#include "renderer/image/color.h"
#include "renderer/io/color_profile.h"
#include "renderer/io/image_file.h"
#include "renderer/io/image_filter.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using renderer::DecodedImage;
using renderer::Image;

// Averages of files with so few bits are known less well than 16 bits tell.
constexpr int kMaxBitsOfRounded = 8;

/// To whole parts of the largest: they are packed into half the memory of floats.
void RoundTo16Bits(Image& image) {
  constexpr double kParts = 65535.0;
  const auto largest = static_cast<double>(std::ranges::max(image.data));
  if (largest <= 0.0) return;
  for (float& v : image.data) {
    const double parts = std::round(kParts / largest * static_cast<double>(v));
    v = static_cast<float>(parts * largest / kParts);
  }
}

constexpr double kNearlyClipped = 0.8;  // of the level

/// 1 where any channel of the encoded image reaches the level, or nearly does beside such a pixel:
/// files that lose something (JPEG) and cameras that sharpen leave less than there was at the rim
/// of what is clipped.
Image ClippedPixels(const Image& encoded, double clip_above) {
  Image clipped(encoded.width, encoded.height, 1);
  const auto reaches = [&](int x, int y, double level) {
    const renderer::Rgb value = encoded.ColorAt(x, y);
    return std::max({value.r, value.g, value.b}) >= level;
  };
  bool any = false;
  for (int y = 0; y < encoded.height; ++y) {
    for (int x = 0; x < encoded.width; ++x) {
      if (!reaches(x, y, clip_above)) continue;
      any = true;
      for (int j = std::max(0, y - 1); j <= std::min(y + 1, encoded.height - 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(x + 1, encoded.width - 1); ++i) {
          if (reaches(i, j, kNearlyClipped * clip_above)) clipped.At(i, j, 0) = 1.0F;
        }
      }
    }
  }
  return any ? clipped : Image();
}

/// Undoes the sRGB curve; integer files have few values, so these are looked up.
void MakeLinear(int bits, Image& image) {
  if (bits > 16) {
    std::ranges::transform(image.data, image.data.begin(), [](float v) {
      return static_cast<float>(renderer::LinearFromSrgb(static_cast<double>(v)));
    });
    return;
  }
  const int top = (1 << bits) - 1;
  std::vector<float> linear(static_cast<std::size_t>(top) + 1);
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = static_cast<float>(renderer::LinearFromSrgb(static_cast<double>(i) / top));
  }
  for (float& v : image.data) {
    v = linear[static_cast<std::size_t>(
        std::lround(std::clamp(v, 0.0F, 1.0F) * static_cast<float>(top)))];
  }
}

PhotoFile ReadRawPhoto(const fs::path& path, const ObservationOptions& options) {
  if (options.transfer == Transfer::kSrgb) {
    throw renderer::IoError(path.string() +
                            ": RAW photos are linear, and transfer is 'srgb'; use 'auto'");
  }
  renderer::RawPhoto raw =
      renderer::ReadRawFile(path,
                            {.white_balance = options.white_balance,
                             .clip_above = options.clip_above,
                             .apply_orientation = options.apply_exif_orientation});
  PhotoFile file;
  file.bits = 16;
  file.exif_orientation = raw.exif_orientation;
  file.exif_exposure = PlausibleExposure(raw.time_s, raw.f_number, raw.iso, raw.flash);
  file.raw = RawDevelopment{raw.white_balance, raw.multipliers, raw.has_color_matrix};
  file.photo = std::move(raw.image);
  file.clipped = std::move(raw.clipped);
  RoundTo16Bits(file.photo);  // sensors have 14 at most
  return file;
}

const std::vector<std::string> kPictureExtensions = {
    ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".hdr"};

bool HasPictureExtension(const fs::path& path) {
  const std::string extension = renderer::LowerCase(path.extension().string());
  return std::ranges::find(kPictureExtensions, extension) != kPictureExtensions.end() ||
         renderer::HasRawExtension(path);
}

std::string UpperCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// A RAW photo with the stem of a candidate, whose extension, if it is that of a picture, is not
/// part of it.
std::optional<fs::path> FindRaw(const std::vector<fs::path>& candidates) {
  for (const fs::path& candidate : candidates) {
    if (renderer::HasRawExtension(candidate)) continue;
    fs::path stem = candidate;
    if (HasPictureExtension(candidate)) stem.replace_extension();
    for (const std::string& extension : renderer::RawExtensions()) {
      for (const std::string& spelling : {extension, UpperCase(extension)}) {
        const fs::path path = (fs::path(stem) += spelling).lexically_normal();
        if (IsFile(path)) return path;
      }
    }
  }
  return std::nullopt;
}

void Try(const fs::path& candidate, FileSearch& search) {
  const fs::path path = candidate.lexically_normal();
  if (search.found || std::ranges::find(search.tried, path) != search.tried.end()) {
    return;
  }
  search.tried.push_back(path);
  if (IsFile(path)) search.found = path;
}

/// What a file says of its colours; empty: nothing, so sRGB.
std::optional<renderer::ColorProfile> ProfileOf(const DecodedImage& decoded, const fs::path& path) {
  if (!decoded.icc.empty()) return renderer::ColorProfile(decoded.icc, path.string());
  if (NamesAdobeRgb(decoded.exif)) return renderer::ColorProfile::AdobeRgb();
  return std::nullopt;
}

}  // namespace

bool IsPicture(const fs::path& path) { return HasPictureExtension(path) && IsFile(path); }

std::vector<fs::path> PicturesIn(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (IsPicture(it->path())) found.push_back(it->path());
  }
  std::ranges::sort(found);
  return found;
}

std::vector<fs::path> WithoutRawTwins(std::vector<fs::path> pictures) {
  std::set<fs::path> developed;
  for (const fs::path& picture : pictures) {
    if (!renderer::HasRawExtension(picture))
      developed.insert(fs::path(picture).replace_extension());
  }
  std::erase_if(pictures, [&](const fs::path& picture) {
    return renderer::HasRawExtension(picture) &&
           developed.contains(fs::path(picture).replace_extension());
  });
  return pictures;
}

PhotoFile ReadPhotoFile(const fs::path& path, const ObservationOptions& options) {
  if (renderer::HasRawExtension(path)) return ReadRawPhoto(path, options);
  DecodedImage decoded = renderer::ReadImageFile(path, options.apply_exif_orientation);
  PhotoFile file;
  file.bits = decoded.bits;
  file.grey = decoded.grey;
  file.exif_orientation = decoded.exif_orientation;
  file.exif_exposure = ParseExifExposure(decoded.exif);
  const bool is_integer = decoded.bits <= 16;
  if (is_integer && options.clip_above < 1.0) {
    file.clipped = ClippedPixels(decoded.image, options.clip_above);
  }
  file.srgb = options.transfer == Transfer::kSrgb ||
              (options.transfer == Transfer::kAuto && !decoded.linear);
  file.photo = std::move(decoded.image);
  file.alpha = std::move(decoded.alpha);
  file.straight_alpha = !decoded.linear;
  if (options.transfer == Transfer::kAuto && !decoded.linear) {
    const auto profile = ProfileOf(decoded, path);
    if (profile && !profile->IsSrgb()) {
      profile->MakeLinear(file.photo);
      if (file.bits <= kMaxBitsOfRounded) RoundTo16Bits(file.photo);
      file.srgb = false;
      file.profile = profile->description();
    }
  }
  if (file.srgb) MakeLinear(file.bits, file.photo);
  return file;
}

Image ReadMaskFile(const fs::path& path, bool apply_exif_orientation) {
  const DecodedImage decoded = renderer::ReadImageFile(path, apply_exif_orientation);
  Image mask(decoded.image.width, decoded.image.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const float* p = decoded.image.data.data() + 3 * i;
    mask.data[i] = std::clamp((p[0] + p[1] + p[2]) / 3.0F, 0.0F, 1.0F);
  }
  return mask;
}

std::pair<int, int> ReducedSize(int width, int height, const ObservationOptions& options) {
  const int longest = std::max(width, height);
  if (options.max_size_px <= 0 || longest <= options.max_size_px) return {width, height};
  const double scale = static_cast<double>(options.max_size_px) / longest;
  return {std::max(1, static_cast<int>(std::lround(width * scale))),
          std::max(1, static_cast<int>(std::lround(height * scale)))};
}

void ReducePhoto(const ObservationOptions& options, PhotoFile& file) {
  const auto [width, height] = ReducedSize(file.photo.width, file.photo.height, options);
  if (width == file.photo.width && height == file.photo.height) return;
  for (Image* image : {&file.photo, &file.clipped}) {
    if (!image->Empty()) *image = renderer::ResizeArea(*image, width, height);
  }
  if (file.bits <= kMaxBitsOfRounded) RoundTo16Bits(file.photo);
}

void FinishMask(const MaskOptions& options, Image& mask) {
  for (float& v : mask.data) v = std::clamp(options.invert ? 1.0F - v : v, 0.0F, 1.0F);
}

FileSearch FindPhoto(const std::string& image,
                     const ImportedCameras& cameras,
                     const fs::path& images_dir) {
  const fs::path name(image);
  std::vector<fs::path> candidates;
  if (images_dir.empty()) {
    for (const fs::path& folder : cameras.image_folders) candidates.push_back(folder / name);
  } else {
    candidates = {images_dir / name, images_dir / name.filename()};
  }
  FileSearch search;
  for (const fs::path& candidate : candidates) Try(candidate, search);
  for (const fs::path& candidate : candidates) {
    if (HasPictureExtension(candidate)) continue;
    for (const std::string& extension : kPictureExtensions) {
      for (const std::string& spelling : {extension, UpperCase(extension)}) {
        Try(fs::path(candidate) += spelling, search);
      }
    }
  }
  if (!search.found) search.found = FindRaw(candidates);
  return search;
}

FileSearch FindMask(const ImportedCamera& camera,
                    const fs::path& photo,
                    const ImportedCameras& cameras,
                    const ObservationOptions& options) {
  FileSearch search;
  if (IsFile(options.masks.folder)) {
    Try(options.masks.folder, search);
    return search;
  }
  if (options.masks.folder.empty()) {
    if (!camera.mask.empty()) Try(cameras.folder / camera.mask, search);
    return search;
  }
  const fs::path file_name = photo.filename();
  // Below the folder as the photo is below its own, however the camera file's names begin.
  std::vector<fs::path> folders;
  const fs::path with_folder = fs::path(camera.image).relative_path().parent_path();
  for (auto first = with_folder.begin(); first != with_folder.end(); ++first) {
    fs::path below;
    for (auto part = first; part != with_folder.end(); ++part) below /= *part;
    folders.push_back(options.masks.folder / below);
  }
  folders.push_back(options.masks.folder);
  for (const fs::path& folder : folders) {
    for (const fs::path& name : {fs::path(file_name) += ".png",
                                 fs::path(file_name.stem()) += ".png",
                                 fs::path(file_name.stem()) += ".mask.png"}) {
      if ((folder / name).lexically_normal() !=
          photo) {  // masks beside PNG photos: a.png is the photo itself
        Try(folder / name, search);
      }
    }
  }
  return search;
}

std::string TriedNames(const FileSearch& search) {
  std::string text;
  for (const fs::path& path : search.tried) text += (text.empty() ? "" : ", ") + path.string();
  return text;
}

}  // namespace pathfit::optim
