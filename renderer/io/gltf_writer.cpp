#include "renderer/io/gltf_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
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

/// Materials and what they show, each picture once.
class MaterialWriter {
 public:
  MaterialWriter(const std::filesystem::path& path, BufferBuilder& buffer, tinygltf::Model& model)
      : path_(path), buffer_(buffer), model_(model) {}

  void Add(const GlbMaterial& material) {
    tinygltf::Material result = MakeMaterial(material, path_);
    for (const auto& [name, value] : result.extensions) {
      if (std::ranges::find(model_.extensionsUsed, name) == model_.extensionsUsed.end()) {
        model_.extensionsUsed.push_back(name);
      }
    }
    tinygltf::PbrMetallicRoughness& pbr = result.pbrMetallicRoughness;
    if (material.base_color_texture) {
      pbr.baseColorTexture.index = AddColors(*material.base_color_texture);
    }
    if (material.roughness_texture || material.metallic_texture) {
      if (material.roughness_texture) pbr.roughnessFactor = 1.0;
      if (material.metallic_texture) pbr.metallicFactor = 1.0;
      pbr.metallicRoughnessTexture.index =
          AddOnce({2, OneOf(material.roughness_texture), OneOf(material.metallic_texture)}, [&] {
            const Texture joined = MetallicRoughness(material, path_);
            return AddTexture(joined, EncodedNumbers(joined, path_));
          });
    }
    if (const std::optional<Texture>& normals = material.normal_texture) {
      result.normalTexture.index = AddOnce({1, OneOf(*normals), {}}, [&] {
        CheckTexels(*normals, path_);
        return AddTexture(*normals, EncodedNumbers(*normals, path_));
      });
      result.normalTexture.scale = static_cast<double>(StoredFloat(material.normal_scale, path_));
    }
    if (material.emission_texture) {
      result.emissiveTexture.index = AddColors(*material.emission_texture);
    }
    model_.materials.push_back(std::move(result));
  }

 private:
  /// Of one or two textures by name, texels and wrap, and how they are encoded.
  using One = std::tuple<std::string, const Rgb*, TextureWrap>;
  using Key = std::tuple<int, One, One>;
  static One OneOf(const Texture& texture) {
    return {texture.name, std::as_const(texture.texels).data(), texture.wrap};
  }
  static One OneOf(const std::optional<Texture>& texture) {
    return texture ? OneOf(*texture) : One();
  }

  template <class Make>
  int AddOnce(const Key& key, const Make& make) {
    const auto known = known_.find(key);
    return known != known_.end() ? known->second : known_[key] = make();
  }

  int AddColors(const Texture& texture) {
    return AddOnce({0, OneOf(texture), {}},
                   [&] { return AddTexture(texture, EncodedColors(texture, path_)); });
  }

  /// Index of the new texture, whose picture is `encoded`.
  int AddTexture(const Texture& texture, const Image& encoded) {
    tinygltf::Image image;
    image.name = texture.name;
    image.mimeType = "image/png";
    image.bufferView = buffer_.AddBytes(EncodePng(encoded));
    model_.images.push_back(std::move(image));
    tinygltf::Sampler sampler;
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.wrapS = sampler.wrapT = texture.wrap == TextureWrap::kRepeat
                                        ? TINYGLTF_TEXTURE_WRAP_REPEAT
                                        : TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    model_.samplers.push_back(std::move(sampler));
    tinygltf::Texture result;
    result.source = static_cast<int>(model_.images.size()) - 1;
    result.sampler = static_cast<int>(model_.samplers.size()) - 1;
    model_.textures.push_back(std::move(result));
    return static_cast<int>(model_.textures.size()) - 1;
  }

  const std::filesystem::path& path_;
  BufferBuilder& buffer_;
  tinygltf::Model& model_;
  std::map<Key, int> known_;
};

bool HasTextures(const GlbMaterial& material) {
  return material.base_color_texture || material.roughness_texture || material.metallic_texture ||
         material.normal_texture || material.emission_texture;
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
              const std::vector<GlbMesh>& meshes,
              const std::vector<GlbMaterial>& given,
              double metres_per_unit) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "pathfit";
  std::vector<GlbMaterial> materials;
  for (const GlbMaterial& material : given) materials.push_back(WithDimEmissionTexture(material));
  BufferBuilder buffer(model);
  tinygltf::Scene scene;
  for (const GlbMesh& item : meshes) {
    const GlbMaterial& material = materials.at(item.material);
    if (item.mesh.triangles.empty()) {
      throw SceneError(path.string() + ": a mesh to be written has no triangle");
    }
    if (HasTextures(material) && item.mesh.uv_triangles.empty()) {
      throw SceneError(path.string() + ": a mesh to be written with a texture has no UVs");
    }
    tinygltf::Mesh mesh;
    mesh.name = item.name;
    mesh.primitives.push_back(AddPrimitive(
        WithUnitNormals(item.mesh), material.normal_texture.has_value(), path, buffer));
    mesh.primitives.back().material = static_cast<int>(item.material);
    tinygltf::Node node;
    node.name = item.name;
    node.mesh = static_cast<int>(model.meshes.size());
    if (metres_per_unit > 0.0 && metres_per_unit != 1.0) {
      node.scale.assign(3, metres_per_unit);
      node.extras = tinygltf::Value({{kMetresPerUnit, tinygltf::Value(metres_per_unit)}});
    }
    model.meshes.push_back(std::move(mesh));
    scene.nodes.push_back(static_cast<int>(model.nodes.size()));
    model.nodes.push_back(std::move(node));
  }
  MaterialWriter writer(path, buffer, model);
  for (const GlbMaterial& material : materials) writer.Add(material);
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

void WriteGlb(const std::filesystem::path& path,
              const Mesh& mesh,
              const GlbMaterial& material,
              double metres_per_unit) {
  WriteGlb(path, {{path.stem().string(), mesh, 0}}, {material}, metres_per_unit);
}

}  // namespace pathfit::renderer
