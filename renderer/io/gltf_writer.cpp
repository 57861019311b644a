#include "renderer/io/gltf_writer.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <sstream>
#include <utility>
#include <vector>

#include <tiny_gltf.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/split_vertices.h"

namespace pathfit::renderer {
namespace {

std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Unit sums of the face normals weighted by area, one per position.
std::vector<Vec3> SmoothNormals(const Mesh& mesh) {
  std::vector<Vec3> normals(mesh.positions.size());
  std::vector<Vec3> any_face(mesh.positions.size(), Vec3{0.0, 0.0, 1.0});
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3& origin = mesh.positions[Index(a)];
    const Vec3 area = Cross(mesh.positions[Index(b)] - origin, mesh.positions[Index(c)] - origin);
    const double length = Norm(area);
    for (const std::int32_t i : {a, b, c}) {
      normals[Index(i)] += area;
      if (length > 0.0) any_face[Index(i)] = area / length;
    }
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double length = Norm(normals[i]);
    // Opposite faces can cancel; the format demands a unit normal all the same.
    normals[i] = length > 0.0 ? normals[i] / length : any_face[i];
  }
  return normals;
}

/// Collects vertex data in one buffer; all parts are of 4-byte numbers, so that every offset is
/// aligned.
class BufferBuilder {
 public:
  explicit BufferBuilder(tinygltf::Model& model) : model_(model) { model_.buffers.resize(1); }

  /// Index of a new accessor over `values`, three to an element.
  int AddVec3(const std::vector<float>& values, bool with_bounds) {
    tinygltf::Accessor accessor;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.type = TINYGLTF_TYPE_VEC3;
    accessor.count = values.size() / 3;
    if (with_bounds) {
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
    }
    std::vector<std::uint32_t> words;
    words.reserve(values.size());
    for (const float value : values) words.push_back(std::bit_cast<std::uint32_t>(value));
    return Add(words, TINYGLTF_TARGET_ARRAY_BUFFER, std::move(accessor));
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

 private:
  int Add(const std::vector<std::uint32_t>& words, int target, tinygltf::Accessor accessor) {
    std::vector<unsigned char>& bytes = model_.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = words.size() * 4;
    view.target = target;
    for (const std::uint32_t word : words) {
      for (int shift = 0; shift < 32; shift += 8) {
        bytes.push_back(static_cast<unsigned char>((word >> shift) & 0xffU));
      }
    }
    accessor.bufferView = static_cast<int>(model_.bufferViews.size());
    model_.bufferViews.push_back(std::move(view));
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
  result.pbrMetallicRoughness.roughnessFactor = factor(material.roughness);
  result.pbrMetallicRoughness.metallicFactor = factor(material.metallic);
  return result;
}

tinygltf::Primitive AddPrimitive(const Mesh& mesh,
                                 const std::filesystem::path& path,
                                 tinygltf::Model& model) {
  const SplitMesh split = SplitVertices(mesh, {.colors = true});
  const std::vector<Vec3> smooth = SmoothNormals(mesh);
  std::vector<float> positions;
  std::vector<float> normals;
  std::vector<float> colors;
  for (const SplitVertex& vertex : split.vertices) {
    for (int c = 0; c < 3; ++c) {
      positions.push_back(StoredFloat(mesh.positions[Index(vertex.position)][c], path));
      normals.push_back(StoredFloat(smooth[Index(vertex.position)][c], path));
      if (vertex.color < 0) continue;
      colors.push_back(
          std::clamp(StoredFloat(mesh.colors[Index(vertex.color)][c], path), 0.0F, 1.0F));
    }
  }
  BufferBuilder buffer(model);
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = 0;
  primitive.attributes["POSITION"] = buffer.AddVec3(positions, true);
  primitive.attributes["NORMAL"] = buffer.AddVec3(normals, false);
  if (!colors.empty()) primitive.attributes["COLOR_0"] = buffer.AddVec3(colors, false);
  primitive.indices = buffer.AddIndices(split.triangles);
  return primitive;
}

}  // namespace

void WriteGlb(const std::filesystem::path& path, const Mesh& mesh, const GlbMaterial& material) {
  if (mesh.triangles.empty())
    throw SceneError(path.string() + ": a mesh to be written has no triangle");
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "pathfit";
  model.materials.push_back(MakeMaterial(material, path));
  tinygltf::Mesh gltf_mesh;
  gltf_mesh.primitives.push_back(AddPrimitive(mesh, path, model));
  model.meshes.push_back(std::move(gltf_mesh));
  tinygltf::Node node;
  node.mesh = 0;
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
