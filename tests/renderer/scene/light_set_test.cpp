#include <cmath>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "renderer/math/frame.h"
#include "renderer/sampler/counter_rng.h"
#include "renderer/scene/world.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::light_set_test {
namespace {

constexpr double kRounding = 1e-14;
constexpr double kDifference = 1e-6;
const Mat3 kTilt = RotationAboutAxis(Normalized(Vec3{1, 2, 3}), 0.8);
const Transform kCamera{RotationAboutAxis({0, 1, 0}, 0.5 * std::numbers::pi), {1, 2, 3}};

/// All kinds of light but a projector and areas: sky (0), lamp (1), sun (2), spot (3).
Scene SceneWithLights(LightFrame frame, const Vec3& rotation = {}) {
  EnvironmentEmitter sky;
  sky.width = 2;
  sky.texels = {{1, 1, 1}, {2, 2, 2}};
  sky.frame_from_light = kTilt;
  Scene scene;
  scene.emitters = {
      {"sky", frame, rotation, sky},
      {"lamp", frame, {}, PointEmitter{{1.5, 2.0, 2.5}, {4, 3, 2}}},
      {"sun", frame, rotation, DirectionalEmitter{Normalized(Vec3{0.3, -0.4, -1.0}), {6, 7, 8}}},
      {"spot", frame, rotation, SpotEmitter{{0.1, 0.2, 0.3}, kTilt, {4, 3, 2}, 0.2, 0.5}}};
  return scene;
}
double Distance(const Vec3& a, const Vec3& b) { return Norm(a - b); }

TEST(LightSet, WorldLightsIgnoreTheCamera) {
  const Scene scene = SceneWithLights(LightFrame::kWorld);
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera);
  ASSERT_EQ(set.points.size(), 2U);
  ASSERT_EQ(set.directionals.size(), 1U);
  ASSERT_TRUE(set.environment.has_value());
  EXPECT_EQ(set.environment->sampler, &*world.light_samplers().environment());
  EXPECT_EQ(set.points[0].position, (Vec3{1.5, 2.0, 2.5}));
  EXPECT_EQ(set.points[0].emitter, 1);
  EXPECT_EQ(set.points[1].emitter, 3);
  EXPECT_EQ(set.points[1].world_from_light, kTilt);
  EXPECT_EQ(set.directionals[0].to_light, -Normalized(Vec3{0.3, -0.4, -1.0}));
  EXPECT_EQ(set.environment->world_from_light, kTilt);
  EXPECT_EQ(set.area_sampler, nullptr);
}

/// The camera looks along -x of the world with its right along -z: (x, y, z) -> (z, y, -x).
TEST(LightSet, CameraLightsTurnAndMoveWithTheCamera) {
  const Scene scene = SceneWithLights(LightFrame::kCamera);
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera);
  EXPECT_LT(Distance(set.points[0].position, {1 + 2.5, 2 + 2.0, 3 - 1.5}), kRounding);
  const Vec3 direction = Normalized(Vec3{0.3, -0.4, -1.0});
  EXPECT_LT(Distance(set.directionals[0].to_light, {-direction.z, -direction.y, direction.x}),
            kRounding);
  const Vec3 d{0.36, 0.48, -0.8};
  const Vec3 in_world = set.environment->world_from_light * d;
  EXPECT_LT(Distance(in_world, kCamera.Direction(kTilt * d)), kRounding);
  EXPECT_LT(Distance(set.environment->light_from_world * in_world, d), kRounding);
}

/// The emitter's rotation acts between the light's own orientation and the camera.
TEST(LightSet, RotationTurnsALightWithinItsFrame) {
  const Vec3 axis = Normalized(Vec3{-0.4, 0.7, 0.2});
  const Mat3 turn = RotationAboutAxis(axis, 0.6);
  const Scene scene = SceneWithLights(LightFrame::kCamera, axis * 0.6);
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera);
  const Vec3 d{0.36, 0.48, -0.8};
  const Vec3 expected = kCamera.Direction(turn * (kTilt * d));
  EXPECT_LT(Distance(set.environment->world_from_light * d, expected), 10.0 * kRounding);
  const LightSet::PointLight& spot = set.points[1];
  EXPECT_LT(Distance(spot.world_from_light * d, expected), 10.0 * kRounding);
  EXPECT_LT(Distance(spot.position, kCamera.Point({0.1, 0.2, 0.3})), kRounding) << "not turned";
  const Vec3 sun = turn * Normalized(Vec3{0.3, -0.4, -1.0});
  EXPECT_LT(Distance(set.directionals[0].to_light, -kCamera.Direction(sun)), 10.0 * kRounding);
  // The spot shines fully along its axis and not 0.6 rad beside it.
  const Vec3 along = kCamera.Direction(turn * (kTilt * Vec3{0, 0, -1}));
  const Vec3 beside = kCamera.Direction(turn * (kTilt * Vec3{std::sin(0.6), 0, -std::cos(0.6)}));
  EXPECT_EQ(IntensityTowards(spot, along), (Rgb{4, 3, 2}));
  EXPECT_EQ(IntensityTowards(spot, beside), (Rgb{0, 0, 0}));
}

/// 4 x 3 colourful texels that stop at the border. Differences are taken inside its bilinear
/// squares.
Texture Slide() {
  Texture texture;
  texture.width = 4;
  texture.height = 3;
  texture.wrap = TextureWrap::kClamp;
  texture.texels.clear();
  for (int i = 0; i < 12; ++i) {
    texture.texels.push_back(
        {1.0 + 0.7 * std::sin(i), 1.0 + 0.6 * std::cos(2.0 * i), 0.2 + 0.1 * (i % 5)});
  }
  return texture;
}
Scene SceneWithProjector(const Texture& texture, const Transform& world_from_light) {
  Scene scene;
  scene.textures = {texture};
  scene.emitters = {
      {"slide",
       LightFrame::kWorld,
       {},
       ProjectorEmitter{
           world_from_light.translation, world_from_light.linear, 0.4, 0.3, {2.0, 1.0, 0.5}, 0}}};
  return scene;
}

/// Every derivative of IntensityDerivative by w against differences along two tangents.
void CheckDirectionDerivatives(const LightSet::PointLight& light, const Vec3& w) {
  const IntensityPartials partials = IntensityDerivative(light, w);
  EXPECT_EQ(partials.value, IntensityTowards(light, w));
  const Frame frame = Frame::FromNormal(w);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(partials.value[c], LightIntensity(*light.light)[c] * partials.factor[c], 1e-12);
    const Vec3& d_w = partials.d_w[static_cast<std::size_t>(c)];
    EXPECT_NEAR(Dot(d_w, w), 0.0, 1e-10);
    for (const Vec3& tangent : {frame.s, frame.t}) {
      const auto along = [&](double t) {
        return IntensityTowards(light, Normalized(w + tangent * t))[c];
      };
      EXPECT_LT(
          tests::RelativeError(Dot(d_w, tangent), tests::RiddersDerivative(along, 0.0, 0.005)),
          kDifference);
    }
  }
}

TEST(IntensityDerivative, PointsShineTheSameInAllDirections) {
  const Scene scene = SceneWithLights(LightFrame::kWorld);
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera);
  EXPECT_EQ(IntensityTowards(set.points[0], {0, 0, 1}), (Rgb{4, 3, 2}));
  CheckDirectionDerivatives(set.points[0], {0.6, 0.8, 0.0});
}

TEST(IntensityDerivative, SpotAgreesWithDifferencesByDirectionAndAngles) {
  const World world(SceneWithLights(LightFrame::kCamera, {0.2, -0.5, 0.3}));
  const LightSet set = LightSet::Make(world, kCamera);
  Emitter emitter = world.scene().emitters[3];
  LightSet::PointLight light = set.points[1];
  light.light = &emitter;
  auto& spot = std::get<SpotEmitter>(emitter.light);
  for (const double angle : {0.1, 0.25, 0.35, 0.45, 0.6, 2.0}) {
    const Vec3 in_light{std::sin(angle) * 0.6, std::sin(angle) * 0.8, -std::cos(angle)};
    const Vec3 w = light.world_from_light * in_light;
    CheckDirectionDerivatives(light, w);
    const IntensityPartials partials = IntensityDerivative(light, w);
    for (int c = 0; c < 3; ++c) {
      const auto by = [&](double& parameter, double x) {
        const double before = std::exchange(parameter, x);
        const double value = IntensityTowards(light, w)[c];
        parameter = before;
        return value;
      };
      const auto by_inner = [&](double x) { return by(spot.inner_angle, x); };
      const auto by_outer = [&](double x) { return by(spot.outer_angle, x); };
      EXPECT_NEAR(partials.d_inner[c], tests::RiddersDerivative(by_inner, 0.2, 0.02), 1e-5);
      EXPECT_NEAR(partials.d_outer[c], tests::RiddersDerivative(by_outer, 0.5, 0.02), 1e-5);
    }
  }
}

/// Irradiance of facing surfaces and of a screen across the axis, by hand.
TEST(Projector, FacingSurfacesReceiveTheStatedIrradiance) {
  Texture grey;
  grey.texels = {{0.5, 0.25, 1.0}};
  const Scene scene = SceneWithProjector(grey, {});
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera);
  // At (0.6, -0.3, -2): depth 2, distance sqrt(4.45), cosine 2 / sqrt(4.45).
  const Vec3 x{0.6, -0.3, -2.0};
  const double r = Norm(x);
  const Rgb facing = IntensityTowards(set.points[0], x / r) / (r * r);
  const double cosine = 2.0 / std::sqrt(4.45);
  EXPECT_NEAR(facing.r, 2.0 * 0.5 * std::numbers::pi / (4.0 * cosine), 1e-13);
  EXPECT_NEAR(facing.g, 1.0 * 0.25 * std::numbers::pi / (4.0 * cosine), 1e-13);
  EXPECT_NEAR(facing.b * cosine, 0.5 * std::numbers::pi / 4.0, 1e-13) << "a screen at depth 2";
  EXPECT_EQ(IntensityTowards(set.points[0], {0, 0, 1}), (Rgb{0, 0, 0})) << "behind";
  EXPECT_EQ(IntensityTowards(set.points[0], Normalized(Vec3{0.41, 0, -1})), (Rgb{0, 0, 0}));
  EXPECT_EQ(IntensityTowards(set.points[0], Normalized(Vec3{0, 0.31, -1})), (Rgb{0, 0, 0}));
}

/// A bright texel at the top right of the picture lights the top right as seen from the projector.
TEST(Projector, ShowsThePictureUprightAndNotMirrored) {
  Texture corner;
  corner.width = corner.height = 2;
  corner.wrap = TextureWrap::kClamp;
  corner.texels = {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}};  // row 0 on top
  const Transform pose = LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
  const Scene scene = SceneWithProjector(corner, pose);
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera);
  const auto at = [&](double x, double y) {
    return IntensityTowards(set.points[0], Normalized(Vec3{x, y, 0.0} - pose.translation)).g;
  };
  EXPECT_GT(at(1.4, 1.0), 3.0);
  EXPECT_EQ(at(-1.4, 1.0), 0.0);
  EXPECT_EQ(at(1.4, -1.0), 0.0);
  EXPECT_EQ(at(-1.4, -1.0), 0.0);
}

TEST(IntensityDerivative, ProjectorAgreesWithDifferencesInsideEachTexelSquare) {
  const Scene scene =
      SceneWithProjector(Slide(), LookAt({2, 1, 3}, {0.2, -0.3, 0.1}, {0.1, 1.0, 0.0}));
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera);
  const LightSet::PointLight& light = set.points[0];
  for (int row = 0; row <= 3; ++row) {
    for (int column = 0; column <= 4; ++column) {
      // Squares lie between texel centres, those at the border are half as large.
      const double u = std::clamp((column + 0.1) / 4.0, 0.05, 0.95);
      const double v = std::clamp((row - 0.1) / 3.0, 0.05, 0.95);
      const Vec3 in_light{(2.0 * u - 1.0) * 0.4, (2.0 * v - 1.0) * 0.3, -1.0};
      const Vec3 w = light.world_from_light * Normalized(in_light);
      CheckDirectionDerivatives(light, w);
      const IntensityPartials partials = IntensityDerivative(light, w);
      const Rgb expected =
          LightIntensity(*light.light) * partials.texture_scale * partials.lookup.value;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(partials.value[c], expected[c], 1e-12);
    }
  }
}

/// A rectangle that shows the whole picture (mesh 1) and a cube that does not shine (mesh 0).
Scene SceneWithPanel(const Texture& texture, bool two_sided) {
  Scene scene;
  scene.meshes = {{"cube", MakeCube()}, {"rectangle", MakeRectangle()}};
  scene.materials = {{"black", LambertBsdf{}}};
  scene.textures = {texture};
  scene.emitters = {{"panel", LightFrame::kWorld, {}, AreaEmitter{1, {3, 2, 1}, 0, two_sided}}};
  return scene;
}

TEST(AreaRadiance, ShowsTheTextureOnItsShiningSides) {
  for (const bool two_sided : {false, true}) {
    const Scene scene = SceneWithPanel(Slide(), two_sided);
    const World world(scene);
    const LightSet set = LightSet::Make(world, kCamera);
    ASSERT_EQ(set.AreaLightOf(0), nullptr);
    const LightSet::AreaLight& light = *set.AreaLightOf(1);
    ASSERT_EQ(set.area_sampler, &world.light_samplers().AreasOf(world, {0}));
    for (std::int32_t triangle : {0, 1}) {
      const double b1 = 0.3;
      const double b2 = 0.15;
      const Mesh& mesh = scene.meshes[1].mesh;
      const Triangle& t = mesh.triangles[static_cast<std::size_t>(triangle)];
      const auto corner = [&](std::size_t i) {
        return mesh.positions[static_cast<std::size_t>(t[i])];
      };
      const Vec3 p = corner(0) * (1.0 - b1 - b2) + corner(1) * b1 + corner(2) * b2;
      const Rgb expected =
          Rgb{3, 2, 1} * TextureValue(scene.textures[0], {0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y});
      const Rgb front = AreaRadiance(light, triangle, b1, b2, 1.0);
      const Rgb back = AreaRadiance(light, triangle, b1, b2, -1.0);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(front[c], expected[c], 1e-13);
        EXPECT_NEAR(back[c], two_sided ? expected[c] : 0.0, 1e-13);
      }
    }
  }
}

TEST(LightSet, LeavesOutWhatIsOff) {
  const Scene scene = SceneWithLights(LightFrame::kWorld);
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera, {0, 1});
  EXPECT_FALSE(set.environment.has_value());
  ASSERT_EQ(set.points.size(), 1U);
  EXPECT_EQ(set.points[0].emitter, 3);
  ASSERT_EQ(set.directionals.size(), 1U);
  EXPECT_EQ(set.directionals[0].emitter, 2);
}

TEST(LightSet, SharesTheSamplerOfTheAreaLightsThatShine) {
  Scene scene = SceneWithPanel(Slide(), false);
  scene.emitters.push_back({"lamp", LightFrame::kWorld, {}, PointEmitter{}});
  scene.emitters.push_back({"cube", LightFrame::kWorld, {}, AreaEmitter{0, {1, 1, 1}}});
  const World world(scene);
  const LightSet both = LightSet::Make(world, kCamera);
  const LightSet cube = LightSet::Make(world, kCamera, {0});
  const LightSet none = LightSet::Make(world, kCamera, {0, 2});
  EXPECT_EQ(both.area_sampler, LightSet::Make(world, kCamera, {1}).area_sampler);
  ASSERT_NE(cube.area_sampler, nullptr);
  EXPECT_NE(cube.area_sampler, both.area_sampler);
  EXPECT_EQ(cube.AreaLightOf(1), nullptr);
  EXPECT_EQ(cube.AreaLightOf(0)->emitter, 2);
  EXPECT_EQ(cube.area_sampler->Pdf({1, 0}), 0.0);
  EXPECT_EQ(none.area_sampler, nullptr);
  EXPECT_EQ(none.AreaLightOf(0), nullptr);
}

/// Rays to a lamp's border, where floats of the ray caster decide; the lamp is far from its centre.
TEST(LightSet, FindsLampsWhereverTheRayCasterDoes) {
  for (const int count : {1, 20}) {
    Scene scene;
    scene.materials = {{}};
    scene.meshes = {{"ball", MakeIcosphere(1, 1.0), 0, {}}};
    for (int i = 0; i < count; ++i) {
      Mesh lamp = MakeRectangle();
      ApplyTransform({{}, {30.0 + 3.0 * i, 20.0, 10.0}}, lamp);
      scene.meshes.push_back({"lamp", lamp, 0, {}});
      scene.emitters.push_back({"lamp", LightFrame::kWorld, {}, AreaEmitter{i + 1, {1, 1, 1}}});
    }
    const World world(scene);
    const LightSet set = LightSet::Make(world, kCamera);
    CounterRng rng(5);
    int hits = 0;
    int misses = 0;
    int outside = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 origin{8 * rng.Next() - 4, 8 * rng.Next() - 4, 8 * rng.Next() - 4};
      Vec3 end{29.0, 19.0 + 2 * rng.Next(), 10.0};
      end.x += 4e-5 * (rng.Next() - 0.5);
      const Ray ray{origin, Normalized(end - origin)};
      const auto hit = world.caster().Intersect(ray);
      const double offset = world.caster().Offset(origin);
      if (hit && hit->id.mesh > 0) {
        ++hits;
        outside += end.x < 29.0 ? 1 : 0;
        EXPECT_TRUE(set.MayMeetArea(ray, offset));
      }
      const Ray away{origin, Normalized(Vec3{2.0 * end.x, -end.y, end.z})};
      misses += set.MayMeetArea(away, offset) ? 0 : 1;
    }
    EXPECT_GT(hits, 5000);
    EXPECT_GT(outside, 100);
    EXPECT_EQ(misses, 20000);
  }
}

TEST(AreaRadiance, DerivativeAgreesWithDifferencesAndIsZeroBehind) {
  const Scene scene = SceneWithPanel(Slide(), false);
  const World world(scene);
  const LightSet set = LightSet::Make(world, kCamera);
  const LightSet::AreaLight& light = set.areas[0];
  for (std::int32_t triangle : {0, 1}) {
    const auto uv = [&](std::size_t corner) {
      const auto i = light.mesh->uv_triangles[static_cast<std::size_t>(triangle)][corner];
      return light.mesh->uvs[static_cast<std::size_t>(i)];
    };
    const Vec2 uv_by_b1 = uv(1) - uv(0);
    const Vec2 uv_by_b2 = uv(2) - uv(0);
    for (const auto& [b1, b2] : {std::pair{0.2, 0.27}, std::pair{0.7, 0.1}, std::pair{0.05, 0.6}}) {
      const AreaRadiancePartials p = AreaRadianceDerivative(light, triangle, b1, b2, 1.0);
      EXPECT_EQ(p.value, AreaRadiance(light, triangle, b1, b2, 1.0));
      EXPECT_EQ(p.value, (Rgb{3, 2, 1} * p.factor));
      for (int c = 0; c < 3; ++c) {
        const auto along_b1 = [&](double x) {
          return AreaRadiance(light, triangle, x, b2, 1.0)[c];
        };
        const auto along_b2 = [&](double x) {
          return AreaRadiance(light, triangle, b1, x, 1.0)[c];
        };
        const double by_u = light.light->intensity[c] * p.lookup.du[c];
        const double by_v = light.light->intensity[c] * p.lookup.dv[c];
        EXPECT_NEAR(by_u * uv_by_b1.x + by_v * uv_by_b1.y,
                    tests::RiddersDerivative(along_b1, b1, 0.004),
                    kDifference);
        EXPECT_NEAR(by_u * uv_by_b2.x + by_v * uv_by_b2.y,
                    tests::RiddersDerivative(along_b2, b2, 0.004),
                    kDifference);
      }
    }
    const AreaRadiancePartials behind = AreaRadianceDerivative(light, triangle, 0.2, 0.27, -1.0);
    EXPECT_EQ(behind.value, (Rgb{0, 0, 0}));
    EXPECT_EQ(behind.lookup.weight, (std::array<double, 4>{}));
  }
}

/// Triangle 0 shows the picture's bottom right half, triangle 1 its top left; each has area 2, and
/// a tenth of the samples is spread by area alone.
TEST(LightSamplers, TexturedTrianglesAreChosenByTheirMeanBrightness) {
  Texture half;
  half.width = half.height = 24;
  half.wrap = TextureWrap::kClamp;
  half.texels.clear();
  Texture ramp = half;
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 24; ++x) {
      half.texels.push_back(Rgb::Constant(x + y > 24 ? 6.0 : 0.0));
      ramp.texels.push_back(Rgb::Constant((x + 0.5) / 24.0));
    }
  }
  const World half_world(SceneWithPanel(half, false));
  const AreaSampler& by_half = half_world.light_samplers().AreasOf(half_world, {0});
  EXPECT_NEAR(by_half.Pdf({1, 0}), 0.45 + 0.025, 1e-12);
  EXPECT_NEAR(by_half.Pdf({1, 1}), 0.025, 1e-12);
  // Means 2/3 and 1/3, up to the constant half texels at the picture's border.
  const World ramp_world(SceneWithPanel(ramp, false));
  const AreaSampler& by_ramp = ramp_world.light_samplers().AreasOf(ramp_world, {0});
  EXPECT_NEAR(by_ramp.Pdf({1, 0}), 0.3 + 0.025, 1e-3);
  EXPECT_NEAR(by_ramp.Pdf({1, 1}), 0.15 + 0.025, 1e-3);
  EXPECT_EQ(by_ramp.Pdf({0, 0}), 0.0);
}

}  // namespace
}  // namespace pathfit::renderer::light_set_test
