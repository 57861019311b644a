#include "renderer/io/gltf_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/io/gltf_reader.h"
#include "renderer/io/texture_file.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::gltf_writer_test {
namespace {

std::uint32_t Uint32At(const std::string& bytes, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, 4);
  return value;
}

/// The two chunks of a binary glTF file; checks the container on the way.
struct Glb {
  nlohmann::json json;
  std::string binary;
};

Glb ParseGlb(const std::filesystem::path& path) {
  const std::string bytes = ReadWholeFile(path);
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(Uint32At(bytes, 4), 2U);
  EXPECT_EQ(Uint32At(bytes, 8), bytes.size());
  const std::uint32_t json_size = Uint32At(bytes, 12);
  EXPECT_EQ(json_size % 4, 0U);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  const std::size_t binary_begin = 20 + json_size;
  const std::uint32_t binary_size = Uint32At(bytes, binary_begin);
  EXPECT_EQ(binary_size % 4, 0U);
  EXPECT_EQ(bytes.substr(binary_begin + 4, 4), std::string("BIN\0", 4));
  EXPECT_EQ(binary_begin + 8 + binary_size, bytes.size());
  return {nlohmann::json::parse(bytes.substr(20, json_size)), bytes.substr(binary_begin + 8)};
}

/// Numbers of an accessor; checks what the format demands of views and accessors.
template <class T>
std::vector<T> ReadAccessor(const Glb& glb, int index, int components, int type, int target) {
  const nlohmann::json& accessor = glb.json["accessors"][static_cast<std::size_t>(index)];
  const nlohmann::json& view = glb.json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
  const auto count = accessor["count"].get<std::size_t>();
  const auto offset = view.value("byteOffset", std::size_t{0});
  EXPECT_EQ(accessor["componentType"], type);
  EXPECT_EQ(accessor["type"], components == 3 ? "VEC3" : (components == 2 ? "VEC2" : "SCALAR"));
  EXPECT_EQ(view["target"], target);
  EXPECT_EQ(view["byteLength"], count * static_cast<std::size_t>(components) * 4);
  EXPECT_EQ(offset % 4, 0U);
  EXPECT_LE(offset + view["byteLength"].get<std::size_t>(),
            glb.json["buffers"][0]["byteLength"].get<std::size_t>());
  std::vector<T> values(count * static_cast<std::size_t>(components));
  std::memcpy(values.data(), glb.binary.data() + offset, values.size() * 4);
  return values;
}

std::vector<float> ReadVec3(const Glb& glb, const char* attribute) {
  const int index = glb.json["meshes"][0]["primitives"][0]["attributes"][attribute];
  return ReadAccessor<float>(glb, index, 3, 5126, 34962);
}

TEST(GltfWriter, SpecularIsTheExtensionsFactor) {
  const TemporaryFolder folder;
  for (const double specular : {0.0, 0.25, 0.875}) {
    GlbMaterial material;
    material.bsdf.specular = specular;
    WriteGlb(folder.Path() / "a.glb", MakeIcosphere(1, 0.5), material);
    const Glb glb = ParseGlb(folder.Path() / "a.glb");
    EXPECT_EQ(glb.json["extensionsUsed"], (std::vector<std::string>{"KHR_materials_specular"}));
    const nlohmann::json& extension =
        glb.json["materials"][0]["extensions"]["KHR_materials_specular"];
    EXPECT_EQ(extension, (nlohmann::json{{"specularFactor", specular}}));
  }
}

TEST(GltfWriter, WritesAValidColoredSphere) {
  Mesh mesh = MakeIcosphere(2, 0.5);
  SetUniformVertexColors({0.25, 0.5, 1.5}, mesh);
  ComputeVertexNormals(mesh);
  const TemporaryFolder folder;
  WriteGlb(folder.Path() / "a.glb", mesh, {"glaze", {0.5, 2.0, 1.0}, {0.25, 0.75}, true});
  const Glb glb = ParseGlb(folder.Path() / "a.glb");
  EXPECT_EQ(glb.json["asset"]["version"], "2.0");
  EXPECT_EQ(glb.json["asset"]["generator"], "pathfit");
  EXPECT_EQ(glb.json["scenes"][0]["nodes"][0], 0);
  EXPECT_EQ(glb.json["nodes"][0]["mesh"], 0);
  EXPECT_FALSE(glb.json["buffers"][0].contains("uri"));
  const nlohmann::json& material = glb.json["materials"][0];
  const nlohmann::json& pbr = material["pbrMetallicRoughness"];
  EXPECT_EQ(material["name"], "glaze");
  EXPECT_EQ(material["doubleSided"], true);
  EXPECT_EQ(pbr["baseColorFactor"], (std::vector<double>{0.5, 1.0, 1.0, 1.0}));
  EXPECT_EQ(pbr["roughnessFactor"], 0.25);
  EXPECT_EQ(pbr["metallicFactor"], 0.75);
  EXPECT_FALSE(material.contains("extensions"));
  EXPECT_FALSE(glb.json.contains("extensionsUsed"));

  const std::vector<float> positions = ReadVec3(glb, "POSITION");
  const std::vector<float> normals = ReadVec3(glb, "NORMAL");
  const std::vector<float> colors = ReadVec3(glb, "COLOR_0");
  ASSERT_EQ(positions.size(), 3 * mesh.positions.size());
  ASSERT_EQ(normals.size(), positions.size());
  ASSERT_EQ(colors.size(), positions.size());
  std::vector<float> low(3, 1e9F);
  std::vector<float> high(3, -1e9F);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
    // The sphere's normals point along its positions, but for facets of unequal areas.
    EXPECT_NEAR(normals[i], 2.0F * positions[i], 0.03F);
  }
  for (std::size_t i = 0; i < normals.size(); i += 3) {
    EXPECT_NEAR(std::hypot(normals[i], normals[i + 1], normals[i + 2]), 1.0F, 1e-6F);
    EXPECT_EQ(std::vector<float>(&colors[i], &colors[i] + 3), (std::vector<float>{.25F, .5F, 1}));
  }
  const nlohmann::json& primitive = glb.json["meshes"][0]["primitives"][0];
  const std::size_t position_accessor = primitive["attributes"]["POSITION"];
  // Bounds must equal the stored floats exactly.
  EXPECT_EQ(glb.json["accessors"][position_accessor]["min"].get<std::vector<float>>(), low);
  EXPECT_EQ(glb.json["accessors"][position_accessor]["max"].get<std::vector<float>>(), high);
  EXPECT_EQ(primitive.value("mode", 4), 4);
  const auto indices = ReadAccessor<std::uint32_t>(glb, primitive["indices"], 1, 5125, 34963);
  ASSERT_EQ(indices.size(), 3 * mesh.triangles.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    EXPECT_EQ(indices[i], static_cast<std::uint32_t>(mesh.triangles[i / 3][i % 3]));
  }
}

TEST(GltfWriter, SplitsVerticesAtColorSeamsOnly) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const TemporaryFolder folder;
  WriteGlb(folder.Path() / "a.glb", mesh, {});
  const Glb plain = ParseGlb(folder.Path() / "a.glb");
  EXPECT_EQ(ReadVec3(plain, "POSITION").size(), 12U);
  EXPECT_FALSE(plain.json["meshes"][0]["primitives"][0]["attributes"].contains("COLOR_0"));
  mesh.colors = {{1, 0, 0}, {0, 1, 0}};
  mesh.color_triangles = {{0, 0, 0}, {1, 1, 1}};
  WriteGlb(folder.Path() / "a.glb", mesh, {});
  const Glb seam = ParseGlb(folder.Path() / "a.glb");
  EXPECT_EQ(ReadVec3(seam, "POSITION").size(), 18U);
  EXPECT_EQ(ReadVec3(seam, "COLOR_0").size(), 18U);
}

TEST(GltfWriter, MetresAreTheScaleOfTheNodeWhichTheReaderLeavesOut) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "ball.glb";
  const Mesh mesh = MakeIcosphere(1, 3.0);
  constexpr double kUnit = 0.0436067573690995;
  WriteGlb(path, mesh, {}, kUnit);
  const nlohmann::json node = ParseGlb(path).json["nodes"][0];
  EXPECT_EQ(node["scale"], (std::vector<double>(3, kUnit)));
  EXPECT_EQ(node["extras"]["metres_per_unit"], kUnit);
  const Scene scaled = ReadGltf(path).scene;
  WriteGlb(path, mesh, {});
  EXPECT_FALSE(ParseGlb(path).json["nodes"][0].contains("scale"));
  const Scene plain = ReadGltf(path).scene;
  EXPECT_EQ(scaled.meshes.at(0).mesh.positions, plain.meshes.at(0).mesh.positions);
  // A scale that another program gave it counts.
  std::string text = R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0, "scale": [2, 2, 2],
    "extras": {"metres_per_unit": 0.5}}], "scenes": [{"nodes": [0]}], "meshes": [{"primitives":
    [{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0, "componentType": 5126,
    "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}], "bufferViews": [{"buffer": 0,
    "byteLength": 36}], "buffers": [{"byteLength": 36, "uri":
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
  EXPECT_EQ(ReadGltf(folder.Write("other.gltf", text)).scene.meshes.at(0).mesh.positions.at(1).x,
            2);
}

TEST(GltfWriter, AFlatShadedMeshHasNoNormals) {
  const TemporaryFolder folder;
  WriteGlb(folder.Path() / "a.glb", MakeIcosphere(1, 0.5), {});
  const Glb glb = ParseGlb(folder.Path() / "a.glb");
  EXPECT_FALSE(glb.json["meshes"][0]["primitives"][0]["attributes"].contains("NORMAL"))
      << "the format demands flat shading without, and smooth normals would look otherwise";
}

TEST(GltfWriter, KeepsTheMeshesOwnNormalsAsUnitVectors) {
  Mesh mesh = MakeCube();
  mesh.normals = {{0, 0, -2}, {0, 0, 1}, {0, -1, 0}, {0, 3, 0}, {-1, 0, 0}, {1, 0, 0}};
  for (std::int32_t face = 0; face < 6; ++face) {
    for (int i = 0; i < 2; ++i) mesh.normal_triangles.push_back({face, face, face});
  }
  const TemporaryFolder folder;
  WriteGlb(folder.Path() / "a.glb", mesh, {});
  const Glb glb = ParseGlb(folder.Path() / "a.glb");
  const std::vector<float> positions = ReadVec3(glb, "POSITION");
  const std::vector<float> normals = ReadVec3(glb, "NORMAL");
  // Three flat faces meet in each of the eight corners.
  ASSERT_EQ(positions.size(), 72U);
  for (std::size_t i = 0; i < positions.size(); i += 3) {
    float along = 0.0F;
    for (std::size_t c = 0; c < 3; ++c) along += positions[i + c] * normals[i + c];
    EXPECT_EQ(along, 1.0F);
  }
}

TEST(GltfWriter, EmbedsTheTextureWithVRunningDown) {
  const Mesh mesh = MakeRectangle();
  GlbMaterial material;
  Texture texture;
  texture.name = "stripes";
  texture.width = 1;
  texture.height = 3;
  texture.texels = {{0.0, 0.5, 2.0}, {1.0, 0.25, 0.75}, {0.2, 0.4, 0.6}};
  texture.wrap = TextureWrap::kClamp;
  material.base_color_texture = texture;
  const TemporaryFolder folder;
  WriteGlb(folder.Path() / "a.glb", mesh, material);
  const Glb glb = ParseGlb(folder.Path() / "a.glb");
  const int index = glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"];
  const std::vector<float> uvs = ReadAccessor<float>(glb, index, 2, 5126, 34962);
  const std::vector<float> positions = ReadVec3(glb, "POSITION");
  ASSERT_EQ(uvs.size(), 8U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(uvs[2 * i], 0.5F + 0.5F * positions[3 * i]);
    EXPECT_EQ(uvs[2 * i + 1], 0.5F - 0.5F * positions[3 * i + 1]);
  }
  EXPECT_EQ(glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
  EXPECT_EQ(glb.json["textures"][0]["source"], 0);
  EXPECT_EQ(glb.json["samplers"][0]["wrapS"], 33071);
  EXPECT_EQ(glb.json["samplers"][0]["magFilter"], 9729);
  const nlohmann::json& image = glb.json["images"][0];
  EXPECT_EQ(image["mimeType"], "image/png");
  EXPECT_FALSE(image.contains("uri"));
  const nlohmann::json& view = glb.json["bufferViews"][image["bufferView"].get<std::size_t>()];
  EXPECT_FALSE(view.contains("target"));
  const std::string png = glb.binary.substr(view["byteOffset"], view["byteLength"]);
  const Texture back = ReadTexture(folder.Write("a.png", png), TextureRole::kColor);
  ASSERT_EQ(back.texels.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    for (int c = 0; c < 3; ++c) {
      // Half a step of the encoding, whose slope is at most 2.28.
      EXPECT_NEAR(back.texels[i][c], std::min(texture.texels[i][c], 1.0), 2.28 * 0.5 / 255.0);
    }
  }
  material.base_color_texture->texels.pop_back();
  EXPECT_THROW(WriteGlb(folder.Path() / "b.glb", mesh, material), SceneError);
  material.base_color_texture = texture;
  EXPECT_THROW(WriteGlb(folder.Path() / "b.glb", MakeCube(), material), SceneError);
}

TEST(GltfWriter, RefusesWhatItCannotStore) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.glb";
  EXPECT_THROW(WriteGlb(path, Mesh(), {}), SceneError);
  Mesh mesh = MakeIcosphere(0, 1.0);
  EXPECT_THROW(WriteGlb(path, mesh, {"m", {std::nan(""), 1, 1}}), IoError);
  EXPECT_THROW(WriteGlb(path, mesh, {"not utf-8: \xff"}), IoError);
  mesh.positions[0].y = 1e200;
  EXPECT_THROW(WriteGlb(path, mesh, {}), IoError);
  mesh.triangles[0][0] = 99;
  EXPECT_THROW(WriteGlb(path, mesh, {}), SceneError);
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace pathfit::renderer::gltf_writer_test
