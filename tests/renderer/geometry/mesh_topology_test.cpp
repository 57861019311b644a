#include "renderer/geometry/mesh_topology.h"

#include <algorithm>
#include <cstddef>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"

namespace pathfit::renderer::mesh_topology_test {
namespace {

Mesh MakeQuad() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// Every edge is an edge of both faces, in opposite directions, and the apex is the third vertex.
void ExpectConsistent(const Mesh& mesh, const MeshTopology& topology) {
  for (const MeshEdge& edge : topology.edges) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (edge.faces[side] < 0) {
        EXPECT_EQ(side, 1U);
        EXPECT_EQ(edge.apex[side], -1);
        continue;
      }
      const Triangle& t = mesh.triangles[static_cast<std::size_t>(edge.faces[side])];
      const auto apex = std::find(t.begin(), t.end(), edge.apex[side]) - t.begin();
      ASSERT_LT(apex, 3);
      const auto k = static_cast<std::size_t>(apex);
      EXPECT_EQ(t[(k + 1) % 3], edge.vertices[side]);
      EXPECT_EQ(t[(k + 2) % 3], edge.vertices[1 - side]);
    }
  }
}

TEST(MeshTopology, CountsOfAnOpenQuad) {
  const Mesh mesh = MakeQuad();
  ValidateMesh(mesh, "quad");
  const MeshTopology topology = MeshTopology::Build(mesh);
  ASSERT_EQ(topology.edges.size(), 5U);
  EXPECT_FALSE(topology.closed);
  EXPECT_EQ(std::count_if(topology.edges.begin(),
                          topology.edges.end(),
                          [](const MeshEdge& e) { return e.faces[1] == -1; }),
            4);
  ExpectConsistent(mesh, topology);
  EXPECT_EQ(topology.Neighbors(mesh)[0], (std::vector<std::int32_t>{1, 2, 3}));
  EXPECT_EQ(topology.Neighbors(mesh)[1], (std::vector<std::int32_t>{0, 2}));
  std::vector<char> marks = {0, 1, 0, 0};
  topology.MarkRing(marks);
  EXPECT_EQ(marks, (std::vector<char>{1, 1, 1, 0}));
}

TEST(MeshTopology, EdgesStandInOrderOfFirstMention) {
  const MeshTopology topology = MeshTopology::Build(MakeQuad());
  const std::vector<std::array<std::int32_t, 2>> expected = {
      {0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 0}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(topology.edges[i].vertices, expected[i]);
  }
  EXPECT_EQ(topology.edges[2].faces, (std::array<std::int32_t, 2>{0, 1}));
  EXPECT_EQ(topology.edges[2].apex, (std::array<std::int32_t, 2>{1, 3}));
}

TEST(MeshTopology, ClosedMeshesFollowEuler) {
  for (const Mesh& mesh : {MakeCube(), MakeIcosphere(0, 1.0), MakeIcosphere(3, 1.0)}) {
    ValidateMesh(mesh, "closed");
    EXPECT_GT(SignedVolume(mesh), 0.0);
    const MeshTopology topology = MeshTopology::Build(mesh);
    EXPECT_TRUE(topology.closed);
    EXPECT_EQ(topology.edges.size(), mesh.triangles.size() * 3 / 2);
    EXPECT_EQ(mesh.positions.size() + mesh.triangles.size(), topology.edges.size() + 2);
    ExpectConsistent(mesh, topology);
    std::size_t num_neighbors = 0;
    for (const auto& ring : topology.Neighbors(mesh)) {
      EXPECT_TRUE(std::is_sorted(ring.begin(), ring.end()));
      EXPECT_EQ(std::adjacent_find(ring.begin(), ring.end()), ring.end());
      num_neighbors += ring.size();
    }
    EXPECT_EQ(num_neighbors, 2 * topology.edges.size());
  }
}

TEST(MeshTopology, EveryPieceOfASolidIsWoundOutwards) {
  Mesh two = MakeIcosphere(1, 1.0);
  EXPECT_TRUE(MeshTopology::Build(two).solid);
  const Mesh small = MakeIcosphere(1, 0.3);
  const auto first = static_cast<std::int32_t>(two.positions.size());
  for (const Vec3& p : small.positions) two.positions.push_back(p + Vec3{3.0, 0.0, 0.0});
  for (const Triangle& t : small.triangles) {
    two.triangles.push_back({first + t[0], first + t[2], first + t[1]});
  }
  EXPECT_GT(SignedVolume(two), 0.0);
  const MeshTopology topology = MeshTopology::Build(two);
  EXPECT_TRUE(topology.closed);
  EXPECT_FALSE(topology.solid);
}

TEST(MeshTopology, PartsAreWhatEdgesJoin) {
  EXPECT_EQ(MeshTopology::Build(MakeQuad()).parts, (std::vector<std::int32_t>{0, 0}));
  // Triangles 0 and 3 share an edge, 1 and 4 another one, 2 shares only a corner with both.
  Mesh mesh;
  for (int i = 0; i < 10; ++i) mesh.positions.push_back({1.0 * i, 0.3 * i * i, 0});
  mesh.triangles = {{0, 1, 2}, {4, 5, 6}, {2, 9, 4}, {1, 3, 2}, {5, 7, 6}};
  const MeshTopology topology = MeshTopology::Build(mesh);
  EXPECT_EQ(topology.parts, (std::vector<std::int32_t>{0, 1, 2, 0, 1}));
  const auto edges_of = topology.EdgesOfTriangles();
  ASSERT_EQ(edges_of.size(), mesh.triangles.size());
  for (std::size_t f = 0; f < edges_of.size(); ++f) {
    std::vector<std::int32_t> corners;
    for (const std::int32_t e : edges_of[f]) {
      const MeshEdge& edge = topology.edges[static_cast<std::size_t>(e)];
      EXPECT_TRUE(edge.faces[0] == static_cast<std::int32_t>(f) ||
                  edge.faces[1] == static_cast<std::int32_t>(f));
      corners.insert(corners.end(), edge.vertices.begin(), edge.vertices.end());
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    Triangle expected = mesh.triangles[f];
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(corners, (std::vector<std::int32_t>(expected.begin(), expected.end())));
  }
}

TEST(MeshTopology, SolidFollowsThePositions) {
  Mesh mesh = MakeIcosphere(1, 1.0);
  MeshTopology topology = MeshTopology::Build(mesh);
  for (Vec3& p : mesh.positions) p.x = -p.x;
  topology.UpdateSolid(mesh);
  EXPECT_FALSE(topology.solid);
  EXPECT_FALSE(MeshTopology::Build(MakeQuad()).solid);
}

}  // namespace
}  // namespace pathfit::renderer::mesh_topology_test
