#include "renderer/io/mesh_assembly.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace pathfit::renderer::mesh_assembly_test {
namespace {

double SignedArea(const std::vector<Vec3>& corners, const FanTriangles& fan) {
  double twice_area = 0.0;
  for (const auto& [a, b, c] : fan) {
    const double one = Cross(corners[b] - corners[a], corners[c] - corners[a]).z;
    EXPECT_GE(one, 0.0);
    twice_area += one;
  }
  return twice_area / 2.0;
}

TEST(PolygonFan, ConvexPolygonsBeginAtTheFirstCorner) {
  const std::vector<Vec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const auto fan = TriangulatePolygon(square);
  ASSERT_TRUE(fan);
  EXPECT_EQ(*fan, (FanTriangles{{0, 1, 2}, {0, 2, 3}}));
}

TEST(PolygonFan, ArrowBeginsAtTheCornerThatSeesAll) {
  const std::vector<Vec3> arrow = {{0, 0, 0}, {2, -1, 0}, {1, 0, 0}, {2, 1, 0}};
  const auto fan = TriangulatePolygon(arrow);
  ASSERT_TRUE(fan);
  EXPECT_NEAR(SignedArea(arrow, *fan), 1.0, 1e-15);
  const std::vector<Vec3> turned = {{2, -1, 0}, {1, 0, 0}, {2, 1, 0}, {0, 0, 0}};
  const auto turned_fan = TriangulatePolygon(turned);
  ASSERT_TRUE(turned_fan);
  EXPECT_NEAR(SignedArea(turned, *turned_fan), 1.0, 1e-15);
}

TEST(PolygonFan, CollinearCornersCountAndCoincidentOnesDoNot) {
  const std::vector<Vec3> with_midpoint = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  const auto fan = TriangulatePolygon(with_midpoint);
  ASSERT_TRUE(fan);
  EXPECT_EQ(fan->size(), 3U);
  EXPECT_NEAR(SignedArea(with_midpoint, *fan), 4.0, 1e-15);
  const std::vector<Vec3> pole = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}};
  const auto one = TriangulatePolygon(pole);
  ASSERT_TRUE(one);
  EXPECT_EQ(*one, (FanTriangles{{0, 1, 2}}));
}

TEST(PolygonFan, RefusesACombAndSurvivesNonsense) {
  std::vector<Vec3> comb = {{6, 0, 0}, {6, 4, 0}};
  for (const double x : {5.0, 3.0, 1.0}) {
    comb.push_back({x, 0.5, 0});
    comb.push_back({x - 1, 4, 0});
  }
  comb.push_back({0, 0, 0});
  EXPECT_FALSE(TriangulatePolygon(comb));
  EXPECT_EQ(TriangulatePolygon(std::vector<Vec3>(5))->size(), 3U);
  std::vector<Vec3> huge(6, Vec3{1e300, 0, 0});
  huge[2] = {0, 1e300, 1e300};
  huge[4] = {-1e300, 0, 1e300};
  EXPECT_NO_THROW(TriangulatePolygon(huge));
  EXPECT_EQ(TriangulatePolygon({}), FanTriangles{});
}

}  // namespace
}  // namespace pathfit::renderer::mesh_assembly_test
