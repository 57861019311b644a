#include "renderer/boundary/view_edges.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/probe.h"

namespace pathfit::renderer::view_edges_test {
namespace {

struct Found {
  int edges = 0;
  double weight = 0.0;
  std::vector<ViewEdge> seen;
};

using Change = std::pair<ParameterKind, int>;
const std::vector<Change> kMeshMoves = {{ParameterKind::kVertexPositions, 0}};
const std::vector<Change> kCameraMoves = {{ParameterKind::kCameraRotation, 0}};

Found EdgesOf(Scene scene,
              const Camera& camera,
              const std::vector<Change>& changes = kMeshMoves,
              DerivativeForm form = DerivativeForm::kImage) {
  scene.sensors = {camera};
  const World world(scene);
  const CameraModel model(camera);
  ParameterLayout layout(scene);
  for (const auto& [kind, object] : changes) layout.Add(kind, object);
  const ActiveParameters active = ActiveParameters::Make(scene, layout, model, 0);
  PathContext path;
  path.world = &world;
  path.lights = LightSet::Make(world, model.Pose());
  RenderOptions options;
  options.form = form;
  const RenderServices services;
  const EdgeTree no_tree;
  const ViewEdges edges({path, model, active, options, services, no_tree, world.contacts()});
  Found found;
  found.weight = edges.distribution().Total();
  double remainder = 0.0;
  std::vector<bool> seen(1000);
  for (int i = 0; !edges.distribution().Empty() && i < 20000; ++i) {
    const int edge = edges.distribution().Sample((i + 0.5) / 20000.0, remainder);
    if (!seen[static_cast<std::size_t>(edge)]) {
      seen[static_cast<std::size_t>(edge)] = true;
      found.seen.push_back(edges.edge(edge));
    }
  }
  found.edges = static_cast<int>(found.seen.size());
  return found;
}

Scene Painted(const Mesh& mesh) { return tests::SceneOf(mesh, LambertBsdf{}, {0.5, 0.5, 0.5}, {}); }
Camera FrontCamera() { return tests::CameraAt({0, 0, 6}, {0, 0, 0}, 40.0, 64, 64); }
Camera CornerCamera() { return tests::CameraAt({4, 5, 6}, {0, 0, 0}, 40.0, 64, 64); }
Camera Parallel(Camera camera, double pixels_per_metre) {
  camera.projection = ProjectionKind::kOrthographic;
  camera.fx = camera.fy = pixels_per_metre;
  return camera;
}

TEST(ViewEdges, RectangleHasFourBordersAndNoDiagonal) {
  const Found found = EdgesOf(Painted(tests::Rectangle()), FrontCamera());
  EXPECT_EQ(found.edges, 4);
  EXPECT_NEAR(found.weight, 4.0 * 2.0 * 40.0 / 6.0, 1e-12) << "length in pixels";
}

TEST(ViewEdges, CubeShowsSilhouettesAndCreasesOfSeenFacesOnly) {
  EXPECT_EQ(EdgesOf(Painted(tests::Cube()), FrontCamera()).edges, 4) << "face on";
  EXPECT_EQ(EdgesOf(Painted(tests::Cube()), CornerCamera()).edges, 9) << "three faces";
  const Camera inside = tests::CameraAt({0, 0, 0.5}, {0, 0, -1}, 10.0, 64, 64);
  EXPECT_GE(EdgesOf(Painted(tests::Cube()), inside).edges, 8)
      << "the inside of a closed mesh is seen";
  EXPECT_EQ(EdgesOf(Painted(tests::Cube()), Parallel(CornerCamera(), 10.0)).edges, 9);
}

TEST(ViewEdges, InsideOutSolidIsSeenFromWithin) {
  Mesh cube = tests::Cube();
  for (Triangle& t : cube.triangles) std::swap(t[1], t[2]);
  EXPECT_EQ(EdgesOf(Painted(cube), FrontCamera()).edges, 12);
}

TEST(ViewEdges, SilhouettesOfConcaveEdgesAreInsideTheSolid) {
  // An L-shaped prism along z: its inner edge is concave.
  Mesh mesh;
  const std::vector<Vec2> outline = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const double z : {0.0, 1.0})
    for (const Vec2& p : outline) mesh.positions.push_back({p.x, p.y, z});
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.push_back({i, j, j + 6});
    mesh.triangles.push_back({i, j + 6, i + 6});
  }
  for (const Triangle& t : std::vector<Triangle>{{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}}) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
  }
  ValidateMesh(mesh, "prism");
  // From below right, the inner edge's lower face is hidden: outlines are convex edges only.
  const Camera camera = tests::CameraAt({6, -4, 3}, {1, 1, 0.5}, 40.0, 64, 64);
  const Found closed = EdgesOf(Painted(mesh), camera, kMeshMoves, DerivativeForm::kMaterial);
  mesh.positions.insert(mesh.positions.end(), {{50, 0, 0}, {51, 0, 0}, {50, 1, 0}});
  mesh.triangles.push_back({12, 13, 14});  // out of sight; now the mesh is open
  const Found open = EdgesOf(Painted(mesh), camera, kMeshMoves, DerivativeForm::kMaterial);
  EXPECT_EQ(open.edges, closed.edges + 1);
}

TEST(ViewEdges, ColorSeamsCountOnlyWhereColorsDiffer) {
  Mesh plate = tests::Rectangle();
  plate.colors = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {1, 0, 0}, {0, 0, 1}};
  plate.color_triangles = {{0, 1, 2},
                           {4, 5, 3}};  // separately indexed, equal values on the diagonal
  Scene scene = Painted(plate);
  scene.materials[0].vertex_colors = true;
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 4);
  scene.meshes[0].mesh.colors[5] = {0, 0, 0.9};
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 5);
  EXPECT_EQ(EdgesOf(scene, FrontCamera(), kMeshMoves, DerivativeForm::kMaterial).edges, 4);
  scene.materials[0].vertex_colors = false;
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 4) << "unused colours make no seam";
}

TEST(ViewEdges, UvSeamsCountOnlyUnderTextures) {
  Mesh plate = tests::Rectangle();
  plate.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}};
  plate.uv_triangles = {plate.triangles[0], plate.triangles[1]};
  plate.uv_triangles[1][0] = 4;
  Scene scene = Painted(plate);
  scene.textures = {Texture{}};
  scene.textures[0].scalar = true;
  scene.materials[0].bsdf = MetallicRoughnessBsdf{};
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 4);
  for (int Material::*role :
       {&Material::base_color_texture, &Material::roughness_texture, &Material::metallic_texture}) {
    scene.materials[0].*role = 0;
    EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 5);
    scene.materials[0].*role = -1;
  }
  AreaEmitter light;
  light.mesh = 0;
  scene.emitters = {{"light", LightFrame::kWorld, {}, light}};
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 4);
  std::get<AreaEmitter>(scene.emitters[0].light).texture = 0;
  EXPECT_EQ(EdgesOf(scene, FrontCamera()).edges, 5);
}

TEST(ViewEdges, CreasesWeighAsTheyBendHoweverShadedAndNormalSeamsMuch) {
  Mesh roof = tests::Rectangle();  // folded along its diagonal, away from the camera
  for (const std::int32_t v : roof.triangles[0]) {
    const Triangle& other = roof.triangles[1];
    if (std::find(other.begin(), other.end(), v) == other.end()) {
      roof.positions[static_cast<std::size_t>(v)].z -= 0.5;
    }
  }
  const double flat = EdgesOf(Painted(roof), FrontCamera()).weight;
  roof.normals = std::vector<Vec3>(5, Vec3{0, 0, 1});
  roof.normal_triangles = roof.triangles;
  const Found smooth = EdgesOf(Painted(roof), FrontCamera());
  EXPECT_EQ(smooth.edges, 5);
  roof.normal_triangles[1] = {4, 4, 4};
  roof.normals[4] = {0, 0.1, 1};
  const Found seam = EdgesOf(Painted(roof), FrontCamera());
  const double length = std::sqrt(8.0) * 40.0 / 6.0;  // of the diagonal
  EXPECT_EQ(flat, smooth.weight);
  const auto normal = [&](std::size_t face) {
    const Triangle& t = roof.triangles[face];
    const auto p = [&](std::size_t i) { return roof.positions[static_cast<std::size_t>(t[i])]; };
    return Normalized(Cross(p(1) - p(0), p(2) - p(0)));
  };
  const double bend = Norm(normal(0) - normal(1));
  EXPECT_GT(bend, ViewEdges::kMinJump);
  EXPECT_NEAR(seam.weight - smooth.weight, (1.0 - bend) * length, 1e-9);
}

TEST(ViewEdges, OnlyWhatMovesInTheImageCounts) {
  Scene scene = Painted(tests::Rectangle());
  scene.meshes.push_back({"other", tests::Cube(), 0, {}});
  const Camera camera = FrontCamera();
  EXPECT_EQ(EdgesOf(scene, camera).edges, 4);
  EXPECT_EQ(EdgesOf(scene, camera, {}).edges, 0);
  EXPECT_EQ(EdgesOf(scene, camera, {{ParameterKind::kObjectScale, 1}}).edges, 4);
  EXPECT_EQ(EdgesOf(scene, camera, kCameraMoves).edges, 8);
  EXPECT_EQ(EdgesOf(scene, camera, {{ParameterKind::kRadialDistortion, 0}}).edges, 8);
  EXPECT_EQ(EdgesOf(scene, camera, {{ParameterKind::kBaseColor, 0}}).edges, 0);
  const Camera away = tests::CameraAt({0, 0, 6}, {0, 0, 7}, 40.0, 64, 64);
  EXPECT_EQ(EdgesOf(scene, away).edges, 0);
}

TEST(ViewEdges, MaterialFormHasOutlinesOfAllMeshes) {
  Scene scene = Painted(tests::Rectangle());
  scene.meshes.push_back({"other", tests::Cube(), 0, {}});
  scene.emitters = {tests::ConstantEnvironment({1, 1, 1})};
  const auto edges = [&](const std::vector<Change>& changes) {
    return EdgesOf(scene, CornerCamera(), changes, DerivativeForm::kMaterial).edges;
  };
  EXPECT_EQ(edges(kMeshMoves), 4 + 6);
  EXPECT_EQ(edges(kCameraMoves), 4 + 6);
  EXPECT_EQ(edges({{ParameterKind::kLightRotation, 0}}), 4 + 6) << "the sky behind them turns";
  EXPECT_EQ(edges({{ParameterKind::kLightIntensity, 0}}), 0);
  EXPECT_EQ(edges({}), 0);
}

TEST(ViewEdges, EdgesThroughTheCameraPlaneAreClipped) {
  Mesh floor = tests::Plate(50, 50, 0);
  ApplyTransform({RotationAboutAxis({1, 0, 0}, -1.5707963267948966), {0, -1, 0}}, floor);
  const Camera camera = tests::CameraAt({0, 0, 0}, {0, 0, -1}, 40.0, 64, 64);
  const Found found = EdgesOf(Painted(floor), camera);
  EXPECT_GE(found.edges, 1);
  EXPECT_LT(found.weight, 1000.0) << "no edge is longer than the field of view";
}

TEST(ViewEdges, FieldReachesAsFarAsTheFilter) {
  Camera camera = tests::CameraAt({0, 0, 6}, {0, 0, 0}, 60.0, 8, 8);  // sees |x| < 0.4
  Mesh plate = tests::Plate(0.5, 3, 0);  // its long sides are one pixel outside the film
  EXPECT_EQ(EdgesOf(Painted(plate), camera).edges, 0);
  camera.filter = {PixelFilter::Shape::kTent, 2.0, 0.5};
  const Found found = EdgesOf(Painted(plate), camera);
  EXPECT_EQ(found.edges, 2);
  EXPECT_NEAR(found.weight, 2.0 * (8.0 + 2.0 * 1.5), 1e-12);
  EXPECT_NEAR(EdgesOf(Painted(plate), Parallel(camera, 10.0)).weight, 2.0 * 11.0, 1e-12);
}

TEST(ViewEdges, PointsAreEvenlySpacedInTheImage) {
  const ViewEdge edge{0, 0, 0.2, 0.9, 4.0};  // depth falls from 4 to 1
  const auto image = [](double t) {
    const double s = (t - 0.2) / 0.7;
    return s / (4.0 * (1.0 - s) + s);  // of a segment from (0, 4) to (1, 1)
  };
  for (const double s : {0.0, 0.1, 0.5, 0.8, 1.0}) {
    const ViewEdge::Point point = edge.At(s);
    EXPECT_NEAR(image(point.t), s, 1e-15);
    if (s > 0.0 && s < 1.0) {
      EXPECT_NEAR((edge.At(s + 1e-6).t - edge.At(s - 1e-6).t) / 2e-6, point.dt, 1e-8);
    }
  }
}

TEST(ViewEdges, DepthRatioIsThatOfTheVisibleEnds) {
  Mesh plate = tests::Rectangle();
  ApplyTransform({RotationAboutAxis({0, 1, 0}, 1.2), {}}, plate);
  const MeshTopology topology = MeshTopology::Build(plate);
  int oblique = 0;
  for (const ViewEdge& edge : EdgesOf(Painted(plate), FrontCamera()).seen) {
    const MeshEdge& ends = topology.edges[static_cast<std::size_t>(edge.edge)];
    const auto depth = [&](double t) {
      const auto z = [&](std::size_t i) {
        return plate.positions[static_cast<std::size_t>(ends.vertices[i])].z;
      };
      return 6.0 - (z(0) * (1.0 - t) + z(1) * t);
    };
    EXPECT_NEAR(edge.depth_ratio, depth(edge.t0) / depth(edge.t1), 1e-12);
    oblique += std::abs(edge.depth_ratio - 1.0) > 0.1 ? 1 : 0;
  }
  EXPECT_EQ(oblique, 2);
}

}  // namespace
}  // namespace pathfit::renderer::view_edges_test
