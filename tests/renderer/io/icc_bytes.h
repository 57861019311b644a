#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <lcms2.h>
#include <zlib.h>

#include "renderer/image/image.h"
#include "renderer/io/image_file.h"

namespace pathfit::renderer {

struct Chromaticity {
  double x, y;
};
inline constexpr std::array<Chromaticity, 3> kRec709 = {{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}}};
inline constexpr std::array<Chromaticity, 3> kP3 = {{{0.68, 0.32}, {0.265, 0.69}, {0.15, 0.06}}};

inline std::string SavedProfile(cmsHPROFILE profile) {
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(profile, bytes.data(), &size);
  cmsCloseProfile(profile);
  return bytes;
}

inline cmsToneCurve* SrgbCurve() {
  const std::array<double, 5> curve = {2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045};
  return cmsBuildParametricToneCurve(nullptr, 4, curve.data());
}

/// With the curve of sRGB, or a power.
inline std::string RgbProfile(const std::array<Chromaticity, 3>& primaries, double gamma = 0.0) {
  const cmsCIExyY white = {0.3127, 0.3290, 1.0};
  const auto of = [&](std::size_t i) { return cmsCIExyY{primaries[i].x, primaries[i].y, 1.0}; };
  const cmsCIExyYTRIPLE corners = {of(0), of(1), of(2)};
  cmsToneCurve* curve = gamma > 0.0 ? cmsBuildGamma(nullptr, gamma) : SrgbCurve();
  const std::array<cmsToneCurve*, 3> curves = {curve, curve, curve};
  const std::string bytes = SavedProfile(cmsCreateRGBProfile(&white, &corners, curves.data()));
  cmsFreeToneCurve(curve);
  return bytes;
}

inline std::string BytesOf(const std::vector<unsigned char>& bytes) {
  return {bytes.begin(), bytes.end()};
}

inline std::string BigEndian(std::size_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i) & 0xff);
  return text;
}

inline std::string PngWith(const std::string& icc, const Image& image) {
  const std::string png = BytesOf(EncodePng(image));
  std::string packed(compressBound(icc.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()),
           &size,
           reinterpret_cast<const Bytef*>(icc.data()),
           icc.size());
  packed.resize(size);
  const std::string data = std::string("iCCPname\0\0", 10) + packed;
  const uLong crc =
      crc32(0, reinterpret_cast<const Bytef*>(data.data()), static_cast<uInt>(data.size()));
  constexpr std::size_t kHeader = 8 + 25;
  return png.substr(0, kHeader) + BigEndian(data.size() - 4, 4) + data + BigEndian(crc, 4) +
         png.substr(kHeader);
}

}  // namespace pathfit::renderer
