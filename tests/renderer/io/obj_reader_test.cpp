#include "renderer/io/obj_reader.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/io/mesh_file.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::obj_reader_test {
namespace {

Mesh Parse(const std::string& text) {
  const TemporaryFolder folder;
  return ReadObj(folder.Write("shape.obj", text));
}

constexpr const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(ObjReader, ReadsEveryIndexForm) {
  const std::string attributes = std::string(kSquare) + "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 2\n";
  for (const char* face : {"f 1/1/1 2/2/1 3/3/1", "f -4/-3/-1 -3/-2/-1 -2/-1/-1"}) {
    const Mesh mesh = Parse(attributes + face);
    EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}));
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
    EXPECT_EQ(mesh.uv_triangles, (std::vector<Triangle>{{0, 1, 2}}));
    EXPECT_EQ(mesh.normal_triangles, (std::vector<Triangle>{{0, 0, 0}}));
    EXPECT_EQ(mesh.normals, (std::vector<Vec3>{{0, 0, 1}}));
    EXPECT_EQ(mesh.uvs[2], (Vec2{1, 1}));
  }
  const Mesh no_uv = Parse(attributes + "f 1//1 2//1 3//1");
  EXPECT_TRUE(no_uv.uv_triangles.empty());
  EXPECT_EQ(no_uv.normal_triangles.size(), 1U);
  const Mesh no_normal = Parse(attributes + "f 1/1 2/2 3/3");
  EXPECT_EQ(no_normal.uv_triangles.size(), 1U);
  EXPECT_TRUE(no_normal.normals.empty());
  const Mesh mixed = Parse(attributes + "f 1/1 2/2 3/3\nf 1 3 4");
  EXPECT_TRUE(mixed.uvs.empty());
  EXPECT_EQ(mixed.triangles.size(), 2U);
}

TEST(ObjReader, FansPolygonsAndIgnoresGroupsAndMaterials) {
  const Mesh mesh = Parse(
      "# comment\nmtllib a b.mtl\no thing\ng x\ns off\nusemtl m\nv 0 0 0 1.0\n v\t1 0 0 # end\r\n"
      "v 1 1 0\nv 0 \\\n 1 0\n\nl 1 2\nf 1 2 3 4\n# ends with \\\nf 3 4 1");
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {2, 3, 0}}));
}

TEST(ObjReader, NormalsBecomeUnitAndMissingOnesSmooth) {
  const Mesh mesh = Parse(std::string(kSquare) +
                          "vn 0 3 4\nvn 0 0 0\nvn 0 0 9\nf 1//1 2//1 3//2\nf 1//1 3//2 4//2\n");
  EXPECT_NO_THROW(ValidateMesh(mesh, "square"));
  EXPECT_EQ(mesh.normals,
            (std::vector<Vec3>{{0, 0.6, 0.8}, {0, 0, 1}, {0, 0, 1}}));  // the last is position 4's
  EXPECT_EQ(mesh.normal_triangles, (std::vector<Triangle>{{0, 0, 1}, {0, 1, 2}}));
  const Mesh mixed = Parse(std::string(kSquare) + "vn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4\n");
  EXPECT_TRUE(mixed.normals.empty());
  EXPECT_TRUE(mixed.normal_triangles.empty());
}

TEST(ObjReader, DropsValuesThatNoFaceUses) {
  const Mesh mesh = Parse(
      "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 7 7\nvt 0 0\nvt 1 0\nvt 0 1\nvn 1 0 0\nvn 0 0 1\n"
      "f 2/2/2 3/3/2 4/4/2\n");
  EXPECT_EQ(mesh.positions.size(), 3U);
  EXPECT_EQ(mesh.uvs, (std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_EQ(mesh.normals, (std::vector<Vec3>{{0, 0, 1}}));
  EXPECT_EQ(mesh.uv_triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

constexpr const char* kParts =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
    "o box\ng left a\nusemtl unused\nusemtl  dark wood \t\nf 1/1 2/2 3/3\n"
    "usemtl steel\nf 2 5 6 3\ng right\no lid\nusemtl dark wood # again\nf -6/1 -4/3 -3/2\n";

std::vector<MeshGroup> ParseGroups(const std::string& text) {
  const TemporaryFolder folder;
  return ReadMeshGroups(folder.Write("shape.obj", text));
}

TEST(ObjGroups, SplitsByMaterialInOrderOfFirstFaces) {
  const std::vector<MeshGroup> groups = ParseGroups(kParts);
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].name, "dark wood");
  EXPECT_EQ(groups[0].mesh.positions,
            (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(groups[0].mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(groups[0].mesh.uv_triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 1}}));
  EXPECT_EQ(groups[1].name, "steel");
  // Each part has UVs if all of its own faces have.
  EXPECT_TRUE(groups[1].mesh.uvs.empty());
  EXPECT_EQ(groups[1].mesh.positions.size(), 4U);
  EXPECT_EQ(groups[1].mesh.triangles.size(), 2U);
  for (const MeshGroup& group : groups) EXPECT_NO_THROW(ValidateMesh(group.mesh, group.name));
}

TEST(ObjGroups, FacesBeforeTheFirstNameHaveNone) {
  const std::vector<MeshGroup> groups =
      ParseGroups(std::string(kSquare) + "f 1 2 3\nusemtl\nf 1 3 4\nusemtl x\nf 4 3 1\n");
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].name, "");
  EXPECT_EQ(groups[0].mesh.triangles.size(), 2U);
  EXPECT_EQ(groups[1].name, "x");
}

TEST(ObjGroups, RefusesWhatReadObjRefuses) {
  const std::string got =
      IoErrorOf([] { ParseGroups("usemtl a\nf 1 2 3\nusemtl b\nv 0 0 0\nv 1 0 0\n"); });
  EXPECT_NE(got.find("shape.obj:2: vertex index 3 is out of range"), std::string::npos) << got;
  EXPECT_THROW(ParseGroups("usemtl a\n"), IoError);
}

TEST(ObjReader, RefusesPlacesBeyondTheRayCastersReach) {
  const std::string got = IoErrorOf([] { Parse("v 0 0 0\nv 1 0 0\nv 0 -2e12 0\nf 1 2 3\n"); });
  EXPECT_NE(got.find("shape.obj:3: a coordinate is beyond 1e12"), std::string::npos) << got;
}

TEST(ObjReader, AllowsFacesBeforeTheirVertices) {
  EXPECT_EQ(Parse(std::string("f 1 2 3\n") + kSquare).triangles.size(), 1U);
}

TEST(ObjReader, WeldsPositionsButKeepsSeparateIndices) {
  const Mesh mesh = Parse(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv -0.0 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 "
      "0.5\n"
      "f 1/1 2/2 3/3\nf 4/4 5/2 6/1\n");
  EXPECT_EQ(mesh.positions.size(), 4U);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(mesh.uv_triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 1, 0}}));
  EXPECT_NO_THROW(ValidateMesh(mesh, "welded"));
}

TEST(ObjReader, ColorsFollowPositionsAndSeamsStay) {
  const Mesh smooth = Parse(
      "v 0 0 0 .1 .2 .3\nv 1 0 0 1 0 0\nv 1 1 0 0 1 0\n"
      "v 1 1 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 0 .1 .2 .3\nf 1 2 3\nf 4 5 6\n");
  EXPECT_EQ(smooth.colors.size(), 4U);
  EXPECT_EQ(smooth.colors[0], (Rgb{.1, .2, .3}));
  EXPECT_EQ(smooth.color_triangles, smooth.triangles);
  const Mesh seam = Parse(
      "v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 1 1 0 1 1 1\nv 0 1 0 1 1 1\nv 0 0 0 0 0 0\n"
      "f 1 2 3\nf 5 3 4\n");
  EXPECT_EQ(seam.positions.size(), 4U);
  EXPECT_EQ(seam.colors.size(), 5U);
  EXPECT_EQ(seam.colors[static_cast<std::size_t>(seam.color_triangles[0][0])], (Rgb{1, 1, 1}));
  EXPECT_EQ(seam.colors[static_cast<std::size_t>(seam.color_triangles[1][0])], (Rgb{0, 0, 0}));
}

TEST(ObjReader, RefusesWithFileAndLine) {
  const std::pair<std::string, std::string> cases[] = {
      {"v 0 0 nan\n", "shape.obj:1: 'nan' is not a finite number"},
      {"v 0 0 0\nv 0 inf 0\n", ":2: 'inf'"},
      {"v 0 1e999 0\n", ":1: '1e999'"},
      {"v 0 0\n", ":1: 'v' takes"},
      {"v 0 0 0 0 0\n", ":1: 'v' takes"},
      {"v 0 0 0\nv 0 0 0 1 1 1\n", ":2: either all vertices have a colour or none"},
      {"v 0 0 0 1 1 1\nv 0 0 0\n", ":2: either all"},
      {"\n\nvn 0 0\n", ":3: 'vn' takes 3"},
      {std::string(kSquare) + "f 1 2\n", ":5: a face needs at least 3"},
      {std::string(kSquare) + "f 0 1 2\n", ":5: '0' is not an index"},
      {std::string(kSquare) + "f 1 2 -5\n", ":5: '-5' is not an index"},
      {std::string(kSquare) + "f 1 2 x\n", ":5: 'x' is not an index"},
      {std::string(kSquare) + "f 1 2 5\n", ":5: vertex index 5 is out of range, the file has 4"},
      {std::string(kSquare) + "f 1/1 2/1 3/1\n", ":5: texture vertex index 1 is out of range"},
      {std::string(kSquare) + "vn 0 0 1\nf 1//1 2//1 3//2\n", ":6: normal index 2"},
      {std::string(kSquare) + "vt 0 0\nf 1/1 2 3\n", ":6: the corners of a face must all"},
      {std::string(kSquare) + "f 1/ 2/ 3/\n", ":5: '1/' is not a face corner"},
      {std::string(kSquare) + "f 1/1/1/1 2 3\n", ":5:"},
      {std::string(kSquare) + "f 1 2 99999999999\n", ":5: '99999999999' is not an index"},
      {std::string(kSquare) + "curv 0 1 1 2\n", ":5: unknown statement 'curv'"},
      {kSquare, "has no face"},
      {"", "has no face"},
  };
  for (const auto& [text, message] : cases) {
    const std::string got = IoErrorOf([&file = text] { Parse(file); });
    EXPECT_NE(got.find(message), std::string::npos) << got << "\nwanted " << message;
  }
}

TEST(ObjReader, SurvivesCutAndDamagedFiles) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Write(
      "shape.obj", std::string(kSquare) + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\n");
  const auto read = [](const std::filesystem::path& file) { ReadObj(file); };
  // Without the third corner there is no face.
  ExpectCutFilesRefused(path, ReadWholeFile(path).find(" 3/1/1"), 100, read);
  ExpectDamagedFilesSurvived(path, 200, read);
  ExpectDamagedFilesSurvived(
      folder.Write("parts.obj", kParts), 200, [](const auto& file) { ReadObjGroups(file); });
}

TEST(MeshFile, ChoosesByExtension) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadMesh(folder.Write("A.OBJ", std::string(kSquare) + "f 1 2 3")).triangles.size(), 1U);
  EXPECT_NE(IoErrorOf([&] { ReadMesh(folder.Write("a.3ds", "")); }).find(".obj, .ply"),
            std::string::npos);
  EXPECT_NE(IoErrorOf([&] { ReadMeshGroups(folder.Write("a.ply", "")); }).find("have no groups"),
            std::string::npos);
  EXPECT_THROW(ReadMesh(folder.Path() / "none.ply"), IoError);
}

}  // namespace
}  // namespace pathfit::renderer::obj_reader_test
