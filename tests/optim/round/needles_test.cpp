#include "optim/round/needles.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/mesh_topology.h"

namespace pathfit {
namespace {

using renderer::Mesh;
using renderer::Vec3;

std::size_t NumNeedles(const Mesh& mesh) {
  const std::vector<char> marks = optim::FindNeedles(mesh);
  return static_cast<std::size_t>(std::count(marks.begin(), marks.end(), 1));
}

TEST(Needles, AreNeitherCornersNorRidges) {
  EXPECT_EQ(NumNeedles(renderer::MakeCube()), 0U);
  // A lens whose rim is a ridge of 30 degrees.
  Mesh lens = renderer::MakeIcosphere(3, 1.0);
  for (Vec3& p : lens.positions) p.z *= 0.25;
  EXPECT_EQ(NumNeedles(lens), 0U);
  Mesh blade = renderer::MakeIcosphere(4, 1.0);
  for (Vec3& p : blade.positions) p.z *= 0.1;
  EXPECT_EQ(NumNeedles(blade), 0U);
  Mesh same = blade;
  EXPECT_FALSE(optim::SmoothNeedles(same));
  EXPECT_EQ(same.positions, blade.positions);
}

TEST(Needles, GoWhereTheyAreAndNowhereElse) {
  const Mesh ball = renderer::MakeIcosphere(3, 1.0);
  Mesh pierced = ball;
  constexpr std::size_t kOut = 7, kIn = 400;
  pierced.positions.Edit()[kOut] = ball.positions[kOut] * 1.5;
  pierced.positions.Edit()[kIn] = ball.positions[kIn] * 0.5;
  const std::vector<char> marks = optim::FindNeedles(pierced);
  EXPECT_EQ(marks[kOut], 1);
  EXPECT_EQ(marks[kIn], 1);
  ASSERT_TRUE(optim::SmoothNeedles(pierced));
  EXPECT_EQ(NumNeedles(pierced), 0U);
  const std::vector<std::vector<std::int32_t>> rings =
      renderer::MeshTopology::Build(ball).Neighbors(ball);
  for (std::size_t v = 0; v < ball.positions.size(); ++v) {
    const double moved = Norm(pierced.positions[v] - ball.positions[v]);
    if (v == kOut || v == kIn) {
      EXPECT_LT(moved, 0.35) << v;
      continue;
    }
    const bool is_beside = std::count(rings[kOut].begin(), rings[kOut].end(), v) > 0 ||
                           std::count(rings[kIn].begin(), rings[kIn].end(), v) > 0;
    EXPECT_LE(moved, is_beside ? 0.2 : 0.0) << v;
  }
}

}  // namespace
}  // namespace pathfit
