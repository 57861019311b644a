#include "renderer/geometry/uv_atlas.h"

#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/uv_charts.h"
#include "renderer/geometry/uv_overlap.h"

namespace pathfit::renderer::uv_atlas_test {
namespace {

std::vector<double> Even(const Mesh& mesh, double density) {
  return std::vector<double>(mesh.triangles.size(), density);
}

/// A ramp that winds around an axis three times: seen along the axis it lies over itself, though
/// its normals hardly differ.
Mesh Ramp() {
  Mesh mesh;
  constexpr int kSteps = 120;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = 6.0 * std::numbers::pi * i / kSteps;
    for (const double radius : {1.0, 2.0}) {
      mesh.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.05 * angle});
    }
  }
  for (std::int32_t i = 0; i < kSteps; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  ValidateMesh(mesh, "ramp");
  return mesh;
}

/// A ball with bumps that hide parts of it from every side.
Mesh Bumpy() {
  Mesh mesh = MakeIcosphere(4, 1.0);
  for (Vec3& p : mesh.positions.Edit()) {
    p *= 1.0 + 0.25 * std::sin(7.0 * p.x) * std::sin(6.0 * p.y + 1.0) * std::sin(8.0 * p.z + 2.0);
  }
  return mesh;
}

void ExpectAtlas(Mesh mesh, double density) {
  const Mesh before = mesh;
  Mesh* const meshes[] = {&mesh};
  const std::vector<double> densities[] = {Even(mesh, density)};
  const UvAtlas atlas = MakeUvAtlas(meshes, densities);
  EXPECT_EQ(mesh.positions, before.positions);
  EXPECT_EQ(mesh.triangles, before.triangles) << "seams do not cut the surface";
  ASSERT_EQ(mesh.uv_triangles.size(), mesh.triangles.size());
  ValidateMesh(mesh, "with UVs");
  const Mesh* const separate[] = {&mesh};
  EXPECT_TRUE(HaveSeparateUvs(separate));
  double texels = 0.0;
  double metres = 0.0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    FlatTriangle flat;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 uv = std::as_const(mesh).uvs[Index(std::as_const(mesh).uv_triangles[f][k])];
      flat[k] = {uv.x * atlas.width, uv.y * atlas.height};
    }
    const double own_texels = 0.5 * TwiceArea(flat);
    const double own_metres = 0.5 * Norm(TwiceArea(mesh, std::as_const(mesh).triangles[f]));
    EXPECT_GT(own_texels, 0.2 * density * density * own_metres) << "and not mirrored";
    texels += own_texels;
    metres += own_metres;
  }
  EXPECT_NEAR(texels, density * density * metres, 1e-6 * texels) << "what was asked for";
}

TEST(UvAtlas, OfABall) { ExpectAtlas(MakeIcosphere(4, 0.3), 300.0); }
TEST(UvAtlas, OfACube) { ExpectAtlas(MakeCube(), 20.0); }
TEST(UvAtlas, OfAnOpenSheet) { ExpectAtlas(MakeDisk(17), 40.0); }
TEST(UvAtlas, OfARampThatLiesOverItself) { ExpectAtlas(Ramp(), 30.0); }
TEST(UvAtlas, OfABallWithBumps) { ExpectAtlas(Bumpy(), 60.0); }

TEST(UvCharts, OfACubeAreItsSides) {
  const std::vector<UvChart> charts = MakeUvCharts(MakeCube());
  ASSERT_EQ(charts.size(), 6U);
  for (const UvChart& chart : charts) {
    EXPECT_EQ(chart.triangles.size(), 2U);
    EXPECT_NEAR(chart.size.x, 2.0, 1e-12) << "upright";
    EXPECT_NEAR(chart.size.y, 2.0, 1e-12);
  }
}

TEST(UvCharts, OfABallAreFew) { EXPECT_LE(MakeUvCharts(MakeIcosphere(5, 1.0)).size(), 16U); }

TEST(UvAtlas, IsTheSameForTheSameMesh) {
  Mesh a = Bumpy();
  Mesh b = Bumpy();
  Mesh* const first[] = {&a};
  Mesh* const second[] = {&b};
  const std::vector<double> densities[] = {Even(a, 50.0)};
  MakeUvAtlas(first, densities);
  MakeUvAtlas(second, densities);
  EXPECT_EQ(a.uvs, b.uvs);
  EXPECT_EQ(a.uv_triangles, b.uv_triangles);
}

TEST(UvAtlas, IsSharedBySeveralMeshes) {
  Mesh ball = MakeIcosphere(3, 1.0);
  Mesh cube = MakeCube();
  Mesh* const meshes[] = {&ball, &cube};
  const std::vector<double> densities[] = {Even(ball, 20.0), Even(cube, 40.0)};
  MakeUvAtlas(meshes, densities);
  const Mesh* const both[] = {&ball, &cube};
  EXPECT_TRUE(HaveSeparateUvs(both));
}

TEST(UvAtlas, LeavesGuttersBetweenCharts) {
  Mesh mesh = Bumpy();
  Mesh* const meshes[] = {&mesh};
  const std::vector<double> densities[] = {Even(mesh, 60.0)};
  const UvAtlas atlas = MakeUvAtlas(meshes, densities);
  // Parts of the UVs that hang together are charts.
  const Mesh& made = mesh;
  std::vector<std::set<std::int32_t>> charts;
  std::vector<std::size_t> chart_of(made.uvs.size());
  for (std::size_t i = 0; i < chart_of.size(); ++i) chart_of[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (const Triangle& t : made.uv_triangles) {
      const std::size_t least =
          std::min({chart_of[Index(t[0])], chart_of[Index(t[1])], chart_of[Index(t[2])]});
      for (const std::int32_t i : t) {
        changed = changed || chart_of[Index(i)] != least;
        chart_of[Index(i)] = least;
      }
    }
  }
  EXPECT_EQ(std::set<std::size_t>(chart_of.begin(), chart_of.end()).size(),
            static_cast<std::size_t>(atlas.charts));
  for (std::size_t i = 0; i < made.uvs.size(); ++i) {
    const Vec2 a{made.uvs[i].x * atlas.width, made.uvs[i].y * atlas.height};
    EXPECT_GE(std::min({a.x, a.y, atlas.width - a.x, atlas.height - a.y}), kAtlasGutter);
    for (std::size_t j = 0; j < i; ++j) {
      if (chart_of[i] == chart_of[j]) continue;
      const Vec2 b{made.uvs[j].x * atlas.width, made.uvs[j].y * atlas.height};
      ASSERT_GE(std::hypot(a.x - b.x, a.y - b.y), 2.0 * kAtlasGutter - 1e-6);
    }
  }
}

TEST(UvAtlas, OfTheLargestSizeHasFewerTexels) {
  Mesh ball = MakeIcosphere(3, 1.0);
  Mesh* const meshes[] = {&ball};
  const std::vector<double> densities[] = {Even(ball, 1000.0)};
  const UvAtlas atlas = MakeUvAtlas(meshes, densities, {.max_side = 256});
  EXPECT_LE(std::max(atlas.width, atlas.height), 256);
  EXPECT_LT(atlas.scale, 0.1);
  const std::vector<double> few[] = {Even(ball, 10.0)};
  EXPECT_THROW(MakeUvAtlas(meshes, few, {.max_side = 8}), SceneError);
}

TEST(UvOverlap, IsSeenWhereTrianglesShareOnlyACorner) {
  FlatTriangles placed({0.0, 0.0}, {2.0, 2.0}, 4);
  placed.Add({{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}});
  EXPECT_FALSE(placed.Meets({{{1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}})) << "a side";
  EXPECT_FALSE(placed.Meets({{{1.0, 0.0}, {2.0, 0.0}, {2.0, 1.0}}})) << "a corner";
  EXPECT_TRUE(placed.Meets({{{0.0, 0.0}, {0.5, 0.1}, {0.1, 0.5}}})) << "inside";
  EXPECT_TRUE(placed.Meets({{{-1.0, -1.0}, {2.0, 0.5}, {0.5, 2.0}}})) << "across";
  EXPECT_EQ(placed.SharedArea({{{1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}}), 0.0);
  EXPECT_NEAR(placed.SharedArea({{{-1.0, -1.0}, {3.0, -1.0}, {-1.0, 3.0}}}), 0.5, 1e-12);
  EXPECT_NEAR(placed.SharedArea({{{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}}), 0.25, 1e-12);
}

TEST(UvOverlap, UvsOfPrimitivesAreNotAlwaysSeparate) {
  const auto separate = [](const Mesh& mesh) {
    const Mesh* const meshes[] = {&mesh};
    return HaveSeparateUvs(meshes);
  };
  EXPECT_TRUE(separate(MakeRectangle()));
  Mesh box = MakeCube();
  EXPECT_FALSE(separate(box)) << "no UVs";
  SetBoxUvs(box);
  EXPECT_FALSE(separate(box)) << "all sides have all of the picture";
  Mesh globe = MakeIcosphere(3, 1.0);
  SetSphereUvs(globe);
  EXPECT_FALSE(separate(globe)) << "beyond the date line";
  // Slips of whoever laid the triangles out, on 1 280 of them.
  Mesh ball = MakeIcosphere(3, 1.0);
  Mesh* const edited[] = {&ball};
  const std::vector<double> densities[] = {Even(ball, 100.0)};
  MakeUvAtlas(edited, densities);
  ASSERT_TRUE(separate(ball));
  auto& triangles = ball.uv_triangles.Edit();
  triangles[0][1] = triangles[0][0];
  EXPECT_TRUE(separate(ball)) << "one without an area";
  triangles[0] = triangles[100];
  EXPECT_TRUE(separate(ball)) << "one over another";
  for (std::size_t f = 0; f < 40; ++f) triangles[f] = triangles[100 + f];
  EXPECT_FALSE(separate(ball)) << "one in 32";
}

}  // namespace
}  // namespace pathfit::renderer::uv_atlas_test
