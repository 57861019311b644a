#include "optim/round/decimate.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "optim/round/remesh.h"
namespace pathfit::decimate_test {
namespace {

using renderer::Mesh;

/// A flat box of so many squares along its long sides, a tenth of them along the short one.
Mesh Plate(int side) {
  const std::array<int, 3> size = {side, side, std::max(1, side / 10)};
  std::map<std::array<int, 3>, std::int32_t> indices;
  std::vector<renderer::Vec3> positions;
  std::vector<renderer::Triangle> triangles;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [place, is_new] = indices.emplace(at, static_cast<std::int32_t>(positions.size()));
    if (is_new) positions.push_back({0.01 * at[0], 0.01 * at[1], 0.01 * at[2]});
    return place->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const int end : {0, size[axis]}) {
      for (int j = 0; j < size[v]; ++j) {
        for (int i = 0; i < size[u]; ++i) {
          const auto corner = [&](int du, int dv) {
            std::array<int, 3> at{};
            at[axis] = end;
            at[u] = i + du;
            at[v] = j + dv;
            return vertex(at);
          };
          const std::int32_t a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
          triangles.push_back(end == 0 ? renderer::Triangle{a, c, b} : renderer::Triangle{a, b, c});
          triangles.push_back(end == 0 ? renderer::Triangle{a, d, c} : renderer::Triangle{a, c, d});
        }
      }
    }
  }
  Mesh plate;
  plate.positions = std::move(positions);
  plate.triangles = std::move(triangles);
  return plate;
}

TEST(Decimate, ABallStaysABall) {
  const Mesh ball = renderer::MakeIcosphere(4, 1.0);
  const Mesh coarse = optim::Decimate(ball, 500);
  renderer::ValidateMesh(coarse, "coarse");
  EXPECT_LE(coarse.triangles.size(), 500U);
  EXPECT_GE(coarse.triangles.size(), 490U);
  // Closed, of one piece without handles.
  EXPECT_EQ(coarse.positions.size(), coarse.triangles.size() / 2 + 2);
  EXPECT_LT(optim::SurfaceDistance(coarse, ball), 0.03);
  const Mesh again = optim::Decimate(ball, 500);
  EXPECT_TRUE(again.triangles == coarse.triangles);
  EXPECT_TRUE(again.positions == coarse.positions);
}

TEST(Decimate, AFlatSheetKeepsItsBorder) {
  constexpr int kSide = 20;
  Mesh sheet;
  for (int y = 0; y <= kSide; ++y) {
    for (int x = 0; x <= kSide; ++x) sheet.positions.push_back({0.1 * x, 0.1 * y, 0.0});
  }
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int a = y * (kSide + 1) + x, b = a + kSide + 1;
      sheet.triangles.push_back({a, a + 1, b + 1});
      sheet.triangles.push_back({a, b + 1, b});
    }
  }
  const Mesh coarse = optim::Decimate(sheet, 100);
  renderer::ValidateMesh(coarse, "coarse");
  EXPECT_LE(coarse.triangles.size(), 100U);
  EXPECT_LT(optim::SurfaceDistance(coarse, sheet), 1e-9);
}

TEST(Decimate, FlatSidesOfAPlateLeaveNoTriangleWithoutArea) {
  // Voxels along the sides: there every collapse is free, and corners can come to lie in a row.
  for (const int side : {16, 24, 28, 32}) {
    const Mesh coarse = optim::Decimate(Plate(side), 60);
    EXPECT_NO_THROW(renderer::ValidateMesh(coarse, "coarse")) << side;
  }
}

TEST(Decimate, WhatHasFewEnoughStays) {
  const Mesh ball = renderer::MakeIcosphere(1, 1.0);
  EXPECT_EQ(optim::Decimate(ball, 1000).triangles.size(), ball.triangles.size());
}

}  // namespace
}  // namespace pathfit::decimate_test
