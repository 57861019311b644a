#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "renderer/image/image.h"
#include "renderer/math/rgb.h"

namespace pathfit::renderer {

/// By what the channels of a camera are multiplied before its colours become Rec.709, so that white
/// things are white: as the camera noted it for this photo, as for daylight (D65) by the camera's
/// colour matrix, which is the same for all its photos, or not at all.
enum class RawWhiteBalance { kCamera, kDaylight, kNone };

struct RawOptions {
  RawWhiteBalance white_balance = RawWhiteBalance::kCamera;
  /// Share of a sensor value's range, from black to full, from which it counts as clipped; 1 =
  /// never. Full is what the file or the library's tables say, or less, where values pile up.
  double clip_above = 0.99;
  bool apply_orientation = false;  ///< turns the picture upright, as the camera was held
};

/// A RAW photo, developed so that pixels are proportional to light.
struct RawPhoto {
  /// 3 channels, linear Rec.709, at least 0. 1 is where green sensor values are full; other
  /// channels go beyond it by their multipliers, so that no photo's white balance changes the scale
  /// of its brightness.
  Image image;
  /// 1 channel, 1 = a sensor value that the pixel is made of is clipped; empty if none is.
  /// Highlights are left as they come out.
  Image clipped;
  int exif_orientation = 1;  ///< how the camera was held, 1 to 8
  Rgb multipliers;           ///< white balance of the camera's channels that was used; green is 1
  /// The one that was used: kDaylight where the camera's was asked for, but the file has none.
  RawWhiteBalance white_balance = RawWhiteBalance::kCamera;
  /// False: nothing is known of the camera's colours, so that they are taken as Rec.709.
  bool has_color_matrix = true;
  double time_s = 0.0, f_number = 0.0, iso = 0.0;  ///< what the camera noted; 0: nothing
  bool flash = false;                              ///< it fired
};

/// Extensions of RAW photos in small letters: ".dng", ".cr2", ... Many of these files cannot be
/// told from a TIFF by their first bytes.
const std::set<std::string>& RawExtensions();
/// Whether a file name has one of them, in any letters.
bool HasRawExtension(const std::filesystem::path& path);

/// Version of LibRaw; empty in a build without it.
std::string LibRawVersion();

/// Develops whatever LibRaw opens, whose visible sensor area is the picture: no curve, no change of
/// brightness, no lens correction. Rows stay as the sensor stored them unless asked otherwise.
/// Fails: IoError naming the file: not a RAW photo, cut off or damaged, not square pixels, or a
/// build without LibRaw.
RawPhoto ReadRawFile(const std::filesystem::path& path, const RawOptions& options);

}  // namespace pathfit::renderer
