#include "tests/fuzz/fuzz_targets.h"

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>

#include <nlohmann/json.hpp>

#include "app/config/config_error.h"
#include "app/output/export_cameras.h"
#include "app/output/fit_history.h"
#include "app/output/report.h"
#include "app/output/run_directory.h"
#include "app/output/run_record.h"
#include "app/output/viewed_model.h"
#include "optim/checkpoint/checkpoint.h"
#include "optim/observation/camera_import.h"
#include "optim/observation/exif_exposure.h"
#include "optim/observation/lamp_list.h"
#include "renderer/geometry/mesh.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/color_profile.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/gltf_reader.h"
#include "renderer/io/gltf_writer.h"
#include "renderer/io/image_check.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_file.h"
#include "renderer/io/ply_file.h"
#include "renderer/io/raw_file.h"
#include "tests/app/config/config_text.h"
#include "tests/optim/observation/camera_texts.h"
#include "tests/optim/observation/exif_bytes.h"
#include "tests/renderer/io/dng_bytes.h"
#include "tests/renderer/io/icc_bytes.h"
#include "tests/support/compressed_gltf.h"
#include "tests/support/test_scenes.h"

namespace pathfit::tests {
namespace {

namespace fs = std::filesystem;
using renderer::BytesOf;
using renderer::Image;

template <class... Values>
std::string Binary(Values... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
  return bytes;
}

// --- Meshes -------------------------------------------------------------------------------------

renderer::Mesh SeedMesh(bool with_all) {
  renderer::Mesh mesh = renderer::MakeIcosphere(0, 1.0);
  if (with_all) renderer::SetUniformVertexColors({0.2, 0.5, 0.7}, mesh);
  return mesh;
}

constexpr const char* kObj = R"(# a cube's corner
mtllib none.mtl
o corner
g one two
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
vt 0 0
vt 1 0
vt 1 1
vn 0 0 1
usemtl red
f 1/1/1 2/2/1 3/3/1 4/3/1
g other
f -5//-1 -4//-1 -1//1
)";

constexpr const char* kPly = R"(ply
format ascii 1.0
comment made by hand
element vertex 4
property float x
property float y
property double z
property uchar red
property uchar green
property uchar blue
property float s
property float t
element face 2
property list uchar int vertex_indices
end_header
0 0 0 255 0 0 0 0
1 0 0 0 255 0 1 0
1 1 0 0 0 255 1 1
0 1 0 9 9 9 0 1
3 0 1 2
4 0 1 2 3
)";

/// A triangle with its numbers in the file, and a node for all that is read beside it.
constexpr const char* kGltf = R"({"asset": {"version": "2.0"}, "scene": 0,
"scenes": [{"nodes": [0, 1, 2]}],
"nodes": [{"name": "n", "mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1], "children": [3]},
 {"camera": 0, "rotation": [0, 0.70710678, 0, 0.70710678], "translation": [0, 0, 3]},
 {"extensions": {"KHR_lights_punctual": {"light": 0}}}, {"scale": [1, 2, 1], "mesh": 0}],
"cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.5, "znear": 0.1}}],
"meshes": [{"name": "m", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0,
 "mode": 4}]}],
"materials": [{"name": "mat", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.2, 0.1, 1],
 "roughnessFactor": 0.4, "metallicFactor": 0.2}, "emissiveFactor": [1, 1, 1], "doubleSided": true,
 "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 3}}}],
"extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"],
"extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 5,
 "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}]}},
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
 "min": [0, 0, 0], "max": [1, 1, 0]}, {"bufferView": 1, "componentType": 5123, "count": 3,
 "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36, "target": 34962},
 {"buffer": 0, "byteOffset": 36, "byteLength": 6, "target": 34963}],
"buffers": [{"byteLength": 42,
 "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA"}]})";

std::string GlbSeed(const fs::path& folder) {
  renderer::Mesh mesh = renderer::MakeRectangle();
  if (mesh.uvs.empty()) mesh = SeedMesh(true);
  renderer::GlbMaterial material;
  material.emission = {2.0, 1.0, 0.5};
  renderer::WriteGlb(folder / "seed.glb", mesh, material);
  return renderer::ReadWholeFile(folder / "seed.glb");
}

void AddMeshes(const fs::path& folder, std::vector<FuzzTarget>& targets) {
  std::vector<FileSet> ply = {{{"m.ply", kPly}}};
  for (const bool with_all : {false, true}) {
    renderer::WritePly(folder / "seed.ply", SeedMesh(with_all));
    ply.push_back({{"m.ply", renderer::ReadWholeFile(folder / "seed.ply")}});
  }
  std::string big = kPly;  // binary of the other byte order, cut
  big.replace(big.find("ascii"), 5, "binary_big_endian");
  ply.push_back({{"m.ply", big}});
  targets.push_back({"ply",
                     ply,
                     {"element",
                      "property",
                      "list",
                      "uchar",
                      "double",
                      "int",
                      "vertex",
                      "face",
                      "end_header\n",
                      "binary_little_endian",
                      "vertex_indices",
                      "nx",
                      "uint"},
                     [](const fs::path& at) { renderer::ReadMesh(at / "m.ply"); },
                     {}});
  targets.push_back({"obj",
                     {{{"m.obj", kObj}}},
                     {"f ", "v ", "vt ", "vn ", "//", "/", "\\\n", "-1", "usemtl", "\ng ", "\n"},
                     [](const fs::path& at) {
                       renderer::ReadMesh(at / "m.obj");
                       renderer::ReadMeshGroups(at / "m.obj");
                     },
                     {}});
  const std::string stl_text =
      "solid a\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1e0 0\n"
      " endloop\nendfacet\nendsolid a\n";
  std::string stl_bytes(84 + 2 * 50, '\x01');
  stl_bytes.replace(80, 4, {'\x02', '\0', '\0', '\0'});
  targets.push_back(
      {"stl",
       {{{"m.stl", stl_text}}, {{"m.stl", stl_bytes}}},
       {"solid", "endsolid\n", "facet ", "outer loop\n", "vertex ", "endloop\n", "\n"},
       [](const fs::path& at) { renderer::ReadMesh(at / "m.stl"); },
       {}});
  targets.push_back({"gltf",
                     {{{"m.gltf", kGltf}}},
                     {"\"byteOffset\":",
                      "\"sparse\":",
                      "\"normalized\": true,",
                      "5121",
                      "5125",
                      "\"VEC4\"",
                      "\"MAT4\"",
                      "[]",
                      "{}",
                      "null",
                      "-1",
                      "4294967295",
                      "\"KHR_texture_transform\"",
                      "\"skin\": 0,",
                      "\"uri\": \"../x\"",
                      "\"mode\": 5"},
                     [](const fs::path& at) { renderer::ReadGltf(at / "m.gltf"); },
                     {}});
  targets.push_back({"glb",
                     {{{"m.glb", GlbSeed(folder)}},
                      {{"m.glb", WithMeshopt(GlbSeed(folder), false)}},
                      {{"m.glb", WithMeshopt(GlbSeed(folder), true)}},
                      {{"m.glb", WithDraco(GlbSeed(folder), 0)}},
                      {{"m.glb", WithDraco(GlbSeed(folder), 10)}}},
                     {"JSON", "BIN", "\"count\":", "5126", "}", "]"},
                     [](const fs::path& at) { renderer::ReadGltf(at / "m.glb"); },
                     {}});
}

// --- Images -------------------------------------------------------------------------------------

Image SeedImage(int channels) {
  Image image(13, 9, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<float>(i % 17) / 16.0F;
  }
  return image;
}

/// Width, height, bits, strips: little endian, one strip, not compressed.
std::string TiffSeed(std::uint16_t bits, std::uint16_t format) {
  constexpr std::uint32_t kWidth = 5, kHeight = 4;
  const std::uint32_t size = kWidth * kHeight * 3 * bits / 8;
  constexpr std::uint16_t kShort = 3, kLong = 4, kEntries = 10;
  constexpr std::uint32_t kBits = 8 + 2 + kEntries * 12 + 4, kData = kBits + 6;
  std::string bytes = "II" + Binary(std::uint16_t{42}, std::uint32_t{8}, kEntries);
  const auto entry =
      [&](std::uint16_t tag, std::uint16_t type, std::uint32_t count, std::uint32_t value) {
        bytes += Binary(tag, type, count, value);
      };
  entry(256, kLong, 1, kWidth);
  entry(257, kLong, 1, kHeight);
  entry(258, kShort, 3, kBits);
  entry(259, kShort, 1, 1);
  entry(262, kShort, 1, 2);
  entry(273, kLong, 1, kData);
  entry(277, kShort, 1, 3);
  entry(278, kLong, 1, kHeight);
  entry(279, kLong, 1, size);
  entry(339, kShort, 1, format);
  bytes += Binary(std::uint32_t{0}, bits, bits, bits);
  return bytes + std::string(size, '\x20');
}

/// Checksums of all chunks of a PNG file, so that damage reaches what is behind them.
void MendPng(std::string& bytes) {
  constexpr std::size_t kSignature = 8;
  const auto big = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      value = value << 8U | static_cast<unsigned char>(bytes[at + i]);
    }
    return value;
  };
  for (std::size_t at = kSignature; at + 12 <= bytes.size();) {
    const std::size_t size = big(at);
    if (size > bytes.size() - at - 12) return;
    std::uint32_t crc = ~0U;
    for (std::size_t i = at + 4; i < at + 8 + size; ++i) {
      crc ^= static_cast<unsigned char>(bytes[i]);
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1U ^ (0xEDB88320U & (0U - (crc & 1U)));
    }
    crc = ~crc;
    for (std::size_t i = 0; i < 4; ++i) {
      bytes[at + 8 + size + i] = static_cast<char>(crc >> (24U - 8U * i));
    }
    at += size + 12;
  }
}

void AddImages(const fs::path& folder, std::vector<FuzzTarget>& targets) {
  renderer::WriteExr(folder / "three.exr", SeedImage(3));
  renderer::WriteExr(folder / "four.exr", SeedImage(4));
  renderer::WriteHdr(folder / "seed.hdr", SeedImage(3));
  const auto read = [](const fs::path& at) { renderer::ReadImageFile(at / "image", true); };
  const auto add = [&](const char* name,
                       const std::vector<std::string>& seeds,
                       const std::vector<std::string>& words,
                       const std::function<void(std::string&)>& mend = {}) {
    FuzzTarget target{name, {}, words, read, mend};
    for (const std::string& seed : seeds) target.seeds.push_back({{"image", seed}});
    targets.push_back(std::move(target));
  };
  add("png",
      {BytesOf(renderer::EncodePng(SeedImage(3))),
       BytesOf(renderer::EncodePng(SeedImage(1))),
       renderer::PngWith(renderer::RgbProfile(renderer::kP3), SeedImage(3))},
      {"IHDR", "IDAT", "PLTE", "tRNS", "gAMA", "iCCP", "IEND", "acTL"},
      MendPng);
  add("jpeg",
      {optim::WithExif(renderer::EncodeJpeg(SeedImage(3), 80), optim::ExifBlock({})),
       BytesOf(renderer::EncodeJpeg(SeedImage(1), 95))},
      {"\xff\xc0", "\xff\xc2", "\xff\xda", "\xff\xd8", "\xff\xd9", "\xff\xe1", "\xff\xdd"});
  add("tiff", {TiffSeed(8, 1), TiffSeed(16, 1), TiffSeed(32, 3)}, {"MM", "II"});
  add("hdr",
      {renderer::ReadWholeFile(folder / "seed.hdr")},
      {"-Y ", "+X ", "EXPOSURE=", "FORMAT=32-bit_rle_xyze", "\n", "#?RADIANCE"});
  add("exr",
      {renderer::ReadWholeFile(folder / "three.exr"), renderer::ReadWholeFile(folder / "four.exr")},
      {"chlist", "tiles", "dataWindow", "box2i", "compression", "lineOrder", "chromaticities"});
  if (!renderer::LibRawVersion().empty()) {
    const auto share = [](int x, int y, int channel) { return (x + y + channel) % 7 / 6.0; };
    targets.push_back({"raw",
                       {{{"image.dng", renderer::DngBytes({}, share)}}},
                       {"II", "MM", "Canon", "NIKON", "SONY", "FUJIFILM"},
                       [](const fs::path& at) { renderer::ReadRawFile(at / "image.dng", {}); },
                       {}});
  }
  targets.push_back({"icc",
                     {{{"icc", renderer::RgbProfile(renderer::kP3)}},
                      {{"icc", renderer::RgbProfile(renderer::kRec709, 1.8)}}},
                     {"rXYZ", "rTRC", "wtpt", "chad", "curv", "para", "mft2", "RGB ", "GRAY"},
                     [](const fs::path& at) {
                       const renderer::ColorProfile profile(renderer::ReadWholeFile(at / "icc"),
                                                            "icc");
                       static_cast<void>(profile.IsSrgb());
                       Image image = SeedImage(3);
                       profile.MakeLinear(image);
                       if (!renderer::FirstNonFinite(image).empty()) std::abort();
                     },
                     {}});
  targets.push_back({"exif",
                     {{{"exif", optim::ExifBlock({})}},
                      {{"exif", optim::ExifBlock({}, true)}},
                      {{"exif", optim::ColorBlock('\xff', "R03")}}},
                     {"II", "MM"},
                     [](const fs::path& at) {
                       const std::string bytes = renderer::ReadWholeFile(at / "exif");
                       static_cast<void>(optim::ParseExifExposure(bytes));
                       static_cast<void>(optim::ParseExifLens(bytes));
                       static_cast<void>(optim::NamesAdobeRgb(bytes));
                     },
                     {}});
}

// --- Cameras ------------------------------------------------------------------------------------

std::string LlffSeed() {
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 17), }";
  header.resize(117, ' ');
  std::string bytes = std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header + "\n";
  for (int i = 0; i < 2; ++i) {
    for (const double value : {1.0,
                               0.0,
                               0.0,
                               -2.0,
                               4.0,
                               0.0,
                               0.0,
                               -1.0,
                               -3.0,
                               6.0,
                               0.0,
                               1.0,
                               0.0,
                               -1.0,
                               5.0,
                               0.5,
                               9.0}) {
      bytes += Binary(value);
    }
  }
  return bytes;
}

constexpr const char* kCameraList = R"(size_px: [200, 120]
focal_px: 200
principal_point_px: [100.5, 60.25]
cameras:
- {image: a.png, axes: opencv, world_from_camera: [[0, 1, 0, -2], [0, 0, 1, -3], [1, 0, 0, -1]]}
- image: c.png
  mask: c_mask.png
  type: orthographic
  look_at: {origin: [-2, -3, -1], target: [-2, -3, 5], up: [-1, 0, 0]}
)";

void AddLamps(std::vector<FuzzTarget>& targets) {
  const std::vector<std::string> words = {"1e308", "-1", "#", ",", "nan", "a.png", "0 0 1"};
  targets.push_back({"lamps",
                     {{{"l.txt", "3\na b.png 0 0 1\nc.png 0.6 0 0.8\nd.png 0 -0.6 0.8\n"}},
                      {{"l.txt", "1 0 0 1 2 3 4\n2 0 1 1 3 3 3\n"}},
                      {{"l.txt", "0.6 0 -0.6 0\n0 0.6 0 -0.6\n0.8 0.8 0.8 0.8\n"}}},
                     words,
                     [](const fs::path& at) { optim::ReadLampList(at / "l.txt"); },
                     {}});
}

void AddCameras(std::vector<FuzzTarget>& targets) {
  const renderer::Scene scene = BallAndWall();
  std::vector<renderer::Camera> cameras(scene.sensors.begin(), scene.sensors.begin() + 1);
  cameras[0].distortion = {.k1 = 0.01, .k2 = -0.02, .k3 = 0.0, .p1 = 1e-3, .p2 = 0.0};
  const app::ColmapText colmap = app::ColmapModel(cameras, {"a photo.jpg"});
  const auto import = [](const char* file) {
    return [file](const fs::path& at) { optim::ImportCameras(at / file, "auto"); };
  };
  const auto add = [&](const char* name,
                       const std::vector<FileSet>& seeds,
                       const char* file,
                       const std::vector<std::string>& words) {
    targets.push_back({name, seeds, words, import(file), {}});
  };
  const std::vector<std::string> json = {
      "[]", "{}", "null", "\"\"", "[[", "-1", "\"1e400\"", "true"};
  std::string frames = app::TransformsJson(cameras, {"a.png"}, 0.5);
  std::string applied = frames;
  applied.insert(1,
                 R"("applied_transform": [[1,0,0,1],[0,0,1,0],[0,-1,0,0]], "applied_scale": 2,)");
  add("transforms", {{{"t.json", frames}}, {{"t.json", applied}}}, "t.json", json);
  add("alicevision", {{{"c.sfm", kAliceVision}}}, "c.sfm", json);
  add("colmap_text",
      {{{"cameras.txt", colmap.cameras}, {"images.txt", colmap.images}}},
      "cameras.txt",
      {"PINHOLE", "OPENCV", "FULL_OPENCV", "RADIAL", "\n\n", "# ", "nan"});
  const std::string binary_cameras = Binary(std::uint64_t{1},
                                            std::uint32_t{7},
                                            std::int32_t{4},
                                            std::uint64_t{200},
                                            std::uint64_t{120},
                                            200.0,
                                            200.0,
                                            100.0,
                                            60.0,
                                            0.1,
                                            0.2,
                                            0.01,
                                            0.02);
  const std::string binary_images =
      Binary(
          std::uint64_t{1}, std::uint32_t{1}, 0.5, 0.5, 0.5, 0.5, 1.0, 2.0, 3.0, std::uint32_t{7}) +
      std::string("a.jpg\0", 6) + Binary(std::uint64_t{1}, 1.5, 2.5, std::uint64_t{9});
  add("colmap_binary",
      {{{"cameras.bin", binary_cameras}, {"images.bin", binary_images}}},
      "cameras.bin",
      {});
  const auto add_points = [&](const char* name, const char* file, const std::string& seed) {
    targets.push_back(
        {name,
         {{{file, seed}}},
         {"nan", "# ", "\n"},
         [file](const fs::path& at) { static_cast<void>(optim::ReadSparsePoints(at / file)); },
         {}});
  };
  add_points("colmap_points_text", "points3D.txt", "# 3D\n1 1 2 3 4 5 6 0.1 1 2 3 4 5 6\n");
  std::string with_points = kAliceVision;
  with_points.insert(with_points.rfind('}'),
                     R"(, "structure": [{"landmarkId": "1", "X": ["1", "2", "-3e0"],
                        "observations": [{"x": ["1", "2"]}, {}, {}]}])");
  add_points("alicevision_points", "c.sfm", with_points);
  add_points("colmap_points_binary",
             "points3D.bin",
             Binary(std::uint64_t{1}, std::uint64_t{7}, 1.0, 2.0, 3.0) + std::string("abc") +
                 Binary(0.5, std::uint64_t{1}, std::uint64_t{3}));
  const std::vector<std::string> xml = {
      "<", ">", "</", "/>", "<!--", "<![CDATA[", "&amp;", "&#0;", "\"", "<data>", "<_>"};
  std::string placed = kMetashape;
  const std::string component = "label=\"Component 1\">";
  placed.insert(placed.find(component) + component.size(),
                "<transform><rotation>1 0 0 0 1 0 0 0 1</rotation>"
                "<translation>1 2 3</translation><scale>2</scale></transform>");
  placed.insert(placed.find("</chunk>"),
                "<reference>LOCAL_CS[\"L\",LOCAL_DATUM[\"L\",0],UNIT[\"metre\",1]]</reference>");
  add("metashape", {{{"c.xml", placed}}}, "c.xml", xml);
  add("opencv_xml", {{{"c.xml", kOpencvXml}}}, "c.xml", xml);
  std::string lists = kOpencvYaml;
  const std::size_t poses = lists.find("extrinsic_parameters");
  lists.replace(poses, lists.find("images:") - poses, "rvecs: [[1, 0, 2]]\ntvecs: [[1, 2, 3]]\n");
  add("opencv_yaml",
      {{{"c.yml", kOpencvYaml}}, {{"c.yml", lists}}},
      "c.yml",
      {"&a ", "*a", "{", "}", "[", "]", "- ", ": ", "!!binary ", "|\n", "---\n", "? ", "%"});
  add("camera_list",
      {{{"c.yaml", app::CameraListYaml(cameras, {"a photo.jpg"}, 0.5)}}, {{"c.yaml", kCameraList}}},
      "c.yaml",
      {"&a ",
       "*a",
       "{",
       "}",
       "[",
       "]",
       "- ",
       ": ",
       "axes: opencv",
       "look_at",
       "~",
       "\ncameras:\n"});
  const std::string picture = BytesOf(renderer::EncodePng(Image(2, 2, 3)));
  targets.push_back({"llff",
                     {{{"poses_bounds.npy", LlffSeed()}}},
                     {"'descr'", "'<f4'", "True", "(", ")", ",", "'shape'", "17"},
                     [picture](const fs::path& at) {
                       for (const char* name : {"a.png", "b.png"}) {
                         if (!fs::exists(at / name)) std::ofstream(at / name) << picture;
                       }
                       optim::ImportCameras(at / "poses_bounds.npy", "auto");
                     },
                     {}});
}

// --- Runs ---------------------------------------------------------------------------------------

struct CheckpointSeed {
  renderer::Scene start = BallAndWall();
  std::vector<optim::UnknownSpec> unknowns = std::vector<optim::UnknownSpec>(1);

  CheckpointSeed() { unknowns[0].kind = renderer::ParameterKind::kVertexPositions; }
  [[nodiscard]] optim::FitOrigin Origin() const { return {start, unknowns}; }
};

/// The checksum of a checkpoint's payload, as the format says.
void MendCheckpoint(std::string& bytes) {
  using nlohmann::json;
  json file;
  try {  // some mistakes throw whatever is asked for
    file = json::from_cbor(bytes);
  } catch (const json::exception&) {
    return;
  }
  if (!file.is_object() || !file.contains("payload") || !file["payload"].is_binary()) return;
  std::uint32_t crc = ~0U;
  for (const std::uint8_t byte : file["payload"].get_binary()) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1U ^ (0x82F63B78U & (0U - (crc & 1U)));
  }
  file["crc32c"] = ~crc;
  const std::vector<std::uint8_t> mended = json::to_cbor(file);
  bytes.assign(mended.begin(), mended.end());
}

void AddRuns(const fs::path& folder, std::vector<FuzzTarget>& targets) {
  const auto seed = std::make_shared<CheckpointSeed>();
  optim::FitState state;
  state.fingerprint = "views 3";
  state.sequence = 1;
  state.costs = {0.3, 0.2};
  state.standard_errors = {{"ball.translation", {0.1, 0.2, 0.3}}};
  state.scene = state.stage_start = state.level_scene = seed->start;
  state.scene.meshes[0].mesh.positions[1] = {0.5, -0.0, 5e-324};
  fs::create_directories(folder / "checkpoints");
  optim::WriteCheckpoint(folder / "checkpoints", seed->Origin(), state);
  const std::string bytes = renderer::ReadWholeFile(folder / "checkpoints" / "state_000001.cbor");
  targets.push_back(
      {"checkpoint",
       {{{"state_000001.cbor", bytes}}},
       {"\xf6", "\xa0", "\x80", "\x40", "payload", "scene", "values"},
       [seed](const fs::path& at) { optim::ReadNewestCheckpoint(at, seed->Origin()); },
       MendCheckpoint});

  app::WriteRunRecord(folder / "run.json", app::MakeRunRecord({"pathfit", "fit", "a.yaml"}));
  app::FitHistory history;
  history.rounds.resize(2);
  history.rounds[1].step = 2;
  history.stages.resize(1);
  history.parameters.resize(1);
  history.gain_errors = {0.1};
  app::WriteHistory(folder / "history.json", history);
  renderer::Scene unseen = seed->start;
  unseen.sensors.clear();
  app::WriteViewedModel(folder / "model.json", app::ViewedModel(unseen, {}, {}));
  FileSet run;
  for (const char* name : {"run.json", "history.json", "model.json"}) {
    run[name] = renderer::ReadWholeFile(folder / name);
  }
  const std::vector<std::string> json = {
      "[]", "{}", "null", "\"\"", "-1", "1e400", "</script>", "true"};
  targets.push_back({"run_json",
                     {run},
                     json,
                     [](const fs::path& at) {
                       const app::RunDirectory run_directory(at);
                       app::ReadRunRecord(run_directory.Record());
                       app::ReadHistory(run_directory.History());
                       app::ReadViewedModel(run_directory.Model());
                     },
                     {}});
  targets.push_back({"report",
                     {run},
                     json,
                     [](const fs::path& at) { app::WriteReport(app::RunDirectory(at)); },
                     {},
                     0.05});
}

void AddConfigs(std::vector<FuzzTarget>& targets) {
  targets.push_back(
      {"config",
       {{{"c.yaml", app::kFitConfig}},
        {{"c.yaml", app::kSceneConfig}},
        {{"c.yaml", app::kRichConfig}}},
       {"{}",  "[]",  "null", "~",      "[[1, 2], 3]",  "1e999", ".inf", "yes", "\"1\"",
        "- a", "\n",  "\t",   ": ",     "&a ",          "*a",    "!!x",  "#",   "'",
        "\"",  "all", "${X",  "<<: *a", "mug.vertices", "free",  "type"},
       [](const fs::path& at) {
         static_cast<void>(app::ResolvedText(app::LoadExperimentConfig(at / "c.yaml", {})));
       },
       {},
       0.2});
}

}  // namespace

std::vector<FuzzTarget> FuzzTargets(const fs::path& folder) {
  std::vector<FuzzTarget> targets;
  AddConfigs(targets);
  AddMeshes(folder, targets);
  AddImages(folder, targets);
  AddCameras(targets);
  AddLamps(targets);
  AddRuns(folder, targets);
  return targets;
}

}  // namespace pathfit::tests
