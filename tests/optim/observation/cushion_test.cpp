#include "optim/observation/cushion.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_topology.h"
#include "tests/optim/observation/lit_ball.h"

namespace pathfit::optim::cushion_test {
namespace {

using renderer::Image;
using renderer::Mesh;
using renderer::Vec3;

TEST(Cushion, ADiscBecomesAnEllipsoid) {
  const Mesh mesh = MakeCushion(tests::BallMask(), 0.01, 0.5);
  ASSERT_TRUE(renderer::MeshTopology::Build(mesh).closed);
  const double radius = 0.01 * tests::kBallRadius;
  double worst = 0.0;
  for (const Vec3& p : mesh.positions) {
    const double r = std::hypot(p.x, p.y, p.z / 0.5);
    worst = std::max(worst, std::abs(r - radius));
  }
  EXPECT_LT(worst, 0.012);  // about a pixel, of what the mask's steps are
}

TEST(Cushion, LiesWhereThePictureShowsIt) {
  Image mask(200, 100, 1);
  for (int y = 10; y < 40; ++y) {
    for (int x = 120; x < 200; ++x) mask.At(x, y, 0) = 1.0F;  // up to the picture's border
  }
  mask.At(3, 90, 0) = 1.0F;  // a speck, which counts for nothing
  const Mesh mesh = MakeCushion(mask, 0.1, 1.0);
  ASSERT_TRUE(renderer::MeshTopology::Build(mesh).closed);
  Vec3 low = mesh.positions[0], high = low;
  for (const Vec3& p : mesh.positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  EXPECT_GT(mesh.positions.size(), 3000U);
  EXPECT_NEAR(low.x, 2.0, 0.15);
  EXPECT_NEAR(high.x, 10.0, 0.15);
  EXPECT_NEAR(low.y, 1.0, 0.15);
  EXPECT_NEAR(high.y, 4.0, 0.15);
  EXPECT_NEAR(high.z, -low.z, 1e-6);
  EXPECT_GT(high.z, 1.4);  // half of 3 pixels' tens, and a little more than round
  EXPECT_LT(high.z, 2.2);
}

TEST(Cushion, RefusesAnEmptyMask) {
  EXPECT_THROW(MakeCushion(Image(20, 20, 1), 1.0, 1.0), renderer::SceneError);
}

}  // namespace
}  // namespace pathfit::optim::cushion_test
