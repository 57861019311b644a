#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/geometry/ray.h"
#include "renderer/math/distribution_1d.h"

namespace pathfit::renderer {

struct AreaSample {
  TriangleId id;
  double b1 = 0.0, b2 = 0.0;
  double pdf = 0.0;  ///< per square metre; 0: no triangle faces the receiver
};

/// How a receiver looks for light: at a point, or in a direction of which `mesh` must be seen.
struct AreaChoice {
  AreaSample point;  ///< pdf 0: look along `direction`
  int mesh = -1;
  Vec3 direction;
  double pdf = 0.0;  ///< of the direction, per steradian
};

/// Sampling of points on triangles that shine, uniform inside a triangle. Without a receiver a
/// triangle is chosen by area times brightness; for a receiver, leaves of a tree, each a nearly
/// flat part of one mesh, are chosen by estimates of what reaches it (a tree of lights as in
/// [ContyEstevezKulla2018], by moments of the normals instead of cones), then a triangle in the
/// leaf by area times brightness.
class AreaSampler {
 public:
  AreaSampler() = default;

  /// Adds a mesh (world frame, index `mesh` of the scene) whose triangle i has mean luminance
  /// brightness[i] >= 0. Triangles without brightness keep a small share, so that their derivative
  /// is found. `two_sided`: receivers behind a triangle see it, too.
  void AddMesh(int mesh, const Mesh& world, const std::vector<double>& brightness, bool two_sided);
  /// Builds distribution and tree; call once after all AddMesh.
  void Finish();

  [[nodiscard]] bool Empty() const { return distribution_.Empty(); }
  /// u0 picks the triangle; what is left of it and u1, a square, are folded onto the triangle:
  /// continuous within a triangle, so stratified numbers give stratified points.
  [[nodiscard]] AreaSample Sample(double u0, double u1) const;
  /// Density per square metre at any point of a triangle; 0 for triangles that were not added.
  [[nodiscard]] double Pdf(TriangleId id) const;
  /// The same two for the receiver x. `w`: unit, from x to a point of the triangle;
  /// `cosine_over_square`: of the angle there, over its squared distance.
  [[nodiscard]] AreaChoice SampleTowards(const Vec3& x, double u0, double u1) const;
  [[nodiscard]] double PdfTowards(const Vec3& x,
                                  TriangleId id,
                                  const Vec3& w,
                                  double cosine_over_square) const;

 private:
  struct Source {
    TriangleId id;
    std::array<Vec3, 3> corners;
    Vec3 normal;
    double area = 0.0, weight = 0.0;
    bool two_sided = false;
    double pdf = 0.0;          // per square metre
    double pdf_in_leaf = 0.0;  // the same if its leaf has been chosen
    std::int32_t leaf = -1;
  };
  /// A range of sources_, the sphere that holds them and the moments of their normals, by weight.
  struct Node {
    std::int32_t first = 0, end = 0;
    std::int32_t parent = -1;
    std::int32_t child = -1;  // and the one behind it; -1: a leaf
    double weight = 0.0;
    bool two_sided = false;
    Vec3 center;
    double squared_radius = 0.0;
    Vec3 mean;             // of n
    Vec3 diagonal, mixed;  // of n n^T: (xx, yy, zz), twice (xy, xz, yz)
    bool several_meshes = false;
    bool is_flat = false;     // normals are nearly parallel
    bool is_compact = false;  // a mesh that is seen as its sphere
  };

  /// `is_whole`: no mesh has sources outside the range.
  [[nodiscard]] Node Bound(std::int32_t first, std::int32_t end, bool is_whole) const;
  /// Orders the node's range so that it can be cut at the result.
  std::int32_t Split(const Node& node);
  [[nodiscard]] static double Importance(const Node& node, const Vec3& x);
  /// Whether x draws directions to the node's sphere.
  [[nodiscard]] static bool SeesCone(const Node& node, const Vec3& x);
  [[nodiscard]] const Source* Find(TriangleId id) const;
  /// Probability of the first of two siblings for x; empty if nothing of them reaches it.
  [[nodiscard]] static std::optional<double> ShareOfFirst(const Node* siblings, const Vec3& x);
  [[nodiscard]] AreaSample SampleIn(const Node& node, double u0, double u1) const;

  std::vector<Source> sources_;  // in the order of the leaves; last those without area
  std::vector<std::vector<std::int32_t>> source_of_;  // by mesh and triangle; empty: not added
  std::vector<Node> nodes_;                           // nodes_[0] is the root
  Distribution1D distribution_;
};

}  // namespace pathfit::renderer
