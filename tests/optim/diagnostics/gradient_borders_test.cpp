#include "tests/optim/diagnostics/gradient_cases.h"
#include "tests/optim/diagnostics/gradient_scenes.h"

// Meshes that meet: the line between them is a border of colours like any other, counted once
// although it is a border of both, however the two are cut into triangles.
namespace pathfit::optim::gradient_borders_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::ParameterLayout;
using renderer::Scene;
using renderer::Vec3;
using tests::ExpectedTerms;

constexpr int kTile = 8;

/// In both forms. `sensor`: whose motion it is, -1 for an object's.
void ExpectRight(const std::string& name,
                 const Scene& scene,
                 const ParameterLayout& layout,
                 const std::vector<double>& direction,
                 int sensor) {
  tests::CheckInBothForms(
      scene,
      sensor,
      layout,
      direction,
      [](DerivativeForm form) {
        GradientCheckOptions options = tests::OptionsForMotion(form, 1);
        options.replicates = 48;
        options.render.seed = 10000;
        options.render.sppe = 48.0;
        options.render.spp_pixel = 48.0;
        return options;
      },
      [&](const GradientCheckResult& result, DerivativeForm form) {
        tests::ExpectRightDerivative(tests::InForm(name, form),
                                     result,
                                     form == DerivativeForm::kImage
                                         ? ExpectedTerms{Term::kPrimary}
                                         : ExpectedTerms{Term::kInterior, Term::kPixel},
                                     kTile);
      });
}
void ExpectRightByCamera(const std::string& name, const Scene& scene, const Vec3& rate) {
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kCameraPosition, 0);
  ExpectRight(name, scene, layout, {rate.x, rate.y, rate.z}, 0);
}
/// All meshes from the second on move together.
void ExpectRightByThings(const std::string& name, const Scene& scene, const Vec3& rate) {
  ParameterLayout layout(scene);
  std::vector<double> direction;
  for (std::size_t m = 1; m < scene.meshes.size(); ++m) {
    layout.Add(ParameterKind::kObjectTranslation, static_cast<int>(m));
    direction.insert(direction.end(), {rate.x, rate.y, rate.z});
  }
  ExpectRight(name, scene, layout, direction, -1);
}

/// A dark floor, and parts of a thing above it in turn light and dark.
Scene OfParts(std::vector<Mesh> parts) {
  Scene scene = tests::Above(parts.front());
  scene.materials[0].base_color = {0.3, 0.2, 0.1};
  scene.materials[1].base_color = {0.9, 0.8, 0.7};
  scene.materials.push_back({"dark", renderer::LambertBsdf{}, {0.1, 0.2, 0.4}});
  for (std::size_t i = 1; i < parts.size(); ++i) {
    scene.meshes.push_back({"part", parts[i], i % 2 == 0 ? 1 : 2, {}});
  }
  return scene;
}
/// Turned, so that its numbers are rounded, and put above the floor.
Mesh Raised(Mesh mesh) {
  return tests::Placed(std::move(mesh), 1.0, {0.1, 0.6, 0.1}, {-1.1, 0.4, 0.2});
}

/// Rows of quads in the plane z = 0 from x0 to x1, with corners at the given y.
Mesh Strip(double x0, double x1, const std::vector<double>& y) {
  Mesh mesh;
  for (const double at : y) {
    mesh.positions.insert(mesh.positions.end(), {Vec3{x0, at, 0}, Vec3{x1, at, 0}});
  }
  for (int i = 0; i + 1 < static_cast<int>(y.size()); ++i) {
    const int k = 2 * i;
    mesh.triangles.push_back({k, k + 1, k + 3});
    mesh.triangles.push_back({k, k + 3, k + 2});
  }
  return mesh;
}

/// As an OBJ file with two materials is read.
Scene SplitSheet() {
  return OfParts({Raised(Strip(-0.6, 0.1, {-0.5, 0.5})), Raised(Strip(0.1, 0.7, {-0.5, 0.5}))});
}
TEST(Borders, SheetOfTwoMaterials) {
  ExpectRightByCamera("split sheet", SplitSheet(), {1.0, 0.0, 0.0});
  ExpectRightByThings("split sheet moves", SplitSheet(), {0.8, 0.3, 0.2});
}

/// A body of two materials: its parts' common border is a crease.
TEST(Borders, BoxOfTwoMaterials) {
  Mesh box = tests::Placed(tests::Cube(), 0.4, {0, 0.6, 0}, {0.1, 0.5, 0.2});
  Mesh half = box;
  box.triangles.resize(4);
  half.triangles =
      std::vector<renderer::Triangle>(half.triangles.begin() + 4, half.triangles.end());
  ExpectRightByCamera("split box", OfParts({box, half}), {1.0, 0.3, 0.5});
}

TEST(Borders, StackedBoxes) {
  const Scene scene = OfParts({tests::Placed(tests::Cube(), 0.3, {0, 0.3, 0}, {0, 0.5, 0}),
                               tests::Placed(tests::Cube(), 0.3, {0, 0.9, 0}, {0, 0.5, 0})});
  ExpectRightByCamera("stacked boxes", scene, {0.0, 0.0, 1.0});
  ExpectRightByThings("stacked boxes move", scene, {0.8, 0.0, 0.4});
}
TEST(Borders, BoxOnALargerOne) {
  ExpectRightByCamera("pyramid",
                      OfParts({tests::Placed(tests::Cube(), 0.4, {0, 0.4, 0}, {0, 0.5, 0}),
                               tests::Placed(tests::Cube(), 0.2, {0.05, 1.0, 0.1}, {0, 0.9, 0})}),
                      {0.0, 0.0, 1.0});
}

/// Closed parts of one mesh touch like meshes do.
Mesh AsOne(Mesh mesh, const Mesh& other) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (renderer::Triangle t : other.triangles) {
    for (std::int32_t& i : t) i += first;
    mesh.triangles.push_back(t);
  }
  return mesh;
}
TEST(Borders, StackedBoxesOfOneMesh) {
  ExpectRightByCamera("stacked boxes of one mesh",
                      OfParts({AsOne(tests::Placed(tests::Cube(), 0.3, {0, 0.3, 0}, {0, 0.5, 0}),
                                     tests::Placed(tests::Cube(), 0.3, {0, 0.9, 0}, {0, 0.5, 0}))}),
                      {0.0, 0.0, 1.0});
}

TEST(Borders, TowerOfManyParts) {
  Mesh tower;
  for (int i = 0; i < 20; ++i) {
    const double side = i % 2 == 0 ? 0.3 : 0.22;
    Mesh slab = tests::Cube();
    for (Vec3& p : slab.positions) p = {side * p.x, 0.1 + 0.04 * (p.y + 1.0 + 2.0 * i), side * p.z};
    tower = i == 0 ? slab : AsOne(tower, slab);
  }
  ExpectRightByCamera("tower of many parts", OfParts({tower}), {0.3, 0.0, 1.0});
}

/// Corners of one mesh lie on edges of the other, which rounding puts beside them.
TEST(Borders, TJunction) {
  ExpectRightByCamera("T-junction",
                      OfParts({Raised(Strip(-0.6, 0.1, {-0.5, 0.5})),
                               Raised(Strip(0.1, 0.7, {-0.7, -0.2, 0.3, 0.6}))}),
                      {1.0, 0.0, 0.4});
}
/// Within one mesh, too: the upper edge of the lower strip is a border along three others.
TEST(Borders, TJunctionWithinAMesh) {
  Mesh mesh = Strip(-0.6, 0.1, {-0.5, 0.5});
  const Mesh other = Strip(0.1, 0.7, {-0.7, -0.2, 0.3, 0.6});
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (Vec3& p : mesh.positions) p.z += 0.5 * std::abs(p.x - 0.1);  // a crease
  for (renderer::Triangle t : other.triangles) {
    for (std::int32_t& i : t) i += first;
    mesh.triangles.push_back(t);
  }
  ExpectRightByCamera("T-junction in a mesh", OfParts({Raised(mesh)}), {1.0, 0.0, 0.4});
}

/// The long border and the two along it have their outer corners in common, and are joined above.
TEST(Borders, TJunctionWithinAPart) {
  Mesh mesh;
  for (const double x : {-0.6, 0.1, 0.7}) {
    for (const double y : {-0.5, 0.4, 0.8}) mesh.positions.push_back({x, y, 0.0});
  }
  mesh.positions.push_back({0.1, -0.1, 0.0});
  mesh.positions.push_back({0.7, -0.1, 0.0});
  mesh.triangles = {{0, 3, 4},
                    {0, 4, 1},
                    {1, 4, 5},
                    {1, 5, 2},
                    {4, 7, 8},
                    {4, 8, 5},
                    {3, 6, 10},
                    {3, 10, 9},
                    {9, 10, 7},
                    {9, 7, 4}};
  for (Vec3& p : mesh.positions) p.z += 0.5 * std::abs(p.x - 0.1);  // a crease
  ExpectRightByCamera("T-junction in a part", OfParts({Raised(mesh)}), {1.0, 0.0, 0.4});
}

/// A sheet that ends on the middle of another's face, as a fin does.
TEST(Borders, Fin) {
  Mesh fin = Strip(-0.4, 0.3, {-0.4, 0.4});
  for (Vec3& p : fin.positions) p = {p.x, 0.1, 0.4 + p.y};
  ExpectRightByCamera(
      "fin", OfParts({Raised(Strip(-0.6, 0.7, {-0.5, 0.5})), Raised(fin)}), {1.0, 0.0, 0.4});
}

/// Three sheets meet in one line.
TEST(Borders, ThreeSheets) {
  Mesh fin = Strip(-0.4, 0.4, {-0.5, 0.5});
  for (Vec3& p : fin.positions) p = {0.1, p.y, 0.4 + p.x};
  Scene scene = OfParts(
      {Raised(Strip(-0.6, 0.1, {-0.5, 0.5})), Raised(Strip(0.1, 0.7, {-0.5, 0.5})), Raised(fin)});
  scene.materials.push_back({"red", renderer::LambertBsdf{}, {0.9, 0.3, 0.2}});
  scene.meshes[3].material = 3;
  ExpectRightByCamera("three sheets", scene, {1.0, 0.0, 0.4});
}

}  // namespace
}  // namespace pathfit::optim::gradient_borders_test
