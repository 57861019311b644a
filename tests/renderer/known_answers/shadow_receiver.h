#pragma once

#include <string>
#include <vector>

#include "tests/renderer/known_answers/known_answer.h"

namespace pathfit::tests {

/// Indices of terms.
inline constexpr std::size_t kInterior = 0;
inline constexpr std::size_t kDirect = 2;
inline constexpr std::size_t kIndirect = 3;

/// A piece of a white floor under things that shade it, and what it must show.
class ShadowReceiver : public ::testing::Test {
 protected:
  ShadowReceiver() {
    options_.max_bounces = 1;
    options_.spp = 4096;
    options_.sppe = 64;
    options_.spp_direct = 16384;
    options_.spp_indirect = 131072;
    options_.spp_pixel = 16384;
  }
  [[nodiscard]] const renderer::Camera& Sensor() const { return floor_.scene.sensors[0]; }

  void ExpectValue(const Known& known) const {
    const renderer::Renderer renderer(floor_.scene);
    ExpectKnown("E",
                Irradiance(Channel(PrimalReplicates(renderer, Sensor(), options_, kReplicates), 0)),
                known);
  }
  TermReplicates ExpectDerivative(const std::string& name,
                                  const Motion& motion,
                                  const Known& known) const {
    const renderer::Renderer renderer(floor_.scene);
    TermReplicates found = DerivativeByTerm(renderer, Sensor(), motion, options_, kReplicates);
    ExpectKnown(name, Irradiance(found.Total()), known);
    return found;
  }
  /// The whole derivative comes from one term. Faces along which light shines are lit by rounding.
  static void ExpectOnly(std::size_t term, const TermReplicates& found) {
    constexpr double kRounding = 1e-15;
    for (std::size_t t = 0; t < kNumTerms; ++t) {
      if (t == term) continue;
      for (const double value : found.terms[t]) EXPECT_NEAR(value, 0.0, kRounding) << "term " << t;
    }
  }
  static Motion& Move(Motion& motion, int mesh, const Vec3& v) {
    return motion.Vertices(mesh, [v](const Vec3&) { return v; });
  }

  static constexpr int kReplicates = 20;

  FloorScene floor_;
  renderer::RenderOptions options_;
};

/// Average over the piece of the floor.
template <class F>
double Average(const F& at, double x0, double x1, double y0, double y1) {
  return Integrate2D(at, x0, x1, y0, y1, 2, 2) / ((x1 - x0) * (y1 - y0));
}

}  // namespace pathfit::tests
