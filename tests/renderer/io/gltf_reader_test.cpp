#include "renderer/io/gltf_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/image/color.h"
#include "renderer/io/gltf_writer.h"
#include "renderer/io/image_file.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::gltf_reader_test {
namespace {

using Json = nlohmann::json;
using namespace std::string_literals;

void AppendUint32(std::uint32_t value, std::string& bytes) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((value >> shift) & 0xffU);
}

std::string Padded(std::string bytes, char with) {
  bytes.resize((bytes.size() + 3) / 4 * 4, with);
  return bytes;
}

std::string Container(const std::string& json, const std::string& binary) {
  const std::string text = Padded(json, ' ');
  const std::string data = Padded(binary, '\0');
  std::string bytes = "glTF";
  AppendUint32(2, bytes);
  AppendUint32(static_cast<std::uint32_t>(28 + text.size() + data.size()), bytes);
  AppendUint32(static_cast<std::uint32_t>(text.size()), bytes);
  bytes += "JSON" + text;
  AppendUint32(static_cast<std::uint32_t>(data.size()), bytes);
  return bytes + "BIN\0"s + data;
}

template <class T>
std::string BytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <class T>
constexpr int kComponentType = std::is_same_v<T, std::int8_t>     ? 5120
                               : std::is_same_v<T, std::uint8_t>  ? 5121
                               : std::is_same_v<T, std::int16_t>  ? 5122
                               : std::is_same_v<T, std::uint16_t> ? 5123
                               : std::is_same_v<T, std::uint32_t> ? 5125
                                                                  : 5126;

/// A file in the making: one node with one mesh of one primitive, a square in the plane z = 0.
class GltfMaker {
 public:
  GltfMaker() {
    json = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
      "nodes": [{"mesh": 0, "name": "plate"}], "meshes": [{"primitives": [{"attributes": {}}]}],
      "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}]})");
    Primitive()["attributes"]["POSITION"] =
        Add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
    Primitive()["indices"] = Add<std::uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
  }

  Json& Primitive() { return json["meshes"][0]["primitives"][0]; }

  int AddView(const std::string& bytes) {
    binary = Padded(binary, '\0');
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
    binary += bytes;
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }

  /// Index of a new accessor.
  template <class T>
  int Add(const std::vector<T>& values, const std::string& type, bool normalized = false) {
    const std::size_t components = type == "SCALAR" ? 1 : static_cast<std::size_t>(type[3] - '0');
    json["accessors"].push_back({{"bufferView", AddView(BytesOf(values))},
                                 {"componentType", kComponentType<T>},
                                 {"count", values.size() / components},
                                 {"type", type}});
    if (normalized) json["accessors"].back()["normalized"] = true;
    return static_cast<int>(json["accessors"].size()) - 1;
  }

  void AddUvs() {
    Primitive()["attributes"]["TEXCOORD_0"] = Add<float>({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2");
  }

  /// Index of a new texture of these 8-bit pixels, in rows of two.
  int AddTexture(const std::vector<Rgb>& pixels, Json sampler = Json::object()) {
    Image image(2, static_cast<int>(pixels.size()) / 2, 3);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        image.data[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(pixels[i][c] / 255.0);
      }
    }
    const std::vector<unsigned char> png = EncodePng(image);
    const auto count = json["textures"].size();
    json["images"].push_back({{"bufferView", AddView(BytesOf(png))},
                              {"mimeType", "image/png"},
                              {"name", "picture" + std::to_string(count)}});
    json["samplers"].push_back(std::move(sampler));
    json["textures"].push_back({{"source", count}, {"sampler", count}});
    return static_cast<int>(count);
  }

  /// The one material, used by the one primitive.
  Json& Material() {
    Primitive()["material"] = 0;
    if (!json.contains("materials")) json["materials"] = Json::array({{{"name", "skin"}}});
    return json["materials"][0];
  }

  [[nodiscard]] std::string Glb() {
    json["buffers"][0]["byteLength"] = binary.size();
    return Container(json.dump(), binary);
  }

  SceneFile Read() {
    const TemporaryFolder folder;
    return ReadGltf(folder.Write("a.glb", Glb()));
  }

  std::string Problem() {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder.Write("a.glb", Glb());
    return IoErrorOf([&] { ReadGltf(path); });
  }

  Json json;
  std::string binary;
};

void ExpectNear(const Vec3& a, const Vec3& b, double tolerance = 1e-7) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance);
}

/// Corners of all triangles, whatever the order of the vertices.
std::vector<Vec3> Corners(const Mesh& mesh) {
  std::vector<Vec3> corners;
  for (const Triangle& t : mesh.triangles) {
    for (const std::int32_t i : t) corners.push_back(mesh.positions[static_cast<std::size_t>(i)]);
  }
  return corners;
}

bool Mentions(const std::vector<std::string>& texts, const std::string& part) {
  return std::ranges::any_of(
      texts, [&](const std::string& text) { return text.find(part) != std::string::npos; });
}

/// Texels from 8-bit numbers.
Texture MakeTexture(const std::string& name, bool scalar, int width, int height) {
  Texture texture;
  texture.name = name;
  texture.width = width;
  texture.height = height;
  texture.scalar = scalar;
  texture.wrap = TextureWrap::kClamp;
  texture.texels.clear();
  for (int i = 0; i < width * height; ++i) {
    const double value = (40 + 13 * i % 200) / 255.0;
    texture.texels.push_back(scalar ? Rgb::Constant(value)
                                    : Rgb{LinearFromSrgb(value), LinearFromSrgb(0.2), 0.0});
  }
  return texture;
}

TEST(GltfReader, ReadsBackWhatIsWritten) {
  Mesh mesh = MakeCube();
  SetBoxUvs(mesh);
  GlbMaterial material;
  material.name = "glaze 1.0";
  material.bsdf.specular = 0.5;
  material.double_sided = true;
  material.base_color_texture = MakeTexture("colours", false, 5, 4);
  material.roughness_texture = MakeTexture("numbers-roughness", true, 3, 2);
  material.metallic_texture = MakeTexture("numbers-metallic", true, 3, 2);
  material.emission = {0.5, 2.0, 4.0};
  material.emission_texture = MakeTexture("glow", false, 2, 2);
  const TemporaryFolder folder;
  WriteGlb(folder.Path() / "bowl.glb", mesh, material);
  const SceneFile file = ReadGltf(folder.Path() / "bowl.glb");
  EXPECT_TRUE(file.warnings.empty()) << file.warnings.front();
  EXPECT_EQ(file.files.size(), 1U);

  const Scene& scene = file.scene;
  ASSERT_EQ(scene.meshes.size(), 1U);
  EXPECT_EQ(scene.meshes[0].name, "bowl");
  const Mesh& read = scene.meshes[0].mesh;
  EXPECT_EQ(Corners(read), Corners(mesh));
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 a = read.uvs[static_cast<std::size_t>(read.uv_triangles[f][k])];
      const Vec2 b = mesh.uvs[static_cast<std::size_t>(mesh.uv_triangles[f][k])];
      EXPECT_NEAR(a.x, b.x, 1e-7);
      EXPECT_NEAR(a.y, b.y, 1e-7);
    }
  }
  EXPECT_NO_THROW(ValidateMesh(read, "read"));
  ASSERT_EQ(scene.materials.size(), 1U);
  const Material& got = scene.materials[0];
  EXPECT_EQ(got.name, "glaze 1.0");
  EXPECT_TRUE(got.two_sided);
  EXPECT_EQ(std::get<MetallicRoughnessBsdf>(got.bsdf).specular, 0.5);
  const auto expect_texture = [&](int index, const Texture& expected) {
    ASSERT_GE(index, 0);
    const Texture& texture = scene.textures.at(static_cast<std::size_t>(index));
    EXPECT_EQ(texture.name, expected.name);
    EXPECT_EQ(texture.width, expected.width);
    EXPECT_EQ(texture.height, expected.height);
    EXPECT_EQ(texture.wrap, expected.wrap);
    EXPECT_EQ(texture.scalar, expected.scalar);
    ASSERT_EQ(texture.texels.size(), expected.texels.size());
    for (std::size_t i = 0; i < texture.texels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(texture.texels[i][c], expected.texels[i][c], 1e-6) << texture.name << " " << i;
      }
    }
  };
  expect_texture(got.base_color_texture, *material.base_color_texture);
  expect_texture(got.roughness_texture, *material.roughness_texture);
  expect_texture(got.metallic_texture, *material.metallic_texture);
  ASSERT_EQ(scene.emitters.size(), 1U);
  EXPECT_EQ(scene.emitters[0].name, "bowl-emission");
  const auto& light = std::get<AreaEmitter>(scene.emitters[0].light);
  EXPECT_EQ(light.intensity, material.emission);
  EXPECT_TRUE(light.two_sided);
  expect_texture(light.texture, *material.emission_texture);
}

TEST(GltfReader, ReadsBackVertexColoursAndConstants) {
  Mesh mesh = MakeIcosphere(1, 0.5);
  SetUniformVertexColors({0.25, 0.5, 0.75}, mesh);
  const TemporaryFolder folder;
  WriteGlb(folder.Path() / "a.glb", mesh, {"glaze", {0.5, 1.0, 1.0}, {0.25, 0.75}});
  const SceneFile file = ReadGltf(folder.Path() / "a.glb");
  const Material& material = file.scene.materials.at(0);
  EXPECT_TRUE(material.vertex_colors);
  EXPECT_FALSE(material.two_sided);
  EXPECT_EQ(std::get<MetallicRoughnessBsdf>(material.bsdf), (MetallicRoughnessBsdf{0.25, 0.75}));
  const Mesh& read = file.scene.meshes.at(0).mesh;
  EXPECT_EQ(read.positions.size(), mesh.positions.size());
  for (const Rgb& color : read.colors) EXPECT_EQ(color, (Rgb{0.125, 0.5, 0.75}));
}

TEST(GltfReader, NodesTurnScaleAndMoveWhatIsBelow) {
  GltfMaker maker;
  const double half = std::sqrt(0.5);
  maker.json["nodes"] = Json::parse(R"([{"children": [1], "translation": [10, 0, 0]},
      {"children": [2], "matrix": [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,5,0,1]},
      {"mesh": 0, "name": "plate", "scale": [3, 1, 1]}])");
  maker.json["nodes"][2]["rotation"] = {0.0, 0.0, half, half};  // x to y
  const SceneFile file = maker.Read();
  const Mesh& mesh = file.scene.meshes.at(0).mesh;
  EXPECT_EQ(file.scene.meshes[0].name, "plate");
  ExpectNear(Corners(mesh)[0], {10, 5, 0});
  ExpectNear(Corners(mesh)[1], {10, 11, 0});
  ExpectNear(Corners(mesh)[2], {8, 11, 0});
}

TEST(GltfReader, AMirroredNodeKeepsItsOutside) {
  GltfMaker maker;
  maker.Primitive()["attributes"]["NORMAL"] =
      maker.Add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  maker.json["nodes"][0]["scale"] = {1, -1, 1};
  const SceneFile file = maker.Read();
  const Mesh& mesh = file.scene.meshes.at(0).mesh;
  const std::vector<Vec3> corners = Corners(mesh);
  EXPECT_GT(Cross(corners[1] - corners[0], corners[2] - corners[0]).z, 0.0);
  for (const Vec3& normal : mesh.normals) ExpectNear(normal, {0, 0, 1});
}

TEST(GltfReader, TrianglesComeFromListsStripsAndFansOfAnyIndex) {
  const std::vector<Vec3> expected = Corners(GltfMaker().Read().scene.meshes.at(0).mesh);
  const auto corners_of = [](int mode, auto indices) {
    GltfMaker maker;
    maker.Primitive()["mode"] = mode;
    maker.Primitive()["indices"] = maker.Add(indices, "SCALAR");
    return Corners(maker.Read().scene.meshes.at(0).mesh);
  };
  EXPECT_EQ(corners_of(4, std::vector<std::uint8_t>{0, 1, 2, 0, 2, 3}), expected);
  EXPECT_EQ(corners_of(4, std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}), expected);
  EXPECT_EQ(corners_of(6, std::vector<std::uint16_t>{0, 1, 2, 3}), expected);
  // 1 2 0, then 2 0 3 turned; the repeated corner at the end only turns the strip.
  EXPECT_EQ(corners_of(5, std::vector<std::uint16_t>{1, 2, 0, 3, 3}),
            (std::vector<Vec3>{{1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}}));
  GltfMaker plain;
  plain.Primitive().erase("indices");
  plain.Primitive()["attributes"]["POSITION"] =
      plain.Add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
  EXPECT_EQ(Corners(plain.Read().scene.meshes.at(0).mesh), expected);
  EXPECT_EQ(plain.Read().scene.meshes.at(0).mesh.positions.size(), 4U);  // welded
}

TEST(GltfReader, NumbersMayBeNormalisedInterleavedAndSparse) {
  GltfMaker maker;
  // Positions and UVs of each vertex side by side: 3 floats, 2 shorts.
  std::string bytes;
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 9, 0};
  const std::vector<std::uint16_t> uvs = {0, 65535, 65535, 65535, 65535, 0, 0, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    bytes += BytesOf(std::vector<float>(&positions[3 * i], &positions[3 * i] + 3));
    bytes += BytesOf(std::vector<std::uint16_t>(&uvs[2 * i], &uvs[2 * i] + 2));
  }
  const int view = maker.AddView(bytes);
  maker.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 16;
  const auto add = [&](Json accessor) {
    maker.json["accessors"].push_back(std::move(accessor));
    return maker.json["accessors"].size() - 1;
  };
  const int indices = maker.AddView(BytesOf(std::vector<std::uint8_t>{3}));
  const int values = maker.AddView(BytesOf(std::vector<float>{0, 1, 0}));
  Json& attributes = maker.Primitive()["attributes"];
  attributes["POSITION"] = add({{"bufferView", view},
                                {"componentType", 5126},
                                {"count", 4},
                                {"type", "VEC3"},
                                {"sparse",
                                 {{"count", 1},
                                  {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                  {"values", {{"bufferView", values}}}}}});
  attributes["TEXCOORD_0"] = add({{"bufferView", view},
                                  {"byteOffset", 12},
                                  {"componentType", 5123},
                                  {"normalized", true},
                                  {"count", 4},
                                  {"type", "VEC2"}});
  attributes["NORMAL"] = maker.Add<std::int8_t>(
      {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, "VEC4", true);
  maker.json["accessors"].back()["type"] = "VEC3";
  maker.json["bufferViews"].back()["byteStride"] = 4;
  const SceneFile file = maker.Read();
  const Mesh& mesh = file.scene.meshes.at(0).mesh;
  EXPECT_EQ(Corners(mesh), Corners(GltfMaker().Read().scene.meshes.at(0).mesh));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(mesh.uvs[i], (Vec2{mesh.positions[i].x, mesh.positions[i].y}));  // v is turned
    EXPECT_EQ(mesh.normals[i], (Vec3{0, 0, 1}));
  }
}

TEST(GltfReader, FactorsAreMultipliedIntoTextures) {
  GltfMaker maker;
  maker.AddUvs();
  const int colors = maker.AddTexture({{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {188, 188, 188}});
  const int numbers = maker.AddTexture({{9, 255, 0}, {9, 128, 255}, {9, 51, 51}, {9, 15, 102}});
  maker.Material()["pbrMetallicRoughness"] = {{"baseColorFactor", {0.5, 0.25, 1.0, 0.5}},
                                              {"baseColorTexture", {{"index", colors}}},
                                              {"roughnessFactor", 0.5},
                                              {"metallicFactor", 0.5},
                                              {"metallicRoughnessTexture", {{"index", numbers}}}};
  const SceneFile file = maker.Read();
  const Material& material = file.scene.materials.at(0);
  const auto texel = [&](int texture, std::size_t i) {
    return file.scene.textures.at(static_cast<std::size_t>(texture)).texels[i];
  };
  ExpectNear({texel(material.base_color_texture, 0).r, 0, 0}, {0.5, 0, 0});
  ExpectNear({texel(material.base_color_texture, 1).g, 0, 0}, {0.25, 0, 0});
  EXPECT_NEAR(texel(material.base_color_texture, 3).b, LinearFromSrgb(188 / 255.0), 1e-6);
  const std::vector<double> roughness = {0.5, 64 / 255.0, 0.1, kMinRoughness};
  const std::vector<double> metallic = {0.0, 0.5, 0.1, 0.2};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(texel(material.roughness_texture, i).r, roughness[i], 1e-7);
    EXPECT_NEAR(texel(material.metallic_texture, i).r, metallic[i], 1e-7);
  }
  EXPECT_EQ(file.scene.textures.at(0).name, "picture0");
  EXPECT_EQ(file.scene.textures.at(1).name, "picture1-roughness");
  EXPECT_EQ(file.scene.textures.at(2).name, "picture1-metallic");
  // 15/255 x 0.5 is just below 0.03.
  EXPECT_TRUE(Mentions(file.warnings,
                       "material 0 'skin': 1 of 4 texels of metallicRoughnessTexture are smoother "
                       "than the least roughness, 0.03; they have that"))
      << file.warnings.size();
}

TEST(GltfReader, AConstantRoughnessBelowTheLeastIsNamed) {
  GltfMaker maker;
  maker.Material()["pbrMetallicRoughness"] = {{"roughnessFactor", 0.02}};
  const SceneFile file = maker.Read();
  EXPECT_EQ(std::get<MetallicRoughnessBsdf>(file.scene.materials.at(0).bsdf).roughness,
            kMinRoughness);
  EXPECT_TRUE(Mentions(file.warnings, "material 0 'skin': its roughness 0.02"));
}

TEST(GltfReader, TexturesAreShiftedScaledAndTurned) {
  GltfMaker maker;
  maker.AddUvs();
  const int texture = maker.AddTexture({{1, 2, 3}, {4, 5, 6}});
  const Json transform = {
      {"offset", {0.25, 0.5}}, {"scale", {2.0, 4.0}}, {"rotation", 0.5 * std::numbers::pi}};
  maker.Material()["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index", texture}, {"extensions", {{"KHR_texture_transform", transform}}}};
  maker.json["extensionsRequired"] = {"KHR_texture_transform"};
  const SceneFile file = maker.Read();
  EXPECT_TRUE(file.warnings.empty());
  const Mesh& mesh = file.scene.meshes.at(0).mesh;
  // Counter-clockwise as seen in the picture, whose v runs down: (u, v) to (v, -u).
  const std::vector<Vec2> of_file = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(mesh.uvs[i].x, 4.0 * of_file[i].y + 0.25, 1e-12);
    EXPECT_NEAR(mesh.uvs[i].y, 1.0 - (-2.0 * of_file[i].x + 0.5), 1e-12);
  }
}

TEST(GltfReader, SamplersSayWhatIsBesideThePicture) {
  const auto wrap_of = [](Json sampler, const std::vector<float>& uvs, std::string* warning) {
    GltfMaker maker;
    maker.Primitive()["attributes"]["TEXCOORD_0"] = maker.Add<float>(uvs, "VEC2");
    const int texture = maker.AddTexture({{1, 2, 3}, {4, 5, 6}}, std::move(sampler));
    maker.Material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", texture}};
    const SceneFile file = maker.Read();
    if (warning != nullptr) *warning = file.warnings.empty() ? "" : file.warnings.front();
    return file.scene.textures.at(0).wrap;
  };
  const std::vector<float> inside = {0, 1, 1, 1, 1, 0, 0, 0};
  const std::vector<float> wide = {0, 1, 3, 1, 3, 0, 0, 0};
  const std::vector<float> all = {0, 3, 3, 3, 3, 0, 0, 0};
  std::string warning;
  EXPECT_EQ(wrap_of(Json::object(), inside, nullptr), TextureWrap::kRepeat);
  EXPECT_EQ(wrap_of({{"wrapS", 33071}, {"wrapT", 33071}}, inside, nullptr), TextureWrap::kClamp);
  EXPECT_EQ(wrap_of({{"wrapS", 33648}, {"wrapT", 33648}}, inside, &warning), TextureWrap::kClamp);
  EXPECT_EQ(warning, "");
  EXPECT_EQ(wrap_of({{"wrapS", 33648}, {"wrapT", 33648}}, wide, &warning), TextureWrap::kRepeat);
  EXPECT_NE(warning.find("MIRRORED_REPEAT"), std::string::npos);
  EXPECT_EQ(wrap_of({{"wrapS", 10497}, {"wrapT", 33071}}, wide, &warning), TextureWrap::kRepeat);
  EXPECT_EQ(warning, "");
  EXPECT_EQ(wrap_of({{"wrapS", 33071}, {"wrapT", 10497}}, wide, nullptr), TextureWrap::kClamp);
  EXPECT_EQ(wrap_of({{"wrapS", 10497}, {"wrapT", 33071}}, all, &warning), TextureWrap::kRepeat);
  EXPECT_NE(warning.find("wrapS and wrapT differ"), std::string::npos);
  wrap_of({{"magFilter", 9728}}, inside, &warning);
  EXPECT_NE(warning.find("NEAREST"), std::string::npos);
}

TEST(GltfReader, PartsOfOneMaterialAreOneMesh) {
  GltfMaker maker;
  maker.json["materials"] = {{{"name", "red"}}, {{"name", "blue"}}};
  Json& primitives = maker.json["meshes"][0]["primitives"];
  primitives[0]["material"] = 0;
  Json second = primitives[0];
  second["indices"] = maker.Add<std::uint8_t>({0, 2, 3}, "SCALAR");
  primitives[0]["indices"] = maker.Add<std::uint8_t>({0, 1, 2}, "SCALAR");
  primitives.push_back(second);
  const SceneFile joined = maker.Read();
  ASSERT_EQ(joined.scene.meshes.size(), 1U);
  EXPECT_EQ(joined.scene.meshes[0].mesh.positions.size(), 4U);
  EXPECT_EQ(joined.scene.meshes[0].mesh.triangles.size(), 2U);
  EXPECT_EQ(joined.scene.materials.size(), 1U);  // blue is not used
  primitives[1]["material"] = 1;
  const SceneFile apart = maker.Read();
  ASSERT_EQ(apart.scene.meshes.size(), 2U);
  EXPECT_EQ(apart.scene.meshes[0].name, "plate-red");
  EXPECT_EQ(apart.scene.meshes[1].name, "plate-blue");
  // Of vertices that are shared, each mesh has its own.
  EXPECT_EQ(apart.scene.meshes[1].mesh.positions.size(), 3U);
  EXPECT_EQ(apart.scene.materials[static_cast<std::size_t>(apart.scene.meshes[1].material)].name,
            "blue");
}

TEST(GltfReader, IsAMeshFileLikeOthers) {
  GltfMaker maker;
  maker.json["materials"] = {{{"name", "red"}}, {{"name", "blue"}}};
  Json& primitives = maker.json["meshes"][0]["primitives"];
  primitives[0]["material"] = 0;
  Json second = primitives[0];
  second["material"] = 1;
  second["indices"] = maker.Add<std::uint8_t>({0, 2, 3}, "SCALAR");
  primitives[0]["indices"] = maker.Add<std::uint8_t>({0, 1, 2}, "SCALAR");
  primitives.push_back(second);
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Write("A.GLB", maker.Glb());
  ASSERT_TRUE(HoldsScene(path));
  EXPECT_FALSE(HoldsScene("a.obj"));
  EXPECT_FALSE(HoldsScene("a.stl"));
  EXPECT_EQ(ReadSceneFile(path).scene.meshes.size(), 2U);
  const Mesh mesh = ReadMesh(path);
  EXPECT_EQ(mesh.positions.size(), 4U) << "welded where materials meet";
  EXPECT_EQ(mesh.triangles.size(), 2U);
  EXPECT_NE(IoErrorOf([&] { ReadMeshGroups(path); }).find("glTF files have no groups"),
            std::string::npos);
  maker.json["nodes"] = Json::array({Json::object()});
  const std::string empty = IoErrorOf([&] { ReadMesh(folder.Write("b.glb", maker.Glb())); });
  EXPECT_NE(empty.find("no triangle"), std::string::npos) << empty;
}

TEST(GltfReader, LightsAndCamerasStandWhereTheirNodesAre) {
  GltfMaker maker;
  maker.json["extensionsUsed"] = {"KHR_lights_punctual"};
  maker.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::parse(
      R"([{"type": "point", "name": "bulb", "color": [1, 0.5, 0], "intensity": 4},
          {"type": "directional", "name": "sun", "intensity": 3},
          {"type": "spot", "name": "torch", "range": 5,
           "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}}])");
  maker.json["cameras"] = Json::parse(
      R"([{"type": "perspective", "name": "eye", "perspective":
            {"yfov": 1.5707963267948966, "znear": 0.1, "aspectRatio": 2}},
          {"type": "orthographic", "orthographic":
            {"xmag": 3, "ymag": 2, "znear": 0.1, "zfar": 9}}])");
  const double half = std::sqrt(0.5);
  for (int light = 0; light < 3; ++light) {
    // -z turns to +x, and everything is twice as large.
    maker.json["nodes"].push_back({{"translation", {1, 2, 3}},
                                   {"rotation", {0.0, -half, 0.0, half}},
                                   {"scale", {2, 2, 2}},
                                   {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
    if (light < 2) maker.json["nodes"].back()["camera"] = light;
  }
  maker.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const SceneFile file = maker.Read();
  const auto& emitters = file.scene.emitters;
  ASSERT_EQ(emitters.size(), 3U);
  EXPECT_EQ(emitters[0].name, "bulb");
  const auto& point = std::get<PointEmitter>(emitters[0].light);
  EXPECT_EQ(point.position, (Vec3{1, 2, 3}));
  EXPECT_EQ(point.intensity, (Rgb{4, 2, 0}));
  const auto& sun = std::get<DirectionalEmitter>(emitters[1].light);
  ExpectNear(sun.direction, {1, 0, 0});
  EXPECT_EQ(sun.irradiance, (Rgb{3, 3, 3}));
  const auto& torch = std::get<SpotEmitter>(emitters[2].light);
  ExpectNear(-torch.frame_from_light.z, {1, 0, 0});
  EXPECT_EQ(torch.outer_angle, 0.2);
  EXPECT_TRUE(Mentions(file.warnings, "light 2 'torch': range is not supported"));
  const auto& sensors = file.scene.sensors;
  ASSERT_EQ(sensors.size(), 2U);
  EXPECT_EQ(sensors[0].name, "eye");
  EXPECT_EQ(sensors[0].width, 2 * kGltfCameraHeight);
  EXPECT_NEAR(sensors[0].fy, 0.5 * kGltfCameraHeight, 1e-9);
  EXPECT_EQ(sensors[1].projection, ProjectionKind::kOrthographic);
  EXPECT_NEAR(sensors[1].fy * 4.0, kGltfCameraHeight, 1e-9);
  for (const Camera& camera : sensors) {
    EXPECT_NO_THROW(CameraModel{camera});
    ExpectNear(-camera.world_from_camera.linear.z, {1, 0, 0});
  }
  // The whole is one that can be rendered.
  EXPECT_NO_THROW(ValidateScene(file.scene));
}

TEST(GltfReader, NormalTexturesLieOnTheFacetsOfMeshesWithoutNormals) {
  GltfMaker maker;
  maker.AddUvs();
  const int texture = maker.AddTexture({{51, 102, 255}, {128, 128, 255}});
  maker.Material()["normalTexture"] = {{"index", texture}, {"scale", 0.5}};
  SceneFile file = maker.Read();
  EXPECT_TRUE(file.warnings.empty());
  const Material& material = file.scene.materials.at(0);
  ASSERT_EQ(material.normal_texture, 0);
  EXPECT_EQ(material.normal_scale, 0.5);
  const Rgb& texel = file.scene.textures.at(0).texels[0];  // no colour: as it is
  EXPECT_NEAR(texel.r, 0.2, 1e-7);
  EXPECT_NEAR(texel.g, 0.4, 1e-7);
  EXPECT_FALSE(file.scene.textures[0].scalar);
  const Mesh& mesh = file.scene.meshes.at(0).mesh;
  ASSERT_EQ(mesh.normal_triangles.size(), mesh.triangles.size());
  for (const Vec3& n : mesh.normals) ExpectNear(n, {0, 0, 1});
  EXPECT_NO_THROW(ValidateScene(file.scene));

  maker.Primitive()["attributes"]["NORMAL"] =
      maker.Add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  const std::vector<float> along_x = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
  maker.Primitive()["attributes"]["TANGENT"] = maker.Add<float>(along_x, "VEC4");
  EXPECT_TRUE(maker.Read().warnings.empty());
  const std::vector<float> along_y = {0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1};
  maker.Primitive()["attributes"]["TANGENT"] = maker.Add<float>(along_y, "VEC4");
  EXPECT_TRUE(Mentions(maker.Read().warnings,
                       "primitive 0: its TANGENT are not those of its UVs, which hold, at 4 of 4"));

  maker.Material()["normalTexture"]["extensions"]["KHR_texture_transform"] = {{"rotation", 1.0}};
  file = maker.Read();
  EXPECT_TRUE(
      Mentions(file.warnings, "normalTexture: a KHR_texture_transform that turns or flips"));
  EXPECT_EQ(file.scene.materials.at(0).normal_texture, -1);
}

TEST(GltfReader, WhatIsNotSupportedIsNamed) {
  GltfMaker maker;
  maker.AddUvs();
  const int texture = maker.AddTexture({{1, 2, 3}, {4, 5, 6}});
  Json& material = maker.Material();
  material["occlusionTexture"] = {{"index", texture}};
  material["alphaMode"] = "BLEND";
  material["pbrMetallicRoughness"] = {
      {"baseColorTexture", {{"index", texture}}},
      {"metallicRoughnessTexture", {{"index", texture}, {"texCoord", 1}}}};
  material["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", 1.0}};
  material["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 1.0}};
  material["extensions"]["KHR_materials_specular"] = {{"specularFactor", 0.5},
                                                      {"specularColorFactor", {1, 0, 0}}};
  maker.json["extensionsUsed"] = {"KHR_materials_clearcoat", "EXT_mesh_gpu_instancing"};
  maker.json["animations"] = {{{"channels", Json::array()}, {"samplers", Json::array()}}};
  maker.json["skins"] = {{{"joints", {0}}}};
  maker.json["nodes"][0]["skin"] = 0;
  maker.Primitive()["targets"] = {{{"POSITION", 0}}};
  maker.Primitive()["attributes"]["COLOR_0"] =
      maker.Add<std::uint8_t>({255, 0, 0, 255, 1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3}, "VEC4", true);
  Json lines = maker.Primitive();
  lines["mode"] = 1;
  maker.json["meshes"][0]["primitives"].push_back(lines);
  maker.json["scenes"].push_back({{"nodes", Json::array()}});
  const SceneFile file = maker.Read();
  for (const char* text : {"occlusionTexture",
                           "alphaMode BLEND",
                           "metallicRoughnessTexture has other texture coordinates",
                           "KHR_materials_clearcoat",
                           "KHR_materials_transmission",
                           "specularColorFactor",
                           "EXT_mesh_gpu_instancing",
                           "animations",
                           "skins",
                           "morph targets",
                           "COLOR_0",
                           "points and lines",
                           "of 2 scenes"}) {
    EXPECT_TRUE(Mentions(file.warnings, text)) << text;
  }
  for (const std::string& text : file.warnings) {
    EXPECT_NE(text.find("a.glb: "), std::string::npos) << text;
  }
  EXPECT_EQ(std::get<MetallicRoughnessBsdf>(file.scene.materials.at(0).bsdf).specular, 0.5);
}

TEST(GltfReader, JsonFilesHaveTheirBytesBesideThemOrInside) {
  GltfMaker maker;
  maker.AddUvs();
  const int texture = maker.AddTexture({{1, 2, 3}, {4, 5, 6}});
  maker.Material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", texture}};
  const Json image = maker.json["images"][0];
  const Json view = maker.json["bufferViews"][image["bufferView"].get<std::size_t>()];
  const std::string png = maker.binary.substr(view["byteOffset"], view["byteLength"]);
  maker.json["images"][0] = {{"uri", "pictures/colour%20map.png"}};
  maker.json["buffers"][0] = {{"uri", "a.bin"}, {"byteLength", maker.binary.size()}};
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.Path() / "pictures");
  folder.Write("pictures/colour map.png", png);
  folder.Write("a.bin", maker.binary);
  const std::filesystem::path path = folder.Write("a.gltf", maker.json.dump());
  const SceneFile file = ReadGltf(path);
  EXPECT_EQ(file.scene.meshes.at(0).mesh.triangles.size(), 2U);
  EXPECT_EQ(file.scene.textures.at(0).name, "colour%20map");
  EXPECT_EQ(file.files.size(), 3U);

  std::filesystem::remove(folder.Path() / "pictures/colour map.png");
  EXPECT_NE(IoErrorOf([&] { ReadGltf(path); })
                .find("image 0: the file 'pictures/colour%20map.png' "
                      "is missing"),
            std::string::npos);
  // A buffer of text: three zero bytes.
  maker.json["buffers"][0] = {{"uri", "data:application/octet-stream;base64,AAAA"},
                              {"byteLength", 3}};
  folder.Write("a.gltf", maker.json.dump());
  EXPECT_NE(IoErrorOf([&] { ReadGltf(path); }).find("buffer 0 has 3"), std::string::npos);
}

TEST(GltfReader, ReadsNothingOutsideOfItsFolder) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.Path() / "in");
  GltfMaker maker;
  folder.Write("secret.bin", maker.binary);
  for (const std::string uri : {"../secret.bin",
                                "in/../../secret.bin",
                                "%2e%2e/secret.bin",
                                "/etc/passwd",
                                "/../secret.bin"}) {
    maker.json["buffers"][0] = {{"uri", uri}, {"byteLength", maker.binary.size()}};
    const std::filesystem::path path = folder.Write("in/a.gltf", maker.json.dump());
    const std::string problem = IoErrorOf([&] { ReadGltf(path); });
    EXPECT_NE(problem.find("is outside of the folder of the file"), std::string::npos) << problem;
  }
  // Nor beside the program.
  maker.json["buffers"][0]["uri"] = "CMakeCache.txt";
  const std::filesystem::path path = folder.Write("in/a.gltf", maker.json.dump());
  EXPECT_NE(IoErrorOf([&] { ReadGltf(path); }).find("File not found"), std::string::npos);
}

TEST(GltfReader, WrongElementsAreRefusedByName) {
  struct Mistake {
    std::function<void(GltfMaker&)> make;
    std::string message;
  };
  const auto set = [](const std::string& pointer, Json value) {
    return [pointer, value](GltfMaker& maker) { maker.json[Json::json_pointer(pointer)] = value; };
  };
  const std::vector<Mistake> mistakes = {
      {set("/asset/version", "1.0"), "glTF of version '1.0'"},
      {set("/extensionsRequired", {"KHR_meshopt_compression"}),
       "needs the extension 'KHR_meshopt_compression', which is not supported; write the file "
       "without compression"},
      {[](GltfMaker& maker) {
         maker.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
             {"buffer", 0}, {"byteLength", 8}, {"byteStride", 12}, {"mode", "ATTRIBUTES"}};
       },
       "bufferView 0, EXT_meshopt_compression: 'count' is missing or out of range"},
      {[](GltfMaker& maker) {
         maker.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
             {"buffer", 3}, {"byteLength", 8}, {"byteStride", 12}, {"count", 4}};
       },
       "bufferView 0: there is no buffer 3"},
      {[](GltfMaker& maker) {
         maker.Primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 9}};
       },
       "primitive 0, KHR_draco_mesh_compression: there is no bufferView 9"},
      {[](GltfMaker& maker) {
         maker.Primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}};
       },
       "primitive 0, KHR_draco_mesh_compression: it is no Draco data"},
      {set("/scene", 7), "there is no scene 7; the file has 1"},
      {set("/scenes/0/nodes", {4}), "scene 0: there is no node 4"},
      {set("/scenes/0/nodes", Json::array()), "no triangle, light or camera"},
      {set("/nodes/0/children", {0}), "node 0 'plate': it is in the scene twice"},
      {set("/nodes/0/mesh", 3), "node 0 'plate': there is no mesh 3"},
      {set("/nodes/0/scale", {1, 2}), "node 0 'plate': scale has 2 numbers, not 3"},
      {set("/nodes/0/scale", {1e200, 1, 1}), "a coordinate is beyond 1e12"},
      {set("/nodes/0/scale", {1e200, 1e200, 1e200}), "its place or size is out of range"},
      {set("/nodes/0/rotation", {0, 0, 0, 0}), "its rotation is not a quaternion"},
      {set("/nodes/0/matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}),
       "the last row of its matrix"},
      {set("/accessors/1/normalized", true), "indices: they cannot be normalized"},
      {set("/meshes/0/primitives/0/mode", 9), "mesh 0, primitive 0: there is no mode 9"},
      {set("/meshes/0/primitives/0/material", 2), "mesh 0, primitive 0: there is no material 2"},
      {set("/meshes/0/primitives/0/attributes", {{"NORMAL", 0}}), "it has no POSITION"},
      {set("/meshes/0/primitives/0/attributes/POSITION", 8), "POSITION: there is no accessor 8"},
      {set("/meshes/0/primitives/0/attributes/POSITION", -8), "there is no accessor -8"},
      {set("/meshes/0/primitives/0/attributes/POSITION", 1), "wrong number of components"},
      {set("/accessors/0/count", 5), "5 elements from byte 0 on do not fit bufferView 0"},
      {set("/accessors/0/count", 0), "its count is 0"},
      {set("/accessors/0/count", 18446744073709551615U), "is too large"},
      {set("/accessors/0/count", 200000000), "do not fit bufferView 0"},
      {set("/accessors/0/byteOffset", 18446744073709551615U), "do not fit bufferView 0"},
      {set("/accessors/0/componentType", 5130), "its componentType is 5130"},
      {set("/accessors/0/type", "VEC9"), "VEC9"},
      {set("/accessors/1/componentType", 5126), "indices"},
      {set("/accessors/1/count", 5), "5 corners are not whole triangles"},
      {set("/bufferViews/0/byteLength", 1000000), "bufferView 0: bytes 0 to 0 + 1000000"},
      {set("/bufferViews/0/byteOffset", 18446744073709551615U), "bufferView 0: bytes"},
      {set("/bufferViews/0/byteStride", 8), "byteStride is too small"},
      {set("/bufferViews/0/buffer", 3), "bufferView 0: there is no buffer 3"},
      {set("/materials", {{{"name", "x"}, {"emissiveFactor", {1, 2}}}}), "emissiveFactor"},
      {[](GltfMaker& m) { m.Material()["pbrMetallicRoughness"]["roughnessFactor"] = 2.0; },
       "material 0 'skin': roughnessFactor must lie in 0 to 1"},
      {[](GltfMaker& m) {
         m.Material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 4}};
       },
       "material 0 'skin', baseColorTexture: there is no texture 4"},
      {[](GltfMaker& m) {
         const int texture = m.AddTexture({{1, 2, 3}, {4, 5, 6}});
         m.Material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", texture}};
       },
       "it has no TEXCOORD_0, which a texture of material 0 'skin' needs"},
      {[](GltfMaker& m) {
         m.AddUvs();
         const int texture = m.AddTexture({{1, 2, 3}, {4, 5, 6}});
         m.Material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", texture}};
         m.json["images"][0]["bufferView"] = 0;
       },
       "image 0 'picture0': not a JPEG or PNG image"},
      {[](GltfMaker& m) {
         m.AddUvs();
         const int texture = m.AddTexture({{1, 2, 3}, {4, 5, 6}});
         m.Material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", texture}};
         m.json["bufferViews"].back()["byteOffset"] = 1000000000;
       },
       "bytes 1000000000"},
      {[](GltfMaker& m) {
         m.Primitive()["attributes"]["NORMAL"] = m.Add<float>({0, 0, 1}, "VEC3");
       },
       "its attributes have different counts"},
      {[](GltfMaker& m) {
         m.Primitive()["indices"] = m.Add<std::uint8_t>({0, 1, 4}, "SCALAR");
       },
       "mesh 0, primitive 0: index 2 is 4; there are 4 vertices"},
      {[](GltfMaker& m) {
         const float nan = std::nanf("");
         m.Primitive()["attributes"]["POSITION"] =
             m.Add<float>({0, 0, 0, 1, 0, 0, 1, nan, 0, 0, 1, 0}, "VEC3");
       },
       "POSITION: element 2 is not finite"},
      {[](GltfMaker& m) {
         m.json["accessors"][0].erase("bufferView");
         m.json["accessors"][0]["count"] = 100000000;
       },
       "its count 100000000 is too large"},
  };
  for (const Mistake& mistake : mistakes) {
    GltfMaker maker;
    mistake.make(maker);
    const std::string problem = maker.Problem();
    EXPECT_NE(problem.find(mistake.message), std::string::npos)
        << mistake.message << "\n  " << problem;
    EXPECT_NE(problem.find("a.glb: "), std::string::npos) << problem;
  }
}

TEST(GltfReader, WrongContainersAreRefused) {
  const TemporaryFolder folder;
  const auto problem_of = [&](const std::string& bytes) {
    const std::filesystem::path path = folder.Write("a.glb", bytes);
    return IoErrorOf([&] { ReadGltf(path); });
  };
  const std::string good = GltfMaker().Glb();
  EXPECT_NO_THROW(ReadGltf(folder.Write("b.glb", good)));
  // What follows the container is no part of it.
  EXPECT_NO_THROW(ReadGltf(folder.Write("b.glb", good + "more")));
  EXPECT_NE(problem_of("").find("a.glb"), std::string::npos);
  EXPECT_NE(problem_of("hello, world").find("not a glTF file"), std::string::npos);
  EXPECT_NE(problem_of(good.substr(0, 100)).find("cut off: 100 of"), std::string::npos);
  std::string old = good;
  old[4] = 1;
  EXPECT_NE(problem_of(old).find("GLB of version 1"), std::string::npos);
  std::string overrun = good;
  overrun[14] = 1;
  EXPECT_NE(problem_of(overrun).find("chunk 0: it is longer than the file"), std::string::npos);
  const std::string deep =
      "{\"asset\":{\"version\":\"2.0\"},\"extras\":" + std::string(100000, '[') +
      std::string(100000, ']') + "}";
  EXPECT_NE(problem_of(Container(deep, "")).find("nested more than"), std::string::npos);
  EXPECT_NE(problem_of(deep).find("nested more than"), std::string::npos);
}

/// A file with everything in it.
std::string FullGlb() {
  GltfMaker maker;
  maker.AddUvs();
  const int texture = maker.AddTexture({{200, 100, 50}, {90, 180, 200}});
  const int numbers = maker.AddTexture({{200, 100, 50}, {90, 180, 200}});
  const Json shift = {{"KHR_texture_transform", {{"offset", {0.5, 0.5}}}}};
  maker.Material()["pbrMetallicRoughness"] = {
      {"baseColorTexture", {{"index", texture}, {"extensions", shift}}},
      {"metallicRoughnessTexture", {{"index", numbers}, {"extensions", shift}}}};
  maker.Material()["emissiveFactor"] = {1, 1, 1};
  maker.Material()["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", 3}};
  maker.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  maker.json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 1}}}}};
  maker.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  maker.json["nodes"][0]["camera"] = 0;
  maker.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  return maker.Glb();
}

TEST(GltfReader, CutFilesAreRefused) {
  const TemporaryFolder folder;
  const std::string bytes = FullGlb();
  ExpectCutFilesRefused(folder.Write("whole.glb", bytes), bytes.size(), 300, ReadGltf);
}

TEST(GltfReader, DamagedFilesAreReadOrRefused) {
  const TemporaryFolder folder;
  const auto read = [](const std::filesystem::path& path) {
    const SceneFile file = ReadGltf(path);
    try {
      ValidateScene(file.scene);
    } catch (const SceneError&) {
    }
  };
  ExpectDamagedFilesSurvived(folder.Write("whole.glb", FullGlb()), 2000, read);
}

TEST(GltfReader, DamagedNumbersAreReadOrRefused) {
  const std::string bytes = FullGlb();
  std::uint32_t json_size = 0;
  std::memcpy(&json_size, bytes.data() + 12, 4);
  const std::string text = bytes.substr(20, json_size);
  const std::string binary = bytes.substr(28 + json_size);
  const std::vector<std::string> numbers = {"-1",
                                            "0",
                                            "1",
                                            "7",
                                            "255",
                                            "65536",
                                            "2147483648",
                                            "1e300",
                                            "-1e300",
                                            "0.5",
                                            "18446744073709551615",
                                            "null",
                                            "\"text\"",
                                            "[]",
                                            "{}",
                                            "true"};
  const TemporaryFolder folder;
  std::uint64_t state = 7;
  const auto next = [&state](std::size_t below) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>(state >> 33) % below;
  };
  std::vector<std::size_t> values;  // where numbers begin
  for (std::size_t i = 1; i < text.size(); ++i) {
    const bool begins = text[i - 1] == ':' || text[i - 1] == ',' || text[i - 1] == '[';
    if (begins && (std::isdigit(static_cast<unsigned char>(text[i])) != 0)) values.push_back(i);
  }
  ASSERT_GT(values.size(), 50U);
  int num_read = 0;
  for (int round = 0; round < 1000; ++round) {
    const std::size_t begin = values[next(values.size())];
    const std::size_t end = text.find_first_not_of("0123456789.eE+-", begin);
    const std::string changed =
        text.substr(0, begin) + numbers[next(numbers.size())] + text.substr(end);
    const std::filesystem::path path = folder.Write("bad.glb", Container(changed, binary));
    try {
      ReadGltf(path);
      ++num_read;
    } catch (const IoError&) {
    }
  }
  EXPECT_GT(num_read, 0);
  EXPECT_LT(num_read, 900);
}

}  // namespace
}  // namespace pathfit::renderer::gltf_reader_test
