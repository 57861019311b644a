#pragma once

#include <vector>

#include <gtest/gtest.h>

#include "renderer/derivative/film_sink.h"
#include "renderer/renderer.h"
#include "tests/support/closed_forms_camera.h"
#include "tests/support/probe.h"
#include "tests/support/statistics.h"

namespace pathfit::tests {

/// One object's parameter and the direction in which it changes.
struct ParameterMotion {
  renderer::ParameterLayout layout;
  std::vector<double> direction;
};
inline ParameterMotion Change(const renderer::Scene& scene,
                              renderer::ParameterKind kind,
                              std::vector<double> direction,
                              int object = 0) {
  ParameterMotion motion{renderer::ParameterLayout(scene), std::move(direction)};
  motion.layout.Add(kind, object);
  return motion;
}
/// Mesh 0 as a whole.
inline ParameterMotion Translate(const renderer::Scene& scene, const renderer::Vec3& v) {
  return Change(scene, renderer::ParameterKind::kObjectTranslation, {v.x, v.y, v.z});
}

/// Derivative images of the scene's first sensor, seeds 0, 1, ...
inline std::vector<renderer::Film> DerivativeFilms(const renderer::Scene& scene,
                                                   const ParameterMotion& motion,
                                                   renderer::RenderOptions options,
                                                   int count) {
  const renderer::Renderer renderer(scene);
  const renderer::Camera& camera = scene.sensors.at(0);
  std::vector<renderer::Film> films;
  for (int i = 0; i < count; ++i) {
    options.seed = static_cast<std::uint64_t>(i);
    renderer::FilmSink sink(motion.layout, motion.direction, camera.width, camera.height);
    renderer.RenderDerivative(camera, 0, options, motion.layout, sink);
    films.push_back(sink.film());
  }
  return films;
}
/// One channel of their sums over pixels.
inline std::vector<double> SumsOf(const std::vector<renderer::Film>& films, int channel) {
  std::vector<double> sums;
  for (const renderer::Film& film : films) sums.push_back(SumOfPixels(film)[channel]);
  return sums;
}

/// The estimators named here and no others.
inline renderer::DerivativeTerms Terms(bool interior, bool primary, bool pixel) {
  renderer::DerivativeTerms terms = {};
  terms.Set(renderer::DerivativeTerm::kInterior, interior);
  terms.Set(renderer::DerivativeTerm::kPrimary, primary);
  terms.Set(renderer::DerivativeTerm::kDirect, false);
  terms.Set(renderer::DerivativeTerm::kIndirect, false);
  terms.Set(renderer::DerivativeTerm::kPixel, pixel);
  return terms;
}

/// |mean| < 4 sigma with sigma below `sharpness`, or exactly zero up to rounding.
inline ::testing::AssertionResult AgreesWithZero(const std::vector<double>& replicates,
                                                 double sharpness) {
  const MeanAndError m = EstimateMean(replicates);
  const bool fine = std::abs(m.mean) <= std::max(4.0 * m.error, 1e-12) && m.error < sharpness;
  return (fine ? ::testing::AssertionSuccess() : ::testing::AssertionFailure())
         << "mean " << m.mean << " +- " << m.error;
}

/// The filters of C12 and C30.
inline std::vector<renderer::PixelFilter> ThreeFilters() {
  using Shape = renderer::PixelFilter::Shape;
  return {{Shape::kBox, 0.5, 0.5}, {Shape::kTent, 1.0, 0.5}, {Shape::kGaussian, 1.5, 0.5}};
}
inline Filter1D ClosedForm(const renderer::PixelFilter& filter) {
  using Shape = renderer::PixelFilter::Shape;
  const Filter1D::Kind kind = filter.shape == Shape::kBox    ? Filter1D::Kind::kBox
                              : filter.shape == Shape::kTent ? Filter1D::Kind::kTent
                                                             : Filter1D::Kind::kGauss;
  return {kind, filter.radius, filter.sigma};
}

/// Makes a mesh of the scene shine evenly, and black otherwise.
inline void Shine(renderer::Scene& scene, int mesh, double radiance) {
  renderer::AreaEmitter light;
  light.mesh = mesh;
  light.intensity = renderer::Rgb::Constant(radiance);
  scene.emitters.push_back(
      {"light" + std::to_string(mesh), renderer::LightFrame::kWorld, {}, light});
}

}  // namespace pathfit::tests
