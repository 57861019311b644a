#include "renderer/boundary/pixel_boundary.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/renderer/boundary/parameter_motion.h"

namespace pathfit::renderer::pixel_boundary_test {
namespace {

using tests::AgreesWithExact;
using tests::SumsOf;
using tests::Terms;
constexpr int kReplicates = 32;

/// Material form, emission only, these terms.
RenderOptions Material(const DerivativeTerms& terms, int spp = 16) {
  RenderOptions options;
  options.spp = spp;
  options.sppe = 500;
  options.spp_pixel = 64;
  options.max_bounces = 0;
  options.form = DerivativeForm::kMaterial;
  options.terms = terms;
  return options;
}

/// Black mesh that shines evenly, seen by one pixel through `filter`.
Scene Shining(const Mesh& mesh, double radiance, double f, const PixelFilter& filter = {}) {
  Scene scene = tests::SceneOf(mesh, LambertBsdf{}, {0, 0, 0}, {});
  tests::Shine(scene, 0, radiance);
  scene.sensors = {tests::OnePixelCamera(f)};
  scene.sensors[0].filter = filter;
  return scene;
}

// C14: nothing changes when an even plane moves in depth; the parts are known.
TEST(PixelBoundary, PlaneMovingInDepth) {
  const auto exact = tests::C14MovingPlane(3.0);
  for (const PixelFilter& filter : tests::ThreeFilters()) {
    const Scene scene = Shining(tests::Plate(50, 50, -3), 1.0, 5.0, filter);
    const auto motion = tests::Translate(scene, {0, 0, -1});
    const auto sums = [&](const DerivativeTerms& terms) {
      return SumsOf(tests::DerivativeFilms(scene, motion, Material(terms, 1024), kReplicates), 0);
    };
    if (filter.shape == PixelFilter::Shape::kBox) {
      EXPECT_TRUE(AgreesWithExact(sums(Terms(true, false, false)), exact.interior));
      EXPECT_TRUE(AgreesWithExact(sums(Terms(false, false, true)), exact.filter));
    }
    EXPECT_TRUE(tests::AgreesWithZero(sums(Terms(true, true, true)), 0.01));
  }
}

// C15: the same for a tilted plane that slides along.
TEST(PixelBoundary, TiltedPlaneMovingAside) {
  const auto exact = tests::C15TiltedPlane(3.0, 0.4);
  for (const PixelFilter& filter : tests::ThreeFilters()) {
    Mesh mesh = tests::Plate(5, 5, 0);
    for (Vec3& x : mesh.positions) x.z = -3.0 - 0.4 * x.x;
    const Scene scene = Shining(mesh, 1.0, 5.0, filter);
    const auto motion = tests::Translate(scene, {1, 0, 0});
    const auto sums = [&](const DerivativeTerms& terms) {
      return SumsOf(tests::DerivativeFilms(scene, motion, Material(terms, 4096), kReplicates), 0);
    };
    if (filter.shape == PixelFilter::Shape::kBox) {
      EXPECT_TRUE(AgreesWithExact(sums(Terms(true, false, false)), exact.interior));
      EXPECT_TRUE(AgreesWithExact(sums(Terms(false, false, true)), exact.filter));
    }
    EXPECT_TRUE(tests::AgreesWithZero(sums(Terms(true, true, true)), 0.002));
  }
}

/// C15b: plane of radiance 1 + 0.7 X, shifted by 0.2.
Scene RampPlane(const PixelFilter& filter) {
  constexpr double kHalf = 2.0;  // the texture runs over X in [-kHalf, kHalf]
  Mesh mesh = tests::Plate(kHalf, kHalf, -3);
  ApplyTransform({{}, {0.2, 0, 0}}, mesh);
  Scene scene = Shining(mesh, 1.0, 5.0, filter);
  Texture ramp;
  ramp.wrap = TextureWrap::kClamp;
  ramp.width = 2;  // linear between the texel centres X = -kHalf / 2 and kHalf / 2
  ramp.texels = {Rgb::Constant(1.0 - 0.35 * kHalf), Rgb::Constant(1.0 + 0.35 * kHalf)};
  scene.textures = {ramp};
  std::get<AreaEmitter>(scene.emitters[0].light).texture = 0;
  scene.sensors[0].cx = 0.2;  // the pixel's centre is u = 0.3
  return scene;
}
TEST(PixelBoundary, TexturedPlaneMovingAside) {
  const auto exact = tests::C15bTexturedPlane(1.0, 0.7, 5.0, 3.0, 0.2, 0.3);
  for (const PixelFilter& filter : tests::ThreeFilters()) {
    const Scene scene = RampPlane(filter);
    RenderOptions options = Material(Terms(true, true, true), 1024);
    const auto motion = tests::Translate(scene, {1, 0, 0});
    const auto agrees = [&] {
      return AgreesWithExact(SumsOf(tests::DerivativeFilms(scene, motion, options, kReplicates), 0),
                             exact.d_s);
    };
    EXPECT_TRUE(agrees());
    options.form = DerivativeForm::kImage;
    EXPECT_TRUE(agrees());
  }
}

/// The half plane of C12 and C30.
constexpr double kF = 4.0;
constexpr double kZ = 2.0;
constexpr double kX = 0.08;
Mesh HalfPlane() {
  Mesh mesh = tests::Plate(10, 20, -kZ);
  ApplyTransform({{}, {kX - 10.0, 0, 0}}, mesh);
  return mesh;
}

// C30 in material form: the primary boundary has the background's part only, a surface's or the
// sky's; the foreground's is the pixel boundary or the slope of the filter.
TEST(PixelBoundary, ForegroundAgainstBackground) {
  for (const PixelFilter& filter : tests::ThreeFilters()) {
    for (const bool sky : {false, true}) {
      Scene scene = Shining(HalfPlane(), 0.3, kF, filter);
      if (sky) {
        scene.emitters.push_back(tests::ConstantEnvironment(Rgb::Constant(1.1)));
      } else {
        scene.meshes.push_back({"back", tests::Plate(30, 30, -5), 0, {}});
        tests::Shine(scene, 1, 1.1);
      }
      const auto exact = tests::C30ForegroundEdge(tests::ClosedForm(filter), 0.3, 1.1, kF, kZ, kX);
      const auto motion = tests::Translate(scene, {1, 0, 0});
      const auto primary =
          tests::DerivativeFilms(scene, motion, Material(Terms(false, true, false)), kReplicates);
      EXPECT_TRUE(AgreesWithExact(SumsOf(primary, 0), exact.primary));
      const auto coverage = tests::C12FilterEdge(tests::ClosedForm(filter), kF, kZ, kX);
      if (sky) {
        EXPECT_TRUE(AgreesWithExact(SumsOf(primary, 3), coverage.d_x));
      } else {
        EXPECT_EQ(primary[0].pixels[0].a, 0.0);
      }
      EXPECT_TRUE(AgreesWithExact(
          SumsOf(tests::DerivativeFilms(
                     scene, motion, Material(Terms(true, false, true), 4096), kReplicates),
                 0),
          exact.foreground));
    }
  }
}

// The background moves, the edge rests: a resting edge counts in material form.
TEST(PixelBoundary, RestingEdgeBeforeMovingBackground) {
  Scene scene = Shining(tests::Plate(30, 30, -5), 1.1, kF);
  scene.meshes.push_back({"front", HalfPlane(), 0, {}});
  tests::Shine(scene, 1, 0.3);
  const auto motion = tests::Translate(scene, {1, 0, 0});
  const auto films = [&](const RenderOptions& options) {
    return tests::DerivativeFilms(scene, motion, options, kReplicates);
  };
  EXPECT_TRUE(AgreesWithExact(SumsOf(films(Material(Terms(false, true, false))), 0), 1.1 * kF / 5));
  RenderOptions all = Material(Terms(true, true, true));
  EXPECT_TRUE(tests::AgreesWithZero(SumsOf(films(all), 0), 1e-9));
  all.form = DerivativeForm::kImage;
  EXPECT_EQ(films(all)[0].pixels[0], Rgba());
}

/// Edge and background on several pixels, with a sky of varied radiance.
Scene SmallView(const PixelFilter& filter, ProjectionKind projection) {
  Scene scene = RampPlane(filter);
  ApplyTransform({RotationAboutAxis({0, 1, 0}, 0.5), {0, 0, -1}}, scene.meshes[0].mesh);
  Mesh front = tests::Plate(0.3, 0.4, -2);
  ApplyTransform({RotationAboutAxis({0, 0, 1}, 0.3), {}}, front);
  scene.meshes.push_back({"front", front, 0, {}});
  tests::Shine(scene, 1, 0.4);
  scene.emitters.push_back(tests::LinearEnvironment(1.0, {0.4, 0.3, -0.2}, 32));
  Camera& camera = scene.sensors[0];
  camera = tests::CameraAt({0.2, 0.1, 0}, {0.1, 0, -3}, 4.0, 4, 3);
  camera.projection = projection;
  if (projection == ProjectionKind::kOrthographic) camera.fx = camera.fy = 1.3;
  camera.filter = filter;
  return scene;
}

/// z-scores of the difference of two estimates over pixels, for one colour (all are grey) and
/// coverage. A stratum of edge samples that crosses a pixel's border is met so rarely that the
/// replicates may miss it: errors below a thousandth of the largest value are not told apart.
class ZScores {
 public:
  void Compare(const std::vector<Film>& a, const std::vector<Film>& b, const std::string& name) {
    for (const int channel : {0, 3}) {
      double scale = 0.0;
      for (const Rgba& p : b[0].pixels) scale = std::max(scale, std::abs(p[channel]));
      for (std::size_t pixel = 0; pixel < a[0].pixels.size(); ++pixel) {
        const tests::MeanAndError ma = At(a, pixel, channel);
        const tests::MeanAndError mb = At(b, pixel, channel);
        const double error =
            std::sqrt(ma.error * ma.error + mb.error * mb.error + 1e-6 * scale * scale + 1e-24);
        const double z = (ma.mean - mb.mean) / error;
        EXPECT_LT(std::abs(z), 4.5) << name << ", pixel " << pixel << ", channel " << channel
                                    << ": " << ma.mean << " and " << mb.mean << " +- " << error;
        sum_ += z * z;
        ++count_;
      }
    }
  }
  [[nodiscard]] double Rms() const { return std::sqrt(sum_ / count_); }

 private:
  static tests::MeanAndError At(const std::vector<Film>& films, std::size_t pixel, int channel) {
    std::vector<double> values;
    for (const Film& f : films) values.push_back(f.pixels[pixel][channel]);
    return tests::EstimateMean(values);
  }
  double sum_ = 0.0;
  int count_ = 0;
};

struct Case {
  ParameterKind kind;
  std::vector<double> direction;
  int object;
};
std::vector<Case> Cases() {
  using Kind = ParameterKind;
  return {{Kind::kObjectTranslation, {0.3, -0.2, 0.5}, 0},
          {Kind::kObjectRotation, {0.2, 0.3, -0.4}, 1},
          {Kind::kObjectScale, {1.0}, 0},
          {Kind::kCameraPosition, {0.4, 0.3, -0.2}, 0},
          {Kind::kCameraRotation, {0.2, -0.3, 0.4}, 0},
          {Kind::kFocal, {0.7, -0.4}, 0},
          {Kind::kPrincipalPoint, {0.5, 0.3}, 0},
          {Kind::kLightRotation, {0.3, 0.5, -0.2}, 2}};
}

TEST(PixelBoundary, BothFormsAgreePerPixel) {
  ZScores scores;
  const auto compare = [&](const PixelFilter& filter, ProjectionKind projection) {
    const Scene scene = SmallView(filter, projection);
    for (const Case& c : Cases()) {
      const auto motion = tests::Change(scene, c.kind, c.direction, c.object);
      RenderOptions options = Material(Terms(true, true, true), 512);
      options.sppe = 80;
      options.spp_pixel = 128;
      const auto material = tests::DerivativeFilms(scene, motion, options, kReplicates);
      options.form = DerivativeForm::kImage;
      options.spp = 128;
      const auto image = tests::DerivativeFilms(scene, motion, options, kReplicates);
      scores.Compare(material,
                     image,
                     std::string(TraitsOf(c.kind).property) + " of " + std::to_string(c.object) +
                         ", radius " + std::to_string(filter.radius) +
                         (projection == ProjectionKind::kOrthographic ? ", parallel" : ""));
    }
  };
  const PixelFilter box;
  const PixelFilter tent{PixelFilter::Shape::kTent, 1.0, 0.5};
  compare(box, ProjectionKind::kPerspective);
  compare(tent, ProjectionKind::kPerspective);
  compare({PixelFilter::Shape::kBox, 1.0, 0.5}, ProjectionKind::kPerspective);
  compare({PixelFilter::Shape::kBox, 0.8, 0.5}, ProjectionKind::kPerspective);
  compare(box, ProjectionKind::kOrthographic);
  compare(tent, ProjectionKind::kOrthographic);
  EXPECT_LT(scores.Rms(), 1.1);
}

// Pairs of mirrored paths are the interior's: boundary samples stand alone.
TEST(PixelBoundary, AntitheticPairsDoNotConcernIt) {
  Scene scene = tests::SceneOf(HalfPlane(),
                               MetallicRoughnessBsdf{0.6, 1.0},
                               {0.9, 0.9, 0.9},
                               {tests::LinearEnvironment(1.0, {0.5, 0.2, 0.6}, 16)});
  scene.sensors = {tests::CameraAt({-5, 0, -1}, {kX, 0, -kZ}, kF, 1, 1)};
  const auto motion = tests::Translate(scene, {1, 0, 0});
  for (const DerivativeForm form : {DerivativeForm::kImage, DerivativeForm::kMaterial}) {
    RenderOptions options = Material(Terms(false, true, true));
    options.form = form;
    options.max_bounces = 1;
    const Rgba alone = tests::DerivativeFilms(scene, motion, options, 1)[0].pixels[0];
    options.antithetic = true;
    EXPECT_EQ(tests::DerivativeFilms(scene, motion, options, 1)[0].pixels[0], alone);
    EXPECT_NE(alone.Color(), Rgb());
  }
}

TEST(PixelBoundary, NothingIsAddedWhereTheVisiblePointRests) {
  Scene scene = SmallView({}, ProjectionKind::kPerspective);
  Mesh behind = tests::Plate(0.1, 0.1, 4.0);  // out of sight
  scene.meshes.insert(scene.meshes.begin(), {"behind", behind, 0, {}});
  for (std::size_t i = 0; i < 2; ++i) {
    ++std::get<AreaEmitter>(scene.emitters[i].light).mesh;
  }
  const auto motion = tests::Translate(scene, {1, 2, 3});
  const auto films = tests::DerivativeFilms(scene, motion, Material(Terms(true, true, true)), 1);
  for (const Rgba& p : films[0].pixels) {
    EXPECT_EQ(p, Rgba());
  }
}

}  // namespace
}  // namespace pathfit::renderer::pixel_boundary_test
