#include "renderer/io/stl_reader.h"

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "renderer/geometry/mesh_primitives.h"
#include "renderer/io/mesh_file.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::stl_reader_test {
namespace {

template <class T>
void Append(T value, std::string& bytes) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// As modellers write it: wrong normals, a header that begins like a text, colours.
std::string BinaryOf(const Mesh& mesh) {
  std::string bytes = "solid of a modeller";
  bytes.resize(80, '\0');
  Append(static_cast<std::uint32_t>(mesh.triangles.size()), bytes);
  for (const Triangle& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) Append(0.0F, bytes);
    for (const std::int32_t v : t) {
      for (int i = 0; i < 3; ++i) {
        Append(static_cast<float>(mesh.positions[static_cast<std::size_t>(v)][i]), bytes);
      }
    }
    Append<std::uint16_t>(0x801F, bytes);
  }
  return bytes;
}

const std::string kText =
    "solid two words\r\n"
    "  facet normal 0 0 0\n    outer loop\n"
    "      vertex 0 0 0\n      vertex 1 0 0\n      vertex 0 2.5e-1 0\n"
    "    endloop\n  endfacet\nendsolid two words\n"
    "\nsolid\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 0.25 0\nvertex 0 0.25 0\n"
    "endloop\nendfacet\nendsolid\n";

std::string ErrorOf(std::string text, const std::string& from, const std::string& to) {
  if (!from.empty()) text.replace(text.find(from), from.size(), to);
  const TemporaryFolder folder;
  const auto path = folder.Write("m.stl", text);
  const std::string error = IoErrorOf([&] { ReadStl(path); });
  EXPECT_TRUE(error.starts_with(path.string())) << error;
  return error.substr(error.find("m.stl") + 5);
}

TEST(Stl, BinaryTrianglesAreWelded) {
  const TemporaryFolder folder;
  const Mesh cube = MakeCube();
  const Mesh read = ReadMesh(folder.Write("cube.STL", BinaryOf(cube)));
  EXPECT_EQ(read.positions.size(), cube.positions.size());
  ASSERT_EQ(read.triangles.size(), cube.triangles.size());
  for (std::size_t t = 0; t < cube.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(read.positions[static_cast<std::size_t>(read.triangles[t][k])],
                cube.positions[static_cast<std::size_t>(cube.triangles[t][k])]);
    }
  }
  EXPECT_TRUE(read.normals.empty()) << "those of the file are not used";
  EXPECT_NO_THROW(ValidateMesh(read, "cube"));
}

TEST(Stl, SolidsOfATextAreOneMesh) {
  const TemporaryFolder folder;
  const Mesh mesh = ReadMesh(folder.Write("m.stl", kText));
  ASSERT_EQ(mesh.triangles.size(), 2U);
  EXPECT_EQ(mesh.positions.size(), 4U) << "of both solids, welded";
  EXPECT_EQ(mesh.positions[2], (Vec3{0.0, 0.25, 0.0}));
  EXPECT_EQ(mesh.triangles[1], (Triangle{1, 3, 2}));
}

TEST(Stl, RefusesWhatIsWrongWithItsPlace) {
  EXPECT_EQ(ErrorOf(kText, "2.5e-1", "nan"), ":6: 'nan' is not a finite number");
  EXPECT_EQ(ErrorOf(kText, "1 0 0", "1 0"), ":5: a vertex has three numbers");
  EXPECT_EQ(ErrorOf(kText, "1 0 0", "1 0 0 1"), ":5: a vertex has three numbers");
  EXPECT_EQ(ErrorOf(kText, "1 0 0", "1 0 2e12"), ":5: a coordinate is beyond 1e12");
  EXPECT_EQ(ErrorOf(kText, "outer loop", "outer"), ":3: 'outer' needs 'loop' behind it");
  EXPECT_EQ(ErrorOf(kText, "    endloop\n", ""),
            ":7: 'endfacet' stands where 'endloop' is expected");
  EXPECT_EQ(ErrorOf(kText, "endsolid\n", ""), ":18: the file ends where 'endsolid' is expected");
  EXPECT_EQ(ErrorOf("solid a\nendsolid a\n", "", ""), ": no triangles");
  EXPECT_EQ(ErrorOf("", "", ""),
            ": no text that begins with 'solid', and too short for a binary STL");
  std::string bytes = BinaryOf(MakeCube());
  EXPECT_EQ(
      ErrorOf(bytes + "x", "", ""),
      ": no text that begins with 'solid', and 12 triangles take 684 bytes; the file has 685");
  const float infinite = std::numeric_limits<float>::infinity();
  std::memcpy(bytes.data() + 84 + 50 + 12, &infinite, sizeof(infinite));
  EXPECT_EQ(ErrorOf(bytes, "", ""), ": triangle 2: a coordinate is not finite or beyond 1e12");
}

TEST(Stl, RefusesCutFilesAndSurvivesDamagedOnes) {
  const TemporaryFolder folder;
  const std::string bytes = BinaryOf(MakeCube());
  const auto binary = folder.Write("cube.stl", bytes);
  ExpectCutFilesRefused(binary, bytes.size(), 200, ReadStl);
  ExpectDamagedFilesSurvived(binary, 200, ReadStl);
  const auto text = folder.Write("text.stl", kText);
  ExpectDamagedFilesSurvived(text, 500, ReadStl);
}

}  // namespace
}  // namespace pathfit::renderer::stl_reader_test
