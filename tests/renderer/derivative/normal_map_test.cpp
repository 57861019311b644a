#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/derivative/color_gradient.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/path/mapped_normal.h"
#include "tests/support/finite_difference.h"
#include "tests/support/probe.h"

// What normal maps do to derivatives, against finite differences without noise.
namespace pathfit::renderer::normal_map_test {
namespace {

using tests::Motion;
using tests::RiddersDerivative;

Camera Probe(double x, double y) {
  return tests::ProbeCamera({0.5, -0.8, 2.0}, {x, y, 0.1 * std::sin(2.0 * x + y)});
}

RenderOptions Options(DerivativeForm form = DerivativeForm::kImage) {
  RenderOptions options;
  options.max_bounces = 1;
  options.spp = 1;
  options.form = form;
  options.terms = {kDerivativeTerms[0].second};
  return options;
}

double Radiance(Scene scene, const Motion& motion, const Camera& camera, double step) {
  const Renderer start(scene);
  std::vector<double> values = motion.layout.Gather(scene);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += step * motion.direction[i];
  motion.layout.Scatter(values, scene);
  return tests::SumOfPixels(Renderer(scene).RenderPrimal(camera, Options())).r;
}

double Derivative(const Scene& scene, const Motion& motion, const Camera& camera) {
  return tests::DerivativeReplicates(
             Renderer(scene), camera, motion.layout, motion.direction, Options(), 1)[0]
      .r;
}

void ExpectRight(const Scene& scene, const Motion& motion, double step) {
  Scene mutant = scene;
  mutant.materials[0].normal_scale *= -1.0;
  double wrong = 0.0;
  for (const auto& [x, y] : {std::pair(0.13, 0.21), {-0.41, 0.37}, {0.62, -0.33}, {-0.2, -0.7}}) {
    const Camera camera = Probe(x, y);
    const double exact =
        RiddersDerivative([&](double s) { return Radiance(scene, motion, camera, s); }, 0.0, step);
    EXPECT_NEAR(Derivative(scene, motion, camera), exact, 1e-5 * (1.0 + std::abs(exact)));
    wrong = std::max(wrong, std::abs(Derivative(mutant, motion, camera) - exact));
  }
  EXPECT_GT(wrong, 1e-2);
}

TEST(NormalMap, ValueTurnsInTheFrame) {
  const Vec3 n = MappedNormal({0, 0, 2}, {3, 0, 0}, 1.0, {0.6, 0.0, 0.8}).Value();
  EXPECT_NEAR(Norm(n - Vec3{0.6, 0.0, 0.8}), 0.0, 1e-15);
  const Vec3 mirrored = MappedNormal({0, 0, 2}, {3, 0, 0}, -1.0, {0.0, 0.6, 0.8}).Value();
  EXPECT_NEAR(Norm(mirrored - Vec3{0.0, -0.6, 0.8}), 0.0, 1e-15);
}

TEST(NormalMap, PullAgreesWithFiniteDifferences) {
  const Vec3 d = {0.3, -0.8, 0.5};
  for (const double sign : {1.0, -1.0}) {
    const Vec3 m = {0.2, 0.1, 1.4}, t = {0.9, 0.3, -0.2}, texel = {0.3, -0.2, 0.8};
    const auto pulled = MappedNormal(m, t, sign, texel).Pull(d);
    for (int c = 0; c < 3; ++c) {
      const auto along = [&](double s) {
        Vec3 v;
        v[c] = s;
        return v;
      };
      const auto value = [&](const Vec3& a, const Vec3& b, const Vec3& e) {
        return Dot(d, MappedNormal(a, b, sign, e).Value());
      };
      EXPECT_NEAR(
          pulled.m[c],
          RiddersDerivative([&](double s) { return value(m + along(s), t, texel); }, 0, 0.1),
          1e-8);
      EXPECT_NEAR(
          pulled.t[c],
          RiddersDerivative([&](double s) { return value(m, t + along(s), texel); }, 0, 0.1),
          1e-8);
      EXPECT_NEAR(
          pulled.texel[c],
          RiddersDerivative([&](double s) { return value(m, t, texel + along(s)); }, 0, 0.1),
          1e-8);
    }
  }
}

TEST(NormalMap, TangentsFollowPositionsAndNormals) {
  const Mesh mesh = tests::Waves().meshes[0].mesh;
  const TangentField field(mesh);
  const Vec3 d = {0.3, -0.8, 0.5};
  for (const std::int32_t triangle : {0, 7, 10}) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::vector<Vec3> by_position(mesh.positions.size()), by_normal(mesh.normals.size());
      field.Pull(
          mesh,
          triangle,
          k,
          d,
          [&](std::int32_t i, const Vec3& g) { by_position[static_cast<std::size_t>(i)] += g; },
          [&](std::int32_t i, const Vec3& g) { by_normal[static_cast<std::size_t>(i)] += g; });
      for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
          const auto moved = [&](SharedVector<Vec3> Mesh::*list) {
            return RiddersDerivative(
                [&](double s) {
                  Mesh other = mesh;
                  (other.*list)[i][c] += s;
                  return Dot(d, TangentField(other)[triangle][k].along_u);
                },
                0.0,
                0.05);
          };
          EXPECT_NEAR(by_position[i][c], moved(&Mesh::positions), 1e-7);
          EXPECT_NEAR(by_normal[i][c], moved(&Mesh::normals), 1e-7);
        }
      }
    }
  }
}

TEST(NormalMap, DerivativeByVertices) {
  const Scene scene = tests::Waves();
  ExpectRight(scene,
              Motion(scene).Vertices(0,
                                     [](const Vec3& p) {
                                       return Vec3{0.3 * p.y + 0.1, 0.2 * p.x * p.x, 0.4 * p.x};
                                     }),
              0.02);
}

TEST(NormalMap, DerivativeByNormals) {
  const Scene scene = tests::Waves();
  std::vector<double> rate;
  for (std::size_t i = 0; i < scene.meshes[0].mesh.normals.size(); ++i) {
    const auto x = static_cast<double>(i);
    rate.insert(rate.end(), {std::sin(x), std::cos(2.0 * x), 0.3});
  }
  ExpectRight(scene, Motion(scene).Add(ParameterKind::kVertexNormals, 0, rate), 0.05);
}

TEST(NormalMap, DerivativeByPose) {
  Scene scene = tests::Waves();
  scene.meshes[0].pose = {{0.1, 0.2, 0.0}, {0.02, 0.0, 0.01}, {0.1, -0.05, 0.2}, 1.1};
  const Motion pose = Motion(scene)
                          .Add(ParameterKind::kObjectRotation, 0, Vec3{0.2, -0.3, 0.5})
                          .Add(ParameterKind::kObjectTranslation, 0, Vec3{0.1, 0.2, -0.1})
                          .Add(ParameterKind::kObjectScale, 0, std::vector<double>{0.2});
  ExpectRight(scene, pose, 0.02);
  // With vertices too the pose turns what the tangents are made of, not the tangents.
  ExpectRight(scene,
              Motion(pose).Vertices(0,
                                    [](const Vec3& p) {
                                      return Vec3{0.1 * p.y, 0.0, 0.2 * p.x};
                                    }),
              0.02);
}

TEST(NormalMap, SteepOnesAreNamedWhereThingsMove) {
  Scene scene = tests::Waves();
  const ParameterLayout layout =
      Motion(scene).Vertices(0, [](const Vec3&) { return Vec3{}; }).layout;
  const auto mentions = [&](double scale) {
    scene.materials[0].normal_scale = scale;
    const std::vector<std::string> limits = DerivativeLimits(scene, layout);
    return std::ranges::count_if(limits, [](const std::string& limit) {
      return limit.starts_with(
          "'object' has the normal texture 'bumps', which turns its normals by ");
    });
  };
  EXPECT_EQ(mentions(0.1), 0);
  EXPECT_EQ(mentions(3.0), 1);
  ParameterLayout uvs(scene);
  uvs.Add(ParameterKind::kUvs, 0);
  const std::string by_uvs =
      "'object' has the normal texture 'bumps': what that does is not in the derivative by its UVs";
  EXPECT_EQ(std::ranges::count(DerivativeLimits(scene, uvs), by_uvs), 1);
  EXPECT_EQ(std::ranges::count(DerivativeLimits(scene, layout), by_uvs), 0);
}

}  // namespace
}  // namespace pathfit::renderer::normal_map_test
