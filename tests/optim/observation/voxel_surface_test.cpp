#include "optim/observation/voxel_surface.h"

#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_topology.h"

namespace pathfit::optim::voxel_surface_test {
namespace {

using renderer::Mesh;
using renderer::Triangle;
using renderer::Vec3;

/// Unit cubes with these low corners, wound outward; positions welded, so that cubes may touch.
Mesh Cubes(std::initializer_list<Vec3> corners) {
  Mesh mesh;
  for (const Vec3& corner : corners) {
    const auto first = static_cast<std::int32_t>(mesh.positions.size());
    for (int i = 0; i < 8; ++i) {
      mesh.positions.push_back(corner + Vec3{static_cast<double>(i & 1),
                                             static_cast<double>(i >> 1 & 1),
                                             static_cast<double>(i >> 2)});
    }
    const std::vector<Triangle> cube = {{0, 2, 1},
                                        {1, 2, 3},
                                        {4, 5, 6},
                                        {5, 7, 6},
                                        {0, 1, 4},
                                        {1, 5, 4},
                                        {2, 6, 3},
                                        {3, 6, 7},
                                        {0, 4, 2},
                                        {2, 4, 6},
                                        {1, 3, 5},
                                        {3, 7, 5}};
    for (const Triangle& t : cube) {
      mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  }
  WeldPositions(mesh);
  return mesh;
}

void ExpectClosedManifold(const Mesh& mesh) {
  ASSERT_NO_THROW(ValidateMesh(mesh, "test"));
  EXPECT_TRUE(renderer::MeshTopology::Build(mesh).closed);
}

TEST(SeparateTouchingParts, LeavesAManifoldAlone) {
  Mesh mesh = Cubes({{0.0, 0.0, 0.0}});
  const std::vector<Vec3> before = mesh.positions;
  SeparateTouchingParts(0.01, mesh);
  EXPECT_EQ(mesh.positions, before);
  ExpectClosedManifold(mesh);
}

TEST(SeparateTouchingParts, CutsACommonEdgeBetweenTheBodies) {
  for (const Vec3& diagonal : {Vec3{1.0, 1.0, 0.0}, Vec3{1.0, -1.0, 0.0}, Vec3{0.0, 1.0, -1.0}}) {
    Mesh mesh = Cubes({{0.0, 0.0, 0.0}, diagonal});
    ASSERT_EQ(mesh.positions.size(), 14U);
    EXPECT_THROW(ValidateMesh(mesh, "test"), renderer::SceneError);
    SeparateTouchingParts(0.01, mesh);
    EXPECT_EQ(mesh.positions.size(), 16U);
    ExpectClosedManifold(mesh);
    EXPECT_LT(SignedVolume(mesh), 2.0);  // the copies moved inwards
    EXPECT_GT(SignedVolume(mesh), 1.95);
    WeldPositions(mesh);
    ExpectClosedManifold(mesh);
    KeepLargestPart(mesh);
    EXPECT_EQ(mesh.positions.size(), 8U);
  }
}

TEST(SeparateTouchingParts, CutsACommonVertex) {
  Mesh mesh = Cubes({{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}});
  ASSERT_EQ(mesh.positions.size(), 15U);
  SeparateTouchingParts(0.01, mesh);
  EXPECT_EQ(mesh.positions.size(), 16U);
  ExpectClosedManifold(mesh);
}

TEST(SeparateTouchingParts, RefusesAnOpenSurface) {
  Mesh mesh = Cubes({{0.0, 0.0, 0.0}});
  mesh.triangles.pop_back();
  EXPECT_THROW(SeparateTouchingParts(0.01, mesh), renderer::SceneError);
  mesh = Cubes({{0.0, 0.0, 0.0}});
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  EXPECT_THROW(SeparateTouchingParts(0.01, mesh), renderer::SceneError);
}

TEST(KeepLargestPart, ComparesEnclosedVolume) {
  Mesh mesh = Cubes({{0.0, 0.0, 0.0}, {4.0, 0.0, 0.0}, {8.0, 0.0, 0.0}});
  for (std::size_t i = 8; i < 16; ++i) {
    mesh.positions[i].y *= 1.5;
  }
  KeepLargestPart(mesh);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_NEAR(SignedVolume(mesh), 1.5, 1e-12);
  ExpectClosedManifold(mesh);
}

}  // namespace
}  // namespace pathfit::optim::voxel_surface_test
