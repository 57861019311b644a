#include "renderer/io/gltf_compression.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/io/gltf_reader.h"
#include "renderer/io/gltf_writer.h"
#include "tests/renderer/io/temporary_folder.h"
#include "tests/support/compressed_gltf.h"

namespace pathfit::renderer::gltf_compression_test {
namespace {

/// A globe with normals, UVs, and a picture.
std::string PlainGlb() {
  Mesh mesh = MakeIcosphere(3, 1.0);
  SetSphereUvs(mesh);
  mesh.normals = mesh.positions;
  mesh.normal_triangles = mesh.triangles;
  GlbMaterial material;
  material.base_color_texture = Texture{};
  const TemporaryFolder folder;
  WriteGlb(folder.Path() / "globe.glb", mesh, material);
  return ReadWholeFile(folder.Path() / "globe.glb");
}

/// Position, normal and UV of each corner.
using Corner = std::array<double, 8>;

/// By the middle of the triangles, corners turned so that the least comes first.
std::vector<std::array<Corner, 3>> TrianglesOf(const Mesh& mesh) {
  std::vector<std::array<Corner, 3>> triangles;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    std::array<Corner, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](const SharedVector<Triangle>& list) {
        return static_cast<std::size_t>(list[f][k]);
      };
      const Vec3& x = mesh.positions[at(mesh.triangles)];
      const Vec3& n = mesh.normals[at(mesh.normal_triangles)];
      const Vec2& uv = mesh.uvs[at(mesh.uv_triangles)];
      corners[k] = {x.x, x.y, x.z, n.x, n.y, n.z, uv.x, uv.y};
    }
    std::ranges::rotate(corners, std::ranges::min_element(corners));
    triangles.push_back(corners);
  }
  std::ranges::sort(triangles);
  return triangles;
}

SceneFile ReadBytes(const std::string& bytes) {
  const TemporaryFolder folder;
  return ReadGltf(folder.Write("a.glb", bytes));
}

/// Largest distance from a corner of one to the same corner of the other, whatever their order.
double Distance(const Mesh& a, const Mesh& b) {
  const auto from = TrianglesOf(a);
  const auto to = TrianglesOf(b);
  if (from.size() != to.size()) return 1e300;
  double largest = 0.0;
  for (const auto& triangle : from) {
    double nearest = 1e300;
    for (const auto& other : to) {
      for (std::size_t turn = 0; turn < 3; ++turn) {
        double far = 0.0;
        for (std::size_t k = 0; k < 3 && far < nearest; ++k) {
          for (std::size_t c = 0; c < 8; ++c) {
            far = std::max(far, std::abs(triangle[k][c] - other[(k + turn) % 3][c]));
          }
        }
        nearest = std::min(nearest, far);
      }
    }
    largest = std::max(largest, nearest);
  }
  return largest;
}

TEST(GltfCompression, MeshoptIsReadAsThePlainFile) {
  const std::string plain = PlainGlb();
  const std::string packed = tests::WithMeshopt(plain, false);
  ASSERT_LT(packed.size(), plain.size());
  const SceneFile expected = ReadBytes(plain);
  const SceneFile file = ReadBytes(packed);
  EXPECT_EQ(TrianglesOf(file.scene.meshes.at(0).mesh),
            TrianglesOf(expected.scene.meshes.at(0).mesh));
  EXPECT_TRUE(file.warnings.empty());
  EXPECT_EQ(file.scene.textures.size(), 1U);
}

TEST(GltfCompression, MeshoptFiltersKeepWhatTheirBitsHold) {
  const std::string plain = PlainGlb();
  const SceneFile expected = ReadBytes(plain);
  const SceneFile file = ReadBytes(tests::WithMeshopt(plain, true));
  const double distance = Distance(file.scene.meshes.at(0).mesh, expected.scene.meshes.at(0).mesh);
  EXPECT_GT(distance, 1e-7);
  EXPECT_LT(distance, 2e-4);
}

TEST(GltfCompression, DracoIsReadAsThePlainFile) {
  const std::string plain = PlainGlb();
  const SceneFile expected = ReadBytes(plain);
  const SceneFile same = ReadBytes(tests::WithDraco(plain, 0));
  EXPECT_EQ(TrianglesOf(same.scene.meshes.at(0).mesh),
            TrianglesOf(expected.scene.meshes.at(0).mesh));
  EXPECT_TRUE(same.warnings.empty());
  const SceneFile near = ReadBytes(tests::WithDraco(plain, 12));
  const double distance = Distance(near.scene.meshes.at(0).mesh, expected.scene.meshes.at(0).mesh);
  EXPECT_GT(distance, 1e-5);
  EXPECT_LT(distance, 2e-3);
}

TEST(GltfCompression, QuaternionsComeBack) {
  const std::vector<float> turns = {0.5F, -0.5F, 0.5F, 0.5F, 0.0F, 0.6F, 0.0F, -0.8F};
  std::vector<unsigned char> filtered(16);
  meshopt_encodeFilterQuat(filtered.data(), 2, 8, 16, turns.data());
  std::string bytes(meshopt_encodeVertexBufferBound(2, 8), '\0');
  bytes.resize(meshopt_encodeVertexBuffer(
      reinterpret_cast<unsigned char*>(bytes.data()), bytes.size(), filtered.data(), 2, 8));
  const std::vector<unsigned char> decoded =
      DecodeMeshopt({bytes, 2, 8, "ATTRIBUTES", "QUATERNION"});
  std::array<std::int16_t, 8> numbers{};
  ASSERT_EQ(decoded.size(), 16U);
  std::memcpy(numbers.data(), decoded.data(), 16);
  for (std::size_t q = 0; q < 2; ++q) {
    double product = 0.0;  // a quaternion and its negative are one rotation
    for (std::size_t c = 0; c < 4; ++c) {
      product += numbers[4 * q + c] / 32767.0 * static_cast<double>(turns[4 * q + c]);
    }
    EXPECT_NEAR(std::abs(product), 1.0, 1e-3);
  }
}

TEST(GltfCompression, WrongNumbersAreRefusedBeforeMemoryIsTaken) {
  const std::string bytes(40, '\xa0');
  const auto problem =
      [&](std::size_t count, std::size_t stride, const char* mode, const char* filter = "NONE") {
        return IoErrorOf([&] { DecodeMeshopt({bytes, count, stride, mode, filter}); });
      };
  EXPECT_EQ(problem(2000000000, 256, "ATTRIBUTES"), "its count is too large");
  EXPECT_EQ(problem(2000000000, 2, "INDICES"), "its count is too large");
  EXPECT_EQ(problem(2000000001, 4, "TRIANGLES"), "its count is too large");
  EXPECT_EQ(problem(4, 4, "TRIANGLES"), "its count is not one of whole triangles");
  EXPECT_EQ(problem(4, 3, "INDICES"), "its byteStride is wrong");
  EXPECT_EQ(problem(4, 6, "ATTRIBUTES"), "its byteStride is wrong");
  EXPECT_EQ(problem(0, 4, "ATTRIBUTES"), "its count is 0");
  EXPECT_EQ(problem(4, 4, "POINTS"), "there is no mode 'POINTS'");
  EXPECT_EQ(problem(4, 4, "INDICES", "OCTAHEDRAL"), "filters are for attributes");
  EXPECT_EQ(problem(3, 4, "TRIANGLES"), "its compressed bytes are damaged");
  EXPECT_EQ(IoErrorOf([&] { DracoMesh(bytes, 4); }), "it is no Draco data");
  // Encoder type 1, sequential, no flags, then 2^32 - 1 triangles.
  const std::string large("DRACO\2\2\1\0\0\0\xff\xff\xff\xff\x0f\x03", 17);
  EXPECT_EQ(IoErrorOf([&] { DracoMesh(large, 4); }),
            "its Draco data has 4294967295 triangles, its indices are for 4");
  EXPECT_EQ(IoErrorOf([&] { DracoMesh(large, 4294967295U); }), "its Draco data is cut off");
}

TEST(GltfCompression, DamagedFilesAreReadOrRefused) {
  const std::string plain = PlainGlb();
  const TemporaryFolder folder;
  for (const std::string& bytes : {tests::WithMeshopt(plain, false),
                                   tests::WithMeshopt(plain, true),
                                   tests::WithDraco(plain, 0),
                                   tests::WithDraco(plain, 12)}) {
    ExpectDamagedFilesSurvived(
        folder.Write("whole.glb", bytes), 500, [](const auto& path) { ReadGltf(path); });
  }
}

}  // namespace
}  // namespace pathfit::renderer::gltf_compression_test
