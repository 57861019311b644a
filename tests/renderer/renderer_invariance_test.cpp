#include <cmath>

#include <gtest/gtest.h>

#include "renderer/renderer.h"
#include "tests/support/statistics.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::renderer_invariance_test {
namespace {

std::vector<Film> Replicates(const Scene& scene,
                             const Camera& camera,
                             RenderOptions options,
                             int count) {
  const Renderer renderer(scene);
  std::vector<Film> films;
  for (int i = 0; i < count; ++i) {
    options.seed = static_cast<std::uint64_t>(i);
    films.push_back(renderer.RenderPrimal(camera, options));
  }
  return films;
}

std::vector<double> PixelOf(const std::vector<Film>& films, std::size_t pixel, int channel) {
  std::vector<double> values;
  for (const Film& film : films) values.push_back(film.pixels[pixel][channel]);
  return values;
}

/// z statistics of the difference of two sets of renderings, pixel by pixel.
struct ZScores {
  double rms = 0.0, max = 0.0, signal_to_noise = 0.0;
};
ZScores CompareImages(const std::vector<Film>& a, const std::vector<Film>& b) {
  ZScores z;
  double count = 0.0, signal = 0.0, noise = 0.0;
  for (std::size_t pixel = 0; pixel < a[0].pixels.size(); ++pixel) {
    for (int c = 0; c < 4; ++c) {
      const tests::MeanAndError x = tests::EstimateMean(PixelOf(a, pixel, c));
      const tests::MeanAndError y = tests::EstimateMean(PixelOf(b, pixel, c));
      const double error = std::hypot(x.error, y.error);
      if (error <= 1e-12 && std::abs(x.mean - y.mean) <= 1e-9) continue;
      const double score = std::abs(x.mean - y.mean) / std::max(error, 1e-12);
      z.rms += score * score;
      z.max = std::max(z.max, score);
      signal += x.mean * x.mean;
      noise += error * error;
      count += 1.0;
    }
  }
  z.rms = std::sqrt(z.rms / count);
  z.signal_to_noise = std::sqrt(signal / noise);
  return z;
}

RenderOptions Options(int spp) {
  RenderOptions options;
  options.spp = spp;
  options.max_bounces = 3;
  return options;
}

TEST(RendererInvariance, RigidMotionOfEverythingChangesNothing) {
  const Scene scene = tests::BallAndWall();
  const Transform motion{RotationAboutAxis(Normalized(Vec3{1, -2, 0.5}), 1.3), {5.0, -3.0, 2.0}};
  Scene moved = scene;
  for (SceneMesh& m : moved.meshes) ApplyTransform(motion, m.mesh);
  for (Emitter& e : moved.emitters) {
    if (e.frame == LightFrame::kCamera) continue;
    if (auto* sky = std::get_if<EnvironmentEmitter>(&e.light)) {
      sky->frame_from_light = motion.linear * sky->frame_from_light;
    } else if (auto* lamp = std::get_if<PointEmitter>(&e.light)) {
      lamp->position = motion.Point(lamp->position);
    }
  }
  moved.sensors[0].world_from_camera = motion * scene.sensors[0].world_from_camera;
  const ZScores z = CompareImages(Replicates(scene, scene.sensors[0], Options(32), 24),
                                  Replicates(moved, moved.sensors[0], Options(32), 24));
  // Common random numbers make both nearly equal; the bound is one-sided.
  EXPECT_LT(z.rms, 1.2);
  EXPECT_LT(z.max, 6.0);
  EXPECT_GT(z.signal_to_noise, 50.0);
}

TEST(RendererInvariance, SubdividingAWallChangesNothing) {
  Scene scene = tests::BallAndWall();
  Scene split = scene;
  Mesh& wall = split.meshes[1].mesh;
  // A vertex in the middle: four triangles instead of two, on the same plane.
  const Vec3 middle = (wall.positions[0] + wall.positions[2]) * 0.5;
  wall.positions.push_back(middle);
  wall.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  wall.uvs.clear();
  wall.uv_triangles.clear();
  const ZScores z = CompareImages(Replicates(scene, scene.sensors[0], Options(32), 24),
                                  Replicates(split, split.sensors[0], Options(32), 24));
  EXPECT_LT(z.rms, 1.2);
  EXPECT_LT(z.max, 6.0);
}

TEST(RendererInvariance, CropsAndScaledViewsShowTheSameImage) {
  const Scene scene = tests::BallAndWall();
  const Camera& camera = scene.sensors[0];
  const auto full = Replicates(scene, camera, Options(32), 24);
  const auto crop = Replicates(scene, CroppedCamera(camera, 6, 4, 10, 12), Options(32), 24);
  const auto half = Replicates(scene, ScaledCamera(camera, 12, 12), Options(128), 24);
  std::vector<Film> part;
  std::vector<Film> averaged;
  for (const Film& film : full) {
    const auto at = [&](int x, int y) { return film.pixels[static_cast<std::size_t>(24 * y + x)]; };
    Film cut(10, 12);
    Film down(12, 12);
    for (int y = 0; y < 12; ++y) {
      for (int x = 0; x < 10; ++x)
        cut.pixels[static_cast<std::size_t>(10 * y + x)] = at(x + 6, y + 4);
      for (int x = 0; x < 12; ++x) {
        Rgba sum = at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) +
                   at(2 * x + 1, 2 * y + 1);
        down.pixels[static_cast<std::size_t>(12 * y + x)] = sum * 0.25;
      }
    }
    part.push_back(cut);
    averaged.push_back(down);
  }
  EXPECT_LT(CompareImages(crop, part).rms, 1.2);
  EXPECT_LT(CompareImages(half, averaged).rms, 1.2);
}

/// Root mean square over pixels of the deviation from a long rendering.
TEST(RendererInvariance, MeanOfManySeedsConvergesAsOneOverTheSquareRoot) {
  const Scene scene = tests::BallAndWall();
  const Camera& camera = scene.sensors[0];
  const auto films = Replicates(scene, camera, Options(4), 512);
  RenderOptions options = Options(16384);
  options.seed = 99999;
  const Film truth = Renderer(scene).RenderPrimal(camera, options);
  const auto error_of_means = [&](std::size_t group) {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t first = 0; first + group <= films.size(); first += group) {
      for (std::size_t pixel = 0; pixel < truth.pixels.size(); ++pixel) {
        double mean = 0.0;
        for (std::size_t i = first; i < first + group; ++i)
          mean += films[i].pixels[pixel].g / static_cast<double>(group);
        sum += (mean - truth.pixels[pixel].g) * (mean - truth.pixels[pixel].g);
        count += 1.0;
      }
    }
    return std::sqrt(sum / count);
  };
  const double slope = std::log(error_of_means(64) / error_of_means(1)) / std::log(64.0);
  RecordProperty("slope", std::to_string(slope));
  EXPECT_NEAR(slope, -0.5, 0.1);
}

TEST(RendererInvariance, LatticeIsNoNoisierThanIndependentSamples) {
  const Scene scene = tests::BallAndWall();
  const Camera& camera = scene.sensors[0];
  constexpr int kSpp = 64;
  const auto lattice = Replicates(scene, camera, Options(kSpp), 32);
  const auto single = Replicates(scene, camera, Options(1), 256);
  double variance_lattice = 0.0;
  double variance_single = 0.0;
  for (std::size_t pixel = 0; pixel < lattice[0].pixels.size(); ++pixel) {
    const auto variance = [&](const std::vector<Film>& films) {
      const double error = tests::EstimateMean(PixelOf(films, pixel, 1)).error;
      return error * error * static_cast<double>(films.size());
    };
    variance_lattice += variance(lattice);
    variance_single += variance(single);
  }
  const double ratio = variance_lattice / (variance_single / kSpp);
  std::printf("variance of %d lattice samples over independent samples: %.3f\n", kSpp, ratio);
  EXPECT_LT(ratio, 1.0);
}

}  // namespace
}  // namespace pathfit::renderer::renderer_invariance_test
