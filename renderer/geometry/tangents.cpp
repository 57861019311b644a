#include "renderer/geometry/tangents.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

namespace pathfit::renderer {
namespace {

using Corner = std::array<std::int32_t, 3>;  // indices of position, normal and UV

struct Sum {
  Vec3 along_u{0.0, 0.0, 0.0};
  double sign = 0.0;
};

std::size_t At(std::int32_t index) { return static_cast<std::size_t>(index); }

Vec3 AnyPerpendicular(const Vec3& n) {
  const Vec3 across = std::abs(n.x) < 0.6 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  return Normalized(Cross(n, across));
}

}  // namespace

std::vector<std::array<Tangent, 3>> MakeTangents(const Mesh& mesh) {
  std::map<Corner, Sum> sums;
  const auto corner = [&](std::size_t f, std::size_t k) {
    return Corner{mesh.triangles[f][k], mesh.normal_triangles[f][k], mesh.uv_triangles[f][k]};
  };
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const auto x = [&](std::size_t k) { return mesh.positions[At(mesh.triangles[f][k % 3])]; };
    const auto uv = [&](std::size_t k) { return mesh.uvs[At(mesh.uv_triangles[f][k % 3])]; };
    const Vec3 p = x(1) - x(0), q = x(2) - x(0);
    const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
    const double det = a.x * b.y - a.y * b.x;
    if (det == 0.0) continue;
    const Vec3 along_u = (p * b.y - q * a.y) / det;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 n = Normalized(mesh.normals[At(mesh.normal_triangles[f][k])]);
      const Vec3 in_plane = along_u - n * Dot(n, along_u);
      const double length = Norm(in_plane);
      if (!(length > 0.0)) continue;
      const Vec3 next = x(k + 1) - x(k), previous = x(k + 2) - x(k);
      const double angle = std::atan2(Norm(Cross(next, previous)), Dot(next, previous));
      Sum& sum = sums[corner(f, k)];
      sum.along_u += in_plane * (angle / length);
      sum.sign += det > 0.0 ? angle : -angle;
    }
  }
  std::vector<std::array<Tangent, 3>> tangents(mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = sums.find(corner(f, k));
      const bool is_known = found != sums.end() && SquaredNorm(found->second.along_u) > 0.0;
      const Vec3 n = Normalized(mesh.normals[At(mesh.normal_triangles[f][k])]);
      tangents[f][k].along_u = is_known ? Normalized(found->second.along_u) : AnyPerpendicular(n);
      if (is_known && found->second.sign < 0.0) tangents[f][k].sign = -1.0;
    }
  }
  return tangents;
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
