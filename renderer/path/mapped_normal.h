#pragma once

#include <array>

#include "renderer/scene/world.h"

namespace pathfit::renderer {

/// The normal that a normal map makes of an interpolated normal and tangent: unit, on the front.
class MappedNormal {
 public:
  /// `m`, `t`: interpolated, of any length; `texel`: direction in their frame, of any length.
  MappedNormal(const Vec3& m, const Vec3& t, double sign, const Vec3& texel) : texel_(texel) {
    m_norm_ = Norm(m);
    t_norm_ = Norm(t);
    n_ = m / m_norm_;
    u_ = t / t_norm_;
    const Vec3 across = Cross(n_, u_) * sign;
    v_norm_ = sign * Norm(across);
    v_ = across * (sign / v_norm_);
    const Vec3 sum = u_ * texel.x + v_ * texel.y + n_ * texel.z;
    norm_ = Norm(sum);
    value_ = sum / norm_;
  }

  /// Not finite where the frame or the texel tells no direction.
  [[nodiscard]] const Vec3& Value() const { return value_; }

  template <class G>
  struct Adjoint {
    G m, t, texel;
  };
  /// Of an adjoint of Value(). G: Vec3 or ColorGradient.
  template <class G>
  [[nodiscard]] Adjoint<G> Pull(const G& d) const {
    const auto across = [](const Vec3& unit, const G& by, double norm) {
      return (by - Outer(unit, Dot(unit, by))) * (1.0 / norm);
    };
    const G d_sum = across(value_, d, norm_);
    const G d_cross = across(v_, d_sum, v_norm_) * texel_.y;
    const G d_n = d_sum * texel_.z + Cross(u_, d_cross);
    const G d_u = d_sum * texel_.x - Cross(n_, d_cross);
    return {across(n_, d_n, m_norm_),
            across(u_, d_u, t_norm_),
            Outer({1, 0, 0}, Dot(u_, d_sum)) + Outer({0, 1, 0}, Dot(v_, d_sum)) +
                Outer({0, 0, 1}, Dot(n_, d_sum))};
  }

 private:
  Vec3 texel_, n_, u_, v_, value_;
  double m_norm_, t_norm_, v_norm_, norm_;
};

/// A point of a mesh that has a normal map.
struct NormalMapPoint {
  std::array<double, 3> weights;
  const Mesh& mesh;
  const Triangle& normals;
  const std::array<Tangent, 3>& tangents;
  const Material& material;
  TextureLookup lookup;

  NormalMapPoint(const World& world, TriangleId id, double b1, double b2)
      : weights{1.0 - b1 - b2, b1, b2},
        mesh(world.mesh(id.mesh)),
        normals(mesh.normal_triangles[static_cast<std::size_t>(id.triangle)]),
        tangents(world.tangents(id.mesh)[id.triangle]),
        material(world.MaterialOf(id.mesh)) {
    const Triangle& uvs = mesh.uv_triangles[static_cast<std::size_t>(id.triangle)];
    Vec2 uv;
    for (std::size_t i = 0; i < 3; ++i) {
      uv = uv + mesh.uvs[static_cast<std::size_t>(uvs[i])] * weights[i];
    }
    lookup = LookUpTexture(
        world.scene().textures[static_cast<std::size_t>(material.normal_texture)], uv);
  }

  [[nodiscard]] const Vec3& Normal(std::size_t corner) const {
    return mesh.normals[static_cast<std::size_t>(normals[corner])];
  }
  [[nodiscard]] MappedNormal Mapped() const {
    Vec3 m{0.0, 0.0, 0.0}, t{0.0, 0.0, 0.0};
    std::size_t heaviest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      m += Normal(i) * weights[i];
      t += tangents[i].along_u * weights[i];
      if (weights[i] > weights[heaviest]) heaviest = i;
    }
    const double scale = material.normal_scale;
    return {m,
            t,
            tangents[heaviest].sign,
            {scale * (2.0 * lookup.value.r - 1.0),
             scale * (2.0 * lookup.value.g - 1.0),
             2.0 * lookup.value.b - 1.0}};
  }
  /// Derivative of the texel's direction by u (`slope`: lookup.du) or v.
  [[nodiscard]] Vec3 TexelSlope(const Rgb& slope) const {
    const double scale = 2.0 * material.normal_scale;
    return {scale * slope.r, scale * slope.g, 2.0 * slope.b};
  }
};

/// Out of line: scenes without normal maps stay as fast.
[[gnu::noinline]] inline Vec3 MappedNormalAt(const World& world,
                                             TriangleId id,
                                             double b1,
                                             double b2) {
  return NormalMapPoint(world, id, b1, b2).Mapped().Value();
}

}  // namespace pathfit::renderer
