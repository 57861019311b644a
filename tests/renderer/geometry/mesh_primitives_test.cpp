#include "renderer/geometry/mesh_primitives.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "renderer/core/error.h"

namespace pathfit::renderer::mesh_primitives_test {
namespace {

constexpr double kRounding = 1e-12;

struct Corner {
  Vec3 position;
  Vec2 uv;
};
std::array<Corner, 3> CornersOf(const Mesh& mesh, std::size_t triangle) {
  std::array<Corner, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k] = {mesh.positions[static_cast<std::size_t>(mesh.triangles[triangle][k])],
                  mesh.uvs[static_cast<std::size_t>(mesh.uv_triangles[triangle][k])]};
  }
  return corners;
}

// Positive where the picture is not mirrored, as seen from outside.
double UvArea(const std::array<Corner, 3>& c) {
  return (c[1].uv.x - c[0].uv.x) * (c[2].uv.y - c[0].uv.y) -
         (c[2].uv.x - c[0].uv.x) * (c[1].uv.y - c[0].uv.y);
}

TEST(MeshPrimitives, DiskIsAPolygonOnTheUnitCircle) {
  const Mesh disk = MakeDisk(100);
  ValidateMesh(disk, "disk");
  double area = 0.0;
  for (std::size_t t = 0; t < disk.triangles.size(); ++t) {
    const std::array<Corner, 3> c = CornersOf(disk, t);
    const Vec3 twice = Cross(c[1].position - c[0].position, c[2].position - c[0].position);
    EXPECT_GT(twice.z, 0.0);
    area += 0.5 * twice.z;
    EXPECT_GT(UvArea(c), 0.0);
    EXPECT_NEAR(c[1].uv.x, 0.5 + 0.5 * c[1].position.x, kRounding);
  }
  EXPECT_NEAR(area, 50.0 * std::sin(2.0 * std::acos(-1.0) / 100.0), kRounding);
  EXPECT_THROW(MakeDisk(2), SceneError);
}

TEST(MeshPrimitives, EverySideOfABoxShowsTheWholePictureUpright) {
  Mesh cube = MakeCube();
  SetBoxUvs(cube);
  ValidateMesh(cube, "cube");
  EXPECT_EQ(cube.uvs.size(), 20U) << "24, of which 4 pairs agree at a corner";
  double area = 0.0;
  for (std::size_t t = 0; t < cube.triangles.size(); ++t) {
    const std::array<Corner, 3> c = CornersOf(cube, t);
    EXPECT_NEAR(UvArea(c), 1.0, kRounding) << "twice half a picture, not mirrored";
    area += 0.5 * UvArea(c);
    const Vec3 n = Cross(c[1].position - c[0].position, c[2].position - c[0].position);
    for (const Corner& corner : c) {
      if (n.y == 0.0) {
        EXPECT_NEAR(corner.uv.y, 0.5 + 0.5 * corner.position.y, kRounding);
      }
    }
  }
  EXPECT_NEAR(area, 6.0, kRounding);
}

TEST(MeshPrimitives, GlobeUvsAreNotMirroredOrTornAtTheDateLine) {
  Mesh sphere = MakeIcosphere(3, 2.0);
  SetSphereUvs(sphere);
  ValidateMesh(sphere, "sphere");
  double area = 0.0;
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    const std::array<Corner, 3> c = CornersOf(sphere, t);
    area += 0.5 * UvArea(c);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LE(std::abs(c[k].uv.x - c[(k + 1) % 3].uv.x), 0.5);
      const double angle = 2.0 * std::acos(-1.0) * (c[k].uv.x - 0.5);
      const double radius = std::hypot(c[k].position.x, c[k].position.z);
      EXPECT_NEAR(radius * std::sin(angle), c[k].position.x, 1e-9);
      EXPECT_NEAR(radius * std::cos(angle), c[k].position.z, 1e-9);
      EXPECT_NEAR(-2.0 * std::cos(std::acos(-1.0) * c[k].uv.y), c[k].position.y, 1e-9);
    }
  }
  EXPECT_NEAR(area, 1.0, 0.05) << "the map is covered once";
}

}  // namespace
}  // namespace pathfit::renderer::mesh_primitives_test
