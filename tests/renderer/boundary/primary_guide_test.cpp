#include "renderer/boundary/primary_guide.h"

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/parallel.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::primary_guide_test {
namespace {

using Point = std::array<double, 3>;

struct Integrand {
  const char* name;
  double (*f)(const Point&);
  double integral;
};

double Smooth(const Point& u) { return 3.0 * u[0] * u[0] * 2.0 * u[1] * (0.5 + u[2]); }

/// A box of 1e-4 of the volume, aligned with nothing.
double Spike(const Point& u) {
  constexpr Point kLow = {0.313, 0.627, 0.441};
  constexpr Point kSize = {0.02, 0.1, 0.05};
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) {
    inside = inside && u[i] >= kLow[i] && u[i] < kLow[i] + kSize[i];
  }
  return inside ? 100.0 : 0.01;
}

/// Jumps across a slanted plane.
double Jump(const Point& u) { return u[0] + u[1] < 0.5 ? 4.0 : 0.1; }

/// A hundred stripes across the first axis.
double Stripes(const Point& u) {
  const double x = 100.0 * u[0];
  return x - std::floor(x) < 0.15 ? 1.0 + u[1] : 0.02;
}

std::vector<Integrand> Integrands() {
  return {{"smooth", Smooth, 1.0},
          {"spike", Spike, 100.0 * 1e-4 + 0.01 * (1.0 - 1e-4)},
          {"jump", Jump, 4.0 * 0.125 + 0.1 * 0.875},
          {"stripes", Stripes, 0.15 * 1.5 + 0.85 * 0.02}};
}

PrimaryGuide Learn(GuideKind kind, std::int64_t pilots, double (*f)(const Point&), int dims = 3) {
  return PrimaryGuide::Build(
      kind, dims, pilots, [f](const Point& u, std::int64_t) { return f(u); });
}

std::vector<double> Draws(const PrimaryGuide& guide, double (*f)(const Point&), int count) {
  std::vector<double> values;
  CounterRng rng(9);
  for (int i = 0; i < count; ++i) {
    const double u0 = rng.Next();
    const double u1 = rng.Next();
    const PrimaryGuide::Draw draw = guide.Sample(u0, u1, rng.Next());
    values.push_back(f(draw.u) / draw.pdf);
  }
  return values;
}

double RelativeVariance(const std::vector<double>& values) {
  const tests::MeanAndError m = tests::EstimateMean(values);
  return m.error * m.error * static_cast<double>(values.size()) / (m.mean * m.mean);
}

constexpr std::array<GuideKind, 2> kKinds = {GuideKind::kGrid, GuideKind::kAdaptive};

TEST(PrimaryGuide, UniformByDefaultAndWithoutPilots) {
  const auto zero = [](const Point&, std::int64_t) { return 0.0; };
  for (const PrimaryGuide& guide : {PrimaryGuide(),
                                    PrimaryGuide::Build(GuideKind::kNone, 3, 100, zero),
                                    PrimaryGuide::Build(GuideKind::kAdaptive, 3, 0, zero),
                                    PrimaryGuide::Build(GuideKind::kAdaptive, 3, 1000, zero),
                                    PrimaryGuide::Build(GuideKind::kGrid, 2, 1000, zero)}) {
    const PrimaryGuide::Draw draw = guide.Sample(0.1, 0.7, 0.4);
    EXPECT_EQ(draw.u, (Point{0.1, 0.7, 0.4}));
    EXPECT_EQ(draw.pdf, 1.0);
    EXPECT_EQ(guide.Mass(), 0.0);
  }
}

TEST(PrimaryGuide, MeanDoesNotDependOnTheGuide) {
  for (const Integrand& integrand : Integrands()) {
    for (const GuideKind kind : kKinds) {
      for (const std::int64_t pilots : {1000, 30000}) {
        const PrimaryGuide guide = Learn(kind, pilots, integrand.f);
        EXPECT_TRUE(
            tests::AgreesWithExact(Draws(guide, integrand.f, 400000), integrand.integral, 0.5))
            << integrand.name << " " << pilots;
      }
    }
  }
}

/// The density over a fine lattice of drawn points: its inverse must integrate to the volume.
TEST(PrimaryGuide, DensityIntegratesToOne) {
  for (const Integrand& integrand : Integrands()) {
    for (const GuideKind kind : kKinds) {
      const PrimaryGuide guide = Learn(kind, 20000, integrand.f);
      const auto one = [](const Point&) { return 1.0; };
      EXPECT_TRUE(tests::AgreesWithExact(Draws(guide, one, 200000), 1.0)) << integrand.name;
      CounterRng rng(4);
      for (int i = 0; i < 2000; ++i) {
        const double u0 = rng.Next();
        EXPECT_GE(guide.Sample(u0, rng.Next(), 0.5).pdf, PrimaryGuide::kUniformShare * 0.999);
      }
    }
  }
}

/// Each cell is met as often as its density says, and only inside itself.
TEST(PrimaryGuide, FrequenciesMatchDensity) {
  const PrimaryGuide guide = Learn(GuideKind::kAdaptive, 20000, Jump);
  std::vector<double> observed(64);
  std::vector<double> expected(64);
  CounterRng rng(5);
  const int n = 400000;
  const auto bin = [](const Point& u) {
    return static_cast<std::size_t>(u[0] * 4.0) * 16 + static_cast<std::size_t>(u[1] * 4.0) * 4 +
           static_cast<std::size_t>(u[2] * 4.0);
  };
  std::vector<double> squares(64);
  for (int i = 0; i < n; ++i) {
    const double u0 = rng.Next();
    const double u1 = rng.Next();
    const PrimaryGuide::Draw draw = guide.Sample(u0, u1, rng.Next());
    observed[bin(draw.u)] += 1.0 / draw.pdf / n;
    squares[bin(draw.u)] += 1.0 / (draw.pdf * draw.pdf) / n;
  }
  for (std::size_t i = 0; i < 64; ++i) {
    EXPECT_NEAR(observed[i], 1.0 / 64.0, 5.0 * std::sqrt(squares[i] / n));
  }
}

TEST(PrimaryGuide, ReducesVariance) {
  struct Limit {
    const char* name;
    double (*f)(const Point&);
    double grid, adaptive;  // share of the unguided variance
  };
  for (const Limit& limit : {Limit{"smooth", Smooth, 0.5, 0.1},
                             Limit{"jump", Jump, 0.5, 0.1},
                             Limit{"stripes", Stripes, 0.5, 0.5},
                             Limit{"spike", Spike, 10.0, 0.2}}) {
    const double none = RelativeVariance(Draws({}, limit.f, 400000));
    const std::int64_t pilots = 65536;
    const double grid =
        RelativeVariance(Draws(Learn(GuideKind::kGrid, pilots, limit.f), limit.f, 200000));
    const double adaptive =
        RelativeVariance(Draws(Learn(GuideKind::kAdaptive, pilots, limit.f), limit.f, 200000));
    EXPECT_LT(grid, limit.grid * none) << limit.name;
    EXPECT_LT(adaptive, limit.adaptive * none) << limit.name;
  }
}

TEST(PrimaryGuide, StratifiedNumbersStayStratified) {
  for (const GuideKind kind : kKinds) {
    const PrimaryGuide guide = Learn(kind, 20000, Smooth, 1);
    double last = -1.0;
    for (int i = 0; i < 10000; ++i) {
      const PrimaryGuide::Draw draw = guide.Sample((i + 0.5) / 10000, 0.25, 0.75);
      EXPECT_GT(draw.u[0], last);
      EXPECT_EQ(draw.u[1], 0.25) << "not guided";
      EXPECT_EQ(draw.u[2], 0.75) << "not guided";
      last = draw.u[0];
    }
    const PrimaryGuide::Draw end = guide.Sample(1.0 - 0x1.0p-53, 1.0 - 0x1.0p-53, 0.0);
    EXPECT_LT(end.u[0], 1.0);
    EXPECT_LT(end.u[1], 1.0);
  }
}

/// Pilots that miss a region by chance: it is drawn all the same, with bounded weights.
TEST(PrimaryGuide, RegionWithoutPilotsStillContributes) {
  const auto hidden = [](const Point& u) { return u[0] > 0.9 ? 3.0 : 1.0; };
  for (const GuideKind kind : kKinds) {
    const PrimaryGuide guide = PrimaryGuide::Build(
        kind, 3, 20000, [](const Point& u, std::int64_t) { return u[0] > 0.9 ? 0.0 : 1.0; });
    const std::vector<double> values = Draws(guide, hidden, 200000);
    EXPECT_TRUE(tests::AgreesWithExact(values, 1.2));
    for (const double value : values) {
      ASSERT_LE(value, 3.0 / PrimaryGuide::kUniformShare * 1.001);
    }
  }
}

TEST(PrimaryGuide, NonFinitePilotsAreIgnored) {
  for (const GuideKind kind : kKinds) {
    const PrimaryGuide guide =
        PrimaryGuide::Build(kind, 3, 10000, [](const Point& u, std::int64_t i) {
          const double bad = i % 2 == 0 ? std::nan("") : std::numeric_limits<double>::infinity();
          return i % 10 < 2 ? bad : Smooth(u);
        });
    EXPECT_NEAR(guide.Mass(), 1.0, 0.1);
    EXPECT_TRUE(tests::AgreesWithExact(Draws(guide, Smooth, 100000), 1.0));
    const PrimaryGuide none =
        PrimaryGuide::Build(kind, 3, 1000, [](const Point&, std::int64_t) { return std::nan(""); });
    EXPECT_EQ(none.Sample(0.5, 0.5, 0.5).pdf, 1.0);
    EXPECT_EQ(none.Mass(), 0.0);
  }
}

TEST(PrimaryGuide, MassIsTheMeanAndPilotsAreCounted) {
  for (const GuideKind kind : kKinds) {
    std::atomic<std::int64_t> calls = 0;
    const PrimaryGuide guide =
        PrimaryGuide::Build(kind, 3, 12345, [&](const Point& u, std::int64_t) {
          ++calls;
          return Smooth(u);
        });
    EXPECT_NEAR(guide.Mass(), 1.0, 0.03);
    EXPECT_EQ(calls, 12345);
  }
}

TEST(PrimaryGuide, SameForAnyNumberOfThreads) {
  for (const GuideKind kind : kKinds) {
    std::vector<std::vector<double>> results;
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      const PrimaryGuide guide =
          PrimaryGuide::Build(kind, 3, 20000, [](const Point& u, std::int64_t index) {
            CounterRng rng(1, RandomDomain{2}, 3, static_cast<std::uint64_t>(index), 4);
            return Jump(u) * rng.Next();
          });
      results.emplace_back();
      CounterRng rng(6);
      for (int i = 0; i < 2000; ++i) {
        const double u0 = rng.Next();
        const PrimaryGuide::Draw draw = guide.Sample(u0, 0.3, 0.6);
        results.back().insert(results.back().end(), {draw.pdf, draw.u[0], draw.u[1], draw.u[2]});
      }
    }
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], results[2]);
  }
}

}  // namespace
}  // namespace pathfit::renderer::primary_guide_test
