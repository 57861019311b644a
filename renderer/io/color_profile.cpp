#include "renderer/io/color_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string_view>
#include <vector>

#include <lcms2.h>

#include "renderer/core/error.h"
#include "renderer/image/color.h"

namespace pathfit::renderer {
namespace {

constexpr double kSameColor = 1.5 / 255.0;  // encoded
constexpr float kBrightest = 16.0F;         // of the white; colours of no wide gamut reach 4

using Handle = std::unique_ptr<void, void (*)(void*)>;

Handle ProfileOf(cmsHPROFILE made) {
  return {made, [](void* profile) { cmsCloseProfile(profile); }};
}

constexpr cmsCIExyY kD65 = {0.3127, 0.3290, 1.0};

/// Of white D65; values to the power of `gamma` are linear.
Handle MakeProfile(const cmsCIExyYTRIPLE& primaries, double gamma) {
  const std::unique_ptr<cmsToneCurve, decltype(&cmsFreeToneCurve)> curve(
      cmsBuildGamma(nullptr, gamma), cmsFreeToneCurve);
  const std::array<cmsToneCurve*, 3> curves = {curve.get(), curve.get(), curve.get()};
  return ProfileOf(cmsCreateRGBProfile(&kD65, &primaries, curves.data()));
}

std::string DescriptionOf(void* profile) {
  std::array<char, 256> text{};
  cmsGetProfileInfoASCII(profile,
                         cmsInfoDescription,
                         "en",
                         "US",
                         text.data(),
                         static_cast<cmsUInt32Number>(text.size()));
  std::string words;
  for (const char c : std::string_view(text.data())) {
    if (c >= ' ' && c <= '~') words += c;
  }
  return words.empty() ? "without a name" : words;
}

}  // namespace

ColorProfile::ColorProfile(const std::string& icc, const std::string& name) : ColorProfile() {
  const Handle profile =
      ProfileOf(cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
  const auto fail = [&](const std::string& what) {
    throw IoError(name + ": its colour profile " + what +
                  "; store it as sRGB, or say with transfer 'srgb' that it is");
  };
  if (!profile) fail("is damaged");
  // From its place in the header: the library's enumeration does not hold what a file may.
  const std::string_view space =
      std::string_view(icc).substr(std::min<std::size_t>(16, icc.size()), 4);
  if (space != "RGB " && space != "GRAY") {
    fail("'" + DescriptionOf(profile.get()) + "' is neither of RGB nor of grey");
  }
  is_grey_ = space == "GRAY";
  description_ = DescriptionOf(profile.get());
  if (!Use(profile.get())) fail("'" + description_ + "' cannot be used");
}

ColorProfile ColorProfile::AdobeRgb() {
  constexpr cmsCIExyYTRIPLE kPrimaries = {{0.64, 0.33, 1.0}, {0.21, 0.71, 1.0}, {0.15, 0.06, 1.0}};
  constexpr double kGamma = 563.0 / 256.0;
  ColorProfile result;
  result.description_ = "Adobe RGB (1998)";
  const Handle profile = MakeProfile(kPrimaries, kGamma);
  if (!profile || !result.Use(profile.get())) throw std::bad_alloc();
  return result;
}

bool ColorProfile::Use(void* profile) {
  constexpr cmsCIExyYTRIPLE kRec709 = {{0.64, 0.33, 1.0}, {0.30, 0.60, 1.0}, {0.15, 0.06, 1.0}};
  const Handle linear = MakeProfile(kRec709, 1.0);
  transform_ = {cmsCreateTransform(profile,
                                   is_grey_ ? TYPE_GRAY_FLT : TYPE_RGB_FLT,
                                   linear.get(),
                                   TYPE_RGB_FLT,
                                   INTENT_RELATIVE_COLORIMETRIC,
                                   cmsFLAGS_NOCACHE),
                cmsDeleteTransform};
  return transform_ != nullptr;
}

bool ColorProfile::IsSrgb() const {
  constexpr int kSteps = 5;
  Image encoded(kSteps * kSteps, kSteps, 3);
  for (int y = 0; y < encoded.height; ++y) {
    for (int x = 0; x < encoded.width; ++x) {
      const std::array<int, 3> steps = {x % kSteps, x / kSteps, y};
      for (int c = 0; c < 3; ++c) {
        encoded.At(x, y, c) = static_cast<float>(steps[static_cast<std::size_t>(c)]) / (kSteps - 1);
      }
    }
  }
  Image linear = encoded;
  MakeLinear(linear);
  for (std::size_t i = 0; i < encoded.data.size(); ++i) {
    const double again = SrgbFromLinear(static_cast<double>(linear.data[i]));
    if (std::abs(again - static_cast<double>(encoded.data[i])) > kSameColor) return false;
  }
  return true;
}

void ColorProfile::MakeLinear(Image& image) const {
  const auto width = static_cast<std::size_t>(image.width);
  // A curve of grey is that of each channel.
  const std::size_t count = is_grey_ ? 3 * width : width;
  std::vector<float> made(3 * count);
  for (int y = 0; y < image.height; ++y) {
    float* row = image.data.data() + 3 * width * static_cast<std::size_t>(y);
    cmsDoTransform(transform_.get(), row, made.data(), static_cast<cmsUInt32Number>(count));
    for (std::size_t i = 0; i < 3 * width; ++i) row[i] = made[is_grey_ ? 3 * i : i];
    // No number, of a curve that is none, is black too.
    std::transform(row, row + 3 * width, row, [](float v) {
      return v > 0.0F ? std::min(v, kBrightest) : 0.0F;
    });
  }
}

}  // namespace pathfit::renderer
