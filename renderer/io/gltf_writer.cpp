#include "renderer/io/gltf_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tiny_gltf.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/tangents.h"
#include "renderer/image/color.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_assembly.h"

namespace pathfit::renderer {
namespace {

/// Collects vertex data in one buffer; all parts fill whole 4-byte words, so that every offset is
/// aligned.
class BufferBuilder {
 public:
  explicit BufferBuilder(tinygltf::Model& model) : model_(model) { model_.buffers.resize(1); }

  /// Index of a new accessor over `values`, `components` (2 to 4) to an element.
  int AddVectors(const std::vector<float>& values, std::size_t components) {
    tinygltf::Accessor accessor;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.type = components == 4   ? TINYGLTF_TYPE_VEC4
                    : components == 3 ? TINYGLTF_TYPE_VEC3
                                      : TINYGLTF_TYPE_VEC2;
    accessor.count = values.size() / components;
    return Add(Words(values), TINYGLTF_TARGET_ARRAY_BUFFER, std::move(accessor));
  }

  /// The format wants bounds of positions.
  int AddPositions(const std::vector<float>& values) {
    const int index = AddVectors(values, 3);
    tinygltf::Accessor& accessor = model_.accessors.back();
    for (std::size_t c = 0; c < 3; ++c) {
      float low = values[c];
      float high = values[c];
      for (std::size_t i = c; i < values.size(); i += 3) {
        low = std::min(low, values[i]);
        high = std::max(high, values[i]);
      }
      accessor.minValues.push_back(static_cast<double>(low));
      accessor.maxValues.push_back(static_cast<double>(high));
    }
    return index;
  }

  int AddIndices(const std::vector<Triangle>& triangles) {
    tinygltf::Accessor accessor;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.type = TINYGLTF_TYPE_SCALAR;
    accessor.count = triangles.size() * 3;
    std::vector<std::uint32_t> words;
    words.reserve(accessor.count);
    for (const Triangle& triangle : triangles) {
      for (const std::int32_t i : triangle) words.push_back(static_cast<std::uint32_t>(i));
    }
    return Add(words, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, std::move(accessor));
  }

  /// Index of a new view of bytes that no accessor describes.
  int AddBytes(const std::vector<unsigned char>& added) {
    std::vector<unsigned char>& bytes = model_.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = added.size();
    bytes.insert(bytes.end(), added.begin(), added.end());
    bytes.resize((bytes.size() + 3) / 4 * 4);
    model_.bufferViews.push_back(std::move(view));
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

 private:
  static std::vector<std::uint32_t> Words(const std::vector<float>& values) {
    std::vector<std::uint32_t> words;
    words.reserve(values.size());
    for (const float value : values) words.push_back(std::bit_cast<std::uint32_t>(value));
    return words;
  }

  int Add(const std::vector<std::uint32_t>& words, int target, tinygltf::Accessor accessor) {
    std::vector<unsigned char> bytes;
    bytes.reserve(words.size() * 4);
    for (const std::uint32_t word : words) {
      for (int shift = 0; shift < 32; shift += 8) {
        bytes.push_back(static_cast<unsigned char>((word >> shift) & 0xffU));
      }
    }
    accessor.bufferView = AddBytes(bytes);
    model_.bufferViews.back().target = target;
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  tinygltf::Model& model_;
};

tinygltf::Material MakeMaterial(const GlbMaterial& material, const std::filesystem::path& path) {
  const auto factor = [&path](double value) {
    return std::clamp(static_cast<double>(StoredFloat(value, path)), 0.0, 1.0);
  };
  tinygltf::Material result;
  result.name = material.name;
  result.doubleSided = material.double_sided;
  result.pbrMetallicRoughness.baseColorFactor = {factor(material.base_color.r),
                                                 factor(material.base_color.g),
                                                 factor(material.base_color.b),
                                                 1.0};
  result.pbrMetallicRoughness.roughnessFactor = factor(material.bsdf.roughness);
  result.pbrMetallicRoughness.metallicFactor = factor(material.bsdf.metallic);
  if (const double specular = factor(material.bsdf.specular); specular != 1.0) {
    result.extensions["KHR_materials_specular"] =
        tinygltf::Value(tinygltf::Value::Object{{"specularFactor", tinygltf::Value(specular)}});
  }
  if (!IsBlack(material.emission)) {
    const double strength = std::max(1.0, MaxChannel(material.emission));
    for (int c = 0; c < 3; ++c) {
      result.emissiveFactor.push_back(factor(material.emission[c] / strength));
    }
    if (strength > 1.0) {
      result.extensions["KHR_materials_emissive_strength"] =
          tinygltf::Value(tinygltf::Value::Object{{"emissiveStrength", tinygltf::Value(strength)}});
    }
  }
  return result;
}

void CheckTexels(const Texture& texture, const std::filesystem::path& path) {
  if (texture.width <= 0 || texture.height <= 0 ||
      texture.texels.size() !=
          static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height)) {
    throw SceneError(path.string() + ": texture '" + texture.name +
                     "' to be written has texels that do not match its size");
  }
}

double Stored01(double value, const std::filesystem::path& path) {
  return std::clamp(static_cast<double>(StoredFloat(value, path)), 0.0, 1.0);
}

Image EncodedColors(const Texture& texture, const std::filesystem::path& path) {
  CheckTexels(texture, path);
  Image image(texture.width, texture.height, 3);
  for (std::size_t i = 0; i < texture.texels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      image.data[3 * i + static_cast<std::size_t>(c)] =
          static_cast<float>(SrgbFromLinear(Stored01(texture.texels[i][c], path)));
    }
  }
  return image;
}

/// Roughness in green and metallic in blue, as large as the larger one; 1 for what there is not.
Texture MetallicRoughness(const GlbMaterial& material, const std::filesystem::path& path) {
  const std::array<const std::optional<Texture>*, 2> parts = {&material.roughness_texture,
                                                              &material.metallic_texture};
  Texture joined;
  for (const auto* part : parts) {
    if (!*part) continue;
    const Texture& texture = **part;
    CheckTexels(texture, path);
    if (joined.name.empty()) {
      // As the reader calls its parts.
      const std::string_view suffix = part == parts[0] ? "-roughness" : "-metallic";
      const bool ends_so = std::string_view(texture.name).ends_with(suffix);
      joined.name = texture.name.substr(0, texture.name.size() - (ends_so ? suffix.size() : 0));
      joined.wrap = texture.wrap;
    }
    joined.width = std::max(joined.width, texture.width);
    joined.height = std::max(joined.height, texture.height);
  }
  joined.texels.clear();
  for (int y = 0; y < joined.height; ++y) {
    for (int x = 0; x < joined.width; ++x) {
      Rgb texel{1.0, 1.0, 1.0};
      for (int c = 1; c < 3; ++c) {
        const std::optional<Texture>& part = *parts.at(static_cast<std::size_t>(c) - 1);
        if (!part) continue;
        const bool same = part->width == joined.width && part->height == joined.height;
        const Vec2 uv = {(x + 0.5) / joined.width, 1.0 - (y + 0.5) / joined.height};
        const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(joined.width) +
                       static_cast<std::size_t>(x);
        texel[c] = (same ? part->texels[i] : TextureValue(*part, uv)).r;
      }
      joined.texels.push_back(texel);
    }
  }
  return joined;
}

Image EncodedNumbers(const Texture& texture, const std::filesystem::path& path) {
  Image image(texture.width, texture.height, 3);
  for (std::size_t i = 0; i < texture.texels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      image.data[3 * i + static_cast<std::size_t>(c)] =
          static_cast<float>(Stored01(std::as_const(texture).texels[i][c], path));
    }
  }
  return image;
}

/// Index of the new texture, whose picture is `encoded`.
int AddTexture(const Texture& texture,
               const Image& encoded,
               BufferBuilder& buffer,
               tinygltf::Model& model) {
  tinygltf::Image image;
  image.name = texture.name;
  image.mimeType = "image/png";
  image.bufferView = buffer.AddBytes(EncodePng(encoded));
  model.images.push_back(std::move(image));
  tinygltf::Sampler sampler;
  sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
  sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
  sampler.wrapS = sampler.wrapT = texture.wrap == TextureWrap::kRepeat
                                      ? TINYGLTF_TEXTURE_WRAP_REPEAT
                                      : TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  model.samplers.push_back(std::move(sampler));
  tinygltf::Texture result;
  result.source = static_cast<int>(model.images.size()) - 1;
  result.sampler = static_cast<int>(model.samplers.size()) - 1;
  model.textures.push_back(std::move(result));
  return static_cast<int>(model.textures.size()) - 1;
}

void AddTextures(const GlbMaterial& material,
                 const Mesh& mesh,
                 const std::filesystem::path& path,
                 BufferBuilder& buffer,
                 tinygltf::Model& model) {
  tinygltf::Material& result = model.materials[0];
  tinygltf::PbrMetallicRoughness& pbr = result.pbrMetallicRoughness;
  const bool has_numbers = material.roughness_texture || material.metallic_texture;
  if ((has_numbers || material.base_color_texture || material.emission_texture ||
       material.normal_texture) &&
      mesh.uv_triangles.empty()) {
    throw SceneError(path.string() + ": a mesh to be written with a texture has no UVs");
  }
  if (material.base_color_texture) {
    pbr.baseColorTexture.index = AddTexture(*material.base_color_texture,
                                            EncodedColors(*material.base_color_texture, path),
                                            buffer,
                                            model);
  }
  if (has_numbers) {
    const Texture joined = MetallicRoughness(material, path);
    if (material.roughness_texture) pbr.roughnessFactor = 1.0;
    if (material.metallic_texture) pbr.metallicFactor = 1.0;
    pbr.metallicRoughnessTexture.index =
        AddTexture(joined, EncodedNumbers(joined, path), buffer, model);
  }
  if (material.normal_texture) {
    CheckTexels(*material.normal_texture, path);
    result.normalTexture.index = AddTexture(
        *material.normal_texture, EncodedNumbers(*material.normal_texture, path), buffer, model);
  }
  if (material.emission_texture) {
    result.emissiveTexture.index = AddTexture(
        *material.emission_texture, EncodedColors(*material.emission_texture, path), buffer, model);
  }
}

/// By split vertex: direction of u, and the side that v is on.
std::vector<float> SplitTangents(const Mesh& mesh,
                                 const SplitMesh& split,
                                 const std::filesystem::path& path) {
  if (mesh.normal_triangles.empty() || mesh.uv_triangles.empty()) {
    throw SceneError(path.string() +
                     ": a mesh to be written with a normal texture has no normals or no UVs");
  }
  const std::vector<std::array<Tangent, 3>> tangents = MakeTangents(mesh);
  std::vector<float> values(4 * split.vertices.size());
  for (std::size_t f = 0; f < tangents.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      float* const first = values.data() + 4 * Index(split.triangles[f][k]);
      for (int c = 0; c < 3; ++c) first[c] = StoredFloat(tangents[f][k].along_u[c], path);
      first[3] = static_cast<float>(tangents[f][k].sign);
    }
  }
  return values;
}

tinygltf::Primitive AddPrimitive(const Mesh& mesh,
                                 bool with_tangents,
                                 const std::filesystem::path& path,
                                 BufferBuilder& buffer) {
  const SplitMesh split = SplitVertices(mesh);
  std::vector<float> positions;
  std::vector<float> normals;
  std::vector<float> uvs;
  std::vector<float> colors;
  for (const SplitVertex& vertex : split.vertices) {
    if (vertex.uv >= 0) {
      const Vec2& uv = mesh.uvs[Index(vertex.uv)];
      uvs.push_back(StoredFloat(uv.x, path));
      uvs.push_back(StoredFloat(1.0 - uv.y, path));
    }
    for (int c = 0; c < 3; ++c) {
      positions.push_back(StoredFloat(mesh.positions[Index(vertex.position)][c], path));
      if (vertex.normal >= 0) {
        normals.push_back(StoredFloat(mesh.normals[Index(vertex.normal)][c], path));
      }
      if (vertex.color < 0) continue;
      colors.push_back(
          std::clamp(StoredFloat(mesh.colors[Index(vertex.color)][c], path), 0.0F, 1.0F));
    }
  }
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = 0;
  primitive.attributes["POSITION"] = buffer.AddPositions(positions);
  // Without normals the format demands flat shading, which is what the mesh has.
  if (!normals.empty()) primitive.attributes["NORMAL"] = buffer.AddVectors(normals, 3);
  if (!uvs.empty()) primitive.attributes["TEXCOORD_0"] = buffer.AddVectors(uvs, 2);
  if (with_tangents) {
    primitive.attributes["TANGENT"] = buffer.AddVectors(SplitTangents(mesh, split, path), 4);
  }
  if (!colors.empty()) primitive.attributes["COLOR_0"] = buffer.AddVectors(colors, 3);
  primitive.indices = buffer.AddIndices(split.triangles);
  return primitive;
}

/// Pictures end at 1, the strength of the emission does not.
GlbMaterial WithDimEmissionTexture(GlbMaterial material) {
  if (!material.emission_texture) return material;
  double brightest = 1.0;
  for (const Rgb& texel : std::as_const(*material.emission_texture).texels) {
    brightest = std::max(brightest, MaxChannel(texel));
  }
  if (brightest == 1.0 || !std::isfinite(brightest)) return material;
  material.emission *= brightest;
  for (Rgb& texel : material.emission_texture->texels) texel *= 1.0 / brightest;
  return material;
}

/// The format demands unit normals.
Mesh WithUnitNormals(Mesh mesh) {
  if (!mesh.normal_triangles.empty()) NormalizeVertexNormals(mesh);
  return mesh;
}

}  // namespace

void WriteGlb(const std::filesystem::path& path,
              const Mesh& mesh,
              const GlbMaterial& given,
              double metres_per_unit) {
  if (mesh.triangles.empty())
    throw SceneError(path.string() + ": a mesh to be written has no triangle");
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "pathfit";
  const GlbMaterial material = WithDimEmissionTexture(given);
  model.materials.push_back(MakeMaterial(material, path));
  for (const auto& [name, value] : model.materials[0].extensions) {
    model.extensionsUsed.push_back(name);
  }
  BufferBuilder buffer(model);
  tinygltf::Mesh gltf_mesh;
  gltf_mesh.name = path.stem().string();
  gltf_mesh.primitives.push_back(
      AddPrimitive(WithUnitNormals(mesh), material.normal_texture.has_value(), path, buffer));
  AddTextures(material, mesh, path, buffer, model);
  model.meshes.push_back(std::move(gltf_mesh));
  tinygltf::Node node;
  node.name = path.stem().string();
  node.mesh = 0;
  if (metres_per_unit > 0.0 && metres_per_unit != 1.0) {
    node.scale.assign(3, metres_per_unit);
    node.extras = tinygltf::Value({{kMetresPerUnit, tinygltf::Value(metres_per_unit)}});
  }
  model.nodes.push_back(std::move(node));
  tinygltf::Scene scene;
  scene.nodes.push_back(0);
  model.scenes.push_back(std::move(scene));
  model.defaultScene = 0;

  std::ostringstream stream;
  try {
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, stream, false, true)) {
      throw IoError("the writer gave up");
    }
  } catch (const std::exception& error) {
    // Such as a material name that is not UTF-8.
    throw IoError(path.string() + ": the glTF scene cannot be encoded: " + error.what());
  }
  WriteFileAtomically(path, stream.str());
}

}  // namespace pathfit::renderer
