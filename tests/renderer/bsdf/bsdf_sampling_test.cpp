#include <numbers>

#include <gtest/gtest.h>

#include "renderer/bsdf/bsdf.h"
#include "renderer/math/frame.h"
#include "renderer/math/warp.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer {
namespace {

constexpr int kRows = 10;     // in cos(theta)
constexpr int kColumns = 16;  // in azimuth
constexpr int kDraws = 60000;

struct Case {
  double roughness, metallic, cos_o;
};

const std::vector<Case>& Cases() {
  static const std::vector<Case> cases = [] {
    std::vector<Case> list;
    for (const double roughness : {0.15, 0.3, 0.6, 1.0}) {
      for (const double metallic : {0.0, 0.5, 1.0}) {
        for (const double cos_o : {0.15, 0.6, 0.98}) list.push_back({roughness, metallic, cos_o});
      }
    }
    return list;
  }();
  return cases;
}

Vec3 DirectionAt(double cos_theta, double phi) {
  const double s = std::sqrt(std::max(0.0, 1.0 - cos_theta * cos_theta));
  return {s * std::cos(phi), s * std::sin(phi), cos_theta};
}

/// Counts of SampleBsdf in the cells of the hemisphere (the last slot: draws below the surface)
/// against the integral of BsdfPdf. `fine`: integration points per cell and axis; a lobe of alpha =
/// roughness^2 must not fall between them.
::testing::AssertionResult SamplesFollowPdf(
    const Bsdf& bsdf, double cos_o, int fine, std::uint64_t seed, int suite) {
  const Rgb base{0.9, 0.6, 0.2};
  const Vec3 n = Normalized(Vec3{0.3, -0.5, 0.7});
  const Frame frame = Frame::FromNormal(n);
  const Vec3 wo_local = DirectionAt(cos_o, 0.7);
  const Vec3 wo = frame.ToWorld(wo_local);
  std::vector<double> observed(kRows * kColumns + 1);
  std::vector<double> expected(kRows * kColumns + 1);
  CounterRng rng(seed, 0, 0, 0, 0);
  for (int i = 0; i < kDraws; ++i) {
    const double u0 = rng.Next();
    const double u1 = rng.Next();
    const auto sample = SampleBsdf(bsdf, base, n, wo, u0, u1, rng.Next());
    if (!sample) {
      observed.back() += 1.0;
      continue;
    }
    const Vec3 local = frame.ToLocal(sample->wi);
    const double again = BsdfPdf(bsdf, base, {local.z, cos_o, Dot(local, wo_local)});
    if (std::abs(Norm(local) - 1.0) > 1e-12 || std::abs(again - sample->pdf) > 1e-8 * again) {
      return ::testing::AssertionFailure()
             << "pdf of the sample " << sample->pdf << ", BsdfPdf " << again;
    }
    const double turn = std::atan2(local.y, local.x) * 0.5 * std::numbers::inv_pi + 0.5;
    const int row = std::min(kRows - 1, static_cast<int>(local.z * kRows));
    const int column = std::min(kColumns - 1, static_cast<int>(turn * kColumns));
    observed[static_cast<std::size_t>(row * kColumns + column)] += 1.0;
  }
  double above = 0.0;
  for (int row = 0; row < kRows * fine; ++row) {
    for (int column = 0; column < kColumns * fine; ++column) {
      const double cos_theta = (row + 0.5) / (kRows * fine);
      const double phi = 2.0 * std::numbers::pi * ((column + 0.5) / (kColumns * fine) - 0.5);
      const Vec3 wi = DirectionAt(cos_theta, phi);
      const double p = BsdfPdf(bsdf, base, {wi.z, cos_o, Dot(wi, wo_local)}) * 2.0 *
                       std::numbers::pi / (kRows * fine * kColumns * fine);
      expected[static_cast<std::size_t>((row / fine) * kColumns + column / fine)] += kDraws * p;
      above += p;
    }
  }
  expected.back() = kDraws * std::max(0.0, 1.0 - above);
  return tests::ChiSquareAccepts(observed, expected, suite);
}

TEST(BsdfSampling, MetallicRoughnessFollowsItsPdf) {
  const int suite = static_cast<int>(Cases().size()) + 2;
  std::uint64_t seed = 0;
  for (const Case& s : Cases()) {
    EXPECT_TRUE(SamplesFollowPdf(MetallicRoughnessBsdf{s.roughness, s.metallic},
                                 s.cos_o,
                                 s.roughness < 0.2 ? 120 : 24,
                                 ++seed,
                                 suite))
        << "roughness " << s.roughness << " metallic " << s.metallic << " cos_o " << s.cos_o;
  }
}

TEST(BsdfSampling, LambertFollowsItsPdf) {
  const int suite = static_cast<int>(Cases().size()) + 2;
  EXPECT_TRUE(SamplesFollowPdf(LambertBsdf{}, 0.9, 24, 100, suite));
  EXPECT_TRUE(SamplesFollowPdf(LambertBsdf{}, 0.1, 24, 101, suite));
}

/// Directional albedo of a white surface by the product of sampling: never above one.
double Albedo(const Bsdf& bsdf, double cos_o) {
  const Vec3 n{0, 0, 1};
  const Vec3 wo = DirectionAt(cos_o, 0.3);
  const Rgb white{1, 1, 1};
  double sum = 0.0;
  constexpr int kSamples = 100000;
  CounterRng rng(11, 0, 0, 0, 0);
  for (int i = 0; i < kSamples; ++i) {
    const double u0 = rng.Next();
    const double u1 = rng.Next();
    const auto sample = SampleBsdf(bsdf, white, n, wo, u0, u1, rng.Next());
    if (sample) {
      const BsdfCosines c{sample->wi.z, wo.z, Dot(sample->wi, wo)};
      sum += EvalBsdf(bsdf, white, c).r * c.cos_i / sample->pdf;
    }
  }
  return sum / kSamples;
}

/// A white metal is the bare GGX lobe. (White dielectrics may gain at grazing angles: glTF's mix of
/// diffuse and specular takes its Fresnel factor at the half vector for both, see THEORY.md.)
TEST(BsdfSampling, GgxReflectsNoMoreThanItReceives) {
  for (const Case& s : Cases()) {
    const double albedo = Albedo(MetallicRoughnessBsdf{s.roughness, 1.0}, s.cos_o);
    // Five standard errors at 1e5 samples of a weight below one.
    EXPECT_LT(albedo, 1.0 + 5e-3) << s.roughness << " " << s.cos_o;
    EXPECT_GT(albedo, s.roughness < 0.5 ? 0.8 : 0.25)
        << "single scattering loses energy at high roughness";
  }
}

TEST(BsdfSampling, LambertReflectsAll) {
  EXPECT_NEAR(Albedo(LambertBsdf{}, 0.5), 1.0, 1e-9)
      << "cosine sampling of a Lambertian has no variance";
}

}  // namespace
}  // namespace pathfit::renderer
