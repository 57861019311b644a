#include "renderer/geometry/mesh_folds.h"

#include <random>

#include <gtest/gtest.h>

#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/triangle_tree.h"

namespace pathfit::renderer::mesh_folds_test {
namespace {

TEST(MeshFolds, OfABallThereAreNone) { EXPECT_EQ(CountFolds(MakeIcosphere(4, 1.0)).Total(), 0); }

TEST(MeshFolds, OfACubeThereAreNone) {
  EXPECT_EQ(CountFolds(MakeCube()).Total(), 0) << "right angles, and coplanar neighbours";
}

TEST(MeshFolds, OfAVertexPushedThroughTheOtherSide) {
  Mesh ball = MakeIcosphere(3, 1.0);
  ball.positions[0] = ball.positions[0] * -1.3;
  const MeshFolds folds = CountFolds(ball);
  EXPECT_GE(folds.crossing_triangles, 6) << "its triangles, and those they pierce";
  EXPECT_EQ(Unfold(ball).Total(), 0);
  EXPECT_EQ(CountFolds(ball).Total(), 0);
}

TEST(MeshFolds, OfAVertexPulledOverItsNeighbours) {
  Mesh ball = MakeIcosphere(3, 1.0);
  const Vec3 before = ball.positions[12];
  ball.positions[0] = ball.positions[0] + Cross(ball.positions[0], Vec3{0.3, 0.5, 0.2}) * 0.6;
  EXPECT_GT(CountFolds(ball).folded_edges, 0);
  EXPECT_EQ(Unfold(ball).Total(), 0);
  EXPECT_EQ(ball.positions[12], before) << "what lies far away stays";
}

TEST(MeshFolds, OfTwoPiecesThatPassThroughEachOther) {
  Mesh two = MakeCube();
  const Mesh other = MakeCube();
  for (const Vec3& p : std::as_const(other.positions)) {
    two.positions.push_back(p + Vec3{0.7, 0.6, 0.5});
  }
  for (Triangle t : std::as_const(other.triangles)) {
    for (std::int32_t& v : t) v += 8;
    two.triangles.push_back(t);
  }
  EXPECT_EQ(CountFolds(two).Total(), 0) << "that is how models are built";
}

TEST(MeshFolds, NeedlesArePointsOneTriangleWide) {
  Mesh ball = MakeIcosphere(3, 1.0);
  EXPECT_EQ(CountNeedles(ball), 0);
  EXPECT_EQ(CountNeedles(MakeCube()), 0);
  const double edge = MeshTopology::Build(ball).MeanEdgeLength(ball);
  const Vec3 foot = ball.positions[100];
  ball.positions[100] = foot * (1.0 + edge);
  EXPECT_EQ(CountNeedles(ball), 0) << "a cone of half the angle 41 degrees";
  ball.positions[100] = foot * (1.0 + 1.8 * edge);
  EXPECT_EQ(CountNeedles(ball), 1) << "of 26 degrees";
}

TEST(TriangleTree, FindsTheNearestPointAsASearchThroughAllDoes) {
  const Mesh ball = MakeIcosphere(2, 1.0);
  const TriangleTree tree(ball);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.6, 1.6);
  for (int i = 0; i < 300; ++i) {
    const Vec3 x{uniform(random), uniform(random), uniform(random)};
    double least = 1e300;
    for (const Triangle& t : std::as_const(ball.triangles)) {
      const auto p = [&](std::size_t k) { return ball.positions[static_cast<std::size_t>(t[k])]; };
      const Vec3 y = ClosestPointOfTriangle(x, TriangleGeometry::Make(p(0), p(1), p(2)));
      least = std::min(least, Norm(y - x));
    }
    const ClosestPoint found = tree.Closest(x);
    EXPECT_NEAR(Norm(found.position - x), least, 1e-14);
    Vec3 mixed{0.0, 0.0, 0.0};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& corners = ball.triangles[static_cast<std::size_t>(found.triangle)];
      mixed += ball.positions[static_cast<std::size_t>(corners[k])] * found.weights[k];
    }
    EXPECT_NEAR(Norm(mixed - found.position), 0.0, 1e-12);
    EXPECT_GT(Dot(tree.Closest(x, Vec3{1.0, 0.0, 0.0}).position, Vec3{1.0, 0.0, 0.0}), -0.2)
        << "only the side that looks along x";
  }
}

}  // namespace
}  // namespace pathfit::renderer::mesh_folds_test
