#include "renderer/derivative/path_adjoint.h"

namespace pathfit::renderer {
namespace {

using Vertex = PathRecorder::Vertex;

void AddChannels(std::array<Rgba, 3>& entry, int channel, const Vec3& gradient) {
  entry[0][channel] += gradient.x;
  entry[1][channel] += gradient.y;
  entry[2][channel] += gradient.z;
}

void AddDiagonal(std::array<Rgba, 3>& entry, const Rgb& d) {
  entry[0].r += d.r;
  entry[1].g += d.g;
  entry[2].b += d.b;
}

void AddScalar(std::array<Rgba, 3>& entry, const Rgb& d) { entry[0] += Rgba(d, 0.0); }

/// Moves the adjoint of a unit vector (b - a) / r to its end point b; the start point receives the
/// negative.
Vec3 EndPointAdjoint(const Vec3& unit, double r, const Vec3& adjoint) {
  return (adjoint - unit * Dot(unit, adjoint)) / r;
}

class Sweep {
 public:
  Sweep(const PathContext& context,
        const ActiveParameters& active,
        PathRecorder& path,
        DerivativeAccumulator& sum)
      : context_(context), active_(active), path_(path), sum_(sum) {}

  void Run() {
    Rgb throughput{1.0, 1.0, 1.0};
    for (Vertex& v : path_.vertices) {
      v.throughput = throughput;
      if (v.continues) {
        const BsdfCosines c{Dot(v.p.n, v.wi), Dot(v.p.n, v.p.wo), Dot(v.wi, v.p.wo)};
        throughput *= EvalBsdf(v.p.material->bsdf, v.p.base_color, c) * v.factor;
      }
    }
    Rgb beyond;  // radiance leaving vertex k + 1 towards vertex k
    for (std::size_t k = path_.vertices.size(); k-- > 0;) {
      beyond = AdjointOfVertex(k, beyond);
    }
    for (std::size_t k = 0; k < path_.vertices.size(); ++k) {
      Scatter(path_.vertices[k], k == 0);
    }
  }

 private:
  /// All that leaves vertex k; returns it and leaves its derivative by the vertices' positions,
  /// normals and materials.
  Rgb AdjointOfVertex(std::size_t k, const Rgb& beyond) {
    Vertex& v = path_.vertices[k];
    Rgb leaving;
    for (std::size_t i = v.first_direct; i < v.end_direct; ++i) {
      leaving += AdjointOfDirect(k, path_.directs[i]);
    }
    if (v.continues && k + 1 < path_.vertices.size()) {
      leaving += AdjointOfSegment(k, beyond);
    }
    return leaving;
  }

  Rgb AdjointOfDirect(std::size_t k, const DirectContribution& direct) {
    Vertex& v = path_.vertices[k];
    const Rgb weight = v.throughput * direct.radiance * direct.factor;
    ColorGradient d_wi{};
    const Rgb bsdf = AdjointOfBsdf(k, direct.wi, weight, d_wi);
    if (active_.any_positions && direct.distance > 0.0) {
      const Rgb value = weight * bsdf;
      for (int c = 0; c < 3; ++c) {
        Vec3& d_x = v.d_x[static_cast<std::size_t>(c)];
        d_x -= EndPointAdjoint(direct.wi, direct.distance, d_wi[static_cast<std::size_t>(c)]);
        d_x += direct.wi * (2.0 * value[c] / direct.distance);
      }
    }
    AccumulateEmitter(direct, v.throughput * bsdf * direct.factor);
    return bsdf * direct.radiance * direct.factor;
  }

  /// Segment x_k -> x_{k+1}: bsdf at k, geometry term of both ends, area ratio of the far one.
  Rgb AdjointOfSegment(std::size_t k, const Rgb& beyond) {
    Vertex& v = path_.vertices[k];
    Vertex& next = path_.vertices[k + 1];
    const Rgb weight = v.throughput * beyond * v.factor;
    ColorGradient d_wi{};
    const Rgb bsdf = AdjointOfBsdf(k, v.wi, weight, d_wi);
    if (active_.any_positions) {
      const Rgb value = weight * bsdf;
      const double r = Norm(next.p.x - v.p.x);
      const double cos_next = Dot(next.p.n, v.wi);
      for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<std::size_t>(c);
        next.d_n[i] += v.wi * (value[c] / cos_next);
        d_wi[i] += next.p.n * (value[c] / cos_next);
        const Vec3 d_end = EndPointAdjoint(v.wi, r, d_wi[i]) - v.wi * (2.0 * value[c] / r);
        next.d_x[i] += d_end;
        v.d_x[i] -= d_end;
      }
      next.d_log_area += value;
    }
    return bsdf * beyond * v.factor;
  }

  /// Adjoint of weight * bsdf * (cosine, which is inside weight) at vertex k for incident direction
  /// wi: fills the vertex' own adjoints, adds to d_wi, and returns the bsdf.
  Rgb AdjointOfBsdf(std::size_t k, const Vec3& wi, const Rgb& weight, ColorGradient& d_wi) {
    Vertex& v = path_.vertices[k];
    const BsdfCosines cosines{Dot(v.p.n, wi), Dot(v.p.n, v.p.wo), Dot(wi, v.p.wo)};
    const BsdfPartials f = EvalBsdfPartials(v.p.material->bsdf, v.p.base_color, cosines);
    v.d_base_color += weight * f.d_base_color;
    v.d_roughness += weight * f.d_roughness;
    v.d_metallic += weight * f.d_metallic;
    if (!active_.any_positions) {
      return f.value;
    }
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const double by_cos_i = weight[c] * (f.d_cos_i[c] + f.value[c] / cosines.cos_i);
      const double by_cos_o = weight[c] * f.d_cos_o[c];
      const double by_dot = weight[c] * f.d_dot_io[c];
      v.d_n[i] += wi * by_cos_i + v.p.wo * by_cos_o;
      d_wi[i] += v.p.n * by_cos_i + v.p.wo * by_dot;
      if (k > 0) {
        // wo runs from this vertex to the previous one; at the camera vertex it is the fixed pixel
        // ray.
        Vertex& previous = path_.vertices[k - 1];
        const Vec3 d_wo = v.p.n * by_cos_o + wi * by_dot;
        const Vec3 d_end = EndPointAdjoint(v.p.wo, Norm(previous.p.x - v.p.x), d_wo);
        previous.d_x[i] += d_end;
        v.d_x[i] -= d_end;
      }
    }
    return f.value;
  }

  void AccumulateEmitter(const DirectContribution& direct, const Rgb& weight) {
    const auto index = static_cast<std::size_t>(direct.emitter);
    if (context_.lights.environment && context_.lights.environment->emitter == direct.emitter) {
      AccumulateEnvironmentAdjoint(*context_.lights.environment, direct.wi, weight, active_, sum_);
    } else if (active_.intensity[index] >= 0) {
      AddDiagonal(sum_.Entry(active_.intensity[index]), weight);
    }
  }

  void Scatter(const Vertex& v, bool is_camera_vertex) {
    const auto mesh_index = static_cast<std::size_t>(v.p.id.mesh);
    const SceneMesh& mesh = context_.scene->meshes[mesh_index];
    const auto material = static_cast<std::size_t>(mesh.material);
    if (active_.any_material) {
      ScatterMaterial(v, mesh, mesh_index, material);
    }
    if (active_.positions[mesh_index] >= 0) {
      ScatterPositions(v, mesh, active_.positions[mesh_index], is_camera_vertex);
    }
  }

  void ScatterMaterial(const Vertex& v,
                       const SceneMesh& mesh,
                       std::size_t mesh_index,
                       std::size_t material) {
    if (v.p.material->vertex_colors) {
      if (const std::int32_t first = active_.colors[mesh_index]; first >= 0) {
        const Triangle& t = mesh.mesh.color_triangles[static_cast<std::size_t>(v.p.id.triangle)];
        AddDiagonal(sum_.Entry(first + t[0]), v.d_base_color * (1.0 - v.p.b1 - v.p.b2));
        AddDiagonal(sum_.Entry(first + t[1]), v.d_base_color * v.p.b1);
        AddDiagonal(sum_.Entry(first + t[2]), v.d_base_color * v.p.b2);
      }
    } else if (active_.base_color[material] >= 0) {
      AddDiagonal(sum_.Entry(active_.base_color[material]), v.d_base_color);
    }
    if (active_.roughness[material] >= 0) {
      AddScalar(sum_.Entry(active_.roughness[material]), v.d_roughness);
    }
    if (active_.metallic[material] >= 0) {
      AddScalar(sum_.Entry(active_.metallic[material]), v.d_metallic);
    }
  }

  void ScatterPositions(const Vertex& v,
                        const SceneMesh& mesh,
                        std::int32_t first,
                        bool is_camera_vertex) {
    const TriangleGeometry& geometry = context_.caster->Geometry(v.p.id);
    const std::array<Vec3, 3> gradients = BarycentricGradients(geometry);
    const std::array<double, 3> b = {1.0 - v.p.b1 - v.p.b2, v.p.b1, v.p.b2};
    std::array<ColorGradient, 3> d_corner;  // [corner][channel]
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      Vec3 d_material = v.d_x[i];  // by the velocity of the material point
      if (is_camera_vertex) {
        const Vec3 texture = ColorGradientInPlane(v, mesh, gradients, c);
        const Vec3 d_point = v.d_x[i] + texture;
        d_material = v.p.n * (Dot(d_point, v.p.wo) / Dot(v.p.n, v.p.wo)) - texture;
      }
      const std::array<Vec3, 3> by_normal = NormalAdjoint(geometry, v.d_n[i] * v.p.side);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        d_corner[corner][i] =
            by_normal[corner] + d_material * b[corner] + gradients[corner] * v.d_log_area[c];
      }
    }
    const Triangle& t = mesh.mesh.triangles[static_cast<std::size_t>(v.p.id.triangle)];
    for (std::size_t corner = 0; corner < 3; ++corner) {
      std::array<Rgba, 3>& entry = sum_.Entry(first + t[corner]);
      for (int c = 0; c < 3; ++c) {
        AddChannels(entry, c, d_corner[corner][static_cast<std::size_t>(c)]);
      }
    }
  }

  /// Gradient of a channel by moving over the material: vertex colours change with the
  /// barycentrics.
  static Vec3 ColorGradientInPlane(const Vertex& v,
                                   const SceneMesh& mesh,
                                   const std::array<Vec3, 3>& gradients,
                                   int channel) {
    Vec3 sum;
    if (v.p.material->vertex_colors) {
      const Triangle& t = mesh.mesh.color_triangles[static_cast<std::size_t>(v.p.id.triangle)];
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const Rgb& color = mesh.mesh.colors[static_cast<std::size_t>(t[corner])];
        sum += gradients[corner] * (v.d_base_color[channel] * color[channel]);
      }
    }
    return sum;
  }

  const PathContext& context_;
  const ActiveParameters& active_;
  PathRecorder& path_;
  DerivativeAccumulator& sum_;
};

}  // namespace

void AccumulatePathAdjoint(const PathContext& context,
                           const ActiveParameters& active,
                           PathRecorder& path,
                           DerivativeAccumulator& sum) {
  Sweep(context, active, path, sum).Run();
}

void AccumulateEnvironmentAdjoint(const LightSet::Environment& environment,
                                  const Vec3& direction,
                                  const Rgb& weight,
                                  const ActiveParameters& active,
                                  DerivativeAccumulator& sum) {
  const auto index = static_cast<std::size_t>(environment.emitter);
  const std::int32_t texels = active.texels[index];
  const std::int32_t intensity = active.intensity[index];
  if (texels < 0 && intensity < 0) {
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
    if (texels >= 0) {
      AddDiagonal(sum.Entry(texels + lookup.texel[i]),
                  weight * environment.light->intensity * lookup.weight[i]);
    }
  }
  if (intensity >= 0) {
    AddDiagonal(sum.Entry(intensity), weight * texel_mean);
  }
}

}  // namespace pathfit::renderer
