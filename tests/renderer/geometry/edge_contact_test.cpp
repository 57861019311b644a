#include "renderer/geometry/edge_contact.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "renderer/geometry/near_pairs.h"

namespace pathfit::renderer::edge_contact_test {
namespace {

Mesh Moved(Mesh mesh, double scale, const Vec3& by) {
  for (Vec3& p : mesh.positions) p = p * scale + by;
  return mesh;
}
/// [0, 1] x [0, 1] in z = 0, as two triangles, the first below the diagonal from (0, 0) to (1, 1).
Mesh Square() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}
Mesh AsOne(Mesh mesh, const Mesh& other) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.triangles) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return mesh;
}

class Contacts {
 public:
  explicit Contacts(std::vector<Mesh> meshes) : meshes_(std::move(meshes)) {
    std::vector<const Mesh*> all;
    for (const Mesh& mesh : meshes_) {
      all.push_back(&mesh);
      topologies_.push_back(MeshTopology::Build(mesh));
    }
    caster_.Build(all);
    contacts_ = std::make_unique<EdgeContacts>(caster_, meshes_, topologies_);
  }
  /// What touches the edge between two places at the share t of the way from the first.
  [[nodiscard]] std::vector<TriangleId> At(int m, const Vec3& a, const Vec3& b, double t) const {
    const Mesh& mesh = meshes_[static_cast<std::size_t>(m)];
    const auto& edges = topologies_[static_cast<std::size_t>(m)].edges;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const Vec3& first = mesh.positions[static_cast<std::size_t>(edges[e].vertices[0])];
      const Vec3& last = mesh.positions[static_cast<std::size_t>(edges[e].vertices[1])];
      const bool along = Norm(first - a) + Norm(last - b) == 0.0;
      if (!along && Norm(first - b) + Norm(last - a) != 0.0) continue;
      const FacesAtEdge at = contacts_->At(m, static_cast<std::int32_t>(e), along ? t : 1.0 - t);
      EXPECT_EQ(at.All().size(), at.Touching().size() + 2);
      EXPECT_EQ(at.All()[0], (TriangleId{m, edges[e].faces[0]}));
      EXPECT_EQ(at.All()[1], (TriangleId{m, edges[e].faces[1]}));
      EXPECT_TRUE(std::is_sorted(at.Touching().begin(), at.Touching().end()));
      return {at.Touching().begin(), at.Touching().end()};
    }
    ADD_FAILURE() << "no such edge";
    return {};
  }
  /// Sum over all edges of the number that touch at their middles.
  [[nodiscard]] std::size_t Sum() const {
    std::size_t sum = 0;
    for (std::size_t m = 0; m < meshes_.size(); ++m) {
      for (std::size_t e = 0; e < topologies_[m].edges.size(); ++e) {
        sum += contacts_->At(static_cast<int>(m), static_cast<std::int32_t>(e), 0.45)
                   .Touching()
                   .size();
      }
    }
    return sum;
  }

 private:
  std::vector<Mesh> meshes_;
  std::vector<MeshTopology> topologies_;
  RayCaster caster_;
  std::unique_ptr<EdgeContacts> contacts_;
};
using Ids = std::vector<TriangleId>;

TEST(EdgeContacts, OfACubeThatStandsOnASquare) {
  // The cube's lower edge from (0.3, 0.2) to (0.7, 0.2) lies below the diagonal.
  const Mesh cube = Moved(MakeCube(), 0.2, {0.5, 0.4, 0.2});
  const Contacts stands({Square(), cube});
  const Vec3 a = Vec3{-1, -1, -1} * 0.2 + Vec3{0.5, 0.4, 0.2};
  const Vec3 b = Vec3{1, -1, -1} * 0.2 + Vec3{0.5, 0.4, 0.2};
  const Vec3 c = Vec3{1, 1, -1} * 0.2 + Vec3{0.5, 0.4, 0.2};
  const Vec3 d = Vec3{-1, 1, -1} * 0.2 + Vec3{0.5, 0.4, 0.2};
  for (const double t : {0.001, 0.5, 0.999}) {
    EXPECT_EQ(stands.At(1, a, b, t), (Ids{{0, 0}})) << t;
  }
  // The one from (0.3, 0.6) to (0.7, 0.6) crosses the diagonal at 3/4 of the way.
  EXPECT_EQ(stands.At(1, d, c, 0.7499), (Ids{{0, 1}}));
  EXPECT_EQ(stands.At(1, d, c, 0.75), (Ids{{0, 0}, {0, 1}})) << "either may be below";
  EXPECT_EQ(stands.At(1, d, c, 0.7501), (Ids{{0, 0}}));
  EXPECT_EQ(stands.At(1, a, a + Vec3{0, 0, 0.4}, 0.01), Ids{}) << "it only stands on it";
  EXPECT_EQ(stands.At(0, {0, 0, 0}, {1, 0, 0}, 0.5), Ids{});
  // The diagonal runs below the cube's bottom between 0.3 and 0.6.
  EXPECT_EQ(stands.At(0, {0, 0, 0}, {1, 1, 0}, 0.29), Ids{});
  EXPECT_FALSE(stands.At(0, {0, 0, 0}, {1, 1, 0}, 0.31).empty());
  EXPECT_FALSE(stands.At(0, {0, 0, 0}, {1, 1, 0}, 0.59).empty());
  EXPECT_EQ(stands.At(0, {0, 0, 0}, {1, 1, 0}, 0.61), Ids{});

  EXPECT_EQ(Contacts({Square(), Moved(cube, 1.0, {0, 0, 1e-4})}).Sum(), 0U) << "hovers";
  const Contacts cuts({Square(), Moved(cube, 1.0, {0, 0, -0.1})});
  const Vec3 low = a + Vec3{0, 0, -0.1};
  EXPECT_EQ(cuts.At(1, low, low + Vec3{0, 0, 0.4}, 0.25), Ids{}) << "they cross";
  EXPECT_EQ(Contacts({cube}).Sum(), 0U) << "joined triangles";
}

TEST(EdgeContacts, HowNearIsNearDependsOnThePlace) {
  // Far from the middle of the scene, at a thousand times the distance, rays tell less apart.
  Mesh wide = Moved(Square(), 2000.0, {-1000, -1000, 0});
  const Mesh small = Moved(MakeCube(), 0.1, {0.45, -0.75, 0.5});
  const auto plate = [](double x, double height) {
    return Moved(Square(), 0.5, {x, -1.0, height});
  };
  EXPECT_EQ(Contacts({wide, small, plate(900.0, 1e-3)}).Sum(), 5U);
  EXPECT_EQ(Contacts({wide, small, plate(0.2, 1e-3)}).Sum(), 0U);
  EXPECT_EQ(Contacts({wide, small, plate(0.2, 1e-7)}).Sum(), 5U);
  const Contacts sheets({wide, small, Moved(wide, 0.9, {0, 0, 1e-3})});
  const Vec3 a = Vec3{-1000, -1000, 0} * 0.9 + Vec3{0, 0, 1e-3};
  const Vec3 b = Vec3{1000, 1000, 0} * 0.9 + Vec3{0, 0, 1e-3};
  EXPECT_FALSE(sheets.At(2, a, b, 0.01).empty());
  EXPECT_TRUE(sheets.At(2, a, b, 0.5).empty());
  EXPECT_FALSE(sheets.At(2, a, b, 0.99).empty());
}

TEST(EdgeContacts, PartsOfOneMeshAndBordersOfOnePart) {
  const Mesh cube = MakeCube();
  const Mesh tower = AsOne(cube, Moved(cube, 1.0, {0, 0, 2}));
  const Contacts of_tower({tower});
  EXPECT_EQ(of_tower.At(0, {-1, -1, 1}, {1, -1, 1}, 0.4).size(), 2U) << "the other's faces";
  EXPECT_EQ(of_tower.At(0, {-1, -1, -1}, {1, -1, -1}, 0.4).size(), 0U);
  EXPECT_EQ(of_tower.Sum(), Contacts({cube, Moved(cube, 1.0, {0, 0, 2})}).Sum());

  // Two squares beside one of double the height, all joined at the top: the corner in the middle of
  // the long side is a T-junction within one part.
  Mesh sheet;
  sheet.positions = {{0, 0, 0},
                     {1, 0, 0},
                     {2, 0, 0},
                     {2, 1, 0},
                     {1, 1, 0},
                     {0, 2, 0},
                     {1, 2, 0},
                     {2, 2, 0},
                     {0, 3, 0},
                     {1, 3, 0},
                     {2, 3, 0}};
  sheet.triangles = {{0, 1, 6},
                     {0, 6, 5},
                     {1, 2, 3},
                     {1, 3, 4},
                     {4, 3, 7},
                     {4, 7, 6},
                     {5, 6, 9},
                     {5, 9, 8},
                     {6, 7, 10},
                     {6, 10, 9}};
  const Contacts within({sheet});
  EXPECT_EQ(within.At(0, {1, 0, 0}, {1, 2, 0}, 0.25), (Ids{{0, 3}}));
  EXPECT_EQ(within.At(0, {1, 0, 0}, {1, 2, 0}, 0.75), (Ids{{0, 5}}));
  EXPECT_EQ(within.At(0, {1, 0, 0}, {1, 1, 0}, 0.5), (Ids{{0, 0}}));
  EXPECT_EQ(within.At(0, {1, 1, 0}, {1, 2, 0}, 0.5), (Ids{{0, 0}}));
  EXPECT_EQ(within.At(0, {0, 0, 0}, {1, 0, 0}, 0.5), Ids{});
  EXPECT_EQ(within.At(0, {0, 2, 0}, {1, 2, 0}, 0.5), Ids{});
}

TEST(EdgeContacts, WhatASliverJoinsDoesNotTouchItsOtherSide) {
  Mesh tent;
  tent.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 1e-7, 0}, {0, 0.3, 0.8}};
  tent.triangles = {{0, 1, 2}, {1, 3, 2}, {0, 2, 3}};
  EXPECT_EQ(Contacts({tent}).At(0, {0, 0, 0}, {1, 0, 0}, 0.7), Ids{});
  Mesh two = tent;  // one behind the other
  two.positions.push_back({0.6, 2e-7, 0});
  two.triangles = {{0, 1, 2}, {1, 4, 2}, {0, 2, 4}, {1, 3, 4}, {0, 4, 3}};
  EXPECT_EQ(Contacts({two}).At(0, {0, 0, 0}, {1, 0, 0}, 0.7), Ids{});
  const Contacts with_another({tent, Moved(Square(), 1.0, {0, 0, 0})});
  EXPECT_EQ(with_another.At(0, {0, 0, 0}, {1, 0, 0}, 0.7), (Ids{{1, 0}}));
}

TEST(EdgeContacts, AnyNumberOfTrianglesAndOfParts) {
  // Fins that all end on one edge.
  Mesh fins;
  const int count = 50;
  for (int i = 0; i < count; ++i) {
    const double angle = 0.05 * (i + 1);
    Mesh fin;
    fin.positions = {{0.1, 0, 0}, {0.9, 0, 0}, {0.5, std::cos(angle), -std::sin(angle)}};
    fin.triangles = {{0, 2, 1}};
    fins = AsOne(fins, fin);
  }
  const Contacts contacts({Square(), fins});
  EXPECT_EQ(contacts.At(0, {0, 0, 0}, {1, 0, 0}, 0.5).size(), static_cast<std::size_t>(count));
  EXPECT_EQ(contacts.At(0, {0, 0, 0}, {1, 0, 0}, 0.05).size(), 0U);
  const Ids found = contacts.At(1, {0.1, 0, 0}, {0.9, 0, 0}, 0.5);
  EXPECT_EQ(found.size(), static_cast<std::size_t>(count)) << "the others and the square";
  EXPECT_EQ(found.front(), (TriangleId{0, 0}));
}

TEST(NearPairs, AreThoseOfAllPairs) {
  std::vector<TriangleGeometry> triangles;
  const Mesh ball = MakeIcosphere(2, 1.0);
  const Mesh both = AsOne(ball, Moved(ball, 1.0, {1.2, 0.3, 0.1}));
  for (const Triangle& t : both.triangles) {
    const auto p = [&](std::size_t k) { return both.positions[static_cast<std::size_t>(t[k])]; };
    triangles.push_back(TriangleGeometry::Make(p(0), p(1), p(2)));
  }
  triangles.push_back(TriangleGeometry::Make({-9, -9, 0}, {9, -9, 1}, {0, 9, -1}));
  std::vector<NearItem> items;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    items.push_back({&triangles[i], 0.02, i == 7 ? -1 : i < ball.triangles.size() ? 3 : 4});
  }
  std::set<std::pair<std::size_t, std::size_t>> found;
  ForEachNearPair(items, [&](std::size_t i, std::size_t k) {
    EXPECT_TRUE(found.insert(std::minmax(i, k)).second) << "twice";
    EXPECT_TRUE(items[i].label != items[k].label || items[i].label < 0);
  });
  std::size_t missed = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    for (std::size_t k = i + 1; k < items.size(); ++k) {
      if (items[i].label == items[k].label && items[i].label >= 0) continue;
      // Near for sure: a corner or the middle of a side of one is near the other.
      bool near = false;
      for (const auto& [t, other] : {std::pair(i, k), std::pair(k, i)}) {
        const std::array<Vec3, 3> corners = triangles[t].Corners();
        for (std::size_t c = 0; c < 3; ++c) {
          SegmentPart part;
          part.KeepNear(triangles[other], corners[c], corners[(c + 1) % 3], 0.02);
          near = near || !part.IsEmpty();
        }
      }
      missed += near && found.count({i, k}) == 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(missed, 0U);
  EXPECT_LT(found.size(), items.size() * 20);
  EXPECT_GT(found.size(), 100U);
}

TEST(SegmentPart, NearATriangle) {
  const TriangleGeometry t = TriangleGeometry::Make({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const auto near = [&](const Vec3& a, const Vec3& b) {
    SegmentPart part;
    part.KeepNear(t, a, b, 0.01);
    return part;
  };
  const SegmentPart along = near({-1, 0.25, 0}, {1, 0.25, 0});
  EXPECT_NEAR(along.begin, 0.495, 1e-12);
  EXPECT_NEAR(along.end, 0.875 + 0.005 * std::sqrt(2.0), 1e-12);
  const SegmentPart through = near({0.25, 0.25, -1}, {0.25, 0.25, 1});
  EXPECT_NEAR(through.begin, 0.495, 1e-12);
  EXPECT_NEAR(through.end, 0.505, 1e-12);
  EXPECT_TRUE(near({-1, 0.25, 0.02}, {1, 0.25, 0.02}).IsEmpty());
  EXPECT_TRUE(near({-1, 1.25, 0}, {1, 1.25, 0}).IsEmpty());
  EXPECT_FALSE(near({0.1, 0.1, 0.005}, {0.2, 0.1, 0.005}).IsEmpty());
  // A thin tip ends where it ends.
  const TriangleGeometry thin = TriangleGeometry::Make({0, 0, 0}, {1, 1e-4, 0}, {1, -1e-4, 0});
  SegmentPart part;
  part.KeepNear(thin, {-1, 0, 0}, {1, 0, 0}, 0.01);
  EXPECT_NEAR(part.begin, 0.495, 1e-4);
}

}  // namespace
}  // namespace pathfit::renderer::edge_contact_test
