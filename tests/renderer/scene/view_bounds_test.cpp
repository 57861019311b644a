#include "renderer/scene/view_bounds.h"

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace pathfit::renderer::view_bounds_test {
namespace {

/// No ray of a filter of a pixel outside the bounds meets the scene; returns how many pixels are
/// inside.
int CheckBounds(const Scene& scene, const Camera& camera) {
  const CameraModel model(camera);
  const World world(scene);
  const PixelBounds bounds = BoundsOfMeshes(world, model);
  const RayCaster& caster = world.caster();
  const double r = 0.999 * camera.filter.radius;
  int inside = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      inside += bounds.Contains(x, y) ? 1 : 0;
      for (const Vec2& at : {Vec2{-r, -r}, Vec2{r, -r}, Vec2{-r, r}, Vec2{r, r}, Vec2{}}) {
        const bool hit =
            caster.Intersect(model.RayThrough(x + 0.5 + at.x, y + 0.5 + at.y)).has_value();
        EXPECT_TRUE(!hit || bounds.Contains(x, y)) << x << " " << y;
      }
    }
  }
  return inside;
}

Scene SmallBallAt(const Vec3& center) {
  Scene scene = tests::BallAndWall();
  scene.meshes.pop_back();
  ApplyTransform({{{0.4, 0, 0}, {0, 0.4, 0}, {0, 0, 0.4}}, center}, scene.meshes[0].mesh);
  return scene;
}

TEST(ViewBounds, HoldEverythingSeenWithAndWithoutDistortion) {
  for (const LensDistortion& lens : {LensDistortion{},
                                     LensDistortion{-0.2, 0.05, 0, 0.01, -0.02},
                                     LensDistortion{0.3, 0, 0, 0, 0}}) {
    for (const Vec3& center :
         {Vec3{0, 0, 0}, Vec3{0.9, 0.4, 0}, Vec3{-1.7, 0.3, 0.5}, Vec3{0.2, -1.6, 1.0}}) {
      Camera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
      camera.distortion = lens;
      const int inside = CheckBounds(SmallBallAt(center), camera);
      if (center == Vec3{}) {
        EXPECT_LT(inside, 1000) << "of 3072: the bounds are worth having";
      }
    }
  }
}

TEST(ViewBounds, HoldWhatAWideFilterSees) {
  for (const double radius : {1.0, 2.0, 8.0}) {
    for (const Vec3& center : {Vec3{0, 0, 0}, Vec3{-1.9, 0.3, 0.5}, Vec3{2.75, 0.0, 0.0}}) {
      Camera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
      camera.filter = {PixelFilter::Shape::kTent, radius, 0.0};
      const int inside = CheckBounds(SmallBallAt(center), camera);
      if (center == Vec3{}) {
        EXPECT_LT(inside, 1400) << "of 3072";
      }
    }
  }
}

TEST(ViewBounds, HoldWhatATurnedCameraSees) {
  Camera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
  camera.rotation = {0.1, -0.3, 0.8};
  for (const Vec3& center : {Vec3{0, 0, 0}, Vec3{0.8, 0.4, 0}}) {
    const int inside = CheckBounds(SmallBallAt(center), camera);
    EXPECT_GT(inside, 0);
    EXPECT_LT(inside, 1000);
  }
}

TEST(ViewBounds, HoldWhatParallelRaysSee) {
  Camera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 15.0, 64, 48);
  camera.projection = ProjectionKind::kOrthographic;
  camera.rotation = {0.0, 0.1, 0.3};
  for (const double radius : {0.5, 2.0}) {
    camera.filter.radius = radius;
    // The last two reach behind the plane of the rays' origins and beyond the image.
    for (const Vec3& center :
         {Vec3{0, 0, 0}, Vec3{0.9, 0.4, 0}, Vec3{0, 0, 4.0}, Vec3{-2.3, 0.3, 0.5}}) {
      EXPECT_LT(CheckBounds(SmallBallAt(center), camera), 1000);
    }
  }
}

TEST(ViewBounds, AreEmptyForObjectsBesideTheView) {
  for (const LensDistortion& lens : {LensDistortion{}, LensDistortion{-0.2, 0.05, 0, 0, 0}}) {
    Camera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
    camera.distortion = lens;
    EXPECT_EQ(CheckBounds(SmallBallAt({9, 0, 0}), camera), 0);
  }
}

TEST(ViewBounds, AreTheWholeImageWhenAVertexIsBehindTheCamera) {
  const Camera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
  EXPECT_EQ(CheckBounds(SmallBallAt({0, 0, 4.0}), camera), 64 * 48);
}

TEST(ViewBounds, AreEmptyWithoutMeshes) {
  const Camera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
  EXPECT_EQ(CheckBounds(Scene{}, camera), 0);
}

}  // namespace
}  // namespace pathfit::renderer::view_bounds_test
