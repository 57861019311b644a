#include "app/output/coarse_asset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "optim/round/decimate.h"
#include "optim/round/remesh.h"
#include "optim/round/texel_fill.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/tangents.h"
#include "renderer/geometry/texel_places.h"
#include "renderer/geometry/triangle_tree.h"
#include "renderer/geometry/uv_atlas.h"
#include "renderer/math/box.h"

namespace pathfit::app {
namespace {

using renderer::Index;
using renderer::Material;
using renderer::Mesh;
using renderer::Rgb;
using renderer::Scene;
using renderer::Texture;
using renderer::Vec2;
using renderer::Vec3;

constexpr double kTexelsPerEdge = 2.0;

/// Texels per metre of a texture on a mesh in the mean.
double DensityOf(const Texture& texture, const Mesh& mesh) {
  double area = 0.0;
  for (const renderer::Triangle& t : mesh.uv_triangles) {
    const Vec2 a = mesh.uvs[Index(t[1])] - mesh.uvs[Index(t[0])];
    const Vec2 b = mesh.uvs[Index(t[2])] - mesh.uvs[Index(t[0])];
    area += 0.5 * std::abs(a.x * b.y - a.y * b.x);
  }
  return std::sqrt(area * texture.width * texture.height / renderer::SurfaceArea(mesh));
}

/// What is looked up on the fine surface.
struct FineSurface {
  const Scene& scene;
  const Material& material;
  Mesh mesh;  ///< in the world, with normals
  renderer::TriangleTree tree;
  renderer::TangentField tangents = {};  ///< where the material has a normal texture

  FineSurface(const Scene& from, const renderer::SceneMesh& item)
      : scene(from),
        material(from.materials[static_cast<std::size_t>(item.material)]),
        mesh(renderer::WorldMesh(item)),
        tree(mesh) {
    if (mesh.normal_triangles.empty()) renderer::ComputeVertexNormals(mesh);
    if (material.normal_texture >= 0) tangents = renderer::TangentField(mesh);
  }

  [[nodiscard]] const Texture* TextureAt(int index) const {
    return index < 0 ? nullptr : &scene.textures[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] Vec3 NormalAt(const renderer::ClosestPoint& at) const {
    Vec3 sum{0.0, 0.0, 0.0};
    const renderer::Triangle& t = mesh.normal_triangles[Index(at.triangle)];
    for (std::size_t k = 0; k < 3; ++k) {
      sum += Normalized(mesh.normals[Index(t[k])]) * at.weights[k];
    }
    const Vec3 smooth =
        SquaredNorm(sum) > 0.0 ? Normalized(sum) : Normalized(mesh.normals[Index(t[0])]);
    const Texture* map = TextureAt(material.normal_texture);
    if (map == nullptr) return smooth;
    const renderer::ShadingFrame frame =
        renderer::InterpolateFrame(mesh, at.triangle, tangents[at.triangle], at.weights);
    const Rgb texel = TexelAt(*map, at);
    const double scale = material.normal_scale;
    const Vec3 mapped = frame.u * (scale * (2.0 * texel.r - 1.0)) +
                        frame.v * (scale * (2.0 * texel.g - 1.0)) +
                        frame.normal * (2.0 * texel.b - 1.0);
    return SquaredNorm(mapped) > 0.0 ? Normalized(mapped) : smooth;
  }
  [[nodiscard]] Rgb ColorAt(const renderer::ClosestPoint& at) const {
    Rgb color;
    const renderer::Triangle& t = mesh.color_triangles[Index(at.triangle)];
    for (std::size_t k = 0; k < 3; ++k) color += mesh.colors[Index(t[k])] * at.weights[k];
    return color;
  }
  [[nodiscard]] Rgb TexelAt(const Texture& texture, const renderer::ClosestPoint& at) const {
    Vec2 uv;
    const renderer::Triangle& t = mesh.uv_triangles[Index(at.triangle)];
    for (std::size_t k = 0; k < 3; ++k) uv = uv + mesh.uvs[Index(t[k])] * at.weights[k];
    return TextureValue(texture, uv);
  }
  [[nodiscard]] double TexelsPerMetre() const {
    const auto topology = renderer::MeshTopology::Build(mesh);
    double density = kTexelsPerEdge / topology.MeanEdgeLength(mesh);
    for (const int index : material.Textures()) {
      if (const Texture* texture = TextureAt(index)) {
        density = std::max(density, DensityOf(*texture, mesh));
      }
    }
    return density;
  }
};

/// The frame's coordinates of a direction, which need not be at right angles.
Vec3 InFrame(const renderer::ShadingFrame& frame, const Vec3& n) {
  const Vec3 across = Cross(frame.v, frame.normal);
  const double volume = Dot(frame.u, across);
  if (std::abs(volume) < 1e-6) return {0.0, 0.0, 1.0};
  return Vec3{Dot(n, across),
              Dot(n, Cross(frame.normal, frame.u)),
              Dot(n, Cross(frame.u, frame.v))} /
         volume;
}

/// One picture that is filled texel by texel.
struct Picture {
  Texture texture;
  std::vector<Rgb> texels;
};
Picture MakePicture(std::string name, const renderer::UvAtlas& atlas, bool scalar) {
  Picture picture;
  picture.texture.name = std::move(name);
  picture.texture.width = atlas.width;
  picture.texture.height = atlas.height;
  picture.texture.wrap = renderer::TextureWrap::kClamp;
  picture.texture.scalar = scalar;
  picture.texels.resize(static_cast<std::size_t>(atlas.width) *
                        static_cast<std::size_t>(atlas.height));
  return picture;
}
Texture Finish(Picture picture, const std::vector<char>& known) {
  optim::FillBeside(picture.texture.width, picture.texture.height, known, picture.texels);
  picture.texture.texels = std::move(picture.texels);
  return std::move(picture.texture);
}

/// Replaces mesh number `index` of the asset.
void MakeCoarse(const Scene& scene, std::size_t index, int num_triangles, CoarseAsset& asset) {
  const renderer::SceneMesh& item = scene.meshes[index];
  const FineSurface fine(scene, item);
  Mesh coarse = optim::Decimate(fine.mesh, num_triangles);
  renderer::ValidateMesh(coarse, "mesh '" + item.name + "' by fewer triangles");
  renderer::ComputeVertexNormals(coarse);
  const std::vector<double> densities(coarse.triangles.size(), fine.TexelsPerMetre());
  Mesh* const meshes[] = {&coarse};
  const std::vector<double> by_mesh[] = {densities};
  const renderer::UvAtlas atlas = renderer::MakeUvAtlas(meshes, by_mesh);
  const std::vector<std::array<renderer::Tangent, 3>> tangents = renderer::MakeTangents(coarse);
  const Mesh* const placed[] = {&coarse};
  const std::vector<renderer::TexelPlace> places =
      renderer::PlaceTexels(placed, atlas.width, atlas.height);

  Picture normals = MakePicture(item.name + "-normal", atlas, false);
  Picture color = MakePicture(item.name + "-base_color", atlas, false);
  Picture roughness = MakePicture(item.name + "-roughness", atlas, true);
  Picture metallic = MakePicture(item.name + "-metallic", atlas, true);
  const Texture* of_color = fine.TextureAt(fine.material.base_color_texture);
  const Texture* of_roughness = fine.TextureAt(fine.material.roughness_texture);
  const Texture* of_metallic = fine.TextureAt(fine.material.metallic_texture);
  std::vector<char> known(places.size(), 0);
  renderer::ParallelFor(static_cast<std::int64_t>(places.size()), [&](std::int64_t i) {
    const auto p = static_cast<std::size_t>(i);
    const renderer::TexelPlace& place = places[p];
    if (place.mesh < 0) return;
    known[p] = 1;
    const renderer::ShadingFrame frame = renderer::InterpolateFrame(
        coarse, place.triangle, tangents[Index(place.triangle)], place.weights);
    const renderer::ClosestPoint at =
        fine.tree.Closest(optim::PointOf(coarse, place.triangle, place.weights), frame.normal);
    const Vec3 n = Normalized(InFrame(frame, fine.NormalAt(at)));
    normals.texels[p] = Rgb{0.5 + 0.5 * n.x, 0.5 + 0.5 * n.y, 0.5 + 0.5 * n.z};
    if (of_color != nullptr) {
      color.texels[p] = fine.TexelAt(*of_color, at);
    } else if (fine.material.vertex_colors) {
      color.texels[p] = fine.ColorAt(at);
    }
    if (of_roughness != nullptr) roughness.texels[p] = fine.TexelAt(*of_roughness, at);
    if (of_metallic != nullptr) metallic.texels[p] = fine.TexelAt(*of_metallic, at);
  });

  Material material = fine.material;
  const auto add = [&](Picture picture) {
    asset.scene.textures.push_back(Finish(std::move(picture), known));
    return static_cast<int>(asset.scene.textures.size()) - 1;
  };
  if (of_color != nullptr || material.vertex_colors) {
    material.vertex_colors = false;
    material.base_color_texture = add(std::move(color));
  }
  if (of_roughness != nullptr) material.roughness_texture = add(std::move(roughness));
  if (of_metallic != nullptr) material.metallic_texture = add(std::move(metallic));
  material.normal_texture = add(std::move(normals));
  material.normal_scale = 1.0;
  const double off = optim::SurfaceDistance(coarse, fine.mesh);
  asset.messages.push_back(fmt::format(
      "{}: {} of {} triangles, at most {:.3g} m off, normals of the fine surface in {} x {} texels",
      item.name,
      coarse.triangles.size(),
      fine.mesh.triangles.size(),
      off,
      atlas.width,
      atlas.height));
  asset.scene.materials.push_back(std::move(material));
  asset.scene.meshes[index] = {
      item.name, std::move(coarse), static_cast<int>(asset.scene.materials.size()) - 1, {}};
}

}  // namespace

CoarseAsset MakeCoarseAsset(const Scene& scene, int num_triangles) {
  CoarseAsset asset{.scene = scene, .messages = {}};
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const renderer::SceneMesh& item = scene.meshes[m];
    const std::size_t count = item.mesh.triangles.size();
    if (AreaLightOf(scene, m) != nullptr || count <= static_cast<std::size_t>(num_triangles)) {
      asset.messages.push_back(fmt::format("{}: stays, with {} triangles", item.name, count));
      continue;
    }
    try {
      MakeCoarse(scene, m, num_triangles, asset);
    } catch (const renderer::SceneError& error) {
      throw renderer::SceneError("mesh '" + item.name + "': " + error.what());
    }
  }
  return asset;
}

}  // namespace pathfit::app
