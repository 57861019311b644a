#include "renderer/geometry/tangents.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/uv_atlas.h"

namespace pathfit::renderer::tangents_test {
namespace {

/// A square in the plane z = 0 with UVs of its own.
Mesh Square(const std::array<Vec2, 4>& uvs) {
  Mesh mesh;
  mesh.positions = {Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{2, 2, 0}, Vec3{0, 2, 0}};
  mesh.triangles = {Triangle{0, 1, 2}, Triangle{0, 2, 3}};
  mesh.uvs = {uvs[0], uvs[1], uvs[2], uvs[3]};
  mesh.uv_triangles = mesh.triangles;
  ComputeVertexNormals(mesh);
  return mesh;
}

void ExpectNear(const Vec3& a, const Vec3& b) {
  EXPECT_NEAR(Norm(a - b), 0.0, 1e-12) << a.x << " " << a.y << " " << a.z;
}

TEST(Tangents, RunAlongU) {
  const Mesh mesh = Square({{{0, 0}, {1, 0}, {1, 1}, {0, 1}}});
  for (const auto& triangle : MakeTangents(mesh)) {
    for (const Tangent& tangent : triangle) {
      ExpectNear(tangent.along_u, {1, 0, 0});
      EXPECT_EQ(tangent.sign, 1.0);
    }
  }
  const ShadingFrame frame = InterpolateFrame(mesh, 0, MakeTangents(mesh)[0], {0.2, 0.3, 0.5});
  ExpectNear(frame.u, {1, 0, 0});
  ExpectNear(frame.v, {0, 1, 0});
  ExpectNear(frame.normal, {0, 0, 1});
}

TEST(Tangents, KnowTurnedAndMirroredPictures) {
  const Mesh turned = Square({{{0, 1}, {0, 0}, {1, 0}, {1, 1}}});
  ExpectNear(MakeTangents(turned)[0][0].along_u, {0, 1, 0});
  EXPECT_EQ(MakeTangents(turned)[0][0].sign, 1.0);
  const Mesh mirrored = Square({{{1, 0}, {0, 0}, {0, 1}, {1, 1}}});
  const Tangent tangent = MakeTangents(mirrored)[1][2];
  ExpectNear(tangent.along_u, {-1, 0, 0});
  EXPECT_EQ(tangent.sign, -1.0);
  ExpectNear(InterpolateFrame(mirrored, 0, MakeTangents(mirrored)[0], {1, 0, 0}).v, {0, 1, 0});
}

TEST(Tangents, AreUnitAndFlatOnABallWithAnAtlas) {
  Mesh ball = MakeIcosphere(2, 0.5);
  ComputeVertexNormals(ball);
  Mesh* const meshes[] = {&ball};
  const std::vector<double> densities[] = {std::vector<double>(ball.triangles.size(), 50.0)};
  MakeUvAtlas(meshes, densities);
  const auto tangents = MakeTangents(ball);
  for (std::size_t f = 0; f < tangents.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(ball.normal_triangles[f][k]);
      EXPECT_NEAR(Norm(tangents[f][k].along_u), 1.0, 1e-12);
      EXPECT_NEAR(Dot(tangents[f][k].along_u, ball.normals[corner]), 0.0, 1e-12);
      EXPECT_EQ(tangents[f][k].sign, 1.0);
    }
  }
}

TEST(Tangents, CollapsedUvsHaveAnyFrame) {
  const Mesh mesh = Square({{{0.5, 0.5}, {0.5, 0.5}, {0.5, 0.5}, {0.5, 0.5}}});
  const ShadingFrame frame = InterpolateFrame(mesh, 1, MakeTangents(mesh)[1], {0.2, 0.3, 0.5});
  EXPECT_NEAR(Norm(frame.u), 1.0, 1e-12);
  EXPECT_NEAR(Dot(frame.u, frame.normal), 0.0, 1e-12);
}

}  // namespace
}  // namespace pathfit::renderer::tangents_test
