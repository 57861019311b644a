#pragma once

#include <cstdint>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/geometry/ray.h"
#include "renderer/math/distribution_1d.h"

namespace pathfit::renderer {

struct AreaSample {
  TriangleId id;
  double b1 = 0.0, b2 = 0.0;
  double pdf = 0.0;  ///< per square metre
};

/// Uniform sampling of points on triangles that shine, each triangle chosen by area times
/// brightness.
class AreaSampler {
 public:
  AreaSampler() = default;

  /// Adds a mesh (world frame, index `mesh` of the scene) whose triangle i has mean luminance
  /// brightness[i] >= 0. Triangles without brightness keep a small share, so that their derivative
  /// is found.
  void AddMesh(int mesh, const Mesh& world, const std::vector<double>& brightness);
  /// Builds the distribution; call once after all AddMesh.
  void Finish();

  [[nodiscard]] bool Empty() const { return distribution_.Empty(); }
  /// u0 picks the triangle; what is left of it and u1, a square, are folded onto the triangle:
  /// continuous within a triangle, so stratified numbers give stratified points.
  [[nodiscard]] AreaSample Sample(double u0, double u1) const;
  /// Density per square metre at any point of a triangle; 0 for triangles that were not added.
  [[nodiscard]] double Pdf(TriangleId id) const;

 private:
  std::vector<TriangleId> triangles_;
  std::vector<double> weights_;
  std::vector<double> areas_;
  std::vector<double> pdf_;                  // per square metre, of each triangle
  std::vector<std::int64_t> first_of_mesh_;  // into triangles_ by mesh, -1 if it was not added
  Distribution1D distribution_;
};

}  // namespace pathfit::renderer
