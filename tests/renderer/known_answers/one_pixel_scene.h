#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "renderer/scene/scene.h"
#include "tests/support/closed_forms.h"

// The scene of path_space 6.5: a diffuse floor, a rectangular light, a diffuse triangle that
// shadows the floor, one pixel; and its measurement without random numbers.
namespace pathfit::tests {

using renderer::Vec2;

struct OnePixelScene {
  enum Object { kFloor, kLight, kOccluder };
  static constexpr double kLightRadiance = 5.0;
  static constexpr double kFloorAlbedo = 0.8;
  static constexpr double kOccluderAlbedo = 0.6;
  static constexpr double kFocal = 300.0;  // in units of the table's pixels
  static constexpr double kHalfU = 60.0, kHalfV = 50.0;

  std::array<std::vector<Vec3>, 3> points{
      std::vector<Vec3>{{-6, -6, 0}, {6, -6, 0}, {6, 6, 0}, {-6, 6, 0}},
      {{-0.5, -0.4, 3}, {-0.5, 0.6, 3}, {0.7, 0.6, 3}, {0.7, -0.4, 3}},
      {{-0.35, -0.3, 1.1}, {0.45, -0.25, 1.3}, {0.1, 0.5, 1}}};
  Vec3 eye{1.6, -1.4, 3.4};
  bool tent = false;  ///< else box; both fill the pixel

  [[nodiscard]] Vec3 Centroid(Object object) const {
    Vec3 sum;
    for (const Vec3& p : points[object]) sum += p;
    return sum / static_cast<double>(points[object].size());
  }

  /// For the renderer: one pixel of size 1, sensor 0; each object's pose turns and grows it about
  /// `pivots`.
  [[nodiscard]] renderer::Scene ToScene(const std::array<Vec3, 3>& pivots = {}) const {
    renderer::Scene scene;
    const std::array<double, 3> albedos{kFloorAlbedo, 0.0, kOccluderAlbedo};
    const std::array<const char*, 3> names{"floor", "light", "occluder"};
    for (std::size_t i = 0; i < 3; ++i) {
      renderer::Mesh mesh;
      mesh.positions = points[i];
      mesh.triangles = {{0, 1, 2}};
      if (points[i].size() == 4) mesh.triangles.push_back({0, 2, 3});
      renderer::ObjectPose pose;
      pose.pivot = pivots[i];
      scene.meshes.push_back({names[i], mesh, static_cast<int>(i), pose});
      renderer::Material material;
      material.name = names[i];
      material.base_color = renderer::Rgb::Constant(albedos[i]);
      material.two_sided = false;
      scene.materials.push_back(material);
    }
    renderer::AreaEmitter light;
    light.mesh = kLight;
    light.intensity = renderer::Rgb::Constant(kLightRadiance);
    scene.emitters = {{"light", renderer::LightFrame::kWorld, {}, light}};
    renderer::Camera camera;
    camera.name = "camera";
    camera.width = camera.height = 1;
    camera.fx = 0.5 * kFocal / kHalfU;
    camera.fy = 0.5 * kFocal / kHalfV;
    camera.cx = camera.cy = 0.5;
    camera.world_from_camera = renderer::LookAt(eye, {0.1, 0.1, 0.6}, {0, 0, 1});
    if (tent) camera.filter = {renderer::PixelFilter::Shape::kTent, 0.5, 0.5};
    scene.sensors = {camera};
    return scene;
  }

  /// The pixel's value: by rows of Gauss points, each row split where it meets an outline. The
  /// camera keeps the orientation of 6.5, only its place is `eye`.
  [[nodiscard]] double Measure() const {
    const Vec3 forward = renderer::Normalized(Vec3{0.1, 0.1, 0.6} - Vec3{1.6, -1.4, 3.4});
    const Vec3 right = renderer::Normalized(Cross(forward, {0, 0, 1}));
    const std::array<Vec3, 3> frame{right, Cross(forward, right), forward};  // v runs down
    const auto& corners = points[kOccluder];
    std::array<Vec2, 3> outline;
    std::vector<double> rows{-kHalfV, 0.0, kHalfV};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 y = corners[i] - eye;
      const double scale = kFocal / Dot(y, frame[2]);
      outline[i] = {Dot(y, frame[0]) * scale, Dot(y, frame[1]) * scale};
      rows.push_back(std::clamp(outline[i].y, -kHalfV, kHalfV));
    }
    const Filter1D shape_u{tent ? Filter1D::Kind::kTent : Filter1D::Kind::kBox, kHalfU};
    const Filter1D shape_v{tent ? Filter1D::Kind::kTent : Filter1D::Kind::kBox, kHalfV};
    const auto row = [&](double v) {
      std::vector<double> cuts{-kHalfU, 0.0, kHalfU};
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec2& a = outline[i];
        const Vec2& b = outline[(i + 1) % 3];
        if ((a.y < v) != (b.y < v)) {
          cuts.push_back(std::clamp(a.x + (b.x - a.x) * (v - a.y) / (b.y - a.y), -kHalfU, kHalfU));
        }
      }
      const auto at = [&](double u) {
        const Vec3 w = frame[0] * (u / kFocal) + frame[1] * (v / kFocal) + frame[2];
        return shape_u.Value(u) * Radiance(w);
      };
      return shape_v.Value(v) * Piecewise(at, cuts);
    };
    return Piecewise(row, rows);
  }

 private:
  template <class F>
  static double Piecewise(const F& f, std::vector<double> cuts) {
    std::sort(cuts.begin(), cuts.end());
    double sum = 0.0;
    for (std::size_t i = 1; i < cuts.size(); ++i) {
      const int panels = 1 + static_cast<int>((cuts[i] - cuts[i - 1]) / 8.0);
      sum += Integrate(f, cuts[i - 1], cuts[i], panels);
    }
    return sum;
  }
  static Vec3 NormalOf(const std::vector<Vec3>& p) {
    return renderer::Normalized(Cross(p[1] - p[0], p[2] - p[0]));
  }
  static Vec3 OntoPlane(const std::vector<Vec3>& p, const Vec3& origin, const Vec3& w) {
    const Vec3 n = NormalOf(p);
    return origin + w * (Dot(n, p[0] - origin) / Dot(n, w));
  }

  [[nodiscard]] double Radiance(const Vec3& w) const {
    const auto& occluder = points[kOccluder];
    const Vec3 near = OntoPlane(occluder, eye, w);
    bool inside = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = occluder[i];
      inside = inside && Dot(Cross(occluder[(i + 1) % 3] - a, near - a), NormalOf(occluder)) > 0.0;
    }
    const double scale = kLightRadiance * std::numbers::inv_pi;
    if (inside) {
      return scale * kOccluderAlbedo * Lambert(near, NormalOf(occluder), points[kLight]);
    }
    const Vec3 x = OntoPlane(points[kFloor], eye, w);
    const Vec3 n = NormalOf(points[kFloor]);
    return scale * kFloorAlbedo * (Lambert(x, n, points[kLight]) - Lambert(x, n, Shadow(x)));
  }
  /// Irradiance of a polygon of radiance 1.
  static double Lambert(const Vec3& x, const Vec3& n, const std::vector<Vec3>& polygon) {
    double sum = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 a = polygon[i] - x;
      const Vec3 b = polygon[(i + 1) % polygon.size()] - x;
      const Vec3 across = Cross(a, b);
      const double sine = Norm(across);
      if (sine > 0.0) sum += std::atan2(sine, Dot(a, b)) * Dot(across, n) / sine;
    }
    return 0.5 * std::abs(sum);
  }
  /// The part of the light behind the occluder, seen from x.
  [[nodiscard]] std::vector<Vec3> Shadow(const Vec3& x) const {
    std::vector<Vec3> polygon = points[kLight];
    const auto& occluder = points[kOccluder];
    for (std::size_t i = 0; i < 3; ++i) {
      Vec3 inward = Cross(occluder[i] - x, occluder[(i + 1) % 3] - x);
      if (Dot(inward, occluder[(i + 2) % 3] - x) < 0.0) inward = -inward;
      std::vector<Vec3> kept;
      for (std::size_t j = 0; j < polygon.size(); ++j) {
        const Vec3& a = polygon[j];
        const Vec3& b = polygon[(j + 1) % polygon.size()];
        const double side_a = Dot(inward, a - x);
        const double side_b = Dot(inward, b - x);
        if (side_a > 0.0) kept.push_back(a);
        if ((side_a > 0.0) != (side_b > 0.0)) {
          kept.push_back(a + (b - a) * (side_a / (side_a - side_b)));
        }
      }
      polygon = kept;
    }
    return polygon;
  }
};

}  // namespace pathfit::tests
