#include "optim/problem/residual_groups.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "optim/problem/jacobian_sink.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/test_scenes.h"

namespace pathfit {
namespace {

using optim::JacobianSink;
using optim::ResidualGroups;

// A mesh of a 17 x 17 grid of vertices seen by 128 x 128 pixels: each pixel depends on its
// triangle's vertices, and 5 % of them, as at silhouettes, on those of a second triangle.
struct GridRows {
  GridRows() : set(MakeSet()) {
    constexpr int kPixels = 128, kCells = 16;
    rows.use.resize(kPixels * kPixels);
    renderer::CounterRng rng(1, renderer::RandomDomain{2}, 3, 4, 5);
    for (int p = 0; p < kPixels * kPixels; ++p) {
      const double x = (p % kPixels + 0.5) * kCells / kPixels;
      const double y = (p / kPixels + 0.5) * kCells / kPixels;
      std::map<std::int32_t, bool> blocks;
      AddTriangle(x, y, blocks);
      if (rng.Next() < 0.05) {
        AddTriangle(rng.Next() * kCells, rng.Next() * kCells, blocks);
      }
      optim::RowUnit unit;
      unit.pixel = p;
      unit.first_entry = rows.entries.size();
      unit.num_entries = static_cast<std::int32_t>(blocks.size());
      for (const auto& [block, unused] : blocks) {
        optim::RowEntry entry;
        entry.block = block;
        entry.jacobian.fill(static_cast<float>(block + 1000 * (p % 7)));
        rows.entries.push_back(entry);
      }
      rows.units.push_back(unit);
    }
  }

  static void AddTriangle(double x, double y, std::map<std::int32_t, bool>& blocks) {
    const int i = static_cast<int>(x), k = static_cast<int>(y);
    const bool upper = (x - i) + (y - k) > 1.0;
    blocks[k * 17 + i + 1] = blocks[(k + 1) * 17 + i] = true;
    blocks[upper ? (k + 1) * 17 + i + 1 : k * 17 + i] = true;
  }

  static optim::ParameterSet MakeSet() {
    renderer::Scene scene;
    scene.meshes = {
        {"grid", renderer::MakeIcosphere(3, 1.0), 0}};  // has more than 17 * 17 vertices
    scene.materials = {{"paint", renderer::LambertBsdf{}}};
    std::vector<optim::UnknownSpec> unknowns(1);
    return {scene, unknowns, {0}, {}, {}};
  }

  optim::ParameterSet set;
  optim::PixelRows rows;
};

TEST(ResidualGroups, StoresHardlyAnyZeros) {
  const GridRows grid;
  const ResidualGroups groups = ResidualGroups::Build(grid.rows, grid.set);
  double stored = 0.0, nonzero = 0.0;  // of blocks of 3, without the rows of noise
  for (const optim::ResidualGroup& group : groups.groups()) {
    stored += 3.0 * group.num_rows * group.num_blocks;
  }
  for (const optim::RowUnit& unit : grid.rows.units) {
    nonzero += 3.0 * unit.NumRows() * unit.num_entries;
  }
  EXPECT_GE(stored, nonzero);
  EXPECT_LE(stored, 1.15 * nonzero);
  // And groups are not single pixels: 512 triangles of 32 pixels, and some strays.
  EXPECT_LT(groups.groups().size(), 2000U);
}

TEST(ResidualGroups, KeepsEveryDerivativeInItsPlace) {
  const GridRows grid;
  const ResidualGroups groups = ResidualGroups::Build(grid.rows, grid.set);
  std::size_t found = 0;
  for (const optim::ResidualGroup& group : groups.groups()) {
    std::size_t cell = group.first_cell;
    for (std::int32_t k = 0; k < group.num_blocks; ++k) {
      const std::int32_t block = groups.blocks()[group.first_block + static_cast<std::size_t>(k)];
      for (std::int32_t row = 0; row < group.num_rows; ++row, cell += 3) {
        const auto source = groups.row_sources()[group.first_row + static_cast<std::size_t>(row)];
        const float value = groups.cells()[cell];
        if (value != 0.0F) {
          EXPECT_EQ(value, static_cast<float>(block + 1000 * (source / 4 % 7)));
          ++found;
        }
      }
      cell += 3;  // noise row
    }
  }
  EXPECT_GE(found + 30,
            3 * grid.rows.entries.size());  // block 0 in pixels of the first kind is stored as 0
}

TEST(JacobianSink, MergesBlocksInTheOrderOfCalls) {
  JacobianSink sink(2, 1);
  renderer::ParameterDerivative a{7, {}}, b{3, {}}, zero{1, {}};
  a.d[0] = {1.0, 2.0, 3.0, 4.0};
  b.d[2] = {0.5, 0.0, 0.0, 0.0};
  for (int i = 0; i < 100; ++i) {
    sink.Add(1, std::vector<renderer::ParameterDerivative>{a, zero, b});
  }
  sink.Finish();
  EXPECT_TRUE(sink.Pixel(0).empty());
  ASSERT_EQ(sink.Pixel(1).size(), 2U);
  EXPECT_EQ(sink.Pixel(1)[0].block, 3);
  EXPECT_EQ(sink.Pixel(1)[0].d[8], 50.0F);
  EXPECT_EQ(sink.Pixel(1)[1].block, 7);
  EXPECT_EQ(sink.Pixel(1)[1].d[3], 400.0F);
}

}  // namespace
}  // namespace pathfit
