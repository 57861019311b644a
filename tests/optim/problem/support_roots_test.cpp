#include "optim/problem/support_roots.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "optim/problem/gram_system.h"
#include "renderer/core/parallel.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/test_scenes.h"

namespace pathfit::support_roots_test {
namespace {

using optim::RootPanel;
using optim::Support;
using optim::SupportRoots;

constexpr int kPixels = 64, kCells = 16;

/// A mesh of a 17 x 17 grid of vertices seen by 64 x 64 pixels: each pixel depends on its
/// triangle's vertices, and 5 % of them, as at silhouettes, on those of a second triangle. Some
/// depend on a light and the view's camera as well.
class GridTest : public testing::Test {
 protected:
  enum class Shared { kNone, kLights };

  static optim::ParameterSet MakeSet(Shared shared) {
    renderer::Scene scene;
    scene.meshes = {
        {"grid", renderer::MakeIcosphere(3, 1.0), 0}};  // has more than 17 * 17 vertices
    scene.materials = {{"paint", renderer::LambertBsdf{}}};
    std::vector<optim::UnknownSpec> unknowns(1);
    std::vector<int> active = {0};
    if (shared == Shared::kLights) {
      scene.emitters.resize(2);
      for (int i = 0; i < 2; ++i) {
        scene.emitters[static_cast<std::size_t>(i)].name = "lamp" + std::to_string(i);
        scene.emitters[static_cast<std::size_t>(i)].light = renderer::PointEmitter{};
        optim::UnknownSpec lamp;
        lamp.kind = renderer::ParameterKind::kLightPosition;
        lamp.object = i;
        unknowns.push_back(lamp);
        active.push_back(i + 1);
      }
    }
    return {scene, unknowns, active, {}, {}};
  }

  static void AddTriangle(double x, double y, std::map<std::int32_t, bool>& blocks) {
    const int i = static_cast<int>(x), k = static_cast<int>(y);
    const bool upper = (x - i) + (y - k) > 1.0;
    blocks[k * 17 + i + 1] = blocks[(k + 1) * 17 + i] = true;
    blocks[upper ? (k + 1) * 17 + i + 1 : k * 17 + i] = true;
  }

  static optim::PixelRows MakeRows(const optim::ParameterSet& set, int view, double far = 0.05) {
    optim::PixelRows rows;
    const auto num_blocks = static_cast<std::int32_t>(set.NumBlocks());
    renderer::CounterRng rng(1, renderer::RandomDomain{2}, static_cast<std::uint64_t>(view), 4, 5);
    const auto number = [&rng] { return static_cast<float>(rng.Next() - 0.4); };
    for (int p = 0; p < kPixels * kPixels; ++p) {
      std::map<std::int32_t, bool> blocks;
      AddTriangle(
          (p % kPixels + 0.5) * kCells / kPixels, (p / kPixels + 0.5) * kCells / kPixels, blocks);
      if (rng.Next() < far) {
        AddTriangle(rng.Next() * kCells, rng.Next() * kCells, blocks);
      }
      if (num_blocks > 642) {  // the mesh's
        if (rng.Next() < 0.02) {
          blocks.clear();
        }
        blocks[642] = true;
        if (view % 2 == 1) {
          blocks[643] = true;
        }
      }
      optim::RowUnit unit;
      unit.pixel = p;
      unit.is_coverage = rng.Next() < 0.3;
      unit.first_entry = rows.entries.size();
      unit.num_entries = static_cast<std::int32_t>(blocks.size());
      for (int row = 0; row < unit.NumRows(); ++row) {
        unit.residual[static_cast<std::size_t>(row)] = static_cast<double>(number());
      }
      unit.difference[0] = std::sqrt(rng.Next());
      for (const auto& [block, unused] : blocks) {
        optim::RowEntry entry;
        entry.block = block;
        for (float& j : entry.jacobian) {
          j = number();
        }
        for (float& v : entry.noise) {
          v = number();
        }
        rows.entries.push_back(entry);
      }
      rows.units.push_back(unit);
    }
    return rows;
  }

  /// As two halves see them that disagree by about as much as there is.
  static optim::PixelRows WithNoise(optim::PixelRows rows, int view) {
    renderer::CounterRng rng(2, renderer::RandomDomain{2}, static_cast<std::uint64_t>(view), 4, 5);
    for (optim::RowEntry& entry : rows.entries) {
      optim::EntrySpread& spread = rows.spreads.emplace_back();
      for (std::size_t k = 0; k < entry.jacobian.size(); ++k) {
        const double a = 1.5 * (rng.Next() - 0.5), b = 1.5 * (rng.Next() - 0.5);
        entry.jacobian[k] += static_cast<float>(a + b);
        spread.jacobian[k] = static_cast<float>(a - b);
      }
    }
    return rows;
  }

  /// x^T J^T J x as it is without the noise, as the rows have it, and as the solver is fed with it.
  static void ExpectNoiseTakenOut(Shared shared) {
    constexpr int kViews = 12;
    const optim::ParameterSet set = MakeSet(shared);
    SupportRoots exact(set, kViews), square(set, kViews), fed(set, kViews);
    optim::GradientSums sums(set.NumScalars());
    for (int view = 0; view < kViews; ++view) {
      const optim::PixelRows rows = MakeRows(set, view, 0.0);
      optim::PixelRows noisy = WithNoise(rows, view);
      sums.Add(noisy, set);
      exact.BeginView();
      exact.Add(rows);
      fed.BeginView();
      fed.Add(noisy);
      noisy.spreads.clear();
      square.BeginView();
      square.Add(noisy);
    }
    for (SupportRoots* roots : {&exact, &square, &fed}) {
      roots->Finish();
    }
    for (const double wave : {0.0, 0.1, 1.0}) {  // smooth and rough directions
      std::vector<double> x(set.NumScalars());
      constexpr std::size_t kOfMesh = 642 * 3;  // shared blocks are left as they are
      for (std::size_t i = 0; i < kOfMesh; ++i) {
        x[i] = std::cos(wave * static_cast<double>(i));
      }
      const auto form = [&](const SupportRoots& roots) {
        const std::vector<double> product = Feed(roots, set, x, false).product;
        return std::inner_product(x.begin(), x.end(), product.begin(), 0.0);
      };
      const double truth = form(exact);
      EXPECT_GT(form(square), 1.05 * truth);
      EXPECT_LT(std::abs(form(fed) - truth), 0.3 * (form(square) - truth)) << wave;
    }
    const Fed with_noise = Feed(fed, set, std::vector<double>(set.NumScalars()), true);
    for (std::size_t i = 0; i < sums.gradient.size(); ++i) {
      EXPECT_NEAR(
          with_noise.gradient[i], sums.gradient[i], 1e-4 * (1.0 + std::sqrt(sums.diagonal[i])));
    }
  }

  static SupportRoots MakeRoots(const optim::ParameterSet& set, int num_views, double far = 0.05) {
    SupportRoots roots(set, static_cast<std::size_t>(num_views));
    for (int view = 0; view < num_views; ++view) {
      roots.BeginView();
      roots.Add(MakeRows(set, view, far));
    }
    roots.Finish();
    return roots;
  }

  /// J^T J x and J^T r of what the solver is fed.
  struct Fed {
    std::vector<double> product, gradient;
  };
  static Fed Feed(const SupportRoots& roots,
                  const optim::ParameterSet& set,
                  const std::vector<double>& x,
                  bool with_noise_rows) {
    Fed fed{std::vector<double>(set.NumScalars()), std::vector<double>(set.NumScalars())};
    for (const Support& support : roots.supports()) {
      std::vector<std::size_t> scalar;
      for (const std::int32_t block : support.blocks) {
        for (int c = 0; c < set.BlockSize(block); ++c) {
          scalar.push_back(set.BlockOffset(block) + static_cast<std::size_t>(c));
        }
      }
      const auto add = [&](std::size_t first, std::size_t end, auto&& cell, double residual) {
        double along = 0.0;
        for (std::size_t c = first; c < end; ++c) {
          along += cell(c) * x[scalar[c]];
        }
        for (std::size_t c = first; c < end; ++c) {
          fed.product[scalar[c]] += cell(c) * along;
          fed.gradient[scalar[c]] += cell(c) * residual;
        }
      };
      for (std::size_t row = 0; row < support.NumRows(); ++row) {
        add(
            support.is_root ? row : 0,
            support.num_columns,
            [&](std::size_t c) {
              return static_cast<double>(support.rows[support.RowOffset(row) + c]);
            },
            support.residual[row]);
      }
      if (with_noise_rows) {
        const double rho = std::sqrt(support.offset_squared);
        add(
            0,
            support.num_local_columns,
            [&](std::size_t c) { return support.noise[c] / rho; },
            rho);
      }
    }
    return fed;
  }

  static void ExpectSameQuadraticForm(Shared shared) {
    constexpr int kViews = 6;
    const optim::ParameterSet set = MakeSet(shared);
    const SupportRoots roots = MakeRoots(set, kViews);
    std::vector<double> x(set.NumScalars());
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = std::sin(static_cast<double>(i));
    }
    std::vector<double> product(x.size());
    optim::GradientSums sums(x.size());
    for (int view = 0; view < kViews; ++view) {
      const optim::PixelRows rows = MakeRows(set, view);
      sums.Add(rows, set);
      for (const optim::RowUnit& unit : rows.units) {
        for (int row = 0; row < unit.NumRows(); ++row) {
          const auto visit = [&](auto&& body) {
            for (std::int32_t e = 0; e < unit.num_entries; ++e) {
              const auto& entry = rows.entries[unit.first_entry + static_cast<std::size_t>(e)];
              for (std::size_t c = 0; c < 3; ++c) {
                body(set.BlockOffset(entry.block) + c,
                     static_cast<double>(entry.jacobian[static_cast<std::size_t>(row) * 3 + c]));
              }
            }
          };
          double along = 0.0;
          visit([&](std::size_t i, double j) { along += j * x[i]; });
          visit([&](std::size_t i, double j) { product[i] += j * along; });
        }
      }
    }
    const Fed fed = Feed(roots, set, x, false);
    const Fed with_noise = Feed(roots, set, x, true);
    for (std::size_t i = 0; i < x.size(); ++i) {
      EXPECT_NEAR(fed.product[i], product[i], 1e-5 * (1.0 + std::abs(product[i])));
      EXPECT_NEAR(
          with_noise.gradient[i], sums.gradient[i], 1e-5 * (1.0 + std::sqrt(sums.diagonal[i])));
    }
  }
};

TEST_F(GridTest, RootsHaveTheNormalEquationsAndTheSplitHalfGradientOfAllRows) {
  ExpectSameQuadraticForm(Shared::kNone);
}

TEST_F(GridTest, SharedBlocksAreEliminatedIntoOneRoot) {
  ExpectSameQuadraticForm(Shared::kLights);
  const optim::ParameterSet set = MakeSet(Shared::kLights);
  const SupportRoots roots = MakeRoots(set, 3);
  EXPECT_EQ(roots.supports()[0].blocks, (std::vector<std::int32_t>{642, 643}));
  EXPECT_EQ(roots.panels()[0].num_rows, 6);
}

TEST_F(GridTest, WhatTheHalvesDisagreeOnDoesNotInflateTheRoots) {
  ExpectNoiseTakenOut(Shared::kNone);
  ExpectNoiseTakenOut(Shared::kLights);
}

TEST_F(GridTest, RowsThatAreManyAtOnceBecomeARootThatNothingStoodBefore) {
  // All pixels of one view have the same blocks: the support begins as a root of no rows.
  const optim::ParameterSet set = MakeSet(Shared::kLights);
  optim::PixelRows rows = MakeRows(set, 0, 0.0);
  const optim::RowUnit first = rows.units.front();
  for (optim::RowUnit& unit : rows.units) {
    unit.first_entry = first.first_entry;
    unit.num_entries = first.num_entries;
  }
  SupportRoots roots(set, 1);
  roots.BeginView();
  roots.Add(rows);
  roots.Finish();
  ASSERT_EQ(roots.supports().size(), 2U);
  EXPECT_TRUE(roots.supports()[1].is_root);
  EXPECT_GT(roots.supports()[1].rows[0], 0.0F);
}

TEST_F(GridTest, PanelsCoverEveryRowOnceAndAllItsCells) {
  const optim::ParameterSet set = MakeSet(Shared::kLights);
  const SupportRoots roots = MakeRoots(set, 4);
  std::vector<std::int32_t> next_row(roots.supports().size(), 0);
  for (const RootPanel& panel : roots.panels()) {
    const auto id = static_cast<std::size_t>(panel.support);
    const Support& support = roots.supports()[id];
    EXPECT_EQ(panel.first_row, next_row[id]);
    EXPECT_EQ(panel.has_noise_row, panel.first_row == 0);
    EXPECT_EQ(static_cast<std::size_t>(panel.first_block + panel.num_blocks),
              support.blocks.size());
    std::int32_t column = 0;
    for (std::int32_t k = 0; k < panel.first_block; ++k) {
      column += set.BlockSize(support.blocks[static_cast<std::size_t>(k)]);
    }
    EXPECT_EQ(column, panel.first_column);
    EXPECT_LE(panel.first_column, panel.first_row);
    next_row[id] += panel.num_rows;
  }
  for (std::size_t i = 0; i < next_row.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(next_row[i]), roots.supports()[i].NumRows());
  }
}

TEST_F(GridTest, WhatRootsWereGatheredInIsGivenBack) {
  const optim::ParameterSet set = MakeSet(Shared::kNone);
  const SupportRoots roots = MakeRoots(set, 8);
  std::size_t num_roots = 0;
  for (const Support& support : roots.supports()) {
    num_roots += support.is_root ? 1 : 0;
    EXPECT_EQ(support.is_root ? support.matrix.capacity() : 0, 0U);
    EXPECT_EQ(support.is_root ? support.gradient.capacity() : 0, 0U);
  }
  EXPECT_GT(num_roots, 10U);
}

TEST_F(GridTest, MemoryOfASurfaceDoesNotGrowWithTheNumberOfViews) {
  const optim::ParameterSet set = MakeSet(Shared::kNone);
  const double few = MakeRoots(set, 4, 0.0).Size().jacobian_cells;
  const double many = MakeRoots(set, 16, 0.0).Size().jacobian_cells;
  EXPECT_LT(many, 1.1 * few);
  // 512 triangles of 9 scalars each, in roots of their own.
  EXPECT_LT(many, 512.0 * 90.0);
}

TEST_F(GridTest, FarCouplingsTakeLessThanTheirRows) {
  const optim::ParameterSet set = MakeSet(Shared::kNone);
  constexpr int kViews = 16;
  const auto bytes = [](const SupportRoots& roots) {
    const optim::RootSize size = roots.Size();
    return size.kept_bytes + 8.0 * size.jacobian_cells + 600.0 * size.num_panels +
           40.0 * size.panel_blocks;
  };
  const double near = bytes(MakeRoots(set, kViews, 0.0));
  const double all = bytes(MakeRoots(set, kViews));
  // 2.4 rows and one of noise, of 18 scalars, each in a support of its own.
  const double num_far = kViews * 0.05 * kPixels * kPixels;
  EXPECT_LT(all - near,
            num_far * (static_cast<double>(sizeof(Support)) + 12.0 * 18.0 + 2.4 * 18.0 * 4.0 +
                       3.4 * 18.0 * 8.0 + 600.0 + 6.0 * 40.0));
}

TEST_F(GridTest, IsTheSameForAnyNumberOfThreads) {
  const optim::ParameterSet set = MakeSet(Shared::kLights);
  std::vector<std::vector<float>> rows;
  for (const int threads : {1, 2}) {
    const renderer::ThreadLimit limit(threads);
    const SupportRoots roots = MakeRoots(set, 3);
    rows.emplace_back();
    for (const Support& support : roots.supports()) {
      rows.back().insert(rows.back().end(), support.rows.begin(), support.rows.end());
    }
  }
  EXPECT_EQ(rows[0], rows[1]);
}

TEST_F(GridTest, WhatTheHalvesDoNotAgreeOnMayLieOutsideOfTheRows) {
  // One row of one vertex: two of three directions have no square, but they have a gradient.
  const optim::ParameterSet set = MakeSet(Shared::kNone);
  optim::PixelRows rows;
  for (int i = 0; i < 200; ++i) {
    optim::RowUnit unit;
    unit.is_coverage = true;
    unit.first_entry = rows.entries.size();
    unit.num_entries = 1;
    unit.residual[0] = 0.5;
    unit.difference[0] = std::sqrt(0.3);
    optim::RowEntry entry;
    entry.block = 7;
    entry.jacobian = {1.0F, 2.0F, 0.0F};
    entry.noise = {0.1F, -0.2F, 0.3F};
    rows.entries.push_back(entry);
    rows.units.push_back(unit);
  }
  optim::GradientSums sums(set.NumScalars());
  sums.Add(rows, set);
  SupportRoots roots(set, 1);
  roots.BeginView();
  roots.Add(rows);
  roots.Finish();
  const Fed fed = Feed(roots, set, std::vector<double>(set.NumScalars()), true);
  for (std::size_t i = 0; i < fed.gradient.size(); ++i) {
    EXPECT_NEAR(fed.gradient[i], sums.gradient[i], 1e-9);
  }
  EXPECT_LT(roots.residual_squared(), 1e7);  // no residual is large for want of a square
}

}  // namespace
}  // namespace pathfit::support_roots_test
