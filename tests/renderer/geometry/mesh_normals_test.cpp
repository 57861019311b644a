#include "renderer/geometry/mesh_normals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_primitives.h"

namespace pathfit::renderer::mesh_normals_test {
namespace {

void ExpectNear(const Vec3& a, const Vec3& b, double tolerance) {
  EXPECT_LT(Norm(a - b), tolerance) << a.x << " " << a.y << " " << a.z;
}

TEST(VertexNormals, OfACubePointAlongItsDiagonalsHoweverItsFacesAreCut) {
  Mesh cube = MakeCube();
  ComputeVertexNormals(cube);
  EXPECT_EQ(cube.normal_triangles, cube.triangles);
  ASSERT_EQ(cube.normals.size(), 8U);
  // Three faces with a right angle each, whether it is in one triangle or two.
  for (std::size_t i = 0; i < 8; ++i) {
    ExpectNear(cube.normals[i], Normalized(cube.positions[i]), 1e-15);
  }
}

/// Largest distance between the smooth and the radial normals of an icosphere.
double RadialError(int subdivisions) {
  Mesh sphere = MakeIcosphere(subdivisions, 2.0);
  ComputeVertexNormals(sphere);
  double error = 0.0;
  for (std::size_t i = 0; i < sphere.normals.size(); ++i) {
    error = std::max(error, Norm(sphere.normals[i] - sphere.positions[i] / 2.0));
    EXPECT_NEAR(Norm(sphere.normals[i]), 1.0, 1e-15);
  }
  return error;
}

TEST(VertexNormals, OfASphereBecomeRadial) {
  // By symmetry exact at first, then of first order in the edge length where triangles are uneven.
  EXPECT_LT(RadialError(0), 1e-15);
  for (int level = 2; level < 5; ++level) {
    EXPECT_NEAR(RadialError(level) / RadialError(level + 1), 2.0, 0.01);
  }
}

TEST(VertexNormals, AreUnitWhereTrianglesAreOpposedOrDegenerate) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 1}, {0, 1, 3}, {3, 3, 3}};
  ComputeVertexNormals(mesh);
  for (const Vec3& normal : mesh.normals) ExpectNear({0, 0, std::abs(normal.z)}, {0, 0, 1}, 1e-15);
  Mesh wrong = MakeCube();
  wrong.triangles[3][1] = 8;
  EXPECT_THROW(ComputeVertexNormals(wrong), SceneError);
}

TEST(VertexNormals, CanBeRemoved) {
  Mesh cube = MakeCube();
  ComputeVertexNormals(cube);
  RemoveVertexNormals(cube);
  EXPECT_TRUE(cube.normals.empty());
  EXPECT_TRUE(cube.normal_triangles.empty());
  EXPECT_NO_THROW(ValidateMesh(cube, "cube"));
}

TEST(VertexNormals, AreNormalizedAndOnlyBadOnesReplaced) {
  Mesh cube = MakeCube();
  Mesh smooth = cube;
  ComputeVertexNormals(smooth);
  // One normal for each face of two triangles; that of the top of the cube is missing, and one has
  // a length whose square does not fit a double.
  cube.normals = {{0, 0, -3}, {0, 0, 0}, {0, -1, 0}, {0, 1e-200, 0}, {-1e300, 0, 0}, {1, 0, 0}};
  for (std::int32_t face = 0; face < 6; ++face) {
    for (int i = 0; i < 2; ++i) cube.normal_triangles.push_back({face, face, face});
  }
  EXPECT_EQ(NormalizeVertexNormals(cube), 1);
  EXPECT_EQ(cube.normals[0], (Vec3{0, 0, -1}));
  EXPECT_EQ(cube.normals[3], (Vec3{0, 1, 0}));
  EXPECT_EQ(cube.normals[4], (Vec3{-1, 0, 0}));
  // Four positions share the missing one: it serves one of them, three are new.
  EXPECT_EQ(cube.normals.size(), 9U);
  for (const std::size_t f : {2U, 3U}) {
    for (std::size_t k = 0; k < 3; ++k) {
      ExpectNear(cube.normals[static_cast<std::size_t>(cube.normal_triangles[f][k])],
                 smooth.normals[static_cast<std::size_t>(cube.triangles[f][k])],
                 1e-15);
    }
  }
  EXPECT_NO_THROW(ValidateMesh(cube, "cube"));
  EXPECT_EQ(NormalizeVertexNormals(cube), 0);
}

TEST(VertexNormals, ThatAreNotFiniteAreReplaced) {
  Mesh cube = MakeCube();
  ComputeVertexNormals(cube);
  const std::vector<Vec3> smooth = cube.normals;
  cube.normals[2].y = std::numeric_limits<double>::quiet_NaN();
  cube.normals[7].x = std::numeric_limits<double>::infinity();
  EXPECT_EQ(NormalizeVertexNormals(cube), 2);
  for (std::size_t i = 0; i < 8; ++i) ExpectNear(cube.normals[i], smooth[i], 1e-15);
  cube.normals[2] = {};
  cube.normal_triangles.pop_back();
  EXPECT_THROW(NormalizeVertexNormals(cube), SceneError);
}

}  // namespace
}  // namespace pathfit::renderer::mesh_normals_test
