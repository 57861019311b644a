#include "renderer/scene/view_bounds.h"

#include <gtest/gtest.h>

#include "renderer/geometry/ray_caster.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer {
namespace {

/// No ray of a pixel outside the bounds meets the scene; returns how many pixels are inside.
int CheckBounds(const Scene& scene, const PerspectiveCamera& camera) {
  const CameraModel model(camera);
  const PixelBounds bounds = BoundsOfMeshes(scene, model);
  RayCaster caster;
  std::vector<const Mesh*> meshes;
  for (const SceneMesh& m : scene.meshes) meshes.push_back(&m.mesh);
  caster.Build(meshes);
  int inside = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      inside += bounds.Contains(x, y) ? 1 : 0;
      for (const Vec2& at : {Vec2{0.0, 0.0},
                             Vec2{0.999, 0.0},
                             Vec2{0.0, 0.999},
                             Vec2{0.999, 0.999},
                             Vec2{0.5, 0.5}}) {
        const bool hit = caster.Intersect(model.RayThrough(x + at.x, y + at.y)).has_value();
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
      PerspectiveCamera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
      camera.distortion = lens;
      const int inside = CheckBounds(SmallBallAt(center), camera);
      if (center == Vec3{}) {
        EXPECT_LT(inside, 1000) << "of 3072: the bounds are worth having";
      }
    }
  }
}

TEST(ViewBounds, AreTheWholeImageWhenAVertexIsBehindTheCamera) {
  const PerspectiveCamera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
  EXPECT_EQ(CheckBounds(SmallBallAt({0, 0, 4.0}), camera), 64 * 48);
}

TEST(ViewBounds, AreEmptyWithoutMeshes) {
  const PerspectiveCamera camera = tests::CameraAt({0, 0, 4}, {0, 0, 0}, 60.0, 64, 48);
  EXPECT_EQ(CheckBounds(Scene{}, camera), 0);
}

}  // namespace
}  // namespace pathfit::renderer
