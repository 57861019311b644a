#include <array>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/bsdf/bsdf.h"
#include "renderer/math/frame.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/renderer/bsdf/direction_quadrature.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::bsdf_sampling_test {
namespace {

using tests::DirectionAt;

constexpr int kRows = 20;     // in cos(theta), of the whole sphere
constexpr int kColumns = 16;  // in azimuth
constexpr int kDraws = 60000;
constexpr int kNarrowRows = 60;

constexpr auto kGgx = MicrofacetDistribution::kGgx;
constexpr auto kBeckmann = MicrofacetDistribution::kBeckmann;

struct Case {
  std::string name;
  Bsdf bsdf;
  BsdfInputs inputs;
  double cos_o;
  int fine_rows, fine_columns;  // integration points per cell: no lobe may fall between them
};

bool IsBeckmann(const Bsdf& bsdf) {
  const auto* metal = std::get_if<RoughConductorBsdf>(&bsdf);
  const auto* glass = std::get_if<RoughDielectricBsdf>(&bsdf);
  return (metal != nullptr && metal->distribution == kBeckmann) ||
         (glass != nullptr && glass->distribution == kBeckmann);
}

std::vector<Case> Cases() {
  std::vector<Case> list;
  const Rgb base{0.9, 0.6, 0.2};
  const auto add = [&](const char* name, const Bsdf& bsdf, const BsdfInputs& in, double cos_o) {
    const bool narrow = in.roughness < 0.2 || (IsTransmissive(bsdf) && in.roughness < 0.4);
    const bool grazing = cos_o < 0.05;  // the density is large at the horizon only
    list.push_back({std::string(name) + (IsBeckmann(bsdf) ? " (Beckmann)" : "") +
                        (" roughness " + std::to_string(in.roughness)) + " metallic " +
                        std::to_string(in.metallic) + (in.from_inside ? " inside" : "") +
                        " cos_o " + std::to_string(cos_o),
                    bsdf,
                    in,
                    cos_o,
                    grazing ? 120 : (narrow ? kNarrowRows : 24),
                    narrow || grazing ? 96 : 24});
  };
  for (const double roughness : {0.15, 0.3, 1.0}) {
    for (const double metallic : {0.0, 0.5, 1.0}) {
      for (const double cos_o : {0.15, 0.6, 0.98})
        add("gltf", MetallicRoughnessBsdf{}, {base, roughness, metallic}, cos_o);
    }
  }
  for (const double roughness : {0.3, 0.6, 1.0}) {
    for (const double cos_o : {0.15, 0.6, 0.98}) {
      add("conductor", RoughConductorBsdf{}, {base, roughness}, cos_o);
      add("dielectric", RoughDielectricBsdf{0.5, 1.5}, {base, roughness}, cos_o);
      add("dielectric", RoughDielectricBsdf{0.5, 1.5}, {base, roughness, 0.0, true}, cos_o);
      add("dielectric", RoughDielectricBsdf{0.5, 0.7}, {base, roughness, 0.0, true}, cos_o);
    }
  }
  // Interpolated normals: below the least cosine, and behind the surface.
  for (const double cos_o : {0.005, -0.2}) {
    add("gltf", MetallicRoughnessBsdf{}, {base, 0.5, 0.5}, cos_o);
    add("conductor", RoughConductorBsdf{}, {base, 0.5}, cos_o);
    add("dielectric", RoughDielectricBsdf{}, {base, 0.5}, cos_o);
  }
  for (const double cos_o : {0.9, 0.1, -0.1}) add("lambert", LambertBsdf{}, {base}, cos_o);
  for (const double roughness : {0.3, 0.6, 1.0}) {
    for (const double cos_o : {0.15, 0.6, 0.98}) {
      add("conductor", RoughConductorBsdf{.distribution = kBeckmann}, {base, roughness}, cos_o);
      add("dielectric", RoughDielectricBsdf{0.5, 1.5, kBeckmann}, {base, roughness}, cos_o);
    }
  }
  return list;
}

std::size_t Cell(const Vec3& local) {
  const double turn = std::atan2(local.y, local.x) * 0.5 * std::numbers::inv_pi + 0.5;
  const int row = std::min(kRows - 1, static_cast<int>((0.5 * local.z + 0.5) * kRows));
  const int column = std::min(kColumns - 1, static_cast<int>(turn * kColumns));
  return static_cast<std::size_t>(row * kColumns + column);
}

/// Counts of SampleBsdf in the cells of the sphere (the last slot: absorbed draws) against the
/// integral of its density; `mirrored` draws have the density 2 MirroredPairPdf - BsdfPdf.
::testing::AssertionResult SamplesFollowPdf(const Case& at,
                                            bool mirrored,
                                            std::uint64_t seed,
                                            int suite) {
  const Vec3 n = Normalized(Vec3{0.3, -0.5, 0.7});
  const Frame frame = Frame::FromNormal(n);
  const Vec3 wo_local = DirectionAt(at.cos_o, 0.7);
  const Vec3 wo = frame.ToWorld(wo_local);
  std::vector<double> observed(kRows * kColumns + 1);
  std::vector<double> expected(kRows * kColumns + 1);
  CounterRng rng(seed);
  for (int i = 0; i < kDraws; ++i) {
    const double u0 = rng.Next();
    const double u1 = rng.Next();
    const auto sample = SampleBsdf(at.bsdf, at.inputs, n, wo, u0, u1, rng.Next(), mirrored);
    if (!sample) {
      observed.back() += 1.0;
      continue;
    }
    const BsdfCosines c{Dot(n, sample->wi), Dot(n, wo), Dot(sample->wi, wo)};
    const double again = BsdfPdf(at.bsdf, at.inputs, c);
    if (std::abs(Norm(sample->wi) - 1.0) > 1e-12 || std::abs(again - sample->pdf) > 1e-7 * again ||
        sample->delta) {
      return ::testing::AssertionFailure()
             << "pdf of the sample " << sample->pdf << ", BsdfPdf " << again;
    }
    observed[Cell(frame.ToLocal(sample->wi))] += 1.0;
  }
  const int rows = kRows * at.fine_rows;
  const int columns = kColumns * at.fine_columns;
  double total = 0.0;
  for (int row = IsTransmissive(at.bsdf) ? 0 : rows / 2; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double cos_theta = 2.0 * (row + 0.5) / rows - 1.0;
      const Vec3 wi =
          DirectionAt(cos_theta, 2.0 * std::numbers::pi * ((column + 0.5) / columns - 0.5));
      const BsdfCosines c{wi.z, at.cos_o, Dot(wi, wo_local)};
      double p = BsdfPdf(at.bsdf, at.inputs, c);
      if (mirrored) {
        p = 2.0 * MirroredPairPdf(at.bsdf, at.inputs, c) - p;
      }
      p *= 4.0 * std::numbers::pi / (static_cast<double>(rows) * columns);
      expected[Cell(wi)] += kDraws * p;
      total += p;
    }
  }
  if (total > 1.0 + 2e-3) {
    return ::testing::AssertionFailure() << "the density integrates to " << total;
  }
  expected.back() = kDraws * std::max(0.0, 1.0 - total);
  return tests::ChiSquareAccepts(observed, expected, suite);
}

TEST(BsdfSampling, FollowsItsDensity) {
  const std::vector<Case> cases = Cases();
  std::uint64_t seed = 0;
  for (const Case& at : cases) {
    EXPECT_TRUE(SamplesFollowPdf(at, false, ++seed, static_cast<int>(2 * cases.size()))) << at.name;
  }
}

TEST(BsdfSampling, MirroredFollowsItsDensity) {
  const std::vector<Case> cases = Cases();
  std::uint64_t seed = 1000;
  for (const Case& at : cases) {
    if (at.fine_rows == kNarrowRows) continue;  // the same formulas, dear to integrate
    EXPECT_TRUE(SamplesFollowPdf(at, true, ++seed, static_cast<int>(2 * cases.size()))) << at.name;
  }
}

/// The same where lobes are narrow, in cells of the half vector's slope over alpha; reflected and
/// refracted draws apart. The density of wi is taken to that of h by its solid angle per that of h:
/// 4 wo.h for reflection, (wo + e wi)^2 / (e^2 |wi.h|) for refraction [Walter2007].
TEST(BsdfSampling, NarrowLobesFollowTheirDensity) {
  constexpr int kRadii = 12;  // in 1 - 1 / sqrt(1 + r^2): of GGX at grazing view all are full
  constexpr int kTurns = 8;
  constexpr int kFine = 24;  // integration points per cell and axis
  constexpr int kNarrowDraws = 40000;
  constexpr int kSuite = 36;
  const auto cell = [](double share, double turn, bool refracted) {
    const int radius = std::min(kRadii - 1, static_cast<int>(share * kRadii));
    const int column = std::min(kTurns - 1, static_cast<int>(turn * kTurns));
    return static_cast<std::size_t>(((refracted ? kRadii : 0) + radius) * kTurns + column);
  };
  std::uint64_t seed = 500;
  for (const MicrofacetDistribution distribution : {kGgx, kBeckmann}) {
    for (const double eta : {0.0, 1.5, 1.0 / 1.5}) {  // 0: metal
      const Bsdf bsdf = eta == 0.0 ? Bsdf{RoughConductorBsdf{.distribution = distribution}}
                                   : Bsdf{RoughDielectricBsdf{0.5, eta, distribution}};
      for (const double roughness : {kMinRoughness, 0.1}) {
        for (const double cos_o : {kMinCosO, 0.1, 0.9}) {
          const double alpha = roughness * roughness;
          const BsdfInputs in{{1, 1, 1}, roughness};
          const Vec3 wo = DirectionAt(cos_o, 0.4);
          std::vector<double> observed(2 * kRadii * kTurns + 1);
          std::vector<double> expected(observed.size());
          CounterRng rng(++seed);
          for (int i = 0; i < kNarrowDraws; ++i) {
            const double u0 = rng.Next();
            const double u1 = rng.Next();
            const auto sample = SampleBsdf(bsdf, in, {0, 0, 1}, wo, u0, u1, rng.Next());
            if (!sample) {
              observed.back() += 1.0;
              continue;
            }
            const bool refracted = sample->wi.z < 0.0;
            Vec3 h = Normalized(refracted ? wo + sample->wi * eta : wo + sample->wi);
            if (h.z < 0.0) h = -h;
            const double r2 = (h.x * h.x + h.y * h.y) / (h.z * h.z * alpha * alpha);
            const double turn = std::atan2(h.y, h.x) * 0.5 * std::numbers::inv_pi + 0.5;
            observed[cell(1.0 - 1.0 / std::sqrt(1.0 + r2), turn, refracted)] += 1.0;
          }
          double total = 0.0;
          for (int i = 0; i < kRadii * kFine; ++i) {
            for (int j = 0; j < kTurns * kFine; ++j) {
              const double share = (i + 0.5) / (kRadii * kFine);
              const double turn = (j + 0.5) / (kTurns * kFine);
              const double rest = 1.0 - share;
              const double r = alpha * std::sqrt(1.0 / (rest * rest) - 1.0);
              const double phi = 2.0 * std::numbers::pi * (turn - 0.5);
              const Vec3 h = Normalized(Vec3{r * std::cos(phi), r * std::sin(phi), 1.0});
              const double facing = Dot(wo, h);
              if (facing <= 0.0) continue;
              // d(share) d(turn) to area of slopes to solid angle of h.
              const double solid_angle = 2.0 * std::numbers::pi * alpha * alpha /
                                         (rest * rest * rest) * h.z * h.z * h.z /
                                         (kRadii * kFine * kTurns * kFine);
              const auto add = [&](const Vec3& wi, double by_h, bool refracted) {
                const double p = BsdfPdf(bsdf, in, {wi.z, cos_o, Dot(wi, wo)}) * by_h * solid_angle;
                expected[cell(share, turn, refracted)] += kNarrowDraws * p;
                total += p;
              };
              const Vec3 mirrored = h * (2.0 * facing) - wo;
              if (mirrored.z > 0.0) add(mirrored, 4.0 * facing, false);
              const double refracted2 =
                  eta == 0.0 ? -1.0 : 1.0 - (1.0 - facing * facing) / (eta * eta);
              if (refracted2 <= 0.0) continue;
              const double cos_refracted = std::sqrt(refracted2);
              const Vec3 wi = h * (facing / eta - cos_refracted) - wo / eta;
              const double sum = facing - eta * cos_refracted;
              if (wi.z < 0.0) add(wi, sum * sum / (eta * eta * cos_refracted), true);
            }
          }
          ASSERT_LT(total, 1.0 + 2e-3);
          expected.back() = kNarrowDraws * std::max(0.0, 1.0 - total);
          EXPECT_TRUE(tests::ChiSquareAccepts(observed, expected, kSuite))
              << (distribution == kBeckmann ? "Beckmann" : "GGX") << " eta " << eta << " roughness "
              << roughness << " cos_o " << cos_o << " total " << total;
        }
      }
    }
  }
}

/// Directional albedo of a white surface by the product of sampling: never above one.
double Albedo(const Bsdf& bsdf, const BsdfInputs& in, double cos_o) {
  const Vec3 n{0, 0, 1};
  const Vec3 wo = DirectionAt(cos_o, 0.3);
  double sum = 0.0;
  constexpr int kSamples = 50000;
  CounterRng rng(11);
  for (int i = 0; i < kSamples; ++i) {
    const double u0 = rng.Next();
    const double u1 = rng.Next();
    const auto sample = SampleBsdf(bsdf, in, n, wo, u0, u1, rng.Next());
    if (sample) {
      const BsdfCosines c{sample->wi.z, wo.z, Dot(sample->wi, wo)};
      sum += EvalBsdf(bsdf, in, c).r * c.cos_i / sample->pdf;
    }
  }
  return sum / kSamples;
}

/// A white metal is the bare lobe. (White dielectrics may gain at grazing angles: glTF's mix of
/// diffuse and specular takes its Fresnel factor at the half vector for both, see THEORY.md.)
TEST(BsdfSampling, MetalsReflectNoMoreThanTheyReceive) {
  const RoughConductorBsdf perfect{0.5, {0, 0, 0}, {0, 0, 0}};
  const RoughConductorBsdf beckmann{0.5, {0, 0, 0}, {0, 0, 0}, kBeckmann};
  for (const double roughness : {kMinRoughness, 0.15, 0.3, 0.6, 1.0}) {
    for (const double cos_o : {0.15, 0.6, 0.98}) {
      for (const Bsdf& bsdf : {Bsdf{MetallicRoughnessBsdf{}}, Bsdf{perfect}, Bsdf{beckmann}}) {
        const double albedo = Albedo(bsdf, {{1, 1, 1}, roughness, 1.0}, cos_o);
        // Five standard errors at 5e4 samples of a weight below 1/0.9.
        EXPECT_LT(albedo, 1.0 + 8e-3) << roughness << " " << cos_o;
        EXPECT_GT(albedo, roughness < 0.5 ? 0.8 : 0.25)
            << "single scattering loses energy at high roughness";
      }
    }
  }
}

TEST(BsdfSampling, WeightsOfTheConductorNeverExceedItsColour) {
  const Vec3 wo = DirectionAt(0.3, 0.4);
  const BsdfInputs in{{0.7, 0.7, 0.7}, 0.6};
  CounterRng rng(5);
  for (int i = 0; i < 2000; ++i) {
    const double u0 = rng.Next();
    const double u1 = rng.Next();
    const auto sample = SampleBsdf(RoughConductorBsdf{}, in, {0, 0, 1}, wo, u0, u1, rng.Next());
    if (!sample) continue;
    const BsdfCosines c{sample->wi.z, wo.z, Dot(sample->wi, wo)};
    EXPECT_LE(EvalBsdf(RoughConductorBsdf{}, in, c).r * c.cos_i / sample->pdf, 0.7 + 1e-12);
  }
}

TEST(BsdfSampling, LambertReflectsAll) {
  EXPECT_NEAR(Albedo(LambertBsdf{}, {}, 0.5), 1.0, 1e-9)
      << "cosine sampling of a Lambertian has no variance";
}

}  // namespace
}  // namespace pathfit::renderer::bsdf_sampling_test
