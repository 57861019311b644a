#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pathfit::optim {

/// What a camera notes about one exposure.
struct ExifExposure {
  double time_s = 0.0;
  double f_number = 0.0;
  double iso = 0.0;
  bool flash = false;  ///< it fired

  /// Brightness of equal radiance in a photo: log2 of time times sensitivity over the square of the
  /// f-number, up to a constant.
  [[nodiscard]] double Ev() const;
};

/// From the TIFF structure of an EXIF block, whose bytes may be anything. Empty unless exposure
/// time, f-number and ISO are all there with plausible values.
std::optional<ExifExposure> ParseExifExposure(std::string_view exif);

/// Of numbers that were read otherwise; empty likewise.
std::optional<ExifExposure> PlausibleExposure(double time_s,
                                              double f_number,
                                              double iso,
                                              bool flash);

/// Camera and focal length that an EXIF block names: "Canon EOS 5D, 50 mm". Empty where it names
/// neither.
std::string ParseExifLens(std::string_view exif);

/// Whether an EXIF block says that the picture's colours are those of Adobe RGB, as cameras do that
/// add no profile. [DCF 2.0, option file]
bool NamesAdobeRgb(std::string_view exif);

struct ExifComparison {
  std::vector<double> ev;  ///< of each photo, around their mean; empty if they are not to be used
  std::string seen;        ///< for people; empty if no photo says anything
};

/// Exposures are used where all photos have one, and they differ by what can be believed: not too
/// much, and not by the time of photos with flash, whose light is shorter than that.
ExifComparison CompareExifExposures(const std::vector<std::optional<ExifExposure>>& photos);

}  // namespace pathfit::optim
