#include "renderer/geometry/edge_tree.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/tangent_wedge.h"
#include "renderer/math/warp.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::edge_tree_test {
namespace {

std::vector<BoundaryEdge> EdgesOf(const Mesh& mesh) {
  const auto normal = [&](std::int32_t face) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(face)];
    const auto p = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(t[i])]; };
    return Normalized(Cross(p(1) - p(0), p(2) - p(0)));
  };
  std::vector<BoundaryEdge> edges;
  for (const MeshEdge& e : MeshTopology::Build(mesh).edges) {
    BoundaryEdge edge;
    edge.edge = static_cast<std::int32_t>(edges.size());
    edge.a = mesh.positions[static_cast<std::size_t>(e.vertices[0])];
    edge.b = mesh.positions[static_cast<std::size_t>(e.vertices[1])];
    edge.n0 = normal(e.faces[0]);
    edge.border = e.faces[1] < 0;
    edge.n1 = edge.border ? -edge.n0 : normal(e.faces[1]);
    edge.weight = edges.size() % 3 == 0 ? 0.2 : 1.0;
    edges.push_back(edge);
  }
  return edges;
}

Mesh BumpySphere(int subdivisions) {
  Mesh mesh = MakeIcosphere(subdivisions, 1.0);
  for (Vec3& p : mesh.positions) {
    p *= 1.0 + 0.2 * std::sin(5.0 * p.x) * std::sin(6.0 * p.y + 1.0) * std::cos(4.0 * p.z);
  }
  return mesh;
}

/// A waved sheet of n x n squares with four borders.
Mesh Sheet(int n, double height) {
  Mesh mesh;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = 2.0 * i / n - 1.0;
      const double y = 2.0 * j / n - 1.0;
      mesh.positions.push_back({x, y, height * std::sin(3.0 * x) * std::cos(4.0 * y)});
      if (i < n && j < n) {
        const std::int32_t at = j * (n + 1) + i;
        mesh.triangles.push_back({at, at + 1, at + n + 2});
        mesh.triangles.push_back({at, at + n + 2, at + n + 1});
      }
    }
  }
  return mesh;
}

/// A view: from a point or along a direction.
struct View {
  bool point = true;
  Vec3 at;

  [[nodiscard]] EdgeTree::Pick Sample(const EdgeTree& tree, double u) const {
    return point ? tree.SampleFromPoint(at, true, u) : tree.SampleAlongDirection(at, u);
  }
  [[nodiscard]] bool IsSilhouette(const BoundaryEdge& e) const {
    return e.IsSilhouette(point ? at - (e.a + e.b) * 0.5 : at);
  }
};

std::vector<View> Views(int count) {
  CounterRng rng(7);
  std::vector<View> views;
  for (int i = 0; i < count; ++i) {
    const double u0 = rng.Next();
    const Vec3 w = SampleUniformSphere(u0, rng.Next());
    views.push_back({false, w});
    views.push_back({true, w * (1.3 + 4.0 * rng.Next())});
  }
  return views;
}

/// What a fine sweep of u meets. Probabilities of edges are the widths of their intervals.
struct Sweep {
  std::map<int, double> probability;
  std::map<int, double> share;
  bool monotone = true;
};

Sweep SweepOver(const EdgeTree& tree, const View& view, int steps) {
  Sweep sweep;
  int last = -1;
  for (int i = 0; i < steps; ++i) {
    const EdgeTree::Pick pick = view.Sample(tree, (i + 0.5) / steps);
    if (pick.edge >= 0) {
      sweep.probability[pick.edge] = pick.probability;
      sweep.share[pick.edge] += 1.0 / steps;
      sweep.monotone = sweep.monotone && pick.edge >= last;
      last = pick.edge;
    }
  }
  return sweep;
}

/// Every silhouette is met, and as often as its probability says.
void ExpectSweepComplete(const EdgeTree& tree, const View& view, int steps) {
  const Sweep sweep = SweepOver(tree, view, steps);
  EXPECT_TRUE(sweep.monotone);
  double total = 0.0;
  for (const auto& [edge, probability] : sweep.probability) {
    total += probability;
    EXPECT_NEAR(sweep.share.at(edge), probability, 1.01 / steps);
  }
  EXPECT_LE(total, 1.0 + 1e-9);
  int missing = 0;
  for (std::size_t i = 0; i < tree.edges().size(); ++i) {
    missing +=
        view.IsSilhouette(tree.edges()[i]) && !sweep.probability.contains(static_cast<int>(i)) ? 1
                                                                                               : 0;
  }
  EXPECT_EQ(missing, 0) << "of " << sweep.probability.size();
}

TEST(EdgeTree, EverySilhouetteIsDrawnWithItsProbability) {
  const Vec3 far = {1e3, -2e3, 5e2};
  for (const Mesh& mesh : {MakeIcosphere(2, 1.0), BumpySphere(3), Sheet(12, 0.3), MakeCube()}) {
    const EdgeTree tree(EdgesOf(mesh));
    for (const View& view : Views(3)) {
      ExpectSweepComplete(tree, view, 100000);
    }
    ExpectSweepComplete(tree, {true, far}, 100000);
  }
}

/// Views that only just make an edge a silhouette: bounds and roundings must err on its side.
TEST(EdgeTree, EdgesAtTheRimOfTheirWedgeAreFound) {
  const EdgeTree tree(EdgesOf(BumpySphere(2)));
  CounterRng rng(17);
  int missing = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto index =
        static_cast<std::size_t>(rng.Next() * static_cast<double>(tree.edges().size()));
    const BoundaryEdge& e = tree.edges()[index];
    const double rim = i % 3 == 0 ? 1e-7 : 1e-3;
    const Vec3 w = SampleWedge(e, i % 2 == 0 ? rim : 1.0 - rim, rng.Next());
    const double distance = std::exp2(12.0 * rng.Next() - 8.0);
    const Vec3 x = e.a + (e.b - e.a) * rng.Next();
    const View view = i % 5 == 0 ? View{false, w} : View{true, x + w * distance};
    if (view.IsSilhouette(e)) {
      const Sweep sweep = SweepOver(tree, view, 2000);
      missing += sweep.probability.contains(static_cast<int>(index)) ? 0 : 1;
    }
  }
  EXPECT_EQ(missing, 0);
}

TEST(EdgeTree, SilhouettesOfALargeMeshAreNeverSkipped) {
  // The sweep is too coarse for the least likely ones: weighed by length.
  const EdgeTree tree(EdgesOf(BumpySphere(5)));
  for (const View& view : Views(2)) {
    const Sweep sweep = SweepOver(tree, view, 200000);
    double drawn = 0.0;
    double all = 0.0;
    for (std::size_t i = 0; i < tree.edges().size(); ++i) {
      const BoundaryEdge& e = tree.edges()[i];
      if (view.IsSilhouette(e)) {
        all += e.weight * e.Length();
        drawn += sweep.probability.contains(static_cast<int>(i)) ? e.weight * e.Length() : 0.0;
      }
    }
    EXPECT_GT(drawn, 0.995 * all);
  }
}

TEST(EdgeTree, EstimatesSumsOverSilhouettes) {
  for (const Mesh& mesh : {MakeIcosphere(5, 1.0), BumpySphere(5), Sheet(60, 0.3)}) {
    const EdgeTree tree(EdgesOf(mesh));
    for (const View& view : Views(2)) {
      double exact = 0.0;
      for (const BoundaryEdge& e : tree.edges()) {
        exact += view.IsSilhouette(e) ? e.Length() * (2.0 + e.a.x) : 0.0;
      }
      CounterRng rng(5);
      std::vector<double> values;
      for (int i = 0; i < 40000; ++i) {
        const EdgeTree::Pick pick = view.Sample(tree, rng.Next());
        double value = 0.0;
        if (pick.edge >= 0) {
          const BoundaryEdge& e = tree.edges()[static_cast<std::size_t>(pick.edge)];
          value = view.IsSilhouette(e) ? e.Length() * (2.0 + e.a.x) / pick.probability : 0.0;
        }
        values.push_back(value);
      }
      EXPECT_TRUE(tests::AgreesWithExact(values, exact, 0.05));
    }
  }
}

TEST(EdgeTree, MostPicksAreSilhouettes) {
  const EdgeTree tree(EdgesOf(MakeIcosphere(5, 1.0)));
  CounterRng rng(3);
  for (const bool point : {true, false}) {
    const int n = 20000;
    int hits = 0;
    for (int i = 0; i < n; ++i) {
      const double u0 = rng.Next();
      const Vec3 w = SampleUniformSphere(u0, rng.Next());
      const View view{point, w * (point ? 6.0 : 1.0)};
      const EdgeTree::Pick pick = view.Sample(tree, rng.Next());
      hits += pick.edge >= 0 && view.IsSilhouette(tree.edges()[static_cast<std::size_t>(pick.edge)])
                  ? 1
                  : 0;
    }
    EXPECT_GT(hits, 0.85 * n);
  }
}

TEST(EdgeTree, NothingIsDrawnWhereNothingIsASilhouette) {
  const EdgeTree ball(EdgesOf(MakeIcosphere(4, 1.0)));
  const EdgeTree cube(EdgesOf(MakeCube()));
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(ball.SampleFromPoint({0.1, 0.05, -0.1}, true, i / 100.0).edge, -1);
    EXPECT_EQ(cube.SampleFromPoint({0.3, -0.2, 0.5}, true, i / 100.0).edge, -1);
  }
  EXPECT_EQ(EdgeTree().SampleFromPoint({}, true, 0.5).edge, -1);
  EXPECT_EQ(EdgeTree().SampleAlongDirection({0, 0, 1}, 0.5).edge, -1);
  EXPECT_EQ(EdgeTree().SampleByWedge(0.5).edge, -1);
  EXPECT_TRUE(EdgeTree(std::vector<BoundaryEdge>{}).Empty());
}

TEST(EdgeTree, CubeSharesItsSilhouettesByWeightLengthAndDistance) {
  std::vector<BoundaryEdge> edges = EdgesOf(MakeCube());
  const EdgeTree tree(edges);
  const View view{true, {4.0, 5.0, 6.0}};
  const Sweep sweep = SweepOver(tree, view, 10000);
  ASSERT_EQ(sweep.probability.size(), 6U) << "diagonals are none";
  double total = 0.0;
  const auto importance = [&](const BoundaryEdge& e) {
    return e.weight * e.Length() / SquaredNorm(view.at - (e.a + e.b) * 0.5);
  };
  for (const auto& [i, p] : sweep.probability) {
    total += importance(tree.edges()[static_cast<std::size_t>(i)]);
  }
  for (const auto& [i, p] : sweep.probability) {
    EXPECT_NEAR(p, importance(tree.edges()[static_cast<std::size_t>(i)]) / total, 1e-6);
  }
}

TEST(EdgeTree, BordersAreDrawnFromEverywhere) {
  const EdgeTree tree(EdgesOf(Sheet(20, 0.0)));
  ASSERT_FALSE(tree.Empty());
  for (const View& view : Views(10)) {
    const Sweep sweep = SweepOver(tree, view, 20000);
    EXPECT_EQ(sweep.probability.size(), 80U);
    double total = 0.0;
    for (const auto& [i, p] : sweep.probability) {
      EXPECT_TRUE(tree.edges()[static_cast<std::size_t>(i)].border);
      total += p;
    }
    EXPECT_NEAR(total, 1.0, 1e-9);
  }
}

TEST(EdgeTree, FewBordersAmongManyEdgesLoseNothing) {
  const BoundaryEdge border = EdgesOf(Sheet(1, 0.0))[0];
  ASSERT_TRUE(border.border);
  for (const std::size_t borders : {1U, 2U, 3U, 5U}) {
    std::vector<BoundaryEdge> edges = EdgesOf(MakeIcosphere(2, 1.0));
    edges.insert(edges.begin() + 7, borders, border);
    const EdgeTree tree(edges);
    for (const View& view : Views(3)) {
      ExpectSweepComplete(tree, view, 50000);
    }
  }
}

TEST(EdgeTree, NearlyFlatEdgesAreFoundInTheirWedge) {
  // A sheet bent by 1e-6 per edge: silhouettes are seen from a sliver of directions only.
  const EdgeTree tree(EdgesOf(Sheet(20, 1e-6)));
  CounterRng rng(11);
  int tried = 0;
  for (const BoundaryEdge& e : tree.edges()) {
    if (e.border || WedgeAngle(e) < 1e-8 || ++tried > 30) {
      continue;
    }
    const double u0 = rng.Next();
    const Vec3 w = SampleWedge(e, 0.2 + 0.6 * u0, 0.25);
    ASSERT_TRUE(e.IsSilhouette(w));
    const Sweep sweep = SweepOver(tree, {false, w}, 20000);
    EXPECT_TRUE(sweep.probability.contains(static_cast<int>(&e - tree.edges().data())));
  }
  EXPECT_GT(tried, 20);
}

TEST(EdgeTree, WedgePicksFollowLengthAndAngle) {
  const std::vector<BoundaryEdge> edges = EdgesOf(BumpySphere(2));
  const EdgeTree tree(edges);
  double total = 0.0;
  for (const BoundaryEdge& e : edges) {
    total += e.weight * e.Length() * WedgeAngle(e);
  }
  EXPECT_NEAR(tree.WedgeTotal(), total, 1e-12 * total);
  int last = -1;
  for (int i = 0; i < 5000; ++i) {
    const EdgeTree::Pick pick = tree.SampleByWedge((i + 0.5) / 5000);
    const BoundaryEdge& e = tree.edges()[static_cast<std::size_t>(pick.edge)];
    EXPECT_GE(pick.edge, last);
    EXPECT_NEAR(pick.probability, e.weight * e.Length() * WedgeAngle(e) / total, 1e-12);
    EXPECT_TRUE(pick.remainder >= 0.0 && pick.remainder < 1.0);
    last = pick.edge;
  }
}

TEST(EdgeTree, RemainderIsUniform) {
  const EdgeTree tree(EdgesOf(BumpySphere(4)));
  const View view{true, {3.0, 2.0, 1.0}};
  std::vector<double> observed(20);
  CounterRng rng(13);
  double n = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const EdgeTree::Pick pick = view.Sample(tree, rng.Next());
    if (pick.edge >= 0) {
      ASSERT_TRUE(pick.remainder >= 0.0 && pick.remainder < 1.0);
      observed[static_cast<std::size_t>(pick.remainder * 20.0)] += 1.0;
      n += 1.0;
    }
  }
  EXPECT_TRUE(tests::ChiSquareAccepts(observed, std::vector<double>(20, n / 20.0), 1));
}

TEST(EdgeTree, DegenerateInputDoesNoHarm) {
  BoundaryEdge point;
  point.n0 = {0, 0, 1};
  point.n1 = {1, 0, 0};
  BoundaryEdge flat = point;
  flat.b = {1, 0, 0};
  flat.n1 = flat.n0;
  const EdgeTree tree({point, flat});
  EXPECT_FALSE(tree.Empty());
  EXPECT_EQ(tree.SampleFromPoint({1, 2, 3}, true, 0.5).edge, -1);
  std::vector<BoundaryEdge> same(1000);
  for (BoundaryEdge& e : same) {
    e.b = {0, 1, 0};
    e.n0 = {0, 0, 1};
    e.n1 = {1, 0, 0};
  }
  const EdgeTree stack(same);
  for (const Vec3& y : {Vec3{1, 0, -1}, Vec3{0, 0.5, 0}, Vec3{0, 0, 0}, Vec3{1e30, 1, -1e30}}) {
    const EdgeTree::Pick pick = stack.SampleFromPoint(y, true, 0.999);
    EXPECT_TRUE(pick.edge < 0 || (pick.probability > 0.0 && pick.probability <= 1.0));
  }
  EXPECT_NEAR(stack.SampleFromPoint({1, 0, -1}, true, 0.5).probability, 1e-3, 1e-8);
}

}  // namespace
}  // namespace pathfit::renderer::edge_tree_test
