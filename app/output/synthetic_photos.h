#pragma once

#include <cstdint>
#include <filesystem>

#include "renderer/image/image.h"
#include "renderer/math/box.h"
#include "renderer/sensor/camera.h"

namespace pathfit::app {

/// What makes photos of a known scene differ from its pictures, and what is believed of their
/// cameras from what is true. Everything is a function of the seed and the photo's index alone.
struct PhotoErrors {
  std::uint64_t seed = 0;
  double noise = 0.0;  ///< standard deviation of normal noise, in linear values (white = 1)
  double shot = 0.0;   ///< variance of shot noise per linear value
  double exposure_sigma_ev = 0.0;
  /// Radians. Cameras are turned by normal angles about their axes, and moved by the same angles as
  /// seen from the objects.
  double pose_sigma = 0.0;
};

/// Adds normal noise of variance noise^2 + shot * max(0, value) to every value.
void AddNoise(const PhotoErrors& errors, std::uint64_t photo, renderer::Image& linear);

/// By how much the photo's exposure differs from its camera's.
double ExposureErrorEv(const PhotoErrors& errors, std::uint64_t photo);

/// The camera as it is believed to be: where the true one, looking at objects in `box`, is not.
renderer::Camera BelievedCamera(const PhotoErrors& errors,
                                std::uint64_t photo,
                                const renderer::Box& box,
                                const renderer::Camera& camera);

/// Linear values into an .exr file; into .png or .jpg as 8 bits by the sRGB curve, cut at white.
/// `quality`: of JPEG, 1 to 100. Throws IoError.
void WritePhoto(const std::filesystem::path& path, const renderer::Image& linear, int quality);

}  // namespace pathfit::app
