#include "renderer/derivative/appearance_adjoint.h"

namespace pathfit::renderer {
namespace {

/// A block whose component c acts on channel c.
void AddDiagonal(std::array<Rgba, 3>& entry, const Rgb& d) {
  entry[0].r += d.r;
  entry[1].g += d.g;
  entry[2].b += d.b;
}

void AddComponent(std::array<Rgba, 3>& entry, std::size_t component, const Rgb& d) {
  entry[component] += Rgba(d, 0.0);
}

}  // namespace

void AppearanceAdjoint::Texels(int texture,
                               const TextureLookup& lookup,
                               const Rgb& d_value,
                               bool scalar_only) {
  const std::int32_t first = active_.textures[static_cast<std::size_t>(texture)];
  if (first < 0) {
    return;
  }
  const bool scalar = context_.world->scene().textures[static_cast<std::size_t>(texture)].scalar;
  for (std::size_t i = 0; i < 4; ++i) {
    if (lookup.weight[i] == 0.0) {
      continue;
    }
    auto& entry = sum_.Entry(first + lookup.texel[i]);
    if (scalar || scalar_only) {  // of a colour picture used as data the first channel counts
      AddComponent(entry, 0, d_value * lookup.weight[i]);
    } else {
      AddDiagonal(entry, d_value * lookup.weight[i]);
    }
  }
}

void AppearanceAdjoint::Uv(TriangleId id, double b1, double b2, const Rgb& d_u, const Rgb& d_v) {
  const std::int32_t first = active_.meshes[static_cast<std::size_t>(id.mesh)].uvs;
  if (first < 0) {
    return;
  }
  const Mesh& mesh = context_.world->mesh(id.mesh);
  const Triangle& corners = CornersOf(mesh.uv_triangles, id);
  const std::array<double, 3> weights = {1.0 - b1 - b2, b1, b2};
  for (std::size_t i = 0; i < 3; ++i) {
    auto& entry = sum_.Entry(first + corners[i]);
    AddComponent(entry, 0, d_u * weights[i]);
    AddComponent(entry, 1, d_v * weights[i]);
  }
}

void AppearanceAdjoint::TextureRole(const SurfacePoint& p, int texture, const Rgb& d_value) {
  const TextureLookup lookup =
      LookUpTexture(context_.world->scene().textures[static_cast<std::size_t>(texture)],
                    UvAt(context_.world->mesh(p.id.mesh), p.id, p.b1, p.b2));
  const bool is_color = texture == p.material->base_color_texture;
  Texels(texture, lookup, d_value, !is_color);
  const auto slope = [&](const Rgb& s) { return is_color ? s : Rgb::Constant(s.r); };
  Uv(p.id, p.b1, p.b2, d_value * slope(lookup.du), d_value * slope(lookup.dv));
}

void AppearanceAdjoint::Material(const SurfacePoint& p, const VertexAdjoint& d) {
  const SceneMesh& mesh = context_.world->scene().meshes[static_cast<std::size_t>(p.id.mesh)];
  const auto& blocks = active_.materials[static_cast<std::size_t>(mesh.material)];
  if (!blocks.any) {
    return;
  }
  const renderer::Material& material = *p.material;
  if (material.base_color_texture >= 0) {
    TextureRole(p, material.base_color_texture, d.d_base_color);
  } else if (material.vertex_colors) {
    if (const std::int32_t first = active_.meshes[static_cast<std::size_t>(p.id.mesh)].colors;
        first >= 0) {
      const Triangle& t = CornersOf(mesh.mesh.color_triangles, p.id);
      AddDiagonal(sum_.Entry(first + t[0]), d.d_base_color * (1.0 - p.b1 - p.b2));
      AddDiagonal(sum_.Entry(first + t[1]), d.d_base_color * p.b1);
      AddDiagonal(sum_.Entry(first + t[2]), d.d_base_color * p.b2);
    }
  }
  if (material.roughness_texture >= 0) {
    TextureRole(p, material.roughness_texture, d.d_roughness);
  }
  if (material.metallic_texture >= 0) {
    TextureRole(p, material.metallic_texture, d.d_metallic);
  }
  for (const auto& constant : blocks.constants) {
    const Rgb& value = d.*constant.partial;
    if (constant.scalar) {
      AddComponent(sum_.Entry(constant.block), 0, value);
    } else {
      AddDiagonal(sum_.Entry(constant.block), value);
    }
  }
}

void AppearanceAdjoint::AreaEmission(const MaterialPoint& y, double side, const Rgb& weight) {
  const LightSet::AreaLight& light = *context_.lights.AreaLightOf(y.id.mesh);
  const std::int32_t intensity = active_.lights[static_cast<std::size_t>(light.emitter)].intensity;
  if (intensity < 0 && light.texture == nullptr) {
    return;
  }
  const AreaRadiancePartials partials =
      AreaRadianceDerivative(light, y.id.triangle, y.b1, y.b2, side);
  if (intensity >= 0) {
    AddDiagonal(sum_.Entry(intensity), weight * partials.factor);
  }
  if (light.texture != nullptr) {
    const Rgb d_value = weight * light.light->intensity;
    Texels(light.light->texture, partials.lookup, d_value, false);
    Uv(y.id, y.b1, y.b2, d_value * partials.lookup.du, d_value * partials.lookup.dv);
  }
}

void AppearanceAdjoint::Environment(const LightSet::Environment& environment,
                                    const Vec3& direction,
                                    const Rgb& weight) {
  const auto& blocks = active_.lights[static_cast<std::size_t>(environment.emitter)];
  if (blocks.texels < 0 && blocks.intensity < 0) {
    return;
  }
  const TexelWeights lookup = EnvironmentTexelWeights(
      *environment.light, EnvironmentUv(environment.light_from_world * direction));
  Rgb texel_mean;
  for (std::size_t i = 0; i < 4; ++i) {
    if (lookup.weight[i] == 0.0) {
      continue;
    }
    texel_mean +=
        environment.light->texels[static_cast<std::size_t>(lookup.texel[i])] * lookup.weight[i];
    if (blocks.texels >= 0) {
      AddDiagonal(sum_.Entry(blocks.texels + lookup.texel[i]),
                  weight * environment.light->intensity * lookup.weight[i]);
    }
  }
  if (blocks.intensity >= 0) {
    AddDiagonal(sum_.Entry(blocks.intensity), weight * texel_mean);
  }
}

void AppearanceAdjoint::Intensity(const LightSet::PointLight& light,
                                  const IntensityPartials& partials,
                                  const Rgb& weight) {
  const auto& blocks = active_.lights[static_cast<std::size_t>(light.emitter)];
  if (blocks.intensity >= 0) {
    AddDiagonal(sum_.Entry(blocks.intensity), weight * partials.factor);
  }
  if (blocks.angles >= 0) {
    auto& entry = sum_.Entry(blocks.angles);
    AddComponent(entry, 0, weight * partials.d_inner);
    AddComponent(entry, 1, weight * partials.d_outer);
  }
  if (const auto* projector = std::get_if<ProjectorEmitter>(&light.light->light);
      projector != nullptr && light.texture != nullptr) {
    Texels(projector->texture,
           partials.lookup,
           weight * projector->intensity * partials.texture_scale,
           false);
  }
}

void AppearanceAdjoint::Irradiance(const LightSet::Directional& light, const Rgb& weight) {
  const std::int32_t block = active_.lights[static_cast<std::size_t>(light.emitter)].intensity;
  if (block >= 0) {
    AddDiagonal(sum_.Entry(block), weight);
  }
}

ColorGradient AppearanceAdjoint::LabelGradient(const PathRecord::Vertex& v,
                                               const VertexAdjoint& d) const {
  const Mesh& mesh = context_.world->mesh(v.p.id.mesh);
  const renderer::Material& material = *v.p.material;
  std::array<Rgb, 3> d_bary;  // by the weight of each corner
  const auto add_texture = [&](int texture, const Rgb& d_value, bool is_color) {
    const TextureLookup lookup =
        LookUpTexture(context_.world->scene().textures[static_cast<std::size_t>(texture)],
                      UvAt(mesh, v.p.id, v.p.b1, v.p.b2));
    const Triangle& corners = CornersOf(mesh.uv_triangles, v.p.id);
    const Rgb du = is_color ? lookup.du : Rgb::Constant(lookup.du.r);
    const Rgb dv = is_color ? lookup.dv : Rgb::Constant(lookup.dv.r);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2& uv = mesh.uvs[static_cast<std::size_t>(corners[i])];
      d_bary[i] += d_value * (du * uv.x + dv * uv.y);
    }
  };
  if (material.base_color_texture >= 0) {
    add_texture(material.base_color_texture, d.d_base_color, true);
  } else if (material.vertex_colors) {
    const Triangle& corners = CornersOf(mesh.color_triangles, v.p.id);
    for (std::size_t i = 0; i < 3; ++i) {
      d_bary[i] += d.d_base_color * mesh.colors[static_cast<std::size_t>(corners[i])];
    }
  }
  if (material.roughness_texture >= 0) {
    add_texture(material.roughness_texture, d.d_roughness, false);
  }
  if (material.metallic_texture >= 0) {
    add_texture(material.metallic_texture, d.d_metallic, false);
  }
  if (v.emission_weight > 0.0) {
    const LightSet::AreaLight& light = *context_.lights.AreaLightOf(v.p.id.mesh);
    if (light.texture != nullptr && (v.p.side > 0.0 || light.light->two_sided)) {
      add_texture(light.light->texture, d.emission * light.light->intensity, true);
    }
  }
  if (material.normal_texture >= 0) {
    const NormalMapPoint at(*context_.world, v.p.id, v.p.b1, v.p.b2);
    const MappedNormal mapped = at.Mapped();
    if (IsFinite(mapped.Value())) {
      const auto by = mapped.Pull(d.d_n * v.p.side);
      const Rgb du = Dot(by.texel, at.TexelSlope(at.lookup.du));
      const Rgb dv = Dot(by.texel, at.TexelSlope(at.lookup.dv));
      const Triangle& uvs = CornersOf(mesh.uv_triangles, v.p.id);
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec2& uv = mesh.uvs[static_cast<std::size_t>(uvs[i])];
        d_bary[i] +=
            Dot(by.m, at.Normal(i)) + Dot(by.t, at.tangents[i].along_u) + du * uv.x + dv * uv.y;
      }
    }
  } else if (!mesh.normal_triangles.empty()) {
    const Triangle& corners = CornersOf(mesh.normal_triangles, v.p.id);
    const Vec3 stored = InterpolatedNormal(mesh, v.p.id, v.p.b1, v.p.b2);
    const double norm = Norm(stored);
    const Vec3 n = stored * (1.0 / norm);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& m = mesh.normals[static_cast<std::size_t>(corners[i])];
      const Vec3 change = (m - n * Dot(n, m)) * (v.p.side / norm);
      d_bary[i] += Dot(d.d_n, change);
    }
  }
  const std::array<Vec3, 3> gradients =
      BarycentricGradients(context_.world->caster().Geometry(v.p.id));
  ColorGradient sum;
  for (std::size_t i = 0; i < 3; ++i) {
    sum += Outer(gradients[i], d_bary[i]);
  }
  return sum;
}

}  // namespace pathfit::renderer
