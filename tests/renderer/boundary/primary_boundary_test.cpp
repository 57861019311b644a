#include "renderer/boundary/primary_boundary.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "tests/renderer/boundary/parameter_motion.h"
#include "tests/support/finite_difference.h"

namespace pathfit::renderer::primary_boundary_test {
namespace {

using tests::AgreesWithExact;
using tests::Channel;
constexpr int kReplicates = 32;

RenderOptions Options(double sppe, int spp = 1) {
  RenderOptions options;
  options.spp = spp;
  options.sppe = sppe;
  options.terms = tests::Terms(true, true, true);
  return options;
}

/// Derivative of one pixel (and of the sum of many) for a velocity field of mesh 0: all four
/// channels.
template <class Velocity>
std::vector<Rgba> Derivative(const Scene& scene,
                             const Camera& camera,
                             const RenderOptions& options,
                             Velocity velocity) {
  const tests::VertexMotion motion = tests::MoveMesh(scene, velocity);
  return tests::DerivativeReplicates(
      Renderer(scene), camera, motion.layout, motion.direction, options, kReplicates);
}

/// A surface that covers u < s in front of a sky of radiance `sky`.
Scene HalfPlane(double edge_x, double z, double albedo, double sky) {
  Mesh mesh = tests::Rectangle();
  ApplyTransform({{{10, 0, 0}, {0, 20, 0}, {0, 0, 1}}, {edge_x - 10.0, 0, -z}}, mesh);
  return tests::SceneOf(
      mesh, LambertBsdf{}, Rgb::Constant(albedo), {tests::ConstantEnvironment(Rgb::Constant(sky))});
}

constexpr double kF = 4.0;
constexpr double kZ = 2.0;
constexpr double kX = 0.08;
Vec3 Right(const Vec3&) { return {1, 0, 0}; }
Vec3 Backwards(const Vec3&) { return {0, 0, -1}; }
/// Turning about the camera so that u grows.
Vec3 Yaw(const Vec3& x) { return {-x.z, 0, x.x}; }

// C12: the covered share of the pixel is I = 0.66; black in front of a sky of one, so radiance is 1
// - I.
TEST(PrimaryBoundary, HalfPlaneCoverage) {
  const Scene scene = HalfPlane(kX, kZ, 0.0, 1.0);
  const auto primal = tests::PrimalReplicates(
      Renderer(scene), tests::OnePixelCamera(kF), Options(0, 4096), kReplicates);
  EXPECT_TRUE(AgreesWithExact(Channel(primal, 3), 0.66));
  EXPECT_TRUE(AgreesWithExact(Channel(primal, 0), 1.0 - 0.66));
}

TEST(PrimaryBoundary, HalfPlaneByPositionDepthAndYaw) {
  const Scene scene = HalfPlane(kX, kZ, 0.0, 1.0);
  const Camera camera = tests::OnePixelCamera(kF);
  const auto check = [&](const std::vector<Rgba>& d, double exact) {
    EXPECT_TRUE(AgreesWithExact(Channel(d, 3), exact));
    EXPECT_TRUE(AgreesWithExact(Channel(d, 1), -exact));
  };
  check(Derivative(scene, camera, Options(500), Right), 2.0);
  check(Derivative(scene, camera, Options(500), Backwards), -0.08);
  check(Derivative(scene, camera, Options(500), Yaw), 4.0064);
}

/// The same plate as a light of radiance one before nothing, seen through `filter`.
Scene BrightHalfPlane(const PixelFilter& filter, double radiance = 1.0) {
  Scene scene = HalfPlane(kX, kZ, 0.0, 0.0);
  scene.emitters.clear();
  tests::Shine(scene, 0, radiance);
  scene.sensors = {tests::OnePixelCamera(kF)};
  scene.sensors[0].filter = filter;
  return scene;
}
RenderOptions Bright(double sppe, DerivativeForm form = DerivativeForm::kImage) {
  RenderOptions options = Options(sppe);
  options.max_bounces = 0;
  options.form = form;
  return options;
}

// C12 through every filter, moved by the object and by the camera.
TEST(PrimaryBoundary, HalfPlaneThroughFilters) {
  for (const PixelFilter& filter : tests::ThreeFilters()) {
    const Scene scene = BrightHalfPlane(filter);
    const auto exact = tests::C12FilterEdge(tests::ClosedForm(filter), kF, kZ, kX);
    const auto check = [&](const tests::ParameterMotion& motion, double answer) {
      const auto films = tests::DerivativeFilms(scene, motion, Bright(500), kReplicates);
      EXPECT_TRUE(AgreesWithExact(tests::SumsOf(films, 0), answer));
      EXPECT_TRUE(AgreesWithExact(tests::SumsOf(films, 3), answer));
    };
    check(tests::Translate(scene, {1, 0, 0}), exact.d_x);
    check(tests::Translate(scene, {0, 0, -1}), exact.d_z);
    check(tests::Change(scene, ParameterKind::kObjectRotation, {0, -1, 0}),
          -exact.d_yaw);  // about the origin, where the camera is
    check(tests::Change(scene, ParameterKind::kCameraPosition, {1, 0, 0}), -exact.d_x);
    check(tests::Change(scene, ParameterKind::kCameraPosition, {0, 0, 1}), exact.d_z);
    check(tests::Change(scene, ParameterKind::kCameraRotation, {0, 1, 0}), -exact.d_yaw);
    check(tests::Change(scene, ParameterKind::kPrincipalPoint, {1, 0}), exact.d_x * kZ / kF);
    check(tests::Change(scene, ParameterKind::kFocal, {1, 0}), exact.d_x * kX / kF);
  }
}

TEST(PrimaryBoundary, FiltersReachOverTheFilmsBorder) {
  Scene scene = HalfPlane(0.3, kZ, 0.0, 0.0);  // s = 0.6, beside the only pixel
  tests::Shine(scene, 0, 1.0);
  scene.sensors = {tests::OnePixelCamera(kF)};
  scene.sensors[0].filter = {PixelFilter::Shape::kTent, 1.0, 0.5};
  const auto films =
      tests::DerivativeFilms(scene, tests::Translate(scene, {1, 0, 0}), Bright(500), kReplicates);
  EXPECT_TRUE(AgreesWithExact(tests::SumsOf(films, 0), 0.4 * kF / kZ));
}

// A flash at the sensor: the shadow ray of the wall behind the edge passes beside the edge.
TEST(PrimaryBoundary, BackgroundIsLitByALightAtTheSensor) {
  Scene scene = HalfPlane(kX, kZ, 0.0, 0.0);
  scene.meshes.push_back({"wall", tests::Plate(30, 30, -5), 1, {}});
  scene.materials.push_back({"white", LambertBsdf{}, {1, 1, 1}});
  scene.emitters = {{"flash", LightFrame::kCamera, {}, PointEmitter{{0, 0, 0}, {100, 100, 100}}}};
  scene.sensors = {tests::OnePixelCamera(kF)};
  const auto films =
      tests::DerivativeFilms(scene, tests::Translate(scene, {1, 0, 0}), Options(500), kReplicates);
  const double wall = tests::Integrate(
      [](double v) {
        constexpr double kS = kF * kX / kZ;
        const double cosine = kF / std::sqrt(kF * kF + v * v + kS * kS);
        return 4.0 / 3.14159265358979324 * cosine * cosine * cosine;
      },
      -0.5,
      0.5);
  // The shaded point is a little beside the edge.
  EXPECT_TRUE(AgreesWithExact(tests::SumsOf(films, 0), -wall * kF / kZ, 0.01, 2e-4));
}

TEST(PrimaryBoundary, EdgesOutsideThePixelDoNothing) {
  const Scene scene = HalfPlane(0.3, kZ, 0.0, 1.0);  // s = 0.6, just beside the pixel
  for (const Rgba& d : Derivative(scene, tests::OnePixelCamera(kF), Options(200), Right))
    EXPECT_EQ(d, Rgba());
}

// C30: foreground radiance 0.3, background 1.1: dI/dx = (L_f - L_b) h f / z.
TEST(PrimaryBoundary, ForegroundAgainstBackground) {
  const Scene scene = HalfPlane(kX, kZ, 0.3 / 1.1, 1.1);
  const auto d = Derivative(scene, tests::OnePixelCamera(kF), Options(500), Right);
  EXPECT_TRUE(AgreesWithExact(Channel(d, 0), -1.6));
  EXPECT_TRUE(AgreesWithExact(Channel(d, 3), 2.0));
}

TEST(PrimaryBoundary, ForegroundOfTheBackgroundsColorIsInvisible) {
  const Scene scene = HalfPlane(kX, kZ, 1.0, 1.0);
  const auto d = Derivative(scene, tests::OnePixelCamera(kF), Options(500), Right);
  const tests::MeanAndError m = tests::EstimateMean(Channel(d, 0));
  EXPECT_LT(std::abs(m.mean), 4.0 * m.error);
  EXPECT_LT(m.error, 0.02) << "of a coverage derivative of 2";
}

// C13: tilted quad inside one pixel.
class TiltedQuad : public ::testing::Test {
 protected:
  static Scene QuadAt(double tilt) {
    Mesh mesh = tests::Plate(0.1, 0.15, 0.0);
    ApplyTransform({RotationAboutAxis({1, 0, 0}, tilt), {0, 0, -3}}, mesh);
    return tests::SceneOf(mesh, LambertBsdf{}, {0, 0, 0}, {tests::ConstantEnvironment({1, 1, 1})});
  }
  const Camera camera_ = tests::OnePixelCamera(5.0);
};

TEST_F(TiltedQuad, Coverage) {
  const auto primal =
      tests::PrimalReplicates(Renderer(QuadAt(0.4)), camera_, Options(0, 16384), kReplicates);
  EXPECT_TRUE(AgreesWithExact(Channel(primal, 3), 1.536266284006e-01));
}
TEST_F(TiltedQuad, ByDepth) {
  const auto d = Derivative(QuadAt(0.4), camera_, Options(2000), Backwards);
  EXPECT_TRUE(AgreesWithExact(Channel(d, 3), -1.024954382619e-01));
  EXPECT_TRUE(AgreesWithExact(Channel(d, 0), 1.024954382619e-01));
  const auto flat = Derivative(QuadAt(0.0), camera_, Options(2000), Backwards);
  EXPECT_TRUE(AgreesWithExact(Channel(flat, 3), -1.111111111111e-01));
}
TEST_F(TiltedQuad, ByTilt) {
  const auto turn = [](const Vec3& x) { return Cross(Vec3{1, 0, 0}, x - Vec3{0, 0, -3}); };
  EXPECT_TRUE(AgreesWithExact(Channel(Derivative(QuadAt(0.4), camera_, Options(2000), turn), 3),
                              -6.440106273540e-02));
}

TEST_F(TiltedQuad, ByFocalLength) {
  Scene scene = QuadAt(0.4);
  scene.sensors = {camera_};
  const auto motion = tests::Change(scene, ParameterKind::kFocal, {1, 1});
  EXPECT_TRUE(AgreesWithExact(
      tests::SumsOf(tests::DerivativeFilms(scene, motion, Options(2000), kReplicates), 3),
      tests::C13TiltedQuad(5, 0.2, 0.3, 3, 0.4).d_f));
}
TEST_F(TiltedQuad, HasInteriorOnlyInMaterialForm) {
  Scene scene = QuadAt(0.4);
  scene.emitters.clear();
  tests::Shine(scene, 0, 1.0);
  scene.sensors = {camera_};
  const auto motion = tests::Translate(scene, {0, 0, -1});
  RenderOptions options = Bright(2000, DerivativeForm::kMaterial);
  options.terms = tests::Terms(false, true, true);
  for (const Film& film : tests::DerivativeFilms(scene, motion, options, 1))
    EXPECT_EQ(film.pixels[0].Color(), Rgb());
  options.terms = tests::Terms(true, true, true);
  options.spp = 16384;
  EXPECT_TRUE(
      AgreesWithExact(tests::SumsOf(tests::DerivativeFilms(scene, motion, options, kReplicates), 0),
                      tests::C13TiltedQuad(5, 0.2, 0.3, 3, 0.4).d_z));
}

// C13b: a quad that is smaller than the filter.
TEST(PrimaryBoundary, QuadThroughSeparableFilters) {
  const std::vector<PixelFilter> filters = tests::ThreeFilters();
  for (const std::size_t i : {1U, 2U}) {
    Mesh mesh = tests::Plate(0.1, 0.15, -3.0);
    ApplyTransform({{}, {0.12, 0.07, 0}}, mesh);  // v points down
    Scene scene = tests::SceneOf(mesh, LambertBsdf{}, {0, 0, 0}, {});
    tests::Shine(scene, 0, 1.0);
    scene.sensors = {tests::OnePixelCamera(5.0)};
    scene.sensors[0].filter = filters[i];
    const auto exact =
        tests::C13bFilteredQuad(tests::ClosedForm(filters[i]), 5, 0.2, 0.3, 0.12, -0.07, 3);
    const auto check = [&](const Vec3& direction, double answer) {
      const auto motion = tests::Translate(scene, direction);
      EXPECT_TRUE(AgreesWithExact(
          tests::SumsOf(tests::DerivativeFilms(scene, motion, Bright(5000), kReplicates), 0),
          answer));
    };
    check({1, 0, 0}, exact.d_cx);
    check({0, -1, 0}, exact.d_cy);
    check({0, 0, -1}, exact.d_z);
  }
}

/// Area of the image of a convex mesh seen by OnePixelCamera(f): the hull of its projected
/// vertices.
double HullArea(const Mesh& mesh, double f) {
  std::vector<Vec2> p;
  for (const Vec3& x : mesh.positions) p.push_back({f * x.x / -x.z, f * x.y / -x.z});
  std::sort(p.begin(), p.end(), [](const Vec2& a, const Vec2& b) {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
  });
  const auto cross = [](const Vec2& o, const Vec2& a, const Vec2& b) {
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
  };
  std::vector<Vec2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const Vec2& q : p) {
      while (hull.size() >= start + 2 && cross(hull[hull.size() - 2], hull.back(), q) <= 0.0)
        hull.pop_back();
      hull.push_back(q);
    }
    hull.pop_back();
    std::reverse(p.begin(), p.end());
  }
  double area = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2& a = hull[i];
    const Vec2& b = hull[(i + 1) % hull.size()];
    area += 0.5 * (a.x * b.y - a.y * b.x);
  }
  return area;
}

// C17: convex grey body under a constant sky of one: the sum over pixels changes by (rho - 1) dA
// only.
class ConvexBody : public ::testing::Test {
 protected:
  static constexpr double kAlbedo = 0.7;
  static Mesh Ball(int subdivisions, double radius, double distance) {
    Mesh mesh = MakeIcosphere(subdivisions, radius);
    // Turned off the icosahedron's symmetry, so that no face is seen edge on.
    ApplyTransform({RotationAboutAxis(Normalized(Vec3{1, 2, 3}), 0.7), {0, 0, -distance}}, mesh);
    return mesh;
  }
  static Scene SceneWith(const Mesh& mesh) {
    return tests::SceneOf(
        mesh, LambertBsdf{}, Rgb::Constant(kAlbedo), {tests::ConstantEnvironment({1, 1, 1})});
  }
  static Vec3 Grow(const Vec3& x) { return (x - Vec3{0, 0, -3}) * (1.0 / 0.6); }
  const Camera camera_ = tests::OnePixelCamera(2.0);
};

TEST_F(ConvexBody, SphereMeshMovesAsItsOwnExactImageArea) {
  const Scene scene = SceneWith(Ball(2, 0.6, 3.0));
  const double by_radius =
      tests::RiddersDerivative([](double r) { return HullArea(Ball(2, r, 3.0), 2.0); }, 0.6, 1e-3);
  const double by_distance =
      tests::RiddersDerivative([](double d) { return HullArea(Ball(2, 0.6, d), 2.0); }, 3.0, 1e-3);
  const auto grow = Derivative(scene, camera_, Options(500, 512), Grow);
  EXPECT_TRUE(AgreesWithExact(Channel(grow, 3), by_radius));
  EXPECT_TRUE(AgreesWithExact(Channel(grow, 0), (kAlbedo - 1.0) * by_radius));
  const auto recede = Derivative(scene, camera_, Options(2000, 512), Backwards);
  EXPECT_TRUE(AgreesWithExact(Channel(recede, 3), by_distance));
  EXPECT_TRUE(AgreesWithExact(Channel(recede, 0), (kAlbedo - 1.0) * by_distance));
}

TEST_F(ConvexBody, SphereMeshTendsToTheSphereAsTheSquareOfTheEdge) {
  const double smooth = 2.0 * 3.14159265358979324 * 4.0 * 0.6 * 9.0 / ((9.0 - 0.36) * (9.0 - 0.36));
  EXPECT_NEAR((kAlbedo - 1.0) * smooth, -5.454153912482e-01, 1e-11);
  std::vector<double> errors;
  for (const int subdivisions : {1, 2, 3, 4}) {
    const auto area = [&](double r) { return HullArea(Ball(subdivisions, r, 3.0), 2.0); };
    errors.push_back(smooth - tests::RiddersDerivative(area, 0.6, 1e-3));
  }
  // Slope of log error against log edge length over three halvings: 2 +- 0.2.
  EXPECT_NEAR(std::log2(errors.front() / errors.back()) / 3.0, 2.0, 0.2);
  // The finest estimate reaches the smooth sphere's answer.
  const auto grow = Derivative(SceneWith(Ball(4, 0.6, 3.0)), camera_, Options(500, 512), Grow);
  EXPECT_TRUE(
      AgreesWithExact(Channel(grow, 0), -5.454153912482e-01, 0.01, 1.5 * errors.back() / smooth));
}

TEST_F(ConvexBody, CubeByItsHalfEdge) {
  Mesh cube = tests::Cube();
  ApplyTransform({{{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}}, {0, 0, -3}}, cube);
  const auto grow = Derivative(SceneWith(cube), camera_, Options(500, 512), [](const Vec3& x) {
    return (x - Vec3{0, 0, -3}) * 2.0;
  });
  EXPECT_TRUE(AgreesWithExact(Channel(grow, 0), -9.216e-01));
}

TEST_F(ConvexBody, OrthographicSphereByItsRadius) {
  Scene scene = SceneWith(Ball(4, 0.6, 3.0));
  Camera camera = tests::OnePixelCamera(1.0);
  camera.projection = ProjectionKind::kOrthographic;
  camera.width = camera.height = 2;
  camera.cx = camera.cy = 1.0;
  for (const DerivativeForm form : {DerivativeForm::kImage, DerivativeForm::kMaterial}) {
    RenderOptions options = Options(500, form == DerivativeForm::kImage ? 64 : 2048);
    options.form = form;
    const auto grow = Derivative(scene, camera, options, Grow);
    const double exact = tests::C17OrthographicSphere(kAlbedo, 0.6);
    EXPECT_TRUE(AgreesWithExact(Channel(grow, 0), exact, 0.01, 5e-3));
    EXPECT_TRUE(AgreesWithExact(Channel(grow, 3), exact / (kAlbedo - 1.0), 0.01, 5e-3));
  }
}

TEST_F(ConvexBody, CubeInMaterialForm) {
  Mesh cube = tests::Cube();
  ApplyTransform({{{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}}, {0, 0, -3}}, cube);
  RenderOptions options = Options(500, 4096);
  options.form = DerivativeForm::kMaterial;
  const auto grow = Derivative(SceneWith(cube), camera_, options, [](const Vec3& x) {
    return (x - Vec3{0, 0, -3}) * 2.0;
  });
  EXPECT_TRUE(AgreesWithExact(Channel(grow, 0), tests::C17CubeInSky(2.0, kAlbedo, 0.5, 3.0)));
}

TEST(PrimaryBoundary, EdgesBehindAnOccluderDoNothingAndAreCounted) {
  Scene scene = HalfPlane(kX, kZ, 0.0, 1.0);
  scene.meshes.push_back({"screen", tests::Plate(10, 10, -1), 0, {}});
  const tests::VertexMotion motion = tests::MoveMesh(scene, Right);
  const Camera camera = tests::OnePixelCamera(kF);
  FilmSink sink(motion.layout, motion.direction, 1, 1);
  RenderStats stats;
  Renderer(scene).RenderDerivative(
      camera, -1, Options(100), motion.layout, sink, {.stats = &stats});
  EXPECT_EQ(sink.film().pixels[0], Rgba());
  EXPECT_GT(stats.edge_samples_hidden, 50);
  EXPECT_LE(stats.edge_samples_hidden, stats.edge_samples);
}

TEST(PrimaryBoundary, MovingMeshBehindAFixedOneKeepsItsFreePart) {
  // The fixed screen covers the upper half of the pixel; half of the moving edge remains.
  Scene scene = HalfPlane(kX, kZ, 0.0, 1.0);
  Mesh screen = tests::Plate(10, 10, -1);
  ApplyTransform({{}, {0, 10, 0}}, screen);
  scene.meshes.push_back({"screen", screen, 0, {}});
  EXPECT_TRUE(AgreesWithExact(
      Channel(Derivative(scene, tests::OnePixelCamera(kF), Options(1000), Right), 3), 1.0));
}

}  // namespace
}  // namespace pathfit::renderer::primary_boundary_test
