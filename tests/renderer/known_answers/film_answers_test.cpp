#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/renderer/known_answers/known_answer.h"

// Path_space 6.3, C12, C13, C13b, C14, C15, C15b, C17, C30: shining surfaces seen through a filter,
// and a grey body before the sky, in both forms. The camera is at the origin and looks along -z;
// its pixel's axes are x and -y.
namespace pathfit::tests::film_answers_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;
using Kind = Filter1D::Kind;

constexpr int kReplicates = 20;
enum Term { kInterior, kPrimary, kDirect, kIndirect, kPixel };

struct NamedFilter {
  std::string name;
  Filter1D filter;
};
const std::array<NamedFilter, 3>& Filters() {
  static const std::array<NamedFilter, 3> filters{NamedFilter{"box", {Kind::kBox, 0.5, 0.0}},
                                                  NamedFilter{"tent", {Kind::kTent, 1.0, 0.0}},
                                                  NamedFilter{"gauss", {Kind::kGauss, 1.5, 0.5}}};
  return filters;
}
renderer::PixelFilter PixelFilterOf(const Filter1D& filter) {
  using Shape = renderer::PixelFilter::Shape;
  const Shape shape = filter.kind == Kind::kBox    ? Shape::kBox
                      : filter.kind == Kind::kTent ? Shape::kTent
                                                   : Shape::kGaussian;
  return {shape, filter.radius, filter.kind == Kind::kGauss ? filter.sigma : 0.5};
}

/// Rectangle [x0, x1] x [y0, y1] at depth z, facing the camera.
Mesh Screen(double x0, double x1, double y0, double y1, double z) {
  Mesh mesh;
  mesh.positions = {{x0, y0, -z}, {x1, y0, -z}, {x1, y1, -z}, {x0, y1, -z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

class FilmAnswers : public ::testing::TestWithParam<DerivativeForm> {
 protected:
  FilmAnswers() {
    scene_.materials = {{"black", renderer::LambertBsdf{}, {0.0, 0.0, 0.0}}};
    options_.max_bounces = 0;  // only what shines
    options_.form = GetParam();
    options_.spp = 4096;
    options_.sppe = 4096;
    options_.spp_pixel = 16384;
  }
  void Shine(const Mesh& mesh, double radiance, int texture = -1) {
    const int index = static_cast<int>(scene_.meshes.size());
    scene_.meshes.push_back({"screen", mesh, 0, {}});
    renderer::AreaEmitter light;
    light.mesh = index;
    light.intensity = renderer::Rgb::Constant(radiance);
    light.texture = texture;
    scene_.emitters.push_back({"light", renderer::LightFrame::kWorld, {}, light});
  }
  void Look(double focal, const Filter1D& filter, double centre = 0.0) {
    scene_.sensors = {OnePixelCamera(focal)};
    scene_.sensors[0].cx -= centre;
    scene_.sensors[0].filter = PixelFilterOf(filter);
  }
  void ExpectValue(const std::string& name, double value) const {
    const renderer::Renderer renderer(scene_);
    ExpectKnown(name,
                Channel(PrimalReplicates(renderer, scene_.sensors[0], options_, kReplicates), 0),
                {value});
  }
  TermReplicates Derivative(const Motion& motion) const {
    const renderer::Renderer renderer(scene_);
    return DerivativeByTerm(renderer, scene_.sensors[0], motion, options_, kReplicates);
  }
  void ExpectDerivative(const std::string& name, const Motion& motion, const Known& known) const {
    ExpectKnown(name, Derivative(motion).Total(), known);
  }
  static void ExpectOnly(std::size_t term, const TermReplicates& found) {
    for (std::size_t t = 0; t < kNumTerms; ++t) {
      if (t == term) continue;
      for (const double value : found.terms[t]) EXPECT_EQ(value, 0.0) << "term " << t;
    }
  }
  [[nodiscard]] Motion Translation(const Vec3& v, int mesh = 0) const {
    return Motion(scene_).Add(ParameterKind::kObjectTranslation, mesh, v);
  }
  [[nodiscard]] static bool InMaterialForm() { return GetParam() == DerivativeForm::kMaterial; }

  renderer::Scene scene_;
  renderer::RenderOptions options_;
};

TEST_P(FilmAnswers, C12HalfPlane) {
  const double f = 4.0, z = 2.0, x = 0.08;
  Shine(Screen(-30, x, -30, 30, z), 1.0);
  for (const auto& [name, filter] : Filters()) {
    Look(f, filter);
    const C12Answer c12 = C12FilterEdge(filter, f, z, x);
    // In material form the edge's own surface has its share in the interior or on the pixel border,
    // where most of it cancels.
    const double size = c12.d_x;
    ExpectValue("I_" + name, c12.value);
    ExpectDerivative("dI/dx_" + name, Translation({1, 0, 0}), {c12.d_x});
    ExpectDerivative("dI/dz_" + name, Translation({0, 0, -1}), {c12.d_z, size});
    const auto camera = [&](ParameterKind kind, const std::vector<double>& rate) {
      return Motion(scene_).Add(kind, 0, rate);
    };
    ExpectDerivative(
        "dI/dyaw_" + name, camera(ParameterKind::kCameraRotation, {0, -1, 0}), {c12.d_yaw});
    ExpectDerivative(
        "dI/dx_camera_" + name, camera(ParameterKind::kCameraPosition, {-1, 0, 0}), {c12.d_x});
    // The image shifts by a pixel, or grows about its centre.
    const double h = filter.Value(f * x / z);
    ExpectDerivative("dI/dcx_" + name, camera(ParameterKind::kPrincipalPoint, {1, 0}), {h, size});
    ExpectDerivative("dI/df_" + name, camera(ParameterKind::kFocal, {1, 1}), {h * x / z, size});
  }
}

TEST_P(FilmAnswers, C13QuadInsideAPixel) {
  const double f = 5.0, width = 0.2, length = 0.3, z = 3.0;
  const Vec3 centre{0, 0, -z};
  options_.spp = 8192;
  Look(f, Filters()[0].filter);
  for (const double tilt : {0.4, 0.0}) {
    SCOPED_TRACE(tilt);
    scene_.meshes.clear();
    scene_.emitters.clear();
    Mesh mesh = Plate(0.5 * width, 0.5 * length, 0.0);
    renderer::ApplyTransform({renderer::RotationFromVector({tilt, 0, 0}), centre}, mesh);
    Shine(mesh, 1.0);
    scene_.meshes[0].pose.pivot = centre;
    const C13Answer c13 = C13TiltedQuad(f, width, length, z, tilt);
    const std::string tail = tilt > 0.0 ? "_tilted" : "_flat";
    ExpectValue("I" + tail, c13.value);
    const auto expect = [&](const std::string& name, const Motion& motion, const Known& known) {
      const TermReplicates found = Derivative(motion);
      ExpectKnown(name + tail, found.Total(), known);
      ExpectOnly(InMaterialForm() ? kInterior : kPrimary, found);
    };
    expect("dI/dz", Translation({0, 0, -1}), {c13.d_z});
    // Seen straight on, both halves cancel: the near one grows as the far one shrinks.
    expect("dI/dtilt",
           Motion(scene_).Add(ParameterKind::kObjectRotation, 0, Vec3{1, 0, 0}),
           {c13.d_tilt, c13.value});
    expect("dI/df", Motion(scene_).Add(ParameterKind::kFocal, 0, std::vector{1.0, 1.0}), {c13.d_f});
  }
}

TEST_P(FilmAnswers, C13bQuadUnderSeparableFilters) {
  const double f = 5.0, width = 0.2, length = 0.3, cx = 0.12, cy = -0.07, z = 3.0;
  Shine(Screen(cx - 0.5 * width, cx + 0.5 * width, -cy - 0.5 * length, -cy + 0.5 * length, z), 1.0);
  for (const auto& [name, filter] : Filters()) {
    if (filter.kind == Kind::kBox) continue;  // wholly inside: C13
    Look(f, filter);
    const C13bAnswer c13b = C13bFilteredQuad(filter, f, width, length, cx, cy, z);
    const double size = std::abs(c13b.d_cx);
    ExpectValue("I_" + name, c13b.value);
    ExpectDerivative("dI/dcx_" + name, Translation({1, 0, 0}), {c13b.d_cx});
    ExpectDerivative("dI/dcy_" + name, Translation({0, -1, 0}), {c13b.d_cy, size});
    ExpectDerivative("dI/dz_" + name, Translation({0, 0, -1}), {c13b.d_z, size});
  }
}

TEST_P(FilmAnswers, C14PlaneMovingInDepth) {
  const double z = 3.0;
  Shine(Screen(-9, 9, -9, 9, z), 1.0);
  const MaterialSplit c14 = C14MovingPlane(z);
  for (const auto& [name, filter] : Filters()) {
    Look(5.0, filter);
    const TermReplicates found = Derivative(Translation({0, 0, -1}));
    ExpectKnown("dI/dz_" + name, found.Total(), {0.0, c14.filter});
    if (InMaterialForm() && filter.kind == Kind::kBox) {
      ExpectKnown("interior", found.terms[kInterior], {c14.interior});
      ExpectKnown("pixel", found.terms[kPixel], {c14.filter});
    }
  }
}

TEST_P(FilmAnswers, C15TiltedPlaneMovingAside) {
  const double z0 = 3.0, slope = 0.4, reach = 5.0;
  Mesh mesh = Screen(-reach, reach, -reach, reach, z0);
  for (Vec3& p : mesh.positions) p.z -= slope * p.x;
  Shine(mesh, 1.0);
  const MaterialSplit c15 = C15TiltedPlane(z0, slope);
  for (const auto& [name, filter] : Filters()) {
    Look(5.0, filter);
    const TermReplicates found = Derivative(Translation({1, 0, 0}));
    // The pixel's two sides gain and lose f / z0.
    ExpectKnown("dI/dx_" + name, found.Total(), {0.0, 5.0 / z0});
    if (InMaterialForm() && filter.kind == Kind::kBox) {
      ExpectKnown("interior", found.terms[kInterior], {c15.interior});
      ExpectKnown("pixel", found.terms[kPixel], {c15.filter, 5.0 / z0});
    }
  }
}

TEST_P(FilmAnswers, C15bTexturedPlaneMovingAside) {
  const double a = 1.0, b = 0.7, z = 3.0, f = 5.0, s = 0.2, u = 0.3, reach = 1.2;
  // Two texels: linear between their centres, which are the plane's sides.
  renderer::Texture ramp;
  ramp.name = "ramp";
  ramp.width = 2;
  ramp.wrap = renderer::TextureWrap::kClamp;
  ramp.texels = {renderer::Rgb::Constant(a - b * reach), renderer::Rgb::Constant(a + b * reach)};
  scene_.textures = {ramp};
  Mesh mesh = Screen(s - reach, s + reach, -5, 5, z);
  mesh.uvs = {{0.25, 0}, {0.75, 0}, {0.75, 1}, {0.25, 1}};
  mesh.uv_triangles = mesh.triangles;
  Shine(mesh, 1.0, 0);
  for (const auto& [name, filter] : Filters()) {
    Look(f, filter, u);
    const C15bAnswer c15b = C15bTexturedPlane(a, b, f, z, s, u);
    ExpectValue("I_" + name, c15b.value);
    ExpectDerivative("dI/ds_" + name, Translation({1, 0, 0}), {c15b.d_s, f / z});
    // A plane that stretches away from X = 0 by its UVs only: X of a point falls as its UV does.
    Motion uvs(scene_);
    uvs.layout.Add(ParameterKind::kUvs, 0);
    for (int i = 0; i < 4; ++i) uvs.direction.insert(uvs.direction.end(), {-0.25 / reach, 0.0});
    ExpectDerivative("dI/duv_" + name, uvs, {c15b.d_s});
  }
}

/// What the body reflects does not change with its place; the sky it covers does. The triangles
/// next to its silhouettes come closer to the rays along them than single precision can tell.
TEST_P(FilmAnswers, C17GreySphereInASky) {
  const double f = 2.0, albedo = 0.7, radius = 0.6, distance = 3.0;
  constexpr double kMesh = 2e-4;  // the mesh is inscribed: its outline is smaller
  const C17Answer c17 = C17SphereInSky(f, albedo, radius, distance);
  const Vec3 centre{0, 0, -distance};
  Mesh ball = renderer::MakeIcosphere(6, radius);
  // Turned off the icosahedron's symmetry, so that no face is seen edge on.
  renderer::ApplyTransform({renderer::RotationFromVector({0.2, 0.4, 0.6}), centre}, ball);
  scene_.materials[0].base_color = renderer::Rgb::Constant(albedo);
  scene_.meshes = {{"ball", ball, 0, {}}};
  scene_.emitters = {ConstantEnvironment({1, 1, 1})};
  Look(f, Filters()[0].filter);
  options_.max_bounces = 1;
  const renderer::Renderer renderer(scene_);
  const auto image = PrimalReplicates(renderer, scene_.sensors[0], options_, kReplicates);
  ExpectKnown("area", Channel(image, 3), {c17.area, 0.0, kMesh});
  ExpectKnown("I", Channel(image, 0), {1.0 + (albedo - 1.0) * c17.area, 0.0, kMesh});
  ExpectDerivative("dI/dd", Translation({0, 0, -1}), {c17.d_distance, 0.0, kMesh});
  ExpectDerivative("dI/dR",
                   Motion(scene_).Vertices(0, [&](const Vec3& p) { return (p - centre) / radius; }),
                   {c17.d_radius, 0.0, kMesh});
}

TEST_P(FilmAnswers, C30ForegroundOverBackground) {
  const double front = 0.3, back = 1.1, f = 4.0, z = 2.0, x = 0.08;
  Shine(Screen(-30, x, -30, 30, z), front);
  Shine(Screen(-30, 30, -30, 30, 5.0), back);
  for (const auto& [name, filter] : Filters()) {
    Look(f, filter);
    const C30Answer c30 = C30ForegroundEdge(filter, front, back, f, z, x);
    const TermReplicates found = Derivative(Translation({1, 0, 0}));
    ExpectKnown("dI/dx_" + name, found.Total(), {c30.d_x});
    if (!InMaterialForm()) {
      ExpectKnown("primary_" + name, found.terms[kPrimary], {c30.d_x});
      continue;
    }
    ExpectKnown("primary_" + name, found.terms[kPrimary], {c30.primary});
    const Term other = filter.kind == Kind::kBox ? kPixel : kInterior;
    ExpectKnown("foreground_" + name, found.terms[other], {c30.foreground});
  }
}

INSTANTIATE_TEST_SUITE_P(PathSpace63,
                         FilmAnswers,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

}  // namespace
}  // namespace pathfit::tests::film_answers_test
