#include "renderer/io/ply_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/image/color.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::ply_file_test {
namespace {

Mesh Parse(const std::string& text) {
  const TemporaryFolder folder;
  return ReadPly(folder.Write("shape.ply", text));
}

template <class T>
void Append(T value, bool big_endian, std::string& bytes) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// A square with colours and an element and properties nobody knows, in a binary order.
std::string MakeBinary(bool big_endian) {
  std::string bytes = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
                      "_endian 1.0\ncomment x\nelement thing 2\nproperty list ushort double a\n"
                      "property short b\nelement vertex 4\nproperty double x\nproperty float y\n"
                      "property float z\nproperty uint flags\nproperty float red\n"
                      "property float green\nproperty float blue\nelement face 1\n"
                      "property uchar material\nproperty list uint short vertex_index\n"
                      "property list uchar float texcoord\nend_header\n";
  for (int i = 0; i < 2; ++i) {
    Append<std::uint16_t>(3, big_endian, bytes);
    for (int k = 0; k < 3; ++k) Append<double>(1.5, big_endian, bytes);
    Append<std::int16_t>(-1, big_endian, bytes);
  }
  for (int i = 0; i < 4; ++i) {
    Append<double>(i == 1 || i == 2 ? 0.1 : 0.0, big_endian, bytes);
    Append<float>(i >= 2 ? 1.0F : 0.0F, big_endian, bytes);
    Append<float>(7.0F, big_endian, bytes);
    Append<std::uint32_t>(9, big_endian, bytes);
    for (int k = 0; k < 3; ++k) Append<float>(0.25F * static_cast<float>(k + 1), big_endian, bytes);
  }
  Append<std::uint8_t>(5, big_endian, bytes);
  Append<std::uint32_t>(4, big_endian, bytes);
  for (std::int16_t i = 0; i < 4; ++i) Append<std::int16_t>(i, big_endian, bytes);
  Append<std::uint8_t>(1, big_endian, bytes);
  Append<float>(0.0F, big_endian, bytes);
  return bytes;
}

constexpr const char* kAscii =
    "ply\r\nformat ascii 1.0\r\nobj_info hi\r\nelement vertex 4\r\nproperty float x\r\n"
    "property float y\r\nproperty float z\r\nproperty float nx\r\nproperty float ny\r\n"
    "property float nz\r\nproperty uchar red\r\nproperty uchar green\r\nproperty uchar blue\r\n"
    "property float u\r\nproperty float v\r\nelement face 1\r\n"
    "property list uchar int vertex_indices\r\nend_header\r\n"
    "0 0 0 0 0 3 255 0 128 0 0\r\n1 0 0 0 0 3 255 0 128 1 0\r\n1 1 0 0 0 3 255 0 128 1 1\r\n"
    "0 1 0 0 0 3 255 0 128 0 1\r\n4 0 1 2 3\r\n";

TEST(PlyReader, ReadsAsciiWithAllAttributes) {
  const Mesh mesh = Parse(kAscii);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(mesh.normals[3], (Vec3{0, 0, 1}));
  EXPECT_EQ(mesh.uvs[1], (Vec2{1, 0}));
  EXPECT_EQ(mesh.uv_triangles, mesh.triangles);
  EXPECT_EQ(mesh.normal_triangles, mesh.triangles);
  EXPECT_EQ(mesh.color_triangles, mesh.triangles);
  EXPECT_EQ(mesh.colors[2], (Rgb{1.0, 0.0, LinearFromSrgb(128.0 / 255.0)}));
}

TEST(PlyReader, ReadsBothBinaryOrdersAndSkipsTheUnknown) {
  for (const bool big_endian : {false, true}) {
    const Mesh mesh = Parse(MakeBinary(big_endian));
    EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 7}, {.1, 0, 7}, {.1, 1, 7}, {0, 1, 7}}));
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(mesh.colors.size(), 4U);
    EXPECT_EQ(mesh.colors[0], (Rgb{0.25, 0.5, 0.75}));
  }
}

TEST(PlyReader, FacesMayStandBeforeVertices) {
  const Mesh mesh = Parse(
      "ply\nformat ascii 1.0\nelement face 1\nproperty list int uint vertex_indices\n"
      "element vertex 3\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
      "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n");
  EXPECT_EQ(mesh.triangles.size(), 1U);
}

TEST(PlyReader, ReplacesNormalsOfLengthZero) {
  std::string text = kAscii;
  text.replace(text.find("0 1 0 0 0 3"), 11, "0 1 0 0 0 0");
  const Mesh mesh = Parse(text);
  EXPECT_EQ(mesh.normals[3], (Vec3{0, 0, 1}));
  EXPECT_NO_THROW(ValidateMesh(mesh, "square"));
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

TEST(PlyReader, RefusesHostileFiles) {
  const std::string huge = "4000000000000000000";
  const std::pair<std::string, std::string> cases[] = {
      {"", "begins with the line 'ply'"},
      {Replaced(kAscii, "ascii", "morse"), "shape.ply:2: format 'morse' is unknown"},
      {Replaced(kAscii, "1.0", "2.0"), ":2: only version 1.0"},
      {Replaced(kAscii, "vertex 4", "vertex -4"), ":4: an element needs"},
      {Replaced(kAscii, "vertex 4", "vertex " + huge), "declares " + huge},
      {Replaced(kAscii, "vertex 4", "vertex 99999999999999999999"), ":4: an element needs"},
      {Replaced(kAscii, "face 1", "face " + huge), "declares " + huge},
      {Replaced(kAscii, "float x", "quad x"), ":5: type 'quad' is unknown"},
      {Replaced(kAscii, "float x", "float y"), ":6: property 'y' is declared twice"},
      {Replaced(kAscii, "float x", "float w"), "needs the properties x, y and z"},
      {Replaced(kAscii, "float x", "int x"), "'x' has a wrong type, allowed are float, double"},
      {Replaced(kAscii, "uchar red", "int red"), "'red' has a wrong type"},
      {Replaced(kAscii, "list uchar int", "list float int"), "must be of an integer type"},
      {Replaced(kAscii, "list uchar int", "list uchar float"), "must be of an integer type"},
      {Replaced(kAscii, "list uchar int vertex_indices", "int vertex_indices"), "needs a list"},
      {Replaced(kAscii, "end_header", "hello"), "unknown header statement 'hello'"},
      {Replaced(kAscii, "4 0 1 2 3", "4 0 1 2 4"), ":23: face 0: vertex index is out of range"},
      {Replaced(kAscii, "4 0 1 2 3", "4 0 1 2 -1"), ":23: face 0: vertex index is out of range"},
      {Replaced(kAscii, "4 0 1 2 3", "4 0 1 2 2.5"), "'2.5' is not an integer"},
      {Replaced(kAscii, "4 0 1 2 3", "2 0 1"), ":23: face 0: a face needs at least 3"},
      {Replaced(kAscii, "4 0 1 2 3", "-4 0 1 2 3"), "negative length"},
      {Replaced(kAscii, "4 0 1 2 3", "5 0 1 2 3"), "ends too early"},
      {Replaced(kAscii, "4 0 1 2 3", "3 0 1 2 3"), ":23: face 0: too many numbers"},
      {Replaced(kAscii, "1 1 0 0", "1 nan 0 0"), ":21: vertex 2: 'nan' is not a finite number"},
      {Replaced(kAscii, "255 0 128 1 1", "256 0 128 1 1"), "must be 0 to 255"},
      {Replaced(kAscii, "face 1", "face 0"), "has no face"},
  };
  for (const auto& [text, message] : cases) {
    const std::string got = IoErrorOf([&file = text] { Parse(file); });
    EXPECT_NE(got.find(message), std::string::npos) << got << "\nwanted " << message;
  }
}

TEST(PlyReader, RefusesBinaryNumbersThatAreNotFinite) {
  std::string bytes = MakeBinary(false);
  const float infinity = HUGE_VALF;
  const std::size_t z_of_first = bytes.find("end_header\n") + 11 + 2 * 28 + 12;
  std::memcpy(bytes.data() + z_of_first, &infinity, 4);
  EXPECT_NE(IoErrorOf([&] { Parse(bytes); }).find("vertex 0: a number is not finite"),
            std::string::npos);
}

TEST(PlyReader, SurvivesCutAndDamagedFiles) {
  const auto read = [](const std::filesystem::path& file) { ReadPly(file); };
  const TemporaryFolder folder;
  for (const std::string& bytes : {std::string(kAscii), MakeBinary(false), MakeBinary(true)}) {
    const std::filesystem::path path = folder.Write("shape.ply", bytes);
    // An ascii file is whole without the line end behind its last number.
    const std::size_t whole = bytes == kAscii ? bytes.size() - 2 : bytes.size();
    ExpectCutFilesRefused(path, whole, 100, read);
    ExpectDamagedFilesSurvived(path, 200, read);
  }
}

TEST(PlyWriter, RoundTripKeepsFloatsExactly) {
  Mesh mesh = MakeIcosphere(2, 1.0);
  for (Vec3& p : mesh.positions) {
    for (int c = 0; c < 3; ++c) p[c] = std::round(p[c] * 4096.0) / 4096.0;
  }
  SetUniformVertexColors({0, 0, 0}, mesh);
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    const double code = static_cast<double>(i % 256) / 255.0;
    mesh.colors[i] = {LinearFromSrgb(code), LinearFromSrgb(1.0 - code), 1.0};
  }
  const TemporaryFolder folder;
  WritePly(folder.Path() / "a.ply", mesh);
  const Mesh copy = ReadPly(folder.Path() / "a.ply");
  EXPECT_EQ(copy.positions, mesh.positions);
  EXPECT_EQ(copy.triangles, mesh.triangles);
  EXPECT_EQ(copy.color_triangles, mesh.color_triangles);
  ASSERT_EQ(copy.colors.size(), mesh.colors.size());
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(copy.colors[i][c], mesh.colors[i][c], 1e-15);
  }
  EXPECT_TRUE(copy.normals.empty());
  EXPECT_TRUE(copy.uvs.empty());
}

TEST(PlyWriter, RoundTripKeepsNormalsUvsAndSeams) {
  Mesh mesh = Parse(kAscii);
  mesh.colors = {{1, 0, 0}, {0, 1, 0}};
  mesh.color_triangles = {{0, 0, 0}, {1, 1, 1}};
  const TemporaryFolder folder;
  WritePly(folder.Path() / "a.ply", mesh);
  const Mesh copy = ReadPly(folder.Path() / "a.ply");
  EXPECT_EQ(copy.positions, mesh.positions);
  EXPECT_EQ(copy.triangles, mesh.triangles);
  EXPECT_EQ(copy.colors.size(), 6U);
  for (std::size_t f = 0; f < 2; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](const std::vector<Triangle>& t) {
        return static_cast<std::size_t>(t[f][k]);
      };
      EXPECT_EQ(copy.colors[at(copy.color_triangles)], mesh.colors[f]);
      EXPECT_EQ(copy.uvs[at(copy.uv_triangles)], mesh.uvs[at(mesh.uv_triangles)]);
      EXPECT_EQ(copy.normals[at(copy.normal_triangles)], (Vec3{0, 0, 1}));
    }
  }
}

TEST(PlyWriter, RefusesWhatItCannotStore) {
  const TemporaryFolder folder;
  Mesh mesh = MakeIcosphere(0, 1.0);
  EXPECT_THROW(WritePly(folder.Path() / "no" / "a.ply", mesh), IoError);
  mesh.positions[3].x = 1e300;
  EXPECT_THROW(WritePly(folder.Path() / "a.ply", mesh), IoError);
  mesh.positions[3].x = std::nan("");
  EXPECT_THROW(WritePly(folder.Path() / "a.ply", mesh), IoError);
  mesh.positions.resize(5);
  EXPECT_THROW(WritePly(folder.Path() / "a.ply", mesh), SceneError);
  EXPECT_FALSE(std::filesystem::exists(folder.Path() / "a.ply"));
}

}  // namespace
}  // namespace pathfit::renderer::ply_file_test
