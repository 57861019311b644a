#include "optim/problem/sparse_gram.h"

#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/parallel.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/test_scenes.h"

namespace pathfit::sparse_gram_test {
namespace {

using optim::ParameterSet;
using optim::PixelRows;
using optim::SparseGram;

/// Blocks of 3 scalars (vertices) and one of 1 (a material's roughness), in random pixels.
class SparseGramTest : public testing::Test {
 protected:
  static ParameterSet MakeSet() {
    renderer::Scene scene;
    scene.meshes = {{"ball", renderer::MakeIcosphere(2, 1.0), 0}};
    scene.materials = {{"paint", renderer::RoughConductorBsdf{}}};
    std::vector<optim::UnknownSpec> unknowns(2);
    unknowns[1].kind = renderer::ParameterKind::kRoughness;
    return {scene, unknowns, {0, 1}, {}, {}};
  }

  static PixelRows MakeRows(const ParameterSet& set, std::uint64_t view) {
    PixelRows rows;
    renderer::CounterRng rng(1, renderer::RandomDomain{2}, view, 4, 5);
    for (int p = 0; p < 200; ++p) {
      std::map<std::int32_t, bool> blocks;
      for (int k = 0; k < 4; ++k) {
        blocks[static_cast<std::int32_t>(rng.Next() * static_cast<double>(set.NumBlocks()))] = true;
      }
      optim::RowUnit unit;
      unit.pixel = p;
      unit.is_coverage = p % 3 == 0;
      unit.first_entry = rows.entries.size();
      unit.num_entries = static_cast<std::int32_t>(blocks.size());
      rows.units.push_back(unit);
      for (const auto& [block, seen] : blocks) {
        optim::RowEntry entry;
        entry.block = block;
        for (float& x : entry.jacobian) x = static_cast<float>(rng.Next() - 0.4);
        rows.entries.push_back(entry);
      }
    }
    return rows;
  }

  ParameterSet set_ = MakeSet();
};

TEST_F(SparseGramTest, IsTheProductOfAllRows) {
  ASSERT_EQ(set_.BlockSize(static_cast<std::int32_t>(set_.NumBlocks()) - 1), 1);
  const std::size_t n = set_.NumScalars();
  std::vector<double> x(n), expected(n), y;
  for (std::size_t i = 0; i < n; ++i) x[i] = 0.5 + static_cast<double>(i % 7);
  SparseGram gram(set_);
  for (std::uint64_t view = 0; view < 3; ++view) {
    const PixelRows rows = MakeRows(set_, view);
    gram.Add(rows);
    for (const optim::RowUnit& unit : rows.units) {
      for (int row = 0; row < unit.NumRows(); ++row) {
        const auto visit = [&](auto&& body) {
          for (std::int32_t e = 0; e < unit.num_entries; ++e) {
            const auto& entry = rows.entries[unit.first_entry + static_cast<std::size_t>(e)];
            for (int c = 0; c < set_.BlockSize(entry.block); ++c) {
              body(set_.BlockOffset(entry.block) + static_cast<std::size_t>(c),
                   static_cast<double>(entry.jacobian[static_cast<std::size_t>(
                       row * set_.BlockSize(entry.block) + c)]));
            }
          }
        };
        double product = 0.0;
        visit([&](std::size_t i, double j) { product += j * x[i]; });
        visit([&](std::size_t i, double j) { expected[i] += j * product; });
      }
    }
  }
  const double added[] = {2.0, 3.0, 5.0};  // d^2 / (d vertex 4) (d roughness)
  const auto last = static_cast<std::int32_t>(set_.NumBlocks()) - 1;
  gram.Add(4, last, added);
  for (std::size_t c = 0; c < 3; ++c) {
    expected[set_.BlockOffset(4) + c] += added[c] * x[n - 1];
    expected[n - 1] += added[c] * x[set_.BlockOffset(4) + c];
  }
  gram.Multiply(x, y);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_NEAR(y[i], expected[i], 1e-12 * (1.0 + std::abs(expected[i]))) << i;
  }
}

TEST_F(SparseGramTest, TakesNoMoreForTheSamePairsOfMorePhotos) {
  SparseGram gram(set_);
  gram.Add(MakeRows(set_, 1));
  const std::size_t bytes = gram.MemoryBytes();
  gram.Add(MakeRows(set_, 1));
  EXPECT_EQ(gram.MemoryBytes(), bytes);
}

TEST_F(SparseGramTest, HasTheSameBitsForAnyNumberOfThreads) {
  std::vector<double> x(set_.NumScalars(), 1.25), first;
  for (const int threads : {1, 2, 5}) {
    const renderer::ThreadLimit limit(threads);
    SparseGram gram(set_);
    for (std::uint64_t view = 0; view < 3; ++view) gram.Add(MakeRows(set_, view));
    std::vector<double> y;
    gram.Multiply(x, y);
    if (first.empty()) first = y;
    EXPECT_EQ(y, first);
  }
}

TEST_F(SparseGramTest, IsWithoutTheNoiseOfDerivatives) {
  const std::size_t n = set_.NumScalars();
  std::vector<double> x(n), y, without;
  for (std::size_t i = 0; i < n; ++i) x[i] = 0.5 + static_cast<double>(i % 7);
  std::vector<double> gradient(n, 1.0);
  double gradient_noise = 0.0;
  const auto product = [&](double share, bool deflates, std::vector<double>& to) {
    PixelRows rows = MakeRows(set_, 1);
    for (const optim::RowEntry& entry : rows.entries) {
      optim::EntrySpread& spread = rows.spreads.emplace_back();
      for (std::size_t i = 0; i < entry.jacobian.size(); ++i) {
        spread.jacobian[i] = static_cast<float>(std::sqrt(share)) * entry.jacobian[i];
      }
      spread.gradient.fill(static_cast<float>(gradient_noise));
    }
    SparseGram gram(set_);
    gram.Add(rows);
    if (deflates) gram.Deflate(gradient);
    gram.Multiply(x, to);
  };
  product(0.0, false, y);
  for (const auto& [share, left] : {std::pair{0.0, 1.0}, {0.25, 0.75}, {1.0, 0.1}}) {
    product(share, true, without);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_NEAR(without[i], left * y[i], 1e-5 * (1.0 + std::abs(y[i]))) << share;
    }
  }
  gradient_noise = 10.0;
  product(0.25, true, without);
  EXPECT_EQ(without, y) << "the gradient is noise";
}

TEST_F(SparseGramTest, StaysPositiveWhateverTheNoise) {
  PixelRows rows = MakeRows(set_, 1);
  renderer::CounterRng rng(1, renderer::RandomDomain{2}, 7, 4, 5);
  rows.spreads.resize(rows.entries.size());
  for (optim::EntrySpread& spread : rows.spreads) {
    for (float& value : spread.jacobian) value = static_cast<float>(rng.Next() - 0.5);
  }
  SparseGram gram(set_);
  gram.Add(rows);
  gram.Deflate(std::vector<double>(set_.NumScalars(), 1.0));
  std::vector<double> x(set_.NumScalars()), y;
  for (int trial = 0; trial < 200; ++trial) {
    for (double& value : x) value = rng.Next() - 0.5;
    gram.Multiply(x, y);
    EXPECT_GT(std::inner_product(x.begin(), x.end(), y.begin(), 0.0), 0.0);
  }
}

/// A texture of more texels than keep pairs, and a light.
class SpreadTexelsTest : public testing::Test {
 protected:
  static ParameterSet MakeSet(int side) {
    renderer::Scene scene;
    scene.meshes = {{"ball", renderer::MakeIcosphere(1, 1.0), 0}};
    scene.meshes[0].mesh.uvs.resize(1);
    scene.meshes[0].mesh.uv_triangles.resize(scene.meshes[0].mesh.triangles.size());
    scene.materials = {{"paint", renderer::LambertBsdf{}}};
    scene.materials[0].base_color_texture = 0;
    scene.textures = {{"colours", side, side}};
    scene.textures[0].texels = renderer::SharedVector<renderer::Rgb>(
        static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    scene.emitters = {{.name = "lamp", .light = renderer::PointEmitter{}}};
    std::vector<optim::UnknownSpec> unknowns(2);
    unknowns[0].kind = renderer::ParameterKind::kTextureTexels;
    unknowns[1].kind = renderer::ParameterKind::kLightIntensity;
    return {scene, unknowns, {0, 1}, {}, {}};
  }
};

TEST_F(SpreadTexelsTest, TakeLittleMemoryWhereNothingSeesThem) {
  // Of a texel that could keep pairs, and of one that is spread: three numbers.
  for (const auto& [side, most] : {std::pair{100, 72.0}, {800, 24.1}}) {
    const ParameterSet set = MakeSet(side);
    SparseGram gram(set);
    EXPECT_EQ(gram.MemoryBytes(), 0U);
    EXPECT_LE(static_cast<double>(SparseGram::BytesOfEmpty(set)), most * side * side);
  }
}

TEST_F(SpreadTexelsTest, AreBoundedFromAboveByADiagonal) {
  const ParameterSet set = MakeSet(800);
  const std::int32_t lamp = set.layout().FirstBlock(renderer::ParameterKind::kLightIntensity, 0);
  PixelRows rows;
  renderer::CounterRng rng(1, renderer::RandomDomain{2}, 3, 4, 5);
  constexpr std::int32_t kSeen = 40;  // texels, of which a pixel sees eight
  for (std::int32_t p = 0; p < 30; ++p) {
    optim::RowUnit unit;
    unit.first_entry = rows.entries.size();
    for (std::int32_t k = 0; k < 8; ++k) {
      optim::RowEntry& entry = rows.entries.emplace_back();
      entry.block =
          set.layout().FirstBlock(renderer::ParameterKind::kTextureTexels, 0) + (p * 3 + k) % kSeen;
      for (float& x : entry.jacobian) x = static_cast<float>(rng.Next() - 0.3);
    }
    if (p % 2 == 0) {
      rows.entries.push_back({lamp, {1.0F, 0.0F, 0.0F, 0.0F, 2.0F, 0.0F, 0.0F, 0.0F, 3.0F}, {}});
    }
    unit.num_entries = static_cast<std::int32_t>(rows.entries.size() - unit.first_entry);
    rows.units.push_back(unit);
  }
  SparseGram gram(set);
  gram.Add(rows);
  ASSERT_EQ(gram.paired().NumScalars(), 3U);
  const std::vector<double>& diagonal = gram.spread_diagonal();
  std::vector<double> x(set.NumScalars()), lamp_product;
  for (int trial = 0; trial < 100; ++trial) {
    double form = 0.0, bound = 0.0;
    for (std::int32_t b = 0; b < kSeen; ++b) {
      for (std::size_t c = 0; c < 3; ++c) x[set.BlockOffset(b) + c] = rng.Next() - 0.5;
    }
    for (std::size_t c = 0; c < 3; ++c) x[set.BlockOffset(lamp) + c] = rng.Next() - 0.5;
    for (const optim::RowUnit& unit : rows.units) {
      for (std::size_t r = 0; r < 3; ++r) {
        double product = 0.0;
        for (std::int32_t e = 0; e < unit.num_entries; ++e) {
          const auto& entry = rows.entries[unit.first_entry + static_cast<std::size_t>(e)];
          for (std::size_t c = 0; c < 3; ++c) {
            product += static_cast<double>(entry.jacobian[r * 3 + c]) *
                       x[set.BlockOffset(entry.block) + c];
          }
        }
        form += product * product;
      }
    }
    const std::vector<double> short_x = gram.paired().Shorten(x);
    gram.Multiply(short_x, lamp_product);
    bound = std::inner_product(short_x.begin(), short_x.end(), lamp_product.begin(), 0.0);
    for (std::size_t i = 0; i < x.size(); ++i) bound += diagonal[i] * x[i] * x[i];
    EXPECT_LE(form, bound);
  }
}

TEST_F(SpreadTexelsTest, AllTakeThePixelsStep) {
  // One pixel that sees eight texels: a step by minus the gradient over the diagonal changes their
  // sum by as much as the pixel asks for, whatever the weights.
  const ParameterSet set = MakeSet(800);
  PixelRows rows;
  double sum = 0.0;
  for (std::int32_t k = 0; k < 8; ++k) {
    const float weight = 0.1F * static_cast<float>(k + 1);
    rows.entries.push_back({k, {weight, 0.0F, 0.0F, 0.0F, weight, 0.0F, 0.0F, 0.0F, weight}, {}});
    sum += static_cast<double>(weight);
  }
  optim::RowUnit unit;
  unit.num_entries = 8;
  rows.units = {unit};
  SparseGram gram(set);
  gram.Add(rows);
  double change = 0.0;
  for (std::size_t k = 0; k < 8; ++k) {
    const auto weight = static_cast<double>(rows.entries[k].jacobian[0]);
    change += weight * weight / gram.spread_diagonal()[3 * k];
  }
  EXPECT_NEAR(change, 1.0, 1e-6);
  EXPECT_GT(sum, 1.0);
}

}  // namespace
}  // namespace pathfit::sparse_gram_test
