#include "renderer/geometry/mesh.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "renderer/core/error.h"

namespace pathfit::renderer::mesh_test {
namespace {

Mesh MakeTetrahedron() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

std::string ErrorOf(const Mesh& mesh) {
  try {
    ValidateMesh(mesh, "shape");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(Mesh, WeldMergesEqualPositionsInOrderOfFirstAppearance) {
  Mesh mesh;
  mesh.positions = {
      {9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-0.0, -0.0, 0}, {1, 1, 0}};
  mesh.triangles = {{1, 2, 3}, {3, 4, 6}};
  mesh.triangles.push_back({5, 3, 6});
  mesh.colors = {{0.1, 0.2, 0.3}};
  mesh.color_triangles = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  WeldPositions(mesh);
  const std::vector<Vec3> expected = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  EXPECT_EQ(mesh.positions, expected);
  const std::vector<Triangle> triangles = {{0, 1, 2}, {2, 1, 3}, {0, 2, 3}};
  EXPECT_EQ(mesh.triangles, triangles);
  EXPECT_EQ(mesh.color_triangles.size(), 3U);
}

TEST(Mesh, WeldKeepsPositionsThatDifferInTheLastBit) {
  Mesh mesh = MakeTetrahedron();
  mesh.positions.push_back({std::nextafter(1.0, 2.0), 0, 0});
  mesh.triangles.push_back({4, 2, 3});
  WeldPositions(mesh);
  EXPECT_EQ(mesh.positions.size(), 5U);
}

TEST(Mesh, WeldRefusesAnIndexOutOfRange) {
  Mesh mesh = MakeTetrahedron();
  mesh.triangles[2][1] = 4;
  EXPECT_THROW(WeldPositions(mesh), SceneError);
}

TEST(Mesh, ValidateAcceptsClosedAndOpenMeshes) {
  EXPECT_EQ(ErrorOf(MakeTetrahedron()), "");
  Mesh open = MakeTetrahedron();
  open.triangles.pop_back();
  EXPECT_EQ(ErrorOf(open), "");
}

struct BrokenMesh {
  std::string message;
  std::function<void(Mesh&)> breaks;
};

TEST(Mesh, ValidateNamesTheFirstOffendingElement) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const BrokenMesh cases[] = {
      {"no triangle", [](Mesh& m) { m.triangles.clear(); }},
      {"triangle 1 has position indices (0, 1, 4)", [](Mesh& m) { m.triangles[1][2] = 4; }},
      {"triangle 3 has position indices (1, 2, -1)", [](Mesh& m) { m.triangles[3][2] = -1; }},
      {"triangle 2 repeats a vertex: (0, 3, 0)", [](Mesh& m) { m.triangles[2][2] = 0; }},
      {"position 2 is not finite: (0, nan, 0)", [nan](Mesh& m) { m.positions[2].y = nan; }},
      {"position 0 is not finite", [](Mesh& m) { m.positions[0].x = HUGE_VAL; }},
      {"triangle 0 has zero area: (0, 0, 0), (2, 0, 0), (1, 0, 0)",
       [](Mesh& m) {
         m.positions[2] = {2, 0, 0};
       }},
      {"position 1 is beyond 1e12 metres",
       [](Mesh& m) {
         m.positions[1] = {1e200, 0, 0};
       }},
      {"position 4, (5, 5, 5), is used by no triangle",
       [](Mesh& m) {
         m.positions.push_back({5, 5, 5});
       }},
      {"triangle 4 has the corners of triangle 1: (3, 0, 1), at (0, 0, 1)",
       [](Mesh& m) {
         m.triangles.push_back({3, 0, 1});
       }},
      {"triangle 1 has the corners of triangle 0: (0, 1, 2)",
       [](Mesh& m) {
         m.positions.pop_back();
         m.triangles = {{0, 2, 1}, {0, 1, 2}};
       }},
      {"normal 1 of triangle 2 is zero",
       [](Mesh& m) {
         m.normals = {{0, 0, 1}, {0, 0, 0}};
         m.normal_triangles = {{0, 0, 0}, {0, 0, 0}, {0, 0, 1}, {0, 0, 0}};
       }},
      {"edge (1, 2) of triangle 4, from (1, 0, 0) to (0, 1, 0), has more than two triangles",
       [](Mesh& m) {
         m.positions.push_back({2, 2, 2});
         m.triangles.push_back({1, 2, 4});
       }},
      {"edge (1, 3) of triangle 3, from (1, 0, 0) to (0, 0, 1), has two triangles of inconsistent",
       [](Mesh& m) {
         m.triangles[3] = {1, 3, 2};
       }},
      {"1 color triangles for 4 triangles",
       [](Mesh& m) {
         m.colors = {{1, 1, 1}};
         m.color_triangles = {{0, 0, 0}};
       }},
      {"triangle 0 has uv indices (0, 1, 2)",
       [](Mesh& m) {
         m.uv_triangles = MakeTetrahedron().triangles;
         m.uv_triangles[0] = {0, 1, 2};
       }},
      {"color 0 is not finite",
       [nan](Mesh& m) {
         m.colors = {{nan, 1, 1}};
       }},
      {"normal 0 is not finite",
       [nan](Mesh& m) {
         m.normals = {{nan, 1, 1}};
       }},
      {"uv 0 is not finite",
       [nan](Mesh& m) {
         m.uvs = {{nan, 1}};
       }},
  };
  for (const BrokenMesh& broken : cases) {
    Mesh mesh = MakeTetrahedron();
    broken.breaks(mesh);
    const std::string message = ErrorOf(mesh);
    EXPECT_NE(message.find("mesh 'shape': "), std::string::npos) << broken.message;
    EXPECT_NE(message.find(broken.message), std::string::npos)
        << "got: " << message << "\nwant: " << broken.message;
  }
}

TEST(Mesh, IcosphereIsClosedAndPointsOutward) {
  for (int level = 0; level <= 4; ++level) {
    const Mesh mesh = MakeIcosphere(level, 2.5);
    const std::size_t faces = 20U << (2 * level);
    EXPECT_EQ(mesh.triangles.size(), faces);
    EXPECT_EQ(mesh.positions.size(), faces / 2 + 2);
    EXPECT_EQ(ErrorOf(mesh), "");
    for (const Vec3& p : mesh.positions) EXPECT_NEAR(Norm(p), 2.5, 1e-14 * 2.5);
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3& x = mesh.positions[static_cast<std::size_t>(a)];
      const Vec3& y = mesh.positions[static_cast<std::size_t>(b)];
      const Vec3& z = mesh.positions[static_cast<std::size_t>(c)];
      EXPECT_GT(Dot(Cross(y - x, z - x), x + y + z), 0.0);
    }
  }
  const double sphere = 4.0 / 3.0 * std::numbers::pi;
  EXPECT_NEAR(SignedVolume(MakeIcosphere(4, 1.0)), sphere, 0.01 * sphere);
}

TEST(Mesh, IcosphereRefusesNonsense) {
  EXPECT_THROW(MakeIcosphere(-1, 1.0), SceneError);
  EXPECT_THROW(MakeIcosphere(40, 1.0), SceneError);
  EXPECT_THROW(MakeIcosphere(1, 0.0), SceneError);
  EXPECT_THROW(MakeIcosphere(1, std::nan("")), SceneError);
}

TEST(Mesh, TransformScalesVolumeAndKeepsItPositiveUnderReflection) {
  Mesh mesh = MakeTetrahedron();
  EXPECT_DOUBLE_EQ(SignedVolume(mesh), 1.0 / 6.0);
  mesh.normals = {{1, 0, 0}};
  mesh.normal_triangles = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  ApplyTransform({{{-2, 0, 0}, {0, 3, 0}, {0, 0, 1}}, {5, 6, 7}}, mesh);
  EXPECT_EQ(mesh.positions[1], (Vec3{3, 6, 7}));
  EXPECT_NEAR(SignedVolume(mesh), 1.0, 1e-13);
  EXPECT_EQ(mesh.normals[0], (Vec3{-1, 0, 0}));
  EXPECT_EQ(ErrorOf(mesh), "");
}

TEST(Mesh, NormalsStayPerpendicularUnderShear) {
  Mesh mesh;
  mesh.normals = {{0, 1, 0}};
  const Transform shear = {{{1, 0.5, 0}, {0, 1, 0}, {0, 0, 1}}, {}};
  ApplyTransform(shear, mesh);
  EXPECT_NEAR(Dot(mesh.normals[0], shear.Direction({1, 0, 0})), 0.0, 1e-15);
  EXPECT_NEAR(Norm(mesh.normals[0]), 1.0, 1e-15);
  EXPECT_GT(mesh.normals[0].y, 0.0);
}

TEST(Mesh, ReflectionKeepsNormalsOnTheSideOfTheWinding) {
  Mesh mesh = MakeIcosphere(1, 1.0);
  mesh.normals = mesh.positions;
  mesh.normal_triangles = mesh.triangles;
  ApplyTransform({{{0.3, 0.5, 0.1}, {-0.2, 2, 0}, {0.4, 0.1, -1.5}}, {1, 2, 3}}, mesh);
  EXPECT_GT(SignedVolume(mesh), 0.0);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const auto at = [&](std::size_t k) {
      return mesh.positions[static_cast<std::size_t>(mesh.triangles[f][k])];
    };
    const Vec3 face = Cross(at(1) - at(0), at(2) - at(0));
    for (const std::int32_t i : mesh.normal_triangles[f]) {
      EXPECT_GT(Dot(face, mesh.normals[static_cast<std::size_t>(i)]), 0.0);
    }
  }
}

TEST(Mesh, TransformRefusesASingularMatrix) {
  Mesh mesh = MakeTetrahedron();
  EXPECT_THROW(ApplyTransform({{{1, 0, 0}, {0, 0, 0}, {0, 0, 1}}, {}}, mesh), SceneError);
}

TEST(Mesh, UniformVertexColorsHaveOneColorPerPosition) {
  Mesh mesh = MakeTetrahedron();
  EXPECT_FALSE(mesh.HasColors());
  SetUniformVertexColors({0.1, 0.2, 0.3}, mesh);
  EXPECT_TRUE(mesh.HasColors());
  EXPECT_EQ(mesh.colors.size(), 4U);
  EXPECT_EQ(mesh.colors[3], (Rgb{0.1, 0.2, 0.3}));
  EXPECT_EQ(mesh.color_triangles, mesh.triangles);
}

}  // namespace
}  // namespace pathfit::renderer::mesh_test
