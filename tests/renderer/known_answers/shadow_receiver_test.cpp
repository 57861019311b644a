#include "tests/renderer/known_answers/shadow_receiver.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

// Path_space 6.3, C8, C10, C11, C11b, C19, C23: the floor's irradiance in shadows that move. No
// boundary sample meets a point, so the sensor's pixel is a small piece of the floor and the
// answers are averaged over it.
namespace pathfit::tests::shadow_receiver_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;

/// Where the receiver moves the two forms split the derivative differently; elsewhere they are the
/// same numbers.
class MovingShadowReceiver : public ShadowReceiver,
                             public ::testing::WithParamInterface<DerivativeForm> {
 protected:
  MovingShadowReceiver() { options_.form = GetParam(); }
};

/// Black from both sides, its edge x = `edge` at `height`: as much of a half plane as shadows.
Mesh HalfPlane(double edge, double height, double depth, double half_width) {
  return Ceiling(edge - depth, edge, -half_width, half_width, height);
}
/// Vertices on the edge x = `edge` move, the far border stays.
Motion EdgeMotion(const renderer::Scene& scene, int mesh, double edge, const Vec3& v) {
  return Motion(scene).Vertices(mesh, [=](const Vec3& p) { return p.x == edge ? v : Vec3{}; });
}

TEST_P(MovingShadowReceiver, C8HalfPlane) {
  const double edge = 0.05, height = 0.8, r = 0.2;
  const int light = floor_.AddLight(Ceiling(-0.6, 0.6, -0.5, 0.5, 2.0));
  const int occluder = floor_.Add("occluder", HalfPlane(edge, height, 0.5, 0.5));
  floor_.LookDown(-r, r, -r, r);
  const renderer::Scene& scene = floor_.scene;
  const auto exact = [&](double C8Answer::*field) {
    return Average(
        [&](double x, double y) { return C8HalfPlane(0.6, 0.5, 2.0, edge, height, x, y).*field; },
        -r,
        r,
        -r,
        r);
  };
  ExpectValue({exact(&C8Answer::value)});
  ExpectOnly(
      kDirect,
      ExpectDerivative(
          "dE/ds", EdgeMotion(scene, occluder, edge, {1, 0, 0}), {exact(&C8Answer::d_edge_x)}));
  ExpectDerivative("dE/ds_whole",
                   Motion(scene).Add(ParameterKind::kObjectTranslation, occluder, Vec3{1, 0, 0}),
                   {exact(&C8Answer::d_edge_x)});
  const double size = std::abs(exact(&C8Answer::d_edge_x));
  ExpectDerivative("dE/dz_o",
                   Motion(scene).Vertices(occluder,
                                          [](const Vec3&) {
                                            return Vec3{0, 0, 1};
                                          }),
                   {exact(&C8Answer::d_edge_height), 0.2 * size});
  Motion emitter(scene);
  ExpectDerivative(
      "dE/dt_x", Move(emitter, light, {1, 0, 0}), {exact(&C8Answer::d_emitter_x), size});
  // The receiver is what the sensor sees: both move, or all else the other way.
  const Known receiver{exact(&C8Answer::d_receiver_x)};
  Motion together(scene);
  ExpectDerivative(
      "dE/dx",
      Move(together, 0, {1, 0, 0}).Add(ParameterKind::kCameraPosition, 0, Vec3{1, 0, 0}),
      receiver);
  Motion rest(scene);
  ExpectDerivative(
      "dE/dx_rest", Move(Move(rest, light, {-1, 0, 0}), occluder, {-1, 0, 0}), receiver);
}

TEST_F(ShadowReceiver, C11bFootprintBelowATip) {
  const double edge = 0.05, height = 0.8;
  floor_.AddLight(Ceiling(-0.6, 0.6, -0.5, 0.5, 2.0));
  const int occluder = floor_.Add("occluder", HalfPlane(edge, height, 0.5, 0.5));
  // A pinhole below the occluder: the same box of the floor as the parallel camera's.
  const double eye = 0.5, size = 0.2;
  floor_.scene.sensors = {CameraAt({0.1, 0.05, eye}, {0.1, 0.05, 0.0}, eye / size, 1, 1)};
  const C11bAnswer c11b = C11bFootprint(0.6, 0.5, 2.0, edge, height, 0.0, 0.2, -0.05, 0.15);
  ExpectValue({c11b.value});
  ExpectOnly(kDirect,
             ExpectDerivative(
                 "dE/ds", EdgeMotion(floor_.scene, occluder, edge, {1, 0, 0}), {c11b.d_edge_x}));
}

TEST_F(ShadowReceiver, C11StripUnderThreeFilters) {
  const double end = 0.4, height = 2.0, edge = 0.1, edge_height = 0.7;
  // Of the strip only what some receiver of [0, 0.2] sees is there, and its length is cut: C8 of a
  // rectangle around x = 0.1 is the exact answer for that.
  const double start = -0.2, half_length = 8.0, middle = 0.5 * (start + end);
  floor_.AddLight(Ceiling(start, end, -half_length, half_length, height));
  const int occluder = floor_.Add("occluder", HalfPlane(edge, edge_height, 0.25, 4.0));
  using Kind = Filter1D::Kind;
  using Shape = renderer::PixelFilter::Shape;
  const struct {
    std::string name;
    Filter1D filter;
    renderer::PixelFilter pixel;
  } filters[] = {{"box", {Kind::kBox, 0.1, 0.0}, {Shape::kBox, 0.5, 0.5}},
                 {"tent", {Kind::kTent, 0.1, 0.0}, {Shape::kTent, 0.5, 0.5}},
                 {"gauss", {Kind::kGauss, 0.1, 0.04}, {Shape::kGaussian, 0.5, 0.2}}};
  for (const auto& f : filters) {
    floor_.LookDown(0.0, 0.2, -1.0, 1.0);
    floor_.scene.sensors[0].filter = f.pixel;
    const C11Answer c11 = C11StripFiltered(end, height, edge, edge_height, f.filter, 0.1);
    const auto cut = [&](double C8Answer::*field) {
      const auto at = [&](double u, double v) {  // v: tenths of the piece's y
        return f.filter.Value(u) * f.filter.Value(v) *
               (C8HalfPlane(0.5 * (end - start),
                            half_length,
                            height,
                            edge - middle,
                            edge_height,
                            0.1 + u - middle,
                            10.0 * v).*
                field);
      };
      return Integrate2D(at, -0.1, 0.0, -0.1, 0.0) + Integrate2D(at, 0.0, 0.1, -0.1, 0.0) +
             Integrate2D(at, -0.1, 0.0, 0.0, 0.1) + Integrate2D(at, 0.0, 0.1, 0.0, 0.1);
    };
    const double by_edge = cut(&C8Answer::d_edge_x);
    EXPECT_NEAR(cut(&C8Answer::value), c11.value, 0.02 * c11.value);
    EXPECT_NEAR(by_edge, c11.d_edge_x, 0.01 * std::abs(c11.d_edge_x));
    ExpectValue({cut(&C8Answer::value)});
    const renderer::Scene& scene = floor_.scene;
    ExpectDerivative("dE/ds_" + f.name, EdgeMotion(scene, occluder, edge, {1, 0, 0}), {by_edge});
    ExpectDerivative("dE/dz_o_" + f.name,
                     EdgeMotion(scene, occluder, edge, {0, 0, 1}),
                     {cut(&C8Answer::d_edge_height), 0.2 * std::abs(by_edge)});
  }
}

/// A black ball over the floor: what it takes from the light is what it would shine itself.
struct Ball {
  Vec3 centre;
  double radius;
  Mesh mesh;

  Ball(const Vec3& c, double r) : centre(c), radius(r), mesh(renderer::MakeIcosphere(2, r)) {
    for (Vec3& p : mesh.positions) p += c;
  }
  [[nodiscard]] Vec3 Grow(const Vec3& p) const { return (p - centre) / radius; }
  /// Derivative of what it takes from [-r, r]^2 of the floor.
  template <class Velocity>
  [[nodiscard]] double Taken(double r, Velocity velocity) const {
    return RiddersDerivative(
        [&](double h) {
          Mesh moved = mesh;
          for (Vec3& p : moved.positions) p += velocity(p) * h;
          return Average(
              [&](double x, double y) {
                return BodyIrradiance(moved, {x, y, 0.0});
              },
              -r,
              r,
              -r,
              r);
        },
        0.0,
        1e-2);
  }
};

TEST_F(ShadowReceiver, C10BallBeforeARectangle) {
  const Ball ball({0.05, -0.04, 0.9}, 0.15);
  const double half = 0.8, height = 2.0, r = 0.12;
  const int light = floor_.AddLight(Ceiling(-half, half, -half, half, height));
  const int mesh = floor_.Add("ball", ball.mesh);
  floor_.LookDown(-r, r, -r, r);
  const auto grow = [&](const Vec3& p) { return ball.Grow(p); };
  const auto along = [](const Vec3& v) { return [v](const Vec3&) { return v; }; };
  const SphereAnswer c10 = C10SphereOccluder(half, height, ball.radius, ball.centre);
  const double by_radius = -ball.Taken(r, grow);
  // Seen from the origin: the mesh is inscribed, its outline is smaller.
  EXPECT_NEAR(-ball.Taken(1e-3, grow), c10.d_radius, 0.03 * std::abs(c10.d_radius));
  ExpectValue({Average(
      [&](double x, double y) {
        return C3Rectangle(-half - x, half - x, -half - y, half - y, height).value -
               BodyIrradiance(ball.mesh, {x, y, 0});
      },
      -r,
      r,
      -r,
      r)});
  const renderer::Scene& scene = floor_.scene;
  ExpectOnly(kDirect, ExpectDerivative("dE/dR", Motion(scene).Vertices(mesh, grow), {by_radius}));
  // Sideways motion of the shadow within the light cancels from side to side.
  const double scale = std::abs(by_radius);
  for (const auto& [name, v] : {std::pair{"dE/dc_x", Vec3{1, 0, 0}},
                                {"dE/dc_y", Vec3{0, 1, 0}},
                                {"dE/dc_z", Vec3{0, 0, 1}}}) {
    ExpectDerivative(name,
                     Motion(scene).Add(ParameterKind::kObjectTranslation, mesh, v),
                     {-ball.Taken(r, along(v)), scale});
  }
  // The light moves, the shadow in it stays: as if nothing were before it.
  const double sideways = Average(
      [&](double x, double y) {
        return C3Rectangle(-half - x, half - x, -half - y, half - y, height).d_height;
      },
      -r,
      r,
      -r,
      r);
  Motion lift(scene);
  ExpectDerivative("dE/dh", Move(lift, light, {0, 0, 1}), {sideways});
}

TEST_F(ShadowReceiver, C23BallUnderAConstantSky) {
  const Ball ball({0.2, -0.1, 0.8}, 0.3);
  const double r = 0.3;
  const int mesh = floor_.Add("ball", ball.mesh);
  floor_.scene.emitters = {ConstantEnvironment({1.0, 1.0, 1.0})};
  floor_.LookDown(-r, r, -r, r);
  const auto grow = [&](const Vec3& p) { return ball.Grow(p); };
  const auto along = [](const Vec3& v) { return [v](const Vec3&) { return v; }; };
  const SphereAnswer c23 = C23SphereUnderSky(ball.radius, ball.centre);
  const double value = std::numbers::pi - Average(
                                              [&](double x, double y) {
                                                return BodyIrradiance(ball.mesh, {x, y, 0});
                                              },
                                              -r,
                                              r,
                                              -r,
                                              r);
  EXPECT_NEAR(-ball.Taken(1e-3, grow), c23.d_radius, 0.03 * std::abs(c23.d_radius));
  ExpectValue({value});
  const renderer::Scene& scene = floor_.scene;
  ExpectOnly(kDirect,
             ExpectDerivative("dE/dR", Motion(scene).Vertices(mesh, grow), {-ball.Taken(r, grow)}));
  for (const auto& [name, v] : {std::pair{"dE/dc_x", Vec3{1, 0, 0}},
                                {"dE/dc_y", Vec3{0, 1, 0}},
                                {"dE/dc_z", Vec3{0, 0, 1}}}) {
    ExpectDerivative(name,
                     Motion(scene).Add(ParameterKind::kObjectTranslation, mesh, v),
                     {-ball.Taken(r, along(v)), std::abs(c23.d_radius)});
  }
  // A constant sky looks the same however it is turned.
  ExpectDerivative("dE/dturn",
                   Motion(scene).Add(ParameterKind::kLightRotation, 0, Vec3{0.3, 0.5, 0.2}),
                   {0.0, std::abs(c23.d_radius)});
}

/// The wall shines on the floor past a fence.
class WallBehindAFence : public ShadowReceiver {
 protected:
  WallBehindAFence() {
    const C19Scene& s = s_;
    floor_ = FloorScene(3.0);
    floor_.AddLight(Ceiling(s.x0, s.x1, -s.half_y, s.half_y, s.height));
    floor_.scene.materials.push_back(
        {"wall", renderer::LambertBsdf{}, renderer::Rgb::Constant(s.albedo)});
    floor_.scene.materials.back().two_sided = false;
    Mesh wall;  // x = distance, facing -x
    wall.positions = {{s.distance, -s.wall_half_y, 0},
                      {s.distance, -s.wall_half_y, s.wall_top},
                      {s.distance, s.wall_half_y, s.wall_top},
                      {s.distance, s.wall_half_y, 0}};
    wall.triangles = {{0, 1, 2}, {0, 2, 3}};
    floor_.Add("wall", wall, 2);
    Mesh fence;  // x = occluder_x, from below the floor to edge_z
    fence.positions = {{s.occluder_x, -0.5, -0.05},
                       {s.occluder_x, -0.5, s.edge_z},
                       {s.occluder_x, 0.5, s.edge_z},
                       {s.occluder_x, 0.5, -0.05}};
    fence.triangles = {{0, 1, 2}, {0, 2, 3}};
    occluder_ = floor_.Add("fence", fence);
    options_.max_bounces = 2;
  }
  /// What the sensor sees of light that was reflected once before: equal numbers make equal direct
  /// light, which cancels exactly.
  [[nodiscard]] std::vector<double> Indirect() const {
    const renderer::Renderer renderer(floor_.scene);
    renderer::RenderOptions options = options_;
    options.spp = 32768;
    std::vector<double> out =
        Channel(PrimalReplicates(renderer, Sensor(), options, kReplicates), 0);
    options.max_bounces = 1;
    const std::vector<double> direct =
        Channel(PrimalReplicates(renderer, Sensor(), options, kReplicates), 0);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] -= direct[i];
    return Irradiance(out);
  }

  const C19Scene s_;
  int occluder_ = 0;
};

TEST_F(WallBehindAFence, C19IndirectLightOfAPoint) {
  floor_.LookAtOrigin();
  const C19Answer c19 = C19Indirect(s_);
  ExpectKnown("E_indirect", Indirect(), {c19.value});
  options_.max_bounces = 1;
  ExpectValue({c19.direct});
}

TEST_F(WallBehindAFence, C19IndirectLightPastAnEdge) {
  const double r = 0.15;
  floor_.LookDown(-r, r, -r, r);
  const auto exact = [&](auto value) {
    return Average(
        [&](double x, double y) {
          C19Scene seen = s_;
          for (double* place : {&seen.x0, &seen.x1, &seen.distance, &seen.occluder_x}) *place -= x;
          seen.receiver_y = y;
          return value(C19Indirect(seen));
        },
        -r,
        r,
        -r,
        r);
  };
  const double by_edge = exact([](const C19Answer& a) { return a.d_edge_z; });
  ExpectValue({exact([](const C19Answer& a) { return a.value + a.direct; })});
  ExpectKnown("E_indirect", Indirect(), {exact([](const C19Answer& a) { return a.value; })});
  ExpectOnly(kIndirect,
             ExpectDerivative("dE/ds",
                              Motion(floor_.scene)
                                  .Vertices(occluder_,
                                            [&](const Vec3& p) {
                                              return Vec3{0, 0, p.z == s_.edge_z ? 1. : 0.};
                                            }),
                              {by_edge}));
}

INSTANTIATE_TEST_SUITE_P(PathSpace63,
                         MovingShadowReceiver,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

}  // namespace
}  // namespace pathfit::tests::shadow_receiver_test
