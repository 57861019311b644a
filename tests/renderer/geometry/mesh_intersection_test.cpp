#include "renderer/geometry/mesh_intersection.h"

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_primitives.h"

namespace pathfit::renderer::mesh_intersection_test {
namespace {

Mesh CubeAt(const Vec3& center) {
  Mesh cube = MakeCube();
  for (Vec3& p : cube.positions) p += center;
  return cube;
}

const std::vector<Eye> kAbove = {{{0.3, 0.2, 90.0}}};
std::vector<MeshContact> Pairs(const Mesh& a,
                               const Mesh& b,
                               const std::vector<Eye>& eyes = kAbove) {
  return MeshContacts({&a, &b}, eyes);
}
const std::vector<MeshContact> kNone;
const std::vector<MeshContact> kTouch = {{0, 1, false}};
const std::vector<MeshContact> kCut = {{0, 1, true}};

TEST(MeshIntersection, OfCubesThatOverlapTouchOrContainEachOther) {
  const Mesh cube = MakeCube();  // from -1 to 1
  EXPECT_EQ(Pairs(cube, CubeAt({0.5, 0.3, 0.2})), kCut);
  EXPECT_EQ(Pairs(cube, CubeAt({5.0, 0.0, 0.0})), kNone);
  EXPECT_EQ(Pairs(cube, CubeAt({0.3, 2.0, 0.1})), kTouch) << "stands on it";
  EXPECT_EQ(Pairs(CubeAt({0.3, 2.0, 0.1}), cube), kTouch);
  EXPECT_EQ(Pairs(cube, CubeAt({0.3, 2.001, 0.1})), kNone) << "hovers";
  EXPECT_EQ(Pairs(cube, CubeAt({0.3, 1.99, 0.1})), kCut) << "has sunk a little";
  Mesh small = cube;
  for (Vec3& p : small.positions) p *= 0.5;
  EXPECT_EQ(Pairs(cube, small), kNone) << "inside";
}

TEST(MeshIntersection, OfAnEdgeThroughABigTriangle) {
  Mesh floor = MakeRectangle();
  for (Vec3& p : floor.positions) p *= 10.0;
  EXPECT_EQ(Pairs(floor, CubeAt({0.2, 0.1, 0.5})), kCut);
  EXPECT_EQ(Pairs(floor, CubeAt({0.2, 0.1, 1.0})), kTouch);
  EXPECT_EQ(Pairs(floor, CubeAt({0.2, 0.1, 1.01})), kNone);
}

Mesh Rectangle(double x0, double x1, double z) {
  Mesh mesh = MakeRectangle();
  for (Vec3& p : mesh.positions) p = {x0 + 0.5 * (x1 - x0) * (p.x + 1.0), p.y, z};
  return mesh;
}
Mesh Turned(Mesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}
Mesh AsOne(Mesh mesh, const Mesh& other) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.triangles) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return mesh;
}
std::vector<MeshContact> Own(const Mesh& mesh) { return MeshContacts({&mesh}, kAbove); }

TEST(MeshIntersection, OfSurfacesInOnePlane) {
  const std::vector<MeshContact> overlap = {{0, 1, false, true}};
  const Mesh plate = Rectangle(-1, 1, 1);
  EXPECT_EQ(Pairs(plate, Rectangle(0, 2, 1)), overlap);
  EXPECT_EQ(Pairs(plate, plate), overlap) << "the same triangles";
  EXPECT_EQ(Pairs(plate, Turned(plate)), overlap) << "neither is a body";
  EXPECT_EQ(Pairs(plate, Rectangle(1, 2, 1)), kTouch) << "side by side";
  EXPECT_EQ(Pairs(plate, Rectangle(0, 2, 1.001)), kNone);
  const std::vector<Eye> below = {{{0.0, 0.0, -90.0}}};
  const std::vector<Eye> downwards = {{{0.0, 0.1, 1.0}, 0.0}};
  const std::vector<Eye> inside = {{{0.5, -0.3, 0.2}}};
  for (const Mesh& either : {plate, Turned(plate)}) {
    EXPECT_EQ(Pairs(MakeCube(), either), overlap) << "a label on a cube's top";
    EXPECT_EQ(Pairs(either, MakeCube(), downwards), overlap) << "for a parallel sensor";
    EXPECT_EQ(Pairs(MakeCube(), either, below), kTouch) << "a plate on which it stands";
    EXPECT_EQ(Pairs(either, MakeCube(), inside), overlap) << "a mat in a room";
  }
  EXPECT_EQ(Pairs(MakeCube(), Turned(plate), {}), kTouch) << "nobody looks";
  Mesh box = MakeCube();
  for (Vec3& p : box.positions) p = p * 0.4 + Vec3{0.0, 0.0, 0.6};
  EXPECT_EQ(Pairs(MakeCube(), box, inside), kTouch) << "hangs from the ceiling of a room";
  EXPECT_EQ(Pairs(MakeCube(), box), overlap) << "let into a block";
  Mesh open = MakeCube();
  std::erase_if(open.triangles.Edit(), [&](const Triangle& t) {
    return open.positions[static_cast<std::size_t>(t[0])].z +
               open.positions[static_cast<std::size_t>(t[1])].z +
               open.positions[static_cast<std::size_t>(t[2])].z ==
           -3.0;
  });
  EXPECT_EQ(Pairs(open, Turned(plate)), overlap) << "seen from inside";
  EXPECT_EQ(Pairs(Turned(MakeCube()), plate), overlap) << "whichever way the cube is wound";
  EXPECT_EQ(Pairs(MakeCube(), CubeAt({2.0, 0.5, 0.0})), kTouch) << "tops side by side";
}

TEST(MeshIntersection, OfAMeshWithItself) {
  EXPECT_EQ(Own(MakeCube()), kNone);
  EXPECT_EQ(Own(MakeIcosphere(3, 1.0)), kNone);
  EXPECT_EQ(Own(AsOne(MakeCube(), CubeAt({5, 0, 0}))), kNone);
  EXPECT_EQ(Own(AsOne(MakeCube(), CubeAt({0.3, 2.0, 0.1}))),
            (std::vector<MeshContact>{{0, 0, false}}));
  EXPECT_EQ(Own(AsOne(MakeCube(), CubeAt({0.5, 0.3, 0.2}))),
            (std::vector<MeshContact>{{0, 0, true}}));
  EXPECT_EQ(Own(AsOne(Rectangle(-1, 1, 0), Rectangle(0, 2, 0))),
            (std::vector<MeshContact>{{0, 0, false, true}}));
  // A corner on a border of the same part: the derivative knows such contacts.
  Mesh sheet;
  const double y1 = 2.0 / 3.0;
  const double y2 = 4.0 / 3.0;
  sheet.positions = {{0, 0, 0},
                     {1, 0, 0},
                     {2, 0, 0},
                     {2, y1, 0},
                     {1, y1, 0},
                     {0, 2, 0},
                     {1, 2, 0},
                     {2, 2, 0},
                     {0, 3, 0},
                     {1, 3, 0},
                     {2, 3, 0},
                     {1, y2, 0},
                     {2, y2, 0}};
  sheet.triangles = {{0, 1, 6},
                     {0, 6, 5},
                     {1, 2, 3},
                     {1, 3, 4},
                     {4, 3, 12},
                     {4, 12, 11},
                     {11, 12, 7},
                     {11, 7, 6},
                     {5, 6, 9},
                     {5, 9, 8},
                     {6, 7, 10},
                     {6, 10, 9}};
  EXPECT_EQ(Own(sheet), kNone);
  // Many parts of which two cut each other.
  Mesh many;
  for (int i = 0; i < 40; ++i) many = AsOne(many, CubeAt({3.0 * i, 0, 0}));
  EXPECT_EQ(Own(many), kNone);
  EXPECT_EQ(Own(AsOne(many, CubeAt({61.3, 0.4, 0.2}))), (std::vector<MeshContact>{{0, 0, true}}));
  // One part: a band that is bent until it meets itself.
  Mesh band;
  const auto bend = [&](const std::vector<Vec3>& line) {
    band = {};
    for (const Vec3& p : line) {
      band.positions.insert(band.positions.end(), {{p.x, -1.0, p.z}, {p.x, 1.0, p.z}});
    }
    for (int i = 0; i + 1 < static_cast<int>(line.size()); ++i) {
      const int k = 2 * i;
      band.triangles.insert(band.triangles.end(), {{k, k + 2, k + 3}, {k, k + 3, k + 1}});
    }
    return Own(band);
  };
  EXPECT_EQ(bend({{-3, 0, 0}, {3, 0, 0}, {3, 0, 2}, {0.1, 0, 1}, {0.3, 0, 3}}), kNone);
  EXPECT_EQ(bend({{-3, 0, 0}, {3, 0, 0}, {3, 0, 2}, {0.1, 0, -1}, {0.3, 0, -3}}),
            (std::vector<MeshContact>{{0, 0, true}}));
  EXPECT_EQ(bend({{-3, 0, 0}, {3, 0, 0}, {3, 0, 2}, {0.1, 0, 0}, {0.3, 0, 3}}),
            (std::vector<MeshContact>{{0, 0, false, false, true}}));
}

TEST(ShadingDeviation, OfBallsHalvesWithTheirEdges) {
  Mesh ball = MakeIcosphere(1, 1.0);
  EXPECT_EQ(MeanShadingDeviation(ball), 0.0);
  ComputeVertexNormals(ball);
  const double coarse = MeanShadingDeviation(ball);
  Mesh fine = MakeIcosphere(3, 1.0);
  ComputeVertexNormals(fine);
  EXPECT_NEAR(coarse / MeanShadingDeviation(fine), 4.0, 0.3);
  EXPECT_GT(coarse, 0.2);
  EXPECT_LT(coarse, 0.5);
}

}  // namespace
}  // namespace pathfit::renderer::mesh_intersection_test
