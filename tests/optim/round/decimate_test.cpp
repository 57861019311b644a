#include "optim/round/decimate.h"

#include <gtest/gtest.h>

#include "optim/round/remesh.h"
namespace pathfit {
namespace {

using renderer::Mesh;

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

TEST(Decimate, WhatHasFewEnoughStays) {
  const Mesh ball = renderer::MakeIcosphere(1, 1.0);
  EXPECT_EQ(optim::Decimate(ball, 1000).triangles.size(), ball.triangles.size());
}

}  // namespace
}  // namespace pathfit
