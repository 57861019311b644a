#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/derivative/film_sink.h"
#include "renderer/renderer.h"
#include "tests/support/test_scenes.h"

namespace pathfit::tests {

/// A camera of one pixel whose rays all leave in the same direction (to 1e-9): it measures the
/// radiance of a point.
inline renderer::Camera ProbeCamera(const renderer::Vec3& origin, const renderer::Vec3& target) {
  return CameraAt(origin, target, 1e9, 1, 1);
}
/// A camera of one pixel of unit size, looking from the origin along -z with focal length
/// `focal_px`.
inline renderer::Camera OnePixelCamera(double focal_px) {
  return CameraAt({0, 0, 0}, {0, 0, -1}, focal_px, 1, 1);
}

inline renderer::Rgba SumOfPixels(const renderer::Film& film) {
  renderer::Rgba sum;
  for (const renderer::Rgba& p : film.pixels) sum += p;
  return sum;
}

/// Sum over the pixels of independent renderings (seeds 0, 1, ...).
inline std::vector<renderer::Rgba> PrimalReplicates(const renderer::Renderer& renderer,
                                                    const renderer::Camera& camera,
                                                    renderer::RenderOptions options,
                                                    int count) {
  std::vector<renderer::Rgba> out;
  for (int i = 0; i < count; ++i) {
    options.seed = static_cast<std::uint64_t>(i);
    out.push_back(SumOfPixels(renderer.RenderPrimal(camera, options)));
  }
  return out;
}

/// Sum over the pixels of independent estimates of the derivative in `direction`.
inline std::vector<renderer::Rgba> DerivativeReplicates(const renderer::Renderer& renderer,
                                                        const renderer::Camera& camera,
                                                        const renderer::ParameterLayout& layout,
                                                        const std::vector<double>& direction,
                                                        renderer::RenderOptions options,
                                                        int count) {
  std::vector<renderer::Rgba> out;
  for (int i = 0; i < count; ++i) {
    options.seed = static_cast<std::uint64_t>(i);
    renderer::FilmSink sink(layout, direction, camera.width, camera.height);
    renderer.RenderDerivative(camera, -1, options, layout, sink);
    out.push_back(SumOfPixels(sink.film()));
  }
  return out;
}

inline std::vector<double> Channel(const std::vector<renderer::Rgba>& values, int channel) {
  std::vector<double> out;
  for (const renderer::Rgba& v : values) out.push_back(v[channel]);
  return out;
}

/// Layout of the vertices of mesh 0 only, and a direction of it from a velocity field of space.
struct VertexMotion {
  renderer::ParameterLayout layout;
  std::vector<double> direction;
};
template <class Velocity>
VertexMotion MoveMesh(const renderer::Scene& scene, Velocity velocity, int mesh = 0) {
  VertexMotion motion{renderer::ParameterLayout(scene), {}};
  motion.layout.Add(renderer::ParameterKind::kVertexPositions, mesh);
  for (const renderer::Vec3& x : scene.meshes[static_cast<std::size_t>(mesh)].mesh.positions) {
    const renderer::Vec3 v = velocity(x);
    motion.direction.insert(motion.direction.end(), {v.x, v.y, v.z});
  }
  return motion;
}

/// What moves, and how fast: parameters of several objects in one direction.
class Motion {
 public:
  explicit Motion(const renderer::Scene& scene) : layout(scene), scene_(&scene) {}

  /// All vertices of a mesh by a velocity field of the object's frame.
  template <class Velocity>
  Motion& Vertices(int mesh, Velocity velocity) {
    layout.Add(renderer::ParameterKind::kVertexPositions, mesh);
    for (const renderer::Vec3& x : scene_->meshes[static_cast<std::size_t>(mesh)].mesh.positions) {
      const renderer::Vec3 v = velocity(x);
      direction.insert(direction.end(), {v.x, v.y, v.z});
    }
    return *this;
  }
  /// A group of one block.
  Motion& Add(renderer::ParameterKind kind, int object, const std::vector<double>& rate) {
    layout.Add(kind, object);
    direction.insert(direction.end(), rate.begin(), rate.end());
    return *this;
  }
  Motion& Add(renderer::ParameterKind kind, int object, const renderer::Vec3& rate) {
    return Add(kind, object, std::vector<double>{rate.x, rate.y, rate.z});
  }

  renderer::ParameterLayout layout;
  std::vector<double> direction;

 private:
  const renderer::Scene* scene_;
};

inline constexpr std::size_t kNumTerms = renderer::kNumDerivativeTerms;
/// Independent estimates of the terms of one derivative, by DerivativeTerm.
struct TermReplicates {
  std::array<std::vector<double>, kNumTerms> terms;

  /// Their sum with a factor for each term: all 1 is the derivative, 0 and -1 are mutants.
  [[nodiscard]] std::vector<double> Total(std::array<double, kNumTerms> factors = {
                                              1, 1, 1, 1, 1}) const {
    std::vector<double> out(terms[0].size());
    for (std::size_t t = 0; t < kNumTerms; ++t) {
      for (std::size_t i = 0; i < out.size(); ++i) out[i] += factors[t] * terms[t][i];
    }
    return out;
  }
};

/// Sum over the pixels of each term's derivative along `motion`, red channel. Sensor 0 of the scene
/// is what moves if camera parameters do; `camera` stands for it.
inline TermReplicates DerivativeByTerm(const renderer::Renderer& renderer,
                                       const renderer::Camera& camera,
                                       const Motion& motion,
                                       renderer::RenderOptions options,
                                       int count) {
  TermReplicates out;
  const int spp = options.spp;
  const int sensor = renderer.scene().sensors.empty() ? -1 : 0;
  for (std::size_t t = 0; t < kNumTerms; ++t) {
    options.terms = {renderer::kDerivativeTerms[t].second};
    options.spp = t == 0 ? spp : 1;
    for (int i = 0; i < count; ++i) {
      options.seed = static_cast<std::uint64_t>(i);
      renderer::FilmSink sink(motion.layout, motion.direction, camera.width, camera.height);
      renderer.RenderDerivative(camera, sensor, options, motion.layout, sink);
      out.terms[t].push_back(SumOfPixels(sink.film()).r);
    }
  }
  return out;
}

/// One mesh of one material under the given lights.
inline renderer::Scene SceneOf(const renderer::Mesh& mesh,
                               const renderer::Bsdf& bsdf,
                               const renderer::Rgb& base_color,
                               std::vector<renderer::Emitter> emitters) {
  renderer::Scene scene;
  scene.meshes = {{"object", mesh, 0, {}}};
  scene.materials = {{"paint", bsdf, base_color}};
  scene.emitters = std::move(emitters);
  return scene;
}

/// [-half_x, half_x] x [-half_y, half_y] in the plane z = `z`, facing +z.
inline renderer::Mesh Plate(double half_x, double half_y, double z) {
  renderer::Mesh mesh = Rectangle();
  renderer::ApplyTransform({{{half_x, 0, 0}, {0, half_y, 0}, {0, 0, 1}}, {0, 0, z}}, mesh);
  return mesh;
}

/// Radiance l0 + k . w in direction w of the light's own frame, on fine texels.
inline renderer::Emitter LinearEnvironment(double l0, const renderer::Vec3& k, int height = 128) {
  renderer::EnvironmentEmitter environment;
  environment.width = 2 * height;
  environment.height = height;
  environment.texels.clear();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < 2 * height; ++x) {
      const renderer::Vec3 w =
          renderer::EnvironmentDirection({(x + 0.5) / (2 * height), (y + 0.5) / height});
      environment.texels.push_back(renderer::Rgb::Constant(l0 + renderer::Dot(k, w)));
    }
  }
  return {"sky", renderer::LightFrame::kWorld, {}, environment};
}

}  // namespace pathfit::tests
