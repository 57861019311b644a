#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "tests/support/closed_forms.h"
#include "tests/support/probe.h"
#include "tests/support/statistics.h"

// What the tests of this folder share: the check of one figure, and scenes with a white floor whose
// irradiance is what a sensor above it sees.
namespace pathfit::tests {

/// What a figure must be. The standard error must be below 1 % of the larger of |exact| and `scale`
/// (the size of the parts, where they cancel), and the mean within four standard errors.
struct Known {
  double exact = 0.0;
  double scale = 0.0;
  double model = 1e-9;  ///< relative error of the test's own model; of what has no noise
};

/// Checks `replicates` against the answer and records both under `name`: the report of a run
/// (--gtest_output=xml) is the table of all figures.
inline void ExpectKnown(const std::string& name,
                        const std::vector<double>& replicates,
                        const Known& known) {
  const MeanAndError m = EstimateMean(replicates);
  const double size = std::max(std::abs(known.exact), known.scale);
  const double away = std::abs(m.mean - known.exact);
  std::ostringstream text;
  text.precision(9);
  text << "exact " << known.exact << " measured " << m.mean << " sigma " << m.error << " z "
       << (m.error > 0.0 ? (m.mean - known.exact) / m.error : 0.0);
  ::testing::Test::RecordProperty(name, text.str());
  EXPECT_LE(away, 4.0 * m.error + known.model * size) << name << ": " << text.str();
  EXPECT_LE(m.error, 0.01 * size) << name << ": " << text.str();
}

/// Irradiance of a white floor from the radiance that it shows.
inline std::vector<double> Irradiance(std::vector<double> radiance) {
  for (double& value : radiance) value *= std::numbers::pi;
  return radiance;
}

/// A white floor z = 0 (mesh 0, material 0), and things above it that reflect nothing (material 1).
class FloorScene {
 public:
  explicit FloorScene(double half_size = 10.0) {
    scene.materials = {{"white", renderer::LambertBsdf{}, {1.0, 1.0, 1.0}},
                       {"black", renderer::LambertBsdf{}, {0.0, 0.0, 0.0}}};
    scene.materials[0].two_sided = false;
    Add("floor", Plate(half_size, half_size, 0.0), 0);
  }
  /// Both return the index of the mesh.
  int Add(const std::string& name, const renderer::Mesh& mesh, int material = 1) {
    scene.meshes.push_back({name, mesh, material, {}});
    return static_cast<int>(scene.meshes.size()) - 1;
  }
  int AddLight(const renderer::Mesh& mesh, double radiance = 1.0, int texture = -1) {
    const int index = Add("light", mesh);
    Shine(index, radiance, texture);
    return index;
  }
  void Shine(int index, double radiance = 1.0, int texture = -1) {
    renderer::AreaEmitter light;
    light.mesh = index;
    light.intensity = renderer::Rgb::Constant(radiance);
    light.texture = texture;
    scene.emitters.push_back({"light", renderer::LightFrame::kWorld, {}, light});
  }
  /// Sensor 0: a parallel camera at `height` looking straight down at the floor; its one pixel is
  /// [x0, x1] x [y0, y1].
  void LookDown(double x0, double x1, double y0, double y1, double height = 0.02) {
    renderer::Camera camera;
    camera.name = "sensor";
    camera.projection = renderer::ProjectionKind::kOrthographic;
    camera.width = camera.height = 1;
    camera.fx = 1.0 / (x1 - x0);
    camera.fy = 1.0 / (y1 - y0);
    camera.cx = camera.cy = 0.5;
    const renderer::Vec3 centre{0.5 * (x0 + x1), 0.5 * (y0 + y1), height};
    camera.world_from_camera =
        renderer::LookAt(centre, centre - renderer::Vec3{0, 0, 1}, {0, 1, 0});
    scene.sensors = {camera};
  }
  /// Sensor 0: sees the origin only.
  void LookAtOrigin() { scene.sensors = {ProbeCamera({0.02, -0.03, 0.1}, {0, 0, 0})}; }

  renderer::Scene scene;
};

/// [x0, x1] x [y0, y1] at `height`, normal -z.
inline renderer::Mesh Ceiling(double x0, double x1, double y0, double y1, double height) {
  renderer::Mesh mesh;
  mesh.positions = {{x0, y0, height}, {x0, y1, height}, {x1, y1, height}, {x1, y0, height}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// Irradiance at x, normal +z, from a convex body of radiance 1 above the horizon: face by face.
inline double BodyIrradiance(const renderer::Mesh& mesh, const renderer::Vec3& x) {
  double sum = 0.0;
  for (const renderer::Triangle& t : mesh.triangles) {
    std::array<renderer::Vec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = mesh.positions[static_cast<std::size_t>(t[i])] - x;
    }
    if (Dot(Cross(corners[1] - corners[0], corners[2] - corners[0]), corners[0]) < 0.0) {
      sum += PolygonIrradiance(corners);
    }
  }
  return sum;
}

}  // namespace pathfit::tests
