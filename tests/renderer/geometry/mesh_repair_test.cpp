#include "renderer/geometry/mesh_repair.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/mesh_topology.h"

namespace pathfit::renderer::mesh_repair_test {
namespace {

std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }

void Append(const Mesh& part, const Vec3& offset, Mesh& mesh) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (const Vec3& p : part.positions) mesh.positions.push_back(p + offset);
  for (const auto& [a, b, c] : part.triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
}

/// A strip of `count` quads along x from y = low to high, in the plane spanned by x and `across`.
Mesh Strip(int count, const Vec3& low, const Vec3& across) {
  Mesh mesh;
  for (int i = 0; i <= count; ++i) {
    const Vec3 along = {static_cast<double>(i), 0, 0};
    mesh.positions.push_back(low + along);
    mesh.positions.push_back(low + along + across);
    if (i == 0) continue;
    const std::int32_t k = 2 * i;
    mesh.triangles.push_back({k - 2, k, k + 1});
    mesh.triangles.push_back({k - 2, k + 1, k - 1});
  }
  return mesh;
}

/// Surface of cubes of side 2 with these middles, whose common faces vanish.
Mesh Voxels(const std::vector<Vec3>& middles) {
  Mesh mesh;
  const Mesh cube = MakeCube();
  for (const Vec3& middle : middles) {
    const auto first = static_cast<std::int32_t>(mesh.positions.size());
    for (const Vec3& p : cube.positions) mesh.positions.push_back(p + middle);
    for (std::size_t f = 0; f < cube.triangles.size(); ++f) {
      const auto& [a, b, c] = cube.triangles[f];
      const Vec3& o = cube.positions[Index(a)];
      const Vec3 outward = Cross(cube.positions[Index(b)] - o, cube.positions[Index(c)] - o) * 0.5;
      if (std::find(middles.begin(), middles.end(), middle + outward) != middles.end()) continue;
      mesh.triangles.push_back({first + a, first + b, first + c});
    }
  }
  return mesh;
}

std::string ErrorOf(const Mesh& mesh) {
  try {
    RepairMesh(mesh, "shape");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

double AreaOf(const Mesh& mesh) {
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3& o = mesh.positions[Index(a)];
    area += 0.5 * Norm(Cross(mesh.positions[Index(b)] - o, mesh.positions[Index(c)] - o));
  }
  return area;
}

TEST(RepairMesh, LeavesAGoodMeshAlone) {
  for (const Mesh& good : {MakeCube(), MakeRectangle(), MakeIcosphere(2, 0.7)}) {
    MeshRepairs repairs;
    const Mesh mesh = RepairMesh(good, "good", &repairs);
    EXPECT_EQ(repairs, MeshRepairs{});
    EXPECT_EQ(Describe(repairs), "");
    EXPECT_EQ(mesh.positions, good.positions);
    EXPECT_EQ(mesh.triangles, good.triangles);
    EXPECT_EQ(mesh.uv_triangles, good.uv_triangles);
  }
}

TEST(RepairMesh, DropsWhatCannotBeSeenAndKeepsAttributesAligned) {
  Mesh mesh = MakeRectangle();
  mesh.positions.push_back({9, 9, 9});          // unused
  mesh.positions.push_back(mesh.positions[1]);  // equal to 1
  mesh.positions.push_back({0, -1, 0});         // between 0 and 1
  mesh.triangles = {{0, 5, 2}, {0, 0, 2}, {0, 1, 6}, {2, 0, 1}, {0, 2, 3}, {0, 3, 2}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {.5, 0}};
  mesh.uv_triangles = {{0, 1, 2}, {0, 0, 2}, {0, 1, 4}, {2, 0, 1}, {0, 2, 3}, {0, 3, 2}};
  mesh.normals = {{0, 0, 2}, {0, 0, 0}};
  mesh.normal_triangles.assign(6, Triangle{0, 0, 1});
  MeshRepairs repairs;
  const Mesh repaired = RepairMesh(mesh, "shape", &repairs);
  EXPECT_EQ(repairs.merged_positions, 1);
  EXPECT_EQ(repairs.unused_positions, 2);  // the second became so with its sliver
  EXPECT_EQ(repairs.replaced_normals, 1);
  EXPECT_EQ(repairs.degenerate_triangles, 2);
  EXPECT_EQ(repairs.duplicate_triangles, 2);
  EXPECT_EQ(repairs.turned_triangles, 0);
  EXPECT_EQ(repaired.positions.size(), 4U);
  EXPECT_EQ(repaired.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(repaired.uv_triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(repaired.normal_triangles.size(), 2U);
  EXPECT_EQ(Describe(repairs),
            "1 position merged, 2 unused positions dropped, 1 normal of length zero replaced, "
            "2 triangles without area dropped, 2 duplicate triangles dropped");
}

TEST(RepairMesh, TurnsTheMinorityOfEachSurface) {
  Mesh two = MakeIcosphere(2, 1.0);
  Append(MakeIcosphere(1, 1.0), {5, 0, 0}, two);
  const Mesh good = two;
  two.uvs = {{0, 0}, {1, 0}, {0, 1}};
  two.uv_triangles.assign(two.triangles.size(), Triangle{0, 1, 2});
  std::mt19937 random(5);
  int num_turned = 0;
  std::vector<bool> is_turned(two.triangles.size());
  for (std::size_t f = 0; f < two.triangles.size(); ++f) {
    // A third of the first sphere is turned, and two thirds of the second: it stays inside out.
    const bool first = f < 320;
    const bool turn = (random() % 3 == 0) == first;
    if (turn) std::swap(two.triangles[f][1], two.triangles[f][2]);
    if (turn == first) ++num_turned;
    is_turned[f] = turn == first;
  }
  MeshRepairs repairs;
  const Mesh repaired = RepairMesh(two, "spheres", &repairs);
  EXPECT_EQ(repairs.turned_triangles, num_turned);
  for (std::size_t f = 0; f < two.triangles.size(); ++f) {
    Triangle wanted = good.triangles[f];
    if (f >= 320) std::swap(wanted[1], wanted[2]);
    ASSERT_EQ(repaired.triangles[f], wanted) << f;
    // The UVs turned with their corners.
    EXPECT_EQ(repaired.uv_triangles[f], (is_turned[f] ? Triangle{0, 2, 1} : Triangle{0, 1, 2}));
  }
}

TEST(RepairMesh, CutsBodiesThatTouchInAnEdge) {
  Mesh mesh = MakeCube();
  Append(MakeCube(), {2, 2, 0}, mesh);
  MeshRepairs repairs;
  const Mesh repaired = RepairMesh(mesh, "cubes", &repairs);
  EXPECT_EQ(repairs.merged_positions, 2);
  EXPECT_EQ(repairs.cut_edges, 1);
  EXPECT_EQ(repairs.added_positions, 2);
  EXPECT_TRUE(MeshTopology::Build(repaired).closed);
  EXPECT_NEAR(SignedVolume(repaired), 16.0, 16.0 * kCutGap);
  // The two bodies do not touch any more: the second's copies moved into it.
  ASSERT_EQ(repaired.positions.size(), 16U);
  for (const std::size_t i : {14U, 15U}) {
    EXPECT_GT(repaired.positions[i].x, 1.0);
    EXPECT_GT(repaired.positions[i].y, 1.0);
    EXPECT_LT(repaired.positions[i].x, 1.0 + 2.0 * kCutGap);
  }
}

TEST(RepairMesh, CutsAWallFromTheFloorItStandsOn) {
  // Floor on both sides of y = 0, and a shorter wall on that line: the floor stays whole.
  for (const bool is_wall_turned : {false, true}) {
    Mesh mesh = Strip(6, {0, -1, 0}, {0, 1, 0});
    Append(Strip(6, {0, 0, 0}, {0, 1, 0}), {}, mesh);
    Mesh wall = Strip(3, {2, 0, 0}, {0, 0, 1});
    if (is_wall_turned) {
      for (Triangle& t : wall.triangles) std::swap(t[1], t[2]);
    }
    Append(wall, {}, mesh);
    MeshRepairs repairs;
    const Mesh repaired = RepairMesh(mesh, "room", &repairs);
    EXPECT_EQ(repairs.cut_edges, 3);
    EXPECT_EQ(repairs.added_positions, 4);
    EXPECT_EQ(repairs.turned_triangles, 0);
    EXPECT_NEAR(AreaOf(repaired), AreaOf(mesh), AreaOf(mesh) * kCutGap);
    const MeshTopology topology = MeshTopology::Build(repaired);
    // Around the floor 2 * 6 + 4 edges, around the wall 2 * 3 + 2.
    EXPECT_EQ(std::count_if(topology.edges.begin(),
                            topology.edges.end(),
                            [](const MeshEdge& e) { return e.faces[1] < 0; }),
              24);
  }
}

TEST(RepairMesh, RefusesWhatCannotBeMended) {
  Mesh empty = MakeCube();
  for (Triangle& t : empty.triangles) t = {0, 0, 1};
  EXPECT_NE(ErrorOf(empty).find("mesh 'shape': it has no triangle"), std::string::npos);
  Mesh nan = MakeCube();
  nan.positions[3].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(ErrorOf(nan).find("position 3 is not finite"), std::string::npos);
  Mesh wrong = MakeCube();
  wrong.triangles[2][0] = 8;
  EXPECT_NE(ErrorOf(wrong).find("triangle 2 has position indices"), std::string::npos);
  Mesh huge = MakeCube();
  huge.positions[0].x = 1e200;
  EXPECT_NE(ErrorOf(huge).find("beyond 1e12 metres"), std::string::npos);
  // Two cubes that touch in one edge, and joined above and below it: one sheet runs around it.
  std::vector<Vec3> pinched;
  for (int z = -1; z <= 1; ++z) {
    for (int x = 0; x < 2; ++x) {
      for (int y = 0; y < 2; ++y) {
        if (z != 0 || x == y) pinched.push_back({x * 2.0, y * 2.0, z * 2.0});
      }
    }
  }
  EXPECT_NE(ErrorOf(Voxels(pinched)).find("has more than two triangles"), std::string::npos);
}

TEST(RepairMesh, DropsFoldsButKeepsOneSideOfDoubledSheets) {
  // A cube whose face diagonal (0, 3) carries two triangles of opposite winding.
  Mesh folded = MakeCube();
  folded.positions.push_back({0, 0, -2});
  folded.triangles.insert(folded.triangles.begin() + 5, {{0, 3, 8}, {3, 0, 8}});
  MeshRepairs repairs;
  const Mesh cube = RepairMesh(folded, "cube", &repairs);
  EXPECT_EQ(repairs.folded_triangles, 2);
  EXPECT_EQ(repairs.duplicate_triangles, 0);
  EXPECT_EQ(repairs.unused_positions, 1);
  EXPECT_EQ(cube.triangles, MakeCube().triangles);
  // A sheet that was given two sides.
  Mesh sheet = MakeRectangle();
  sheet.uv_triangles.clear();
  for (const Triangle& t : MakeRectangle().triangles) sheet.triangles.push_back({t[1], t[0], t[2]});
  const Mesh single = RepairMesh(sheet, "sheet", &repairs);
  EXPECT_EQ(repairs.folded_triangles, 0);
  EXPECT_EQ(repairs.duplicate_triangles, 2);
  EXPECT_EQ(single.triangles, MakeRectangle().triangles);
}

TEST(RepairMesh, CutsOffAFin) {
  Mesh mesh = Strip(3, {0, -1, 0}, {0, 1, 0});
  Append(Strip(3, {0, 0, 0}, {0, 1, 0}), {}, mesh);
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {{1, 0, 0}, {2, 0, 0}, {1.5, 0, 1}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  MeshRepairs repairs;
  const Mesh repaired = RepairMesh(mesh, "fin", &repairs);
  EXPECT_EQ(repairs.cut_edges, 1);
  EXPECT_EQ(repairs.added_positions, 2);
  // The fin moved to its middle, (1.5, 0, 1/3).
  const Vec3 corner = repaired.positions[Index(repaired.triangles.back()[0])];
  EXPECT_LT(Norm(corner - Vec3{1 + 0.5 * kCutGap, 0, kCutGap / 3}), 1e-15);
}

TEST(RepairMesh, RefusesAMoebiusStrip) {
  constexpr int kCount = 12;
  Mesh strip;
  for (int i = 0; i < kCount; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kCount;
    const Vec3 out = {std::cos(turn), std::sin(turn), 0};
    const Vec3 across = out * (0.3 * std::cos(turn / 2)) + Vec3{0, 0, 0.3 * std::sin(turn / 2)};
    strip.positions.push_back(out - across);
    strip.positions.push_back(out + across);
  }
  for (std::int32_t i = 0; i < kCount; ++i) {
    // After one turn low and high change their roles.
    const bool last = i + 1 == kCount;
    const std::int32_t low = last ? 1 : 2 * i + 2;
    const std::int32_t high = last ? 0 : 2 * i + 3;
    strip.triangles.push_back({2 * i, low, high});
    strip.triangles.push_back({2 * i, high, 2 * i + 1});
  }
  EXPECT_NE(ErrorOf(strip).find("mesh 'shape': a surface has one side only"), std::string::npos);
  strip.triangles.pop_back();
  strip.triangles.pop_back();
  EXPECT_EQ(ErrorOf(strip), "");
}

TEST(RepairMesh, SurvivesTriangleSoup) {
  std::mt19937 random(11);
  int num_repaired = 0;
  for (int round = 0; round < 300; ++round) {
    Mesh soup;
    const auto count = static_cast<std::int32_t>(4 + random() % 8);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (std::int32_t i = 0; i < count; ++i) {
      soup.positions.push_back({uniform(random), uniform(random), std::round(uniform(random))});
    }
    for (std::size_t f = random() % 30 + 1; f > 0; --f) {
      const auto pick = [&] {
        return static_cast<std::int32_t>(random() % static_cast<unsigned>(count));
      };
      soup.triangles.push_back({pick(), pick(), pick()});
    }
    try {
      const Mesh mesh = RepairMesh(soup, "soup");
      EXPECT_NO_THROW(ValidateMesh(mesh, "soup"));
      ++num_repaired;
    } catch (const SceneError&) {
    }
  }
  EXPECT_GT(num_repaired, 50);
}

TEST(CornerFans, OfAManifoldAreItsVertices) {
  const Mesh sphere = MakeIcosphere(1, 1.0);
  const CornerFans fans = CornerFans::Build(sphere);
  EXPECT_EQ(fans.num_unpaired, 0U);
  EXPECT_TRUE(fans.non_manifold_edges.empty());
  std::vector<std::size_t> roots = fans.fan;
  std::sort(roots.begin(), roots.end());
  roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
  EXPECT_EQ(roots.size(), sphere.positions.size());
  EXPECT_EQ(CornerFans::Build(MakeRectangle()).num_unpaired, 4U);
}

TEST(CornerFans, TakesNoTimeOverAnEdgeWithVeryManyTriangles) {
  Mesh book;
  book.positions = {{0, 0, 0}, {0, 0, 1}};
  for (std::int32_t i = 0; i < 20000; ++i) {
    book.positions.push_back({std::cos(i), std::sin(i), 0.5});
    book.triangles.push_back({0, 1, i + 2});
  }
  const CornerFans fans = CornerFans::Build(book);
  EXPECT_EQ(fans.num_unpaired, 60000U);
  EXPECT_EQ(fans.num_irregular, 1U);
  MeshRepairs repairs;
  RepairMesh(book, "book", &repairs);
  EXPECT_EQ(repairs.added_positions, 2 * 19999);
}

}  // namespace
}  // namespace pathfit::renderer::mesh_repair_test
