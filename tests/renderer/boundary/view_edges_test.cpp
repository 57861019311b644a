#include "renderer/boundary/view_edges.h"

#include <gtest/gtest.h>

#include "tests/support/probe.h"

namespace pathfit::renderer {
namespace {

struct Found {
  int edges = 0;
  double weight = 0.0;
};

Found EdgesOf(const Scene& scene, const PerspectiveCamera& camera, std::vector<bool> moves = {}) {
  std::vector<MeshTopology> topologies;
  for (const SceneMesh& m : scene.meshes) topologies.push_back(MeshTopology::Build(m.mesh));
  if (moves.empty()) moves.assign(scene.meshes.size(), true);
  const CameraModel model(camera);
  const ViewEdges edges(scene, topologies, moves, model);
  Found found;
  found.weight = edges.distribution().Total();
  double remainder = 0.0;
  std::vector<bool> seen(1000);
  for (int i = 0; !edges.distribution().Empty() && i < 20000; ++i) {
    seen[static_cast<std::size_t>(edges.distribution().Sample((i + 0.5) / 20000.0, remainder))] =
        true;
  }
  for (const bool s : seen) found.edges += s ? 1 : 0;
  return found;
}

Scene Painted(const Mesh& mesh) { return tests::SceneOf(mesh, LambertBsdf{}, {0.5, 0.5, 0.5}, {}); }
PerspectiveCamera FrontCamera() { return tests::CameraAt({0, 0, 6}, {0, 0, 0}, 40.0, 64, 64); }

TEST(ViewEdges, RectangleHasFourBordersAndNoDiagonal) {
  const Found found = EdgesOf(Painted(tests::Rectangle()), FrontCamera());
  EXPECT_EQ(found.edges, 4);
  EXPECT_NEAR(found.weight, 4.0 * 2.0 * 40.0 / 6.0, 1e-12) << "length in pixels";
}

TEST(ViewEdges, CubeShowsSilhouettesAndCreasesOfSeenFacesOnly) {
  EXPECT_EQ(EdgesOf(Painted(tests::Cube()), FrontCamera()).edges, 4) << "face on";
  const PerspectiveCamera corner = tests::CameraAt({4, 5, 6}, {0, 0, 0}, 40.0, 64, 64);
  EXPECT_EQ(EdgesOf(Painted(tests::Cube()), corner).edges, 9) << "three faces";
  const PerspectiveCamera inside = tests::CameraAt({0, 0, 0.5}, {0, 0, -1}, 10.0, 64, 64);
  EXPECT_GE(EdgesOf(Painted(tests::Cube()), inside).edges, 8)
      << "the inside of a closed mesh is seen";
}

TEST(ViewEdges, ColorSeamsCountOnlyWhereColorsDiffer) {
  Mesh plate = tests::Rectangle();
  plate.colors = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {1, 0, 0}, {0, 0, 1}};
  plate.color_triangles = {{0, 1, 2},
                           {4, 5, 3}};  // separately indexed, equal values on the diagonal
  Scene scene = Painted(plate);
  scene.materials[0].vertex_colors = true;
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 4);
  scene.meshes[0].mesh.colors[5] = {0, 0, 0.9};
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 5);
  scene.materials[0].vertex_colors = false;
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 4) << "unused colours make no seam";
}

TEST(ViewEdges, OnlyMovingMeshesInFrontOfTheCameraCount) {
  Scene scene = Painted(tests::Rectangle());
  scene.meshes.push_back({"other", tests::Cube(), 0});
  EXPECT_EQ(EdgesOf(scene, FrontCamera(), {true, false}).edges, 4);
  EXPECT_EQ(EdgesOf(scene, FrontCamera(), {false, false}).edges, 0);
  const PerspectiveCamera away = tests::CameraAt({0, 0, 6}, {0, 0, 7}, 40.0, 64, 64);
  EXPECT_EQ(EdgesOf(scene, away).edges, 0);
}

TEST(ViewEdges, EdgesThroughTheCameraPlaneAreClipped) {
  Mesh floor = tests::Plate(50, 50, 0);
  ApplyTransform({RotationAboutAxis({1, 0, 0}, -1.5707963267948966), {0, -1, 0}}, floor);
  const PerspectiveCamera camera = tests::CameraAt({0, 0, 0}, {0, 0, -1}, 40.0, 64, 64);
  const Found found = EdgesOf(Painted(floor), camera);
  EXPECT_GE(found.edges, 1);
  EXPECT_LT(found.weight, 1000.0) << "no edge is longer than the field of view";
}

}  // namespace
}  // namespace pathfit::renderer
