#include "renderer/geometry/tangents.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace pathfit::renderer {
namespace {

using Corner = std::array<std::int32_t, 3>;  // indices of position, normal and UV

std::size_t At(std::int32_t index) { return static_cast<std::size_t>(index); }

Vec3 AnyPerpendicular(const Vec3& n) {
  const Vec3 across = std::abs(n.x) < 0.6 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  return Normalized(Cross(n, across));
}

}  // namespace

TangentField::TangentField(const Mesh& mesh) {
  const std::size_t num_corners = 3 * mesh.triangles.size();
  const auto key = [&](std::size_t corner) {
    const std::size_t f = corner / 3, k = corner % 3;
    return Corner{mesh.triangles[f][k], mesh.normal_triangles[f][k], mesh.uv_triangles[f][k]};
  };
  corners_.resize(num_corners);
  std::iota(corners_.begin(), corners_.end(), std::size_t{0});
  std::ranges::stable_sort(corners_, {}, key);
  group_.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < num_corners; ++i) {
    if (i == 0 || key(corners_[i]) != key(corners_[i - 1])) first_.push_back(i);
    group_[corners_[i] / 3][corners_[i] % 3] = static_cast<std::int32_t>(first_.size()) - 1;
  }
  first_.push_back(num_corners);
  Update(mesh);
}

TangentField::Part TangentField::PartOf(const Mesh& mesh, std::size_t f, std::size_t k) {
  Part part;
  const auto x = [&](std::size_t i) { return mesh.positions[At(mesh.triangles[f][i % 3])]; };
  const auto uv = [&](std::size_t i) { return mesh.uvs[At(mesh.uv_triangles[f][i % 3])]; };
  const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
  const double det = a.x * b.y - a.y * b.x;
  if (det == 0.0) return part;
  part.by_corner = {(a.y - b.y) / det, b.y / det, -a.y / det};
  part.along_u = ((x(1) - x(0)) * b.y - (x(2) - x(0)) * a.y) / det;
  const Vec3& stored = mesh.normals[At(mesh.normal_triangles[f][k])];
  part.normal_length = Norm(stored);
  part.n = Normalized(stored);
  part.in_plane = part.along_u - part.n * Dot(part.n, part.along_u);
  part.length = Norm(part.in_plane);
  if (!part.Counts()) return part;
  part.in_plane = part.in_plane / part.length;
  part.next = x(k + 1) - x(k);
  part.previous = x(k + 2) - x(k);
  part.angle = std::atan2(Norm(Cross(part.next, part.previous)), Dot(part.next, part.previous));
  part.sign = det > 0.0 ? part.angle : -part.angle;
  return part;
}

void TangentField::Update(const Mesh& mesh) {
  tangents_.resize(group_.size());
  length_.assign(first_.size() - 1, 0.0);
  for (std::size_t g = 0; g + 1 < first_.size(); ++g) {
    Vec3 along_u{0.0, 0.0, 0.0};
    double sign = 0.0;
    for (std::size_t c = first_[g]; c < first_[g + 1]; ++c) {
      const Part part = PartOf(mesh, corners_[c] / 3, corners_[c] % 3);
      if (!part.Counts()) continue;
      along_u += part.in_plane * part.angle;
      sign += part.sign;
    }
    length_[g] = Norm(along_u);
    const std::size_t first = corners_[first_[g]];
    const Vec3 n = Normalized(mesh.normals[At(mesh.normal_triangles[first / 3][first % 3])]);
    Tangent tangent{length_[g] > 0.0 ? Normalized(along_u) : AnyPerpendicular(n), 1.0};
    if (length_[g] > 0.0 && sign < 0.0) tangent.sign = -1.0;
    for (std::size_t c = first_[g]; c < first_[g + 1]; ++c) {
      tangents_[corners_[c] / 3][corners_[c] % 3] = tangent;
    }
  }
}

std::vector<std::array<Tangent, 3>> MakeTangents(const Mesh& mesh) {
  return TangentField(mesh).Items();
}

ShadingFrame InterpolateFrame(const Mesh& mesh,
                              std::int32_t triangle,
                              const std::array<Tangent, 3>& tangents,
                              const std::array<double, 3>& weights) {
  ShadingFrame frame{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  const Triangle& corners = mesh.normal_triangles[At(triangle)];
  const auto heaviest =
      static_cast<std::size_t>(std::ranges::max_element(weights) - weights.begin());
  for (std::size_t k = 0; k < 3; ++k) {
    frame.normal += Normalized(mesh.normals[At(corners[k])]) * weights[k];
    frame.u += tangents[k].along_u * weights[k];
  }
  // Opposed corners add up to nothing: that which is nearest stands.
  if (!(SquaredNorm(frame.normal) > 1e-12)) frame.normal = mesh.normals[At(corners[heaviest])];
  if (!(SquaredNorm(frame.u) > 1e-12)) frame.u = tangents[heaviest].along_u;
  frame.normal = Normalized(frame.normal);
  frame.u = Normalized(frame.u);
  const Vec3 v = Cross(frame.normal, frame.u) * tangents[heaviest].sign;
  frame.v = SquaredNorm(v) > 1e-12 ? Normalized(v) : AnyPerpendicular(frame.normal);
  return frame;
}

}  // namespace pathfit::renderer
