#include "app/output/viewed_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "app/output/report_images.h"
#include "app/output/sha256.h"
#include "app/output/vector_json.h"
#include "optim/problem/photo_density.h"
#include "renderer/core/check.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/image/color.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_assembly.h"
#include "renderer/math/box.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::app {
namespace {

using renderer::Index;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using renderer::SplitMesh;
using renderer::Vec3;

constexpr int kModelVersion = 1;
constexpr int kJpegQuality = 90;
constexpr double kSteps = 65535.0;
static_assert(std::endian::native == std::endian::little, "buffers are written as they are");

template <class T>
std::string Buffer(const std::vector<T>& items) {
  std::string bytes(items.size() * sizeof(T), '\0');
  std::copy_n(std::as_bytes(std::span(items)).begin(),
              bytes.size(),
              std::as_writable_bytes(std::span(bytes)).begin());
  return Base64(bytes);
}

std::uint8_t Byte(double share) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
}

std::vector<std::uint8_t> EncodedBytes(const Rgb& linear) {
  std::vector<std::uint8_t> bytes;
  for (int c = 0; c < 3; ++c) {
    bytes.push_back(Byte(renderer::ClampedSrgb(linear[c])));
  }
  return bytes;
}

std::string TextureUri(const renderer::Texture& texture) {
  renderer::Image image(texture.width, texture.height, 3);
  for (std::size_t i = 0; i < texture.texels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      image.data[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(texture.texels[i][c]);
    }
  }
  image = ReducedImage(image, kViewedTexturePx);
  const std::vector<unsigned char> jpeg =
      renderer::EncodeJpeg(texture.scalar ? image : EncodedImage(image), kJpegQuality);
  return DataUri({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
}

Json TextureJson(int index, const Scene& scene) {
  const renderer::Texture& texture = scene.textures.at(Index(index));
  return {{"uri", TextureUri(texture)},
          {"size_px", Json::array({texture.width, texture.height})},
          {"repeat", texture.wrap == renderer::TextureWrap::kRepeat}};
}

/// How many fitted photos show each vertex, mesh after mesh.
std::vector<std::vector<int>> VertexCounts(const Scene& scene,
                                           const optim::ObservationSet& observations,
                                           double scale) {
  std::vector<optim::SurfacePoint> points;
  for (const renderer::SceneMesh& placed : scene.meshes) {
    Mesh world = renderer::WorldMesh(placed);
    renderer::ComputeVertexNormals(world);
    const Mesh& mesh = world;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      points.push_back({mesh.positions[i], mesh.normals[i]});
    }
  }
  // Of all at once: each photo is decoded, and the scene made ready for rays, one time.
  const std::vector<int> all = optim::PhotoCounts(scene, observations, scale, points);
  std::vector<std::vector<int>> counts;
  auto next = all.begin();
  for (const renderer::SceneMesh& placed : scene.meshes) {
    const auto end = next + static_cast<std::ptrdiff_t>(placed.mesh.positions.size());
    counts.emplace_back(next, end);
    next = end;
  }
  return counts;
}

void AddPositions(const Mesh& mesh, const SplitMesh& split, Json& json) {
  const auto [low, high] = renderer::BoxAround(mesh.positions.Items());
  std::vector<std::uint16_t> steps;
  for (const renderer::SplitVertex& vertex : split.vertices) {
    const Vec3& position = mesh.positions[Index(vertex.position)];
    for (int c = 0; c < 3; ++c) {
      const double size = high[c] - low[c];
      const double share = size > 0.0 ? (position[c] - low[c]) / size : 0.0;
      steps.push_back(static_cast<std::uint16_t>(std::lround(kSteps * share)));
    }
  }
  json["box"] = Json::array({Components(low), Components(high)});
  json["positions"] = Buffer(steps);
}

void AddTriangles(const SplitMesh& split, Json& json) {
  std::vector<std::uint32_t> wide;
  for (const renderer::Triangle& triangle : split.triangles) {
    for (const std::int32_t corner : triangle) wide.push_back(static_cast<std::uint32_t>(corner));
  }
  const bool narrow = split.vertices.size() <= static_cast<std::size_t>(kSteps) + 1;
  json["triangles"] =
      narrow ? Buffer(std::vector<std::uint16_t>(wide.begin(), wide.end())) : Buffer(wide);
}

/// An attribute of split vertices, from a list that they index.
template <class T, class Append>
std::string Gathered(const SplitMesh& split,
                     std::int32_t renderer::SplitVertex::*index,
                     const Append& append) {
  std::vector<T> items;
  for (const renderer::SplitVertex& vertex : split.vertices) append(Index(vertex.*index), items);
  return Buffer(items);
}

void AddSurface(const Mesh& mesh,
                const SplitMesh& split,
                const renderer::Material& material,
                const Scene& scene,
                Json& json) {
  if (material.vertex_colors) {
    json["colors"] = Gathered<std::uint8_t>(
        split, &renderer::SplitVertex::color, [&](std::size_t i, auto& bytes) {
          for (const std::uint8_t byte : EncodedBytes(mesh.colors[i])) bytes.push_back(byte);
        });
  } else if (material.base_color_texture >= 0) {
    json["texture"] = TextureJson(material.base_color_texture, scene);
  } else {
    json["color"] = EncodedBytes(material.base_color);
  }
  if (const auto* bsdf = std::get_if<renderer::MetallicRoughnessBsdf>(&material.bsdf)) {
    json["roughness"] = bsdf->roughness;
    if (material.roughness_texture >= 0) {
      json["roughness_texture"] = TextureJson(material.roughness_texture, scene);
    }
    json["metallic"] = bsdf->metallic;
    if (material.metallic_texture >= 0) {
      json["metallic_texture"] = TextureJson(material.metallic_texture, scene);
    }
  }
  if (json.contains("texture") || json.contains("roughness_texture") ||
      json.contains("metallic_texture")) {
    json["uvs"] =
        Gathered<float>(split, &renderer::SplitVertex::uv, [&](std::size_t i, auto& values) {
          values.push_back(static_cast<float>(mesh.uvs[i].x));
          values.push_back(static_cast<float>(mesh.uvs[i].y));
        });
  }
}

Json MeshJson(std::size_t index,
              const Scene& scene,
              const std::vector<int>& counts,
              const StandardErrorsByName& errors) {
  const renderer::SceneMesh& placed = scene.meshes[index];
  const renderer::Material& material = scene.materials.at(Index(placed.material));
  Mesh world = renderer::WorldMesh(placed);
  if (!world.normal_triangles.empty()) renderer::NormalizeVertexNormals(world);
  // What the material does not use would split vertices.
  if (!material.vertex_colors) {
    world.colors.clear();
    world.color_triangles.clear();
  }
  if (material.base_color_texture < 0 && material.roughness_texture < 0 &&
      material.metallic_texture < 0) {
    world.uvs.clear();
    world.uv_triangles.clear();
  }
  const Mesh& mesh = world;
  const SplitMesh split = renderer::SplitVertices(mesh);
  Json json = {{"name", placed.name},
               {"num_vertices", split.vertices.size()},
               {"num_triangles", split.triangles.size()}};
  AddPositions(mesh, split, json);
  AddTriangles(split, json);
  if (!mesh.normal_triangles.empty()) {
    json["normals"] = Gathered<std::int8_t>(
        split, &renderer::SplitVertex::normal, [&](std::size_t i, auto& bytes) {
          for (int c = 0; c < 3; ++c) {
            const double part = std::clamp(mesh.normals[i][c], -1.0, 1.0);
            bytes.push_back(static_cast<std::int8_t>(std::lround(127.0 * part)));
          }
        });
  }
  AddSurface(mesh, split, material, scene, json);
  json["photos"] = Gathered<std::uint8_t>(
      split, &renderer::SplitVertex::position, [&](std::size_t i, auto& bytes) {
        bytes.push_back(static_cast<std::uint8_t>(std::min(counts[i], 255)));
      });
  const auto add_errors = [&](const char* key,
                              ParameterKind kind,
                              std::size_t num_blocks,
                              std::int32_t renderer::SplitVertex::*at) {
    const std::vector<double> roots =
        BlockErrors(scene, kind, static_cast<int>(index), num_blocks, errors);
    if (roots.empty()) return;
    json[key] = Gathered<float>(split, at, [&](std::size_t i, auto& values) {
      values.push_back(static_cast<float>(roots[i]));
    });
  };
  add_errors("position_error",
             ParameterKind::kVertexPositions,
             mesh.positions.size(),
             &renderer::SplitVertex::position);
  add_errors("color_error",
             ParameterKind::kVertexColors,
             mesh.colors.size(),
             &renderer::SplitVertex::color);
  return json;
}

Json CameraJson(const renderer::Camera& camera, const optim::View& view) {
  const renderer::Transform pose = renderer::CameraPose(camera);
  const renderer::Mat3 rows = renderer::Transposed(pose.linear);
  Json matrix = Json::array();
  for (int r = 0; r < 3; ++r) {
    const Vec3& row = r == 0 ? rows.x : r == 1 ? rows.y : rows.z;
    matrix.push_back(Json::array({row.x, row.y, row.z, pose.translation[r]}));
  }
  return {{"name", view.name},
          {"validation", view.validation},
          {"size_px", Json::array({camera.width, camera.height})},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"parallel", camera.projection == renderer::ProjectionKind::kOrthographic},
          {"world_from_camera", std::move(matrix)}};
}

}  // namespace

Json ViewedModel(const Scene& scene,
                 const optim::ObservationSet& observations,
                 const StandardErrorsByName& errors) {
  PATHFIT_CHECK(scene.sensors.size() == observations.views.size());
  int longest = 1;
  Json cameras = Json::array();
  for (std::size_t i = 0; i < scene.sensors.size(); ++i) {
    const renderer::Camera& camera = scene.sensors[i];
    longest = std::max({longest, camera.width, camera.height});
    cameras.push_back(CameraJson(camera, observations.views[i]));
  }
  const double scale = std::min(1.0, static_cast<double>(kThumbnailPx) / longest);
  Json json = {{"version", kModelVersion}, {"meshes", Json::array()}};
  const std::vector<std::vector<int>> counts = VertexCounts(scene, observations, scale);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    json["meshes"].push_back(MeshJson(i, scene, counts[i], errors));
  }
  json["cameras"] = std::move(cameras);
  for (const renderer::Emitter& emitter : scene.emitters) {
    const auto* environment = std::get_if<renderer::EnvironmentEmitter>(&emitter.light);
    if (environment == nullptr) continue;
    const renderer::Mat3 turn = renderer::RotationFromVector(emitter.rotation);
    json["environment"] = {
        {"frame", emitter.frame == renderer::LightFrame::kWorld ? "world" : "camera"},
        {"frame_from_light", RowsJson(turn * environment->frame_from_light)}};
  }
  return json;
}

void WriteViewedModel(const std::filesystem::path& path, const Json& model) {
  renderer::WriteFileAtomically(path, JsonText(model, -1) + "\n");
}

Json ReadViewedModel(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return nullptr;
  const std::string text = renderer::ReadWholeFile(path);
  try {
    Json json = Json::parse(text);
    if (json.at("version") != kModelVersion) return nullptr;  // another version's: nothing to draw
    if (!json.at("meshes").is_array() || !json.at("cameras").is_array()) {
      throw renderer::IoError(path.string() + ": is not a model of a run");
    }
    return json;
  } catch (const Json::exception& e) {
    throw renderer::IoError(path.string() + ": is not a model of a run: " + e.what());
  }
}

}  // namespace pathfit::app
