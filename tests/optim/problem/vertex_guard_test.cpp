#include "optim/problem/vertex_guard.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_folds.h"
#include "tests/support/test_scenes.h"

namespace pathfit::vertex_guard_test {
namespace {

class VertexGuardTest : public testing::Test {
 protected:
  VertexGuardTest()
      : scene_(MakeScene()),
        set_(scene_, unknowns_, {0}, {}, {}),
        start_(set_.layout().Gather(scene_)),
        guard_(scene_, set_, start_) {}

  static renderer::Scene MakeScene() {
    renderer::Scene scene;
    scene.meshes = {{"ball", renderer::MakeIcosphere(3, 1.0), 0}};
    scene.materials = {{"paint", renderer::LambertBsdf{}}};
    return scene;
  }
  renderer::Mesh MeshOf(const std::vector<double>& values) const {
    renderer::Scene moved = scene_;
    set_.layout().Scatter(values, moved);
    return moved.meshes[0].mesh;
  }
  std::size_t NumChanged(const std::vector<double>& a, const std::vector<double>& b) const {
    std::size_t changed = 0;
    for (std::size_t i = 0; i < a.size(); i += 3) {
      changed += a[i] != b[i] || a[i + 1] != b[i + 1] || a[i + 2] != b[i + 2] ? 1 : 0;
    }
    return changed;
  }

  std::vector<optim::UnknownSpec> unknowns_{1};
  renderer::Scene scene_;
  optim::ParameterSet set_;
  std::vector<double> start_;
  optim::VertexGuard guard_;
};

TEST_F(VertexGuardTest, StepsWithoutWrecksStayAsTheyAre) {
  std::vector<double> same = start_;
  EXPECT_TRUE(guard_.Restrain(same));
  EXPECT_EQ(same, start_);
  std::vector<double> larger = start_;
  for (double& x : larger) {
    x *= 1.1;
  }
  const std::vector<double> wanted = larger;
  EXPECT_TRUE(guard_.Restrain(larger));
  EXPECT_EQ(larger, wanted);
}

TEST_F(VertexGuardTest, HoldsBackOnlyWhatIsNearAWreck) {
  // All grow; one vertex passes through the other side of the ball, one collapses a triangle, and
  // one edge is pulled out into a ridge.
  std::vector<double> wrecked = start_;
  for (double& x : wrecked) {
    x *= 1.1;
  }
  const std::vector<double> grown = wrecked;
  const std::vector<renderer::Triangle>& triangles = scene_.meshes[0].mesh.triangles.Items();
  const auto put = [&](std::int32_t v, const std::vector<double>& from, std::int32_t w, double s) {
    for (std::size_t i = 0; i < 3; ++i) {
      wrecked[3 * static_cast<std::size_t>(v) + i] = s * from[3 * static_cast<std::size_t>(w) + i];
    }
  };
  put(triangles[0][0], start_, triangles[0][0], -1.5);
  put(triangles[300][0], grown, triangles[300][1], 1.0);
  put(triangles[900][0], start_, triangles[900][0], 3.0);
  put(triangles[900][1], start_, triangles[900][1], 3.0);
  ASSERT_GT(renderer::CountFolds(MeshOf(wrecked)).folded_edges, 0);
  ASSERT_GT(renderer::CountFolds(MeshOf(wrecked)).crossing_triangles, 0);
  std::vector<double> values = wrecked;
  ASSERT_TRUE(guard_.Restrain(values));
  EXPECT_EQ(renderer::CountFolds(MeshOf(values)), renderer::MeshFolds{});
  EXPECT_LT(NumChanged(values, wrecked), 100U) << "of " << start_.size() / 3;
  EXPECT_GT(NumChanged(values, start_), start_.size() / 3 - 100);
}

TEST_F(VertexGuardTest, WhatWasWreckedBeforeDoesNotHinder) {
  std::vector<double> folded = start_;
  const renderer::Triangle& triangle = scene_.meshes[0].mesh.triangles.Items()[0];
  for (std::size_t i = 0; i < 3; ++i) {
    folded[3 * static_cast<std::size_t>(triangle[0]) + i] *= -1.5;
  }
  const optim::VertexGuard guard(scene_, set_, folded);
  std::vector<double> moved = folded;
  for (double& x : moved) {
    x *= 1.1;
  }
  const std::vector<double> wanted = moved;
  EXPECT_TRUE(guard.Restrain(moved));
  EXPECT_EQ(moved, wanted);
}

TEST_F(VertexGuardTest, StopsAStepThatTurnsAllOver) {
  std::vector<double> inside_out = start_;
  for (std::size_t i = 0; i < inside_out.size(); i += 3) {
    inside_out[i] = -inside_out[i];  // a mirror image
  }
  EXPECT_TRUE(guard_.Restrain(inside_out));
  for (std::size_t i = 0; i < inside_out.size(); i += 3) {
    EXPECT_GE(inside_out[i] * start_[i], 0.0);
  }

  std::vector<double> broken = start_;
  broken[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(guard_.Restrain(broken));
}

}  // namespace
}  // namespace pathfit::vertex_guard_test
