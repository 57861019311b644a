#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/renderer/known_answers/known_answer.h"
#include "tests/support/finite_difference.h"

// Path_space 6.3, C1-C7, C25, C26, C33: the irradiance of a point of a white floor under lights
// that nothing hides: interior terms only.
namespace pathfit::tests::point_receiver_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;

constexpr int kReplicates = 20;

renderer::RenderOptions Options() {
  renderer::RenderOptions options;
  options.max_bounces = 1;
  options.spp = 4096;
  options.sppe = options.spp_direct = 64.0;  // nothing to find
  return options;
}

/// A light over the floor, seen at the origin.
class PointReceiver : public ::testing::Test {
 protected:
  void Light(const Mesh& mesh, int texture = -1) {
    light_ = floor_.AddLight(mesh, 1.0, texture);
    floor_.LookAtOrigin();
  }
  [[nodiscard]] const renderer::Camera& Sensor() const { return floor_.scene.sensors[0]; }

  void ExpectValue(const Known& known) const {
    const renderer::Renderer renderer(floor_.scene);
    ExpectKnown(
        "E",
        Irradiance(Channel(PrimalReplicates(renderer, Sensor(), Options(), kReplicates), 0)),
        known);
  }
  void ExpectDerivative(const std::string& name, const Motion& motion, const Known& known) const {
    const renderer::Renderer renderer(floor_.scene);
    const TermReplicates found =
        DerivativeByTerm(renderer, Sensor(), motion, Options(), kReplicates);
    ExpectKnown(name, Irradiance(found.Total()), known);
  }
  /// By the vertices of the light.
  template <class Velocity>
  void ExpectMotion(const std::string& name, Velocity velocity, const Known& known) const {
    ExpectDerivative(name, Motion(floor_.scene).Vertices(light_, velocity), known);
  }

  FloorScene floor_;
  int light_ = 0;
};

/// Regular polygon facing down.
Mesh Disk(int sides, double radius, const Vec3& centre) {
  Mesh mesh = renderer::MakeDisk(sides);
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  renderer::ApplyTransform({{{radius, 0, 0}, {0, -radius, 0}, {0, 0, -1}}, centre}, mesh);
  return mesh;
}

constexpr auto kAlongX = [](const Vec3&) { return Vec3{1, 0, 0}; };
constexpr auto kAlongY = [](const Vec3&) { return Vec3{0, 1, 0}; };
constexpr auto kAlongZ = [](const Vec3&) { return Vec3{0, 0, 1}; };

TEST_F(PointReceiver, C1CoaxialDisk) {
  const C1Answer c1 = C1CoaxialDisk(0.5, 2.0);
  Light(Disk(256, 0.5, {0, 0, 2}));
  constexpr double kMesh = 2e-4;  // 1 - (2 pi / 256)^2 / 6 of the area
  ExpectValue({c1.value, 0.0, kMesh});
  ExpectMotion("dE/dR",
               [](const Vec3& p) {
                 return Vec3{2 * p.x, 2 * p.y, 0};
               },
               {c1.d_radius, 0.0, kMesh});
  ExpectMotion("dE/dh", kAlongZ, {c1.d_height, 0.0, kMesh});
}

TEST_F(PointReceiver, C2OffsetDisk) {
  const C2Answer c2 = C2OffsetDisk(0.5, 2.0, 0.7);
  Light(Disk(256, 0.5, {0.7, 0, 2}));
  constexpr double kMesh = 2e-4;
  ExpectValue({c2.value, 0.0, kMesh});
  ExpectMotion("dE/da", kAlongX, {c2.d_offset, 0.0, kMesh});
  ExpectMotion("dE/dh", kAlongZ, {c2.d_height, 0.0, kMesh});
  ExpectMotion("dE/dR",
               [](const Vec3& p) {
                 return Vec3{2 * (p.x - 0.7), 2 * p.y, 0};
               },
               {c2.d_radius, 0.0, kMesh});
}

TEST_F(PointReceiver, C33RegularPolygonsAreExact) {
  for (const int sides : {8, 32, 128}) {
    SCOPED_TRACE(sides);
    floor_ = FloorScene();
    const C33Answer c33 = C33RegularPolygon(sides, 0.5, 2.0);
    Light(Disk(sides, 0.5, {0, 0, 2}));
    ExpectValue({c33.value});
    ExpectMotion("dE/dR_" + std::to_string(sides),
                 [](const Vec3& p) {
                   return Vec3{2 * p.x, 2 * p.y, 0};
                 },
                 {c33.d_radius});
  }
}

TEST_F(PointReceiver, C3Rectangle) {
  const C3Answer c3 = C3Rectangle(-0.3, 0.7, -0.4, 0.6, 1.5);
  Light(Ceiling(-0.3, 0.7, -0.4, 0.6, 1.5));
  ExpectValue({c3.value});
  ExpectMotion("dE/dt_x", kAlongX, {c3.d_x});
  ExpectMotion("dE/dt_y", kAlongY, {c3.d_y});
  ExpectMotion("dE/dh", kAlongZ, {c3.d_height});
  ExpectMotion("dE/dscale", [](const Vec3& p) { return p - Vec3{0.2, 0.1, 1.5}; }, {c3.d_scale});
}

TEST_F(PointReceiver, C3ByObjectPose) {
  const C3Answer c3 = C3Rectangle(-0.3, 0.7, -0.4, 0.6, 1.5);
  Light(Ceiling(-0.3, 0.7, -0.4, 0.6, 1.5));
  renderer::Scene& scene = floor_.scene;
  scene.meshes[1].pose.pivot = {0.2, 0.1, 1.5};
  const auto translated = [&](const Vec3& v) {
    return Motion(scene).Add(ParameterKind::kObjectTranslation, light_, v);
  };
  ExpectDerivative("dE/dt_x", translated({1, 0, 0}), {c3.d_x});
  ExpectDerivative("dE/dt_y", translated({0, 1, 0}), {c3.d_y});
  ExpectDerivative("dE/dh", translated({0, 0, 1}), {c3.d_height});
  ExpectDerivative("dE/dscale",
                   Motion(scene).Add(ParameterKind::kObjectScale, light_, std::vector{1.0}),
                   {c3.d_scale});
}

TEST_F(PointReceiver, C3ReceiverMotionIsTheOpposite) {
  const C3Answer c3 = C3Rectangle(-0.3, 0.7, -0.4, 0.6, 1.5);
  Light(Ceiling(-0.3, 0.7, -0.4, 0.6, 1.5));
  const auto receiver = [&](const Vec3& v) {
    return Motion(floor_.scene)
        .Vertices(0, [v](const Vec3&) { return v; })
        .Add(ParameterKind::kCameraPosition, 0, v);
  };
  ExpectDerivative("dE/dx", receiver({1, 0, 0}), {-c3.d_x});
  ExpectDerivative("dE/dz", receiver({0, 0, 1}), {-c3.d_height});
}

TEST_F(PointReceiver, C4RotatedRectangle) {
  const Vec3 centre{0.2, 0.1, 1.5};
  const double theta = 0.3;
  const C4Answer c4 = C4RotatedRectangle(1.0, 0.6, centre, theta);
  Mesh mesh = Ceiling(-0.5, 0.5, -0.3, 0.3, 0.0);
  renderer::ApplyTransform({renderer::RotationFromVector({0, theta, 0}), centre}, mesh);
  Light(mesh);
  floor_.scene.meshes[1].pose.pivot = centre;
  const double scale = std::abs(c4.d_z);
  constexpr double kPixel = 1e-6;  // what the pixel is larger than a point
  ExpectValue({c4.value});
  ExpectMotion("dE/dtheta",
               [&](const Vec3& p) {
                 return Cross({0, 1, 0}, p - centre);
               },
               {c4.d_theta});
  ExpectDerivative("dE/dtheta_pose",
                   Motion(floor_.scene).Add(ParameterKind::kObjectRotation, light_, Vec3{0, 1, 0}),
                   {c4.d_theta});
  ExpectMotion("dE/dx", kAlongX, {c4.d_x});
  ExpectMotion("dE/dy", kAlongY, {c4.d_y});
  ExpectMotion("dE/dz", kAlongZ, {c4.d_z});
  ExpectMotion("dE/dturn", [](const Vec3& p) { return Cross({0, 0, 1}, p); }, {0.0, scale, kPixel});
  ExpectMotion("dE/dscale", [&](const Vec3& p) { return p - centre; }, {c4.d_scale});
  ExpectMotion("dE/dscale_receiver", [](const Vec3& p) { return p; }, {0.0, scale, kPixel});
}

TEST_F(PointReceiver, C6Wall) {
  const C6Answer c6 = C6Wall(0.8, -0.5, 0.9, 1.1);
  Mesh mesh;  // x = 0.8, facing -x, standing on the floor
  mesh.positions = {{0.8, -0.5, 0}, {0.8, -0.5, 1.1}, {0.8, 0.9, 1.1}, {0.8, 0.9, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  Light(mesh);
  ExpectValue({c6.value});
  ExpectMotion("dE/dd", kAlongX, {c6.d_distance});
  ExpectMotion("dE/dH", [](const Vec3& p) { return Vec3{0, 0, p.z / 1.1}; }, {c6.d_height});
}

TEST_F(PointReceiver, C7SphereAsAMesh) {
  const Vec3 centre{0.4, -0.3, 1.5};
  const double radius = 0.3;
  Mesh mesh = renderer::MakeIcosphere(3, radius);
  for (Vec3& p : mesh.positions) p += centre;
  const SphereAnswer sphere = C7Sphere(radius, centre);
  const auto derivative = [&](auto velocity) {
    return RiddersDerivative(
        [&](double h) {
          Mesh moved = mesh;
          for (Vec3& p : moved.positions) p += velocity(p) * h;
          return BodyIrradiance(moved, {});
        },
        0.0,
        1e-2);
  };
  const auto grow = [&](const Vec3& p) { return (p - centre) / radius; };
  constexpr double kMesh = 0.01;  // the mesh is inscribed: its outline is smaller
  const double value = BodyIrradiance(mesh, {});
  EXPECT_NEAR(value, sphere.value, kMesh * sphere.value);
  EXPECT_NEAR(derivative(grow), sphere.d_radius, kMesh * sphere.d_radius);
  EXPECT_NEAR(derivative(kAlongZ), sphere.d_centre.z, kMesh * std::abs(sphere.d_centre.z));
  Light(mesh);
  ExpectValue({value});
  ExpectMotion("dE/dR", grow, {derivative(grow)});
  ExpectMotion("dE/dc_x", kAlongX, {derivative(kAlongX)});
  ExpectMotion("dE/dc_y", kAlongY, {derivative(kAlongY)});
  ExpectMotion("dE/dc_z", kAlongZ, {derivative(kAlongZ)});
}

TEST_F(PointReceiver, C26EmitterCarriesItsTexture) {
  const double half_x = 0.5, half_y = 0.4, height = 1.2, s = 0.1;
  const C26Answer c26 = C26TexturedEmitter(half_x, half_y, height, s);
  // Two texels: the lookup runs linearly between their centres, which are the light's sides.
  renderer::Texture ramp;
  ramp.name = "ramp";
  ramp.width = 2;
  ramp.wrap = renderer::TextureWrap::kClamp;
  ramp.texels = {renderer::Rgb::Constant(1.0 - 0.5 * half_x),
                 renderer::Rgb::Constant(1.0 + 0.5 * half_x)};
  floor_.scene.textures = {ramp};
  Mesh mesh = Ceiling(s - half_x, s + half_x, -half_y, half_y, height);
  mesh.uvs = {{0.25, 0}, {0.25, 1}, {0.75, 1}, {0.75, 0}};
  mesh.uv_triangles = mesh.triangles;
  Light(mesh, 0);
  ExpectValue({c26.value});
  ExpectMotion("dE/ds", kAlongX, {c26.d_s});
}

TEST_F(PointReceiver, C25LightAtTheCamera) {
  const double intensity = 3.0, albedo = 0.6, r = 2.0, theta = 0.5;
  const C25Answer c25 = C25CollocatedLight(intensity, albedo, r, theta);
  const Vec3 eye{r * std::sin(theta), 0.0, r * std::cos(theta)};
  const Vec3 w = -eye / r;
  renderer::Scene& scene = floor_.scene;
  scene.materials[0].base_color = renderer::Rgb::Constant(albedo);
  scene.emitters = {{"flash",
                     renderer::LightFrame::kCamera,
                     {},
                     renderer::PointEmitter{{0, 0, 0}, renderer::Rgb::Constant(intensity)}}};
  scene.sensors = {ProbeCamera(eye, {0, 0, 0})};
  const renderer::Renderer renderer(scene);
  const auto derivative = [&](const Vec3& v) {  // the camera keeps looking at the origin
    Motion motion(scene);
    motion.Add(ParameterKind::kCameraPosition, 0, v)
        .Add(ParameterKind::kCameraRotation, 0, Cross(w, -v) / r);
    renderer::RenderOptions options = Options();
    options.spp = 1;
    return DerivativeByTerm(renderer, Sensor(), motion, options, 2).Total();
  };
  renderer::RenderOptions options = Options();
  options.spp = 1;
  constexpr double kPixel = 1e-7;  // the pixel is no point
  ExpectKnown(
      "L", Channel(PrimalReplicates(renderer, Sensor(), options, 2), 0), {c25.value, 0.0, kPixel});
  ExpectKnown("dL/dr", derivative(-w), {c25.d_r, 0.0, kPixel});
  ExpectKnown("dL/dtheta", derivative(Cross({0, 1, 0}, eye)), {c25.d_theta, 0.0, kPixel});
  ExpectKnown("dL/dh", derivative({0, 0, 1}), {c25.d_h, 0.0, kPixel});
}

}  // namespace
}  // namespace pathfit::tests::point_receiver_test
