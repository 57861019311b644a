#include "optim/observation/exif_exposure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <libexif/exif-data.h>
#include <libexif/exif-utils.h>

namespace pathfit::optim {
namespace {

// Cameras write f/5.6 for 5.66 and 1/60 for 1/64: less is no difference.
constexpr double kEqualEv = 0.1;
constexpr double kMaxSpreadEv = 12.0;

constexpr std::size_t kMaxBlock = 65535;  // what a segment of JPEG can hold
constexpr ExifShort kIsoIsElsewhere = 65535;
constexpr ExifShort kAdobeRgb = 2;  // not of the standard, but written

struct Range {
  double low = 0.0, high = 0.0;
};
constexpr Range kTimesS{1e-7, 1e5};
constexpr Range kFNumbers{0.3, 1000.0};
constexpr Range kIsos{1.0, 1e7};
constexpr Range kFocalLengthsMm{0.1, 1e4};

/// The first component of an entry; empty where it has another type or is too short.
class Entries {
 public:
  explicit Entries(ExifData* data) : data_(data), order_(exif_data_get_byte_order(data)) {}

  [[nodiscard]] std::optional<double> Rational(ExifTag tag, Range allowed) const {
    const ExifEntry* entry = Find(tag, EXIF_FORMAT_RATIONAL);
    if (entry == nullptr) return std::nullopt;
    const ExifRational value = exif_get_rational(entry->data, order_);
    if (value.denominator == 0) return std::nullopt;
    return Within(static_cast<double>(value.numerator) / static_cast<double>(value.denominator),
                  allowed);
  }
  [[nodiscard]] std::optional<ExifShort> Short(ExifTag tag) const {
    const ExifEntry* entry = Find(tag, EXIF_FORMAT_SHORT);
    if (entry == nullptr) return std::nullopt;
    return exif_get_short(entry->data, order_);
  }
  [[nodiscard]] static std::optional<double> Within(double value, Range allowed) {
    if (!(value >= allowed.low && value <= allowed.high)) return std::nullopt;
    return value;
  }

 private:
  [[nodiscard]] const ExifEntry* Find(ExifTag tag, ExifFormat format) const {
    const ExifEntry* entry = exif_content_get_entry(data_->ifd[EXIF_IFD_EXIF], tag);
    const bool fits = entry != nullptr && entry->format == format && entry->components >= 1 &&
                      entry->data != nullptr && entry->size >= exif_format_get_size(format);
    return fits ? entry : nullptr;
  }

  ExifData* data_;
  ExifByteOrder order_;
};

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string TimeText(double time_s) {
  return time_s < 0.3 ? "1/" + std::to_string(std::lround(1.0 / time_s)) : Number(time_s);
}

/// "A" or "A to B" of the smallest and largest.
template <class Member, class Text>
std::string Span(const std::vector<ExifExposure>& exposures, Member member, Text text) {
  const auto [low, high] = std::ranges::minmax(exposures, {}, member);
  const std::string first = text(low.*member);
  const std::string last = text(high.*member);
  return first == last ? first : first + " to " + last;
}

using ExifBlock = std::unique_ptr<ExifData, void (*)(ExifData*)>;

/// Empty where it has another type.
std::string_view TextOf(ExifContent* ifd, ExifTag tag) {
  const ExifEntry* entry = exif_content_get_entry(ifd, tag);
  if (entry == nullptr || entry->format != EXIF_FORMAT_ASCII || entry->data == nullptr) return {};
  const std::string_view stored(reinterpret_cast<const char*>(entry->data), entry->size);
  return stored.substr(0, stored.find('\0'));
}

/// Null for what cannot be one.
ExifBlock LoadExif(std::string_view exif) {
  ExifBlock data(nullptr, exif_data_unref);
  if (exif.empty() || exif.size() > kMaxBlock) return data;
  data.reset(exif_data_new());
  if (!data) return data;
  const std::string block = std::string("Exif\0\0", 6) + std::string(exif);
  // Values count as they are stored, not as the library would mend them.
  exif_data_unset_option(data.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_load_data(data.get(),
                      reinterpret_cast<const unsigned char*>(block.data()),
                      static_cast<unsigned int>(block.size()));
  return data;
}

}  // namespace

double ExifExposure::Ev() const { return std::log2(time_s * iso / (f_number * f_number)); }

std::optional<ExifExposure> ParseExifExposure(std::string_view exif) {
  const ExifBlock data = LoadExif(exif);
  if (!data) return std::nullopt;
  const Entries entries(data.get());
  const auto time = entries.Rational(EXIF_TAG_EXPOSURE_TIME, kTimesS);
  const auto f_number = entries.Rational(EXIF_TAG_FNUMBER, kFNumbers);
  const auto stored_iso = entries.Short(EXIF_TAG_ISO_SPEED_RATINGS);
  if (!time || !f_number || !stored_iso || *stored_iso == kIsoIsElsewhere) return std::nullopt;
  const auto iso = Entries::Within(*stored_iso, kIsos);
  if (!iso) return std::nullopt;
  const bool flash = (entries.Short(EXIF_TAG_FLASH).value_or(0) & 1) != 0;
  return ExifExposure{*time, *f_number, *iso, flash};
}

std::optional<ExifExposure> PlausibleExposure(double time_s,
                                              double f_number,
                                              double iso,
                                              bool flash) {
  if (!Entries::Within(time_s, kTimesS) || !Entries::Within(f_number, kFNumbers) ||
      !Entries::Within(iso, kIsos)) {
    return std::nullopt;
  }
  return ExifExposure{time_s, f_number, iso, flash};
}

std::string ParseExifLens(std::string_view exif) {
  const ExifBlock data = LoadExif(exif);
  if (!data) return {};
  std::string text;
  for (const ExifTag tag : {EXIF_TAG_MAKE, EXIF_TAG_MODEL}) {
    const std::string_view name = TextOf(data->ifd[EXIF_IFD_0], tag);
    if (!name.empty()) text += (text.empty() ? "" : " ") + std::string(name);
  }
  const auto focal = Entries(data.get()).Rational(EXIF_TAG_FOCAL_LENGTH, kFocalLengthsMm);
  if (focal) text += (text.empty() ? "" : ", ") + Number(*focal) + " mm";
  return text;
}

bool NamesAdobeRgb(std::string_view exif) {
  const ExifBlock data = LoadExif(exif);
  if (!data) return false;
  return TextOf(data->ifd[EXIF_IFD_INTEROPERABILITY], EXIF_TAG_INTEROPERABILITY_INDEX) == "R03" ||
         Entries(data.get()).Short(EXIF_TAG_COLOR_SPACE) == kAdobeRgb;
}

ExifComparison CompareExifExposures(const std::vector<std::optional<ExifExposure>>& photos) {
  std::vector<ExifExposure> known;
  for (const auto& exposure : photos) {
    if (exposure) known.push_back(*exposure);
  }
  if (known.empty()) return {};
  std::vector<double> ev;
  double mean = 0.0;
  for (const ExifExposure& exposure : known) {
    ev.push_back(exposure.Ev());
    mean += ev.back() / static_cast<double>(known.size());
  }
  const auto [lowest, highest] = std::ranges::minmax(ev);
  const double spread = highest - lowest;
  const auto [shortest, longest] = std::ranges::minmax(known, {}, &ExifExposure::time_s);
  const bool times_differ = std::log2(longest.time_s / shortest.time_s) > kEqualEv;

  ExifComparison result;
  result.seen = "EXIF: " + std::to_string(known.size()) + " of " + std::to_string(photos.size()) +
                (photos.size() == 1 ? " photo" : " photos") +
                " with an exposure: " + Span(known, &ExifExposure::time_s, TimeText) + " s, f/" +
                Span(known, &ExifExposure::f_number, Number) + ", ISO " +
                Span(known, &ExifExposure::iso, Number);
  if (spread <= kEqualEv) {
    result.seen += "; they are alike.";
    return result;
  }
  result.seen += "; they differ by " + Number(0.01 * std::round(100.0 * spread)) + " EV";
  if (known.size() < photos.size()) {
    result.seen += ", which is not used, since the others have none.";
  } else if (spread > kMaxSpreadEv) {
    result.seen += ", which is not used, since that is too much to be believed.";
  } else if (times_differ &&
             std::ranges::any_of(known, [](const ExifExposure& e) { return e.flash; })) {
    result.seen +=
        ", which is not used, since the flash fired: its light is shorter than the time.";
  } else {
    result.seen += ".";
    for (double& value : ev) value -= mean;
    result.ev = std::move(ev);
  }
  return result;
}

}  // namespace pathfit::optim
