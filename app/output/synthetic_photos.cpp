#include "app/output/synthetic_photos.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "app/output/report_images.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_file.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::app {
namespace {

using renderer::CounterRng;
using renderer::RandomDomain;
using renderer::Vec3;

double Normal(CounterRng& rng) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - rng.Next()));
  return radius * std::cos(2.0 * std::numbers::pi * rng.Next());
}

Vec3 NormalVector(CounterRng& rng, double sigma) {
  const double x = Normal(rng);
  const double y = Normal(rng);
  return Vec3{x, y, Normal(rng)} * sigma;
}

}  // namespace

void AddNoise(const PhotoErrors& errors, std::uint64_t photo, renderer::Image& linear) {
  if (errors.noise == 0.0 && errors.shot == 0.0) return;
  CounterRng rng(errors.seed, RandomDomain::kPhotoNoise, photo);
  for (float& v : linear.data) {
    const double variance =
        errors.noise * errors.noise + errors.shot * std::max(0.0, static_cast<double>(v));
    v += static_cast<float>(std::sqrt(variance) * Normal(rng));
  }
}

double ExposureErrorEv(const PhotoErrors& errors, std::uint64_t photo) {
  CounterRng rng(errors.seed, RandomDomain::kPhotoExposure, photo);
  return errors.exposure_sigma_ev * Normal(rng);
}

renderer::Camera BelievedCamera(const PhotoErrors& errors,
                                std::uint64_t photo,
                                const renderer::Box& box,
                                const renderer::Camera& camera) {
  if (errors.pose_sigma == 0.0) return camera;
  CounterRng rng(errors.seed, RandomDomain::kPhotoPose, photo);
  renderer::Camera believed = camera;
  const renderer::Transform pose = renderer::CameraPose(camera);
  const Vec3 turn = NormalVector(rng, errors.pose_sigma);
  const bool is_empty = box.low.x > box.high.x;
  const double distance = Norm(pose.translation - (is_empty ? Vec3{} : box.Middle()));
  believed.rotation = {};
  believed.world_from_camera = {renderer::RotationFromVector(turn) * pose.linear,
                                pose.translation + NormalVector(rng, errors.pose_sigma * distance)};
  return believed;
}

void WritePhoto(const std::filesystem::path& path, const renderer::Image& linear, int quality) {
  if (path.extension() == ".exr") {
    renderer::WriteExr(path, linear);
  } else if (path.extension() == ".png") {
    renderer::WritePng8(path, EncodedImage(linear));
  } else {
    const std::vector<unsigned char> bytes = renderer::EncodeJpeg(EncodedImage(linear), quality);
    renderer::WriteFileAtomically(path, std::string(bytes.begin(), bytes.end()));
  }
}

}  // namespace pathfit::app
