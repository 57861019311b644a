#include "optim/problem/vertex_guard.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace pathfit {
namespace {

class VertexGuardTest : public testing::Test {
 protected:
  VertexGuardTest() { scene_.meshes = {{"ball", renderer::MakeIcosphere(2, 1.0), 0}}; }

  renderer::Scene scene_;
  std::vector<optim::UnknownSpec> unknowns_{1};
};

TEST_F(VertexGuardTest, AdmitsSmallMovesAndRefusesWrecks) {
  scene_.materials = {{"paint", renderer::LambertBsdf{}}};
  const optim::ParameterSet set(scene_, unknowns_, {0}, {}, {});
  const std::vector<double> start = set.layout().Gather(scene_);
  const optim::VertexGuard guard(scene_, set, start);
  EXPECT_TRUE(guard.Admits(start));

  std::vector<double> larger = start;
  for (double& x : larger) {
    x *= 1.1;
  }
  EXPECT_TRUE(guard.Admits(larger));

  std::vector<double> inside_out = start;
  for (std::size_t i = 0; i < inside_out.size(); i += 3) {
    inside_out[i] = -inside_out[i];  // a mirror image
  }
  EXPECT_FALSE(guard.Admits(inside_out));

  std::vector<double> collapsed = start;
  const renderer::Triangle& triangle = scene_.meshes[0].mesh.triangles[0];
  for (std::size_t i = 0; i < 3; ++i) {
    collapsed[3 * static_cast<std::size_t>(triangle[0]) + i] =
        start[3 * static_cast<std::size_t>(triangle[1]) + i];
  }
  EXPECT_FALSE(guard.Admits(collapsed));

  std::vector<double> broken = start;
  broken[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(guard.Admits(broken));
}

TEST_F(VertexGuardTest, RefusesFoldsBetweenTrianglesThatEachTurnLittle) {
  scene_.materials = {{"paint", renderer::LambertBsdf{}}};
  const optim::ParameterSet set(scene_, unknowns_, {0}, {}, {});
  const std::vector<double> start = set.layout().Gather(scene_);
  const optim::VertexGuard guard(scene_, set, start);
  // Edges far from each other are pulled out into ridges.
  const auto with_ridges = [&](std::size_t stride) {
    std::vector<double> values = start;
    const std::vector<renderer::Triangle>& triangles = scene_.meshes[0].mesh.triangles;
    for (std::size_t t = 0; t < triangles.size(); t += stride) {
      for (const std::int32_t v : {triangles[t][0], triangles[t][1]}) {
        for (std::size_t i = 3 * static_cast<std::size_t>(v);
             i < 3 * static_cast<std::size_t>(v) + 3;
             ++i) {
          values[i] = 3.0 * start[i];
        }
      }
    }
    return values;
  };
  EXPECT_TRUE(guard.Admits(with_ridges(1000))) << "one is a small share";
  EXPECT_FALSE(guard.Admits(with_ridges(80)));
}

}  // namespace
}  // namespace pathfit
