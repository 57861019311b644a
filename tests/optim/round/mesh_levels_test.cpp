#include "optim/round/mesh_levels.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "optim/round/remesh.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_folds.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/mesh_topology.h"
#include "tests/optim/round/synthetic_fit.h"

namespace pathfit::mesh_levels_test {
namespace {

using optim::MeshDetail;
using renderer::Mesh;
using renderer::Vec3;

Mesh BumpyBall(int subdivisions) {
  Mesh ball = renderer::MakeIcosphere(subdivisions, 1.0);
  for (Vec3& p : ball.positions) p = p * tests::BumpRadius(p);
  return ball;
}

struct EdgeLengths {
  double mean = 0.0, least = 1e300, most = 0.0;
};
EdgeLengths EdgesOf(const Mesh& mesh) {
  EdgeLengths lengths;
  const auto topology = renderer::MeshTopology::Build(mesh);
  for (const renderer::MeshEdge& edge : topology.edges) {
    const double length = Norm(mesh.positions[static_cast<std::size_t>(edge.vertices[0])] -
                               mesh.positions[static_cast<std::size_t>(edge.vertices[1])]);
    lengths.mean += length / static_cast<double>(topology.edges.size());
    lengths.least = std::min(lengths.least, length);
    lengths.most = std::max(lengths.most, length);
  }
  return lengths;
}

TEST(Remesh, GivesAClosedSurfaceOfTheWantedEdges) {
  for (const int subdivisions : {1, 4}) {
    const Mesh ball = BumpyBall(subdivisions);
    for (const double edge : {0.35, 0.12}) {
      const Mesh made = optim::Remesh(ball, edge);
      renderer::ValidateMesh(made, "made");
      EXPECT_TRUE(renderer::MeshTopology::Build(made).solid);
      const EdgeLengths lengths = EdgesOf(made);
      EXPECT_NEAR(lengths.mean, edge, 0.15 * edge) << subdivisions;
      EXPECT_GT(lengths.least, 0.3 * edge);
      EXPECT_LT(lengths.most, 1.8 * edge);
      EXPECT_EQ(renderer::CountFolds(made).Total(), 0);
      EXPECT_LT(optim::SurfaceDistance(ball, made), 0.3 * edge);
      EXPECT_EQ(made.positions, optim::Remesh(ball, edge).positions) << "not the same twice";
    }
  }
}

// A ring of radius 1 with a square profile.
Mesh Ring(int corners, double half_width) {
  Mesh ring;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    const double in = 1.0 - half_width, out = 1.0 + half_width;
    for (const auto& [r, z] :
         {std::pair(in, -half_width), {out, -half_width}, {out, half_width}, {in, half_width}}) {
      ring.positions.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
  }
  for (int i = 0; i < corners; ++i) {
    for (int k = 0; k < 4; ++k) {
      const int a = 4 * i + k;
      const int b = 4 * i + (k + 1) % 4;
      const int c = (a + 4) % (4 * corners);
      const int d = (b + 4) % (4 * corners);
      ring.triangles.push_back({a, c, b});
      ring.triangles.push_back({c, d, b});
    }
  }
  renderer::ValidateMesh(ring, "ring");
  return ring;
}

void ExpectARing(const Mesh& made) {
  renderer::ValidateMesh(made, "made");
  const auto topology = renderer::MeshTopology::Build(made);
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(made.positions.size() + made.triangles.size(), topology.edges.size())
      << "Euler characteristic";
}

TEST(Remesh, KeepsPiecesAndHandles) {
  for (const double edge : {0.5, 0.1}) ExpectARing(optim::Remesh(Ring(24, 0.2), edge));
}

TEST(RemeshKeepingThinParts, KeepsATubeThatIsThinnerThanAnEdge) {
  constexpr double kEdge = 0.3;
  const Mesh ring = Ring(300, 0.02);
  EXPECT_LT(SignedVolume(optim::Remesh(ring, kEdge)), 0.5 * SignedVolume(ring));
  const Mesh made = optim::RemeshKeepingThinParts(ring, kEdge);
  ExpectARing(made);
  EXPECT_EQ(renderer::CountFolds(made).Total(), 0);
  EXPECT_LT(optim::SurfaceDistance(ring, made), optim::kMostLost * kEdge);
  EXPECT_GT(SignedVolume(made), 0.3 * SignedVolume(ring)) << "a prism inside of it";
  EXPECT_LT(made.positions.size(), ring.positions.size());
  EXPECT_EQ(made.positions, optim::RemeshKeepingThinParts(ring, kEdge).positions);
  EXPECT_FALSE(optim::MendEdges(made, kEdge)) << "short edges are meant";
}

TEST(RemeshKeepingThinParts, IsRemeshOfWhatHasNone) {
  const Mesh ball = BumpyBall(4);
  EXPECT_EQ(optim::RemeshKeepingThinParts(ball, 0.2).positions, optim::Remesh(ball, 0.2).positions);
}

TEST(Remesh, CarriesColoursOver) {
  Mesh ball = renderer::MakeIcosphere(4, 1.0);
  for (const Vec3& p : std::as_const(ball.positions)) {
    ball.colors.push_back({0.5 + 0.4 * p.x, 0.5 + 0.3 * p.y, 0.2});
  }
  ball.color_triangles = ball.triangles;
  const Mesh made = optim::Remesh(ball, 0.2);
  ASSERT_EQ(made.colors.size(), made.positions.size());
  for (std::size_t v = 0; v < made.colors.size(); ++v) {
    EXPECT_NEAR(
        std::as_const(made).colors[v].r, 0.5 + 0.4 * std::as_const(made).positions[v].x, 0.01);
    EXPECT_NEAR(
        std::as_const(made).colors[v].g, 0.5 + 0.3 * std::as_const(made).positions[v].y, 0.01);
  }
}

// A spike, as steps of a fit make it.
Mesh WithSpike(Mesh mesh, std::size_t vertex) {
  Vec3& p = mesh.positions.Edit()[vertex];
  p = p * 1.8;
  return mesh;
}

TEST(MendEdges, LeavesEvenMeshesAlone) {
  EXPECT_FALSE(optim::MendEdges(optim::Remesh(BumpyBall(3), 0.2), 0.2));
}

TEST(MendEdges, MendsWhereASpikeIsAndNowhereElse) {
  const Mesh even = optim::Remesh(BumpyBall(3), 0.2);
  const Mesh spiked = WithSpike(even, 17);
  EXPECT_GT(EdgesOf(spiked).most, 0.6);
  const auto made = optim::MendEdges(spiked, 0.2);
  ASSERT_TRUE(made);
  renderer::ValidateMesh(*made, "made");
  EXPECT_TRUE(renderer::MeshTopology::Build(*made).solid);
  EXPECT_LT(EdgesOf(*made).most, 0.4);
  EXPECT_GT(made->positions.size(), spiked.positions.size());
  const std::vector<Vec3>& after = made->positions.Items();
  const Vec3 foot = even.positions.Items()[17];
  int kept = 0;
  for (const Vec3& p : even.positions.Items()) {
    if (Norm(p - foot) < 1.1) continue;  // three edges and two rings
    ++kept;
    EXPECT_NE(std::find(after.begin(), after.end(), p), after.end()) << "moved far from the spike";
  }
  EXPECT_GT(kept, 50);
}

class MeshLevelsTest : public testing::Test {
 protected:
  MeshLevelsTest() {
    vertices_[0].name = "ball.vertices";
    vertices_[0].mesh_detail = MeshDetail::kLevels;
  }
  [[nodiscard]] optim::MeshLevels At(double scale) const {
    return optim::RefineMeshes(scene_, vertices_, {0}, optim::MakeFitViews(observations_, scale));
  }
  renderer::Scene scene_ = tests::BallScene(2, 4, 128);
  optim::ObservationSet observations_ = tests::Photograph(scene_, 1);
  std::vector<optim::UnknownSpec> vertices_{1};
};

TEST_F(MeshLevelsTest, EdgesFollowThePixels) {
  for (const double scale : {0.5, 1.0}) {
    const Mesh made = At(scale).scene.meshes[0].mesh;
    // The ball's middle is 4 m away from the cameras, most of what they see a little nearer.
    const double pixel = 4.0 / (1.45 * 128 * scale);
    EXPECT_NEAR(EdgesOf(made).mean, optim::kEdgePixels * pixel, 0.3 * optim::kEdgePixels * pixel);
  }
}

TEST_F(MeshLevelsTest, ScaledObjectsHaveEdgesOfTheWorld) {
  const Mesh plain = At(0.5).scene.meshes[0].mesh;
  scene_.meshes[0].pose.scale = 2.0;
  for (Vec3& p : scene_.meshes[0].mesh.positions) p *= 0.5;
  EXPECT_NEAR(EdgesOf(At(0.5).scene.meshes[0].mesh).mean * 2.0, EdgesOf(plain).mean, 1e-3);
}

TEST_F(MeshLevelsTest, ASecondTimeNothingChanges) {
  const optim::MeshLevels once = At(0.5);
  ASSERT_EQ(once.messages.size(), 1U);
  scene_ = once.scene;
  const optim::MeshLevels twice = At(0.5);
  EXPECT_EQ(twice.messages.size(), 0U);
  EXPECT_EQ(twice.scene.meshes[0].mesh.triangles, once.scene.meshes[0].mesh.triangles);
}

TEST_F(MeshLevelsTest, FoldsGoEvenAtTheRightSize) {
  scene_ = At(0.5).scene;
  Vec3& p = scene_.meshes[0].mesh.positions.Edit()[5];
  p = p * -1.2;
  EXPECT_GT(renderer::CountFolds(scene_.meshes[0].mesh).Total(), 0);
  EXPECT_EQ(renderer::CountFolds(At(0.5).scene.meshes[0].mesh).Total(), 0);
}

TEST_F(MeshLevelsTest, MendsBetweenRoundsWhatMayHaveOtherTriangles) {
  const auto mended = [this] {
    return optim::MendMeshes(scene_, vertices_, {0}, optim::MakeFitViews(observations_, 0.5));
  };
  scene_ = At(0.5).scene;
  EXPECT_FALSE(mended()) << "is even";
  scene_.meshes[0].mesh = WithSpike(scene_.meshes[0].mesh, 5);
  const auto made = mended();
  ASSERT_TRUE(made);
  EXPECT_NE(made->meshes[0].mesh.triangles, scene_.meshes[0].mesh.triangles);
  EXPECT_EQ(renderer::CountFolds(made->meshes[0].mesh).Total(), 0);
  EXPECT_EQ(made->meshes[0].mesh.colors.size(), made->meshes[0].mesh.positions.size());
  vertices_[0].mesh_detail = MeshDetail::kKeep;
  EXPECT_FALSE(mended());
  vertices_[0].mesh_detail = MeshDetail::kLevels;
  scene_.meshes[0].mesh.triangles.Edit().pop_back();
  scene_.meshes[0].mesh.color_triangles.Edit().pop_back();
  EXPECT_FALSE(mended()) << "has a border";
}

TEST_F(MeshLevelsTest, BluntsMeshesWithManyNeedles) {
  const auto blunted = [this] {
    return optim::BluntMeshes(scene_, vertices_, {0}, optim::MakeFitViews(observations_, 0.5));
  };
  scene_ = At(0.5).scene;
  const double edge = EdgesOf(scene_.meshes[0].mesh).mean;
  const auto many = static_cast<int>(std::ceil(
      optim::kManyPerVertex * static_cast<double>(scene_.meshes[0].mesh.positions.size())));
  ASSERT_GT(many, optim::kManyNeedles);
  const auto pull = [&, ball = scene_.meshes[0].mesh](int count) {
    scene_.meshes[0].mesh = ball;
    tests::PullNeedles(scene_.meshes[0].mesh, [&count](const Vec3&) { return count-- > 0; });
  };
  for (int count = 0; count < many; ++count) {
    pull(count);
    EXPECT_FALSE(blunted()) << count << " needles";
  }
  pull(many);
  ASSERT_EQ(renderer::CountNeedles(scene_.meshes[0].mesh), many);
  const auto made = blunted();
  ASSERT_TRUE(made);
  EXPECT_LT(renderer::CountNeedles(made->meshes[0].mesh), optim::kManyNeedles);
  EXPECT_NEAR(EdgesOf(made->meshes[0].mesh).mean, edge, 0.1 * edge);
  EXPECT_EQ(made->meshes[0].mesh.colors.size(), made->meshes[0].mesh.positions.size());
  vertices_[0].mesh_detail = MeshDetail::kKeep;
  EXPECT_FALSE(blunted());
}

TEST_F(MeshLevelsTest, WhatCannotBeRemeshedStaysAndIsSaid) {
  const auto stays = [this](const std::string& why) {
    const optim::MeshLevels levels = At(1.0);
    EXPECT_EQ(levels.scene.meshes[0].mesh.triangles, scene_.meshes[0].mesh.triangles);
    ASSERT_EQ(levels.messages.size(), 1U) << why;
    EXPECT_NE(levels.messages[0].find(why), std::string::npos) << levels.messages[0];
  };
  const renderer::Scene whole = scene_;
  scene_.meshes[0].mesh.triangles.Edit().pop_back();
  scene_.meshes[0].mesh.color_triangles.Edit().pop_back();
  stays("borders");
  scene_ = whole;
  renderer::SetSphereUvs(scene_.meshes[0].mesh);
  scene_.materials[0].base_color_texture = 0;
  stays("UVs");
  scene_ = whole;
  vertices_[0].gaussian = optim::GaussianPriorSpec{{}, 0.1};
  stays("prior");
  vertices_[0].gaussian.reset();
  for (Vec3& p : scene_.meshes[0].mesh.positions) p.y += 100.0;
  stays("no fitted view");
  vertices_[0].mesh_detail = MeshDetail::kKeep;
  EXPECT_EQ(At(1.0).messages.size(), 0U) << "as it was asked for";
}

}  // namespace
}  // namespace pathfit::mesh_levels_test
