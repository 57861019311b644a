#include "renderer/geometry/mesh_intersection.h"

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_primitives.h"

namespace pathfit::renderer {
namespace {

Mesh CubeAt(const Vec3& center) {
  Mesh cube = MakeCube();
  for (Vec3& p : cube.positions) p += center;
  return cube;
}

std::vector<MeshContact> Pairs(const Mesh& a, const Mesh& b) { return MeshContacts({&a, &b}); }
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
}  // namespace pathfit::renderer
