#pragma once

#include <memory>
#include <string>

#include "renderer/image/image.h"

namespace pathfit::renderer {

/// What the numbers of an image stand for.
class ColorProfile {
 public:
  /// By an ICC profile. Fails: IoError naming `name`, the image: damaged, or neither of RGB nor of
  /// grey.
  ColorProfile(const std::string& icc, const std::string& name);
  /// What cameras write in Adobe RGB, and most say in EXIF alone. [Adobe RGB (1998)]
  static ColorProfile AdobeRgb();

  [[nodiscard]] const std::string& description() const { return description_; }
  /// Whether it says what sRGB says, to an 8-bit step and a half.
  [[nodiscard]] bool IsSrgb() const;
  /// Encoded values 0..1 of 3 channels become linear Rec.709 relative to the profile's white;
  /// colours outside of it get the nearest that has no negative channel.
  void MakeLinear(Image& image) const;

 private:
  ColorProfile() : transform_(nullptr, nullptr) {}
  /// To what MakeLinear makes; `profile` is the library's. False if it cannot be used.
  bool Use(void* profile);

  std::unique_ptr<void, void (*)(void*)> transform_;  ///< the library's
  std::string description_;
  bool is_grey_ = false;
};

}  // namespace pathfit::renderer
