#include "app/output/export_result.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <variant>

#include <fmt/format.h>

#include "app/config/near_path.h"
#include "app/output/export_cameras.h"
#include "app/output/export_obj.h"
#include "app/output/report_images.h"
#include "app/output/run_directory.h"
#include "app/output/vector_json.h"
#include "optim/parameter/promotion.h"
#include "optim/problem/fit_views.h"
#include "optim/round/texel_fill.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/gltf_writer.h"
#include "renderer/io/image_file.h"
#include "renderer/io/ply_file.h"
#include "renderer/scene/texture_surface.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using renderer::DirectionalEmitter;
using renderer::EnvironmentEmitter;
using renderer::Mat3;
using renderer::PointEmitter;
using renderer::Rgb;
using renderer::Scene;
using renderer::Vec3;

Json EnvironmentJson(const EnvironmentEmitter& environment, const Mat3& turn) {
  return {{"type", "environment"},
          {"size_px", Json::array({environment.width, environment.height})},
          {"files", Json::array({"environment.exr", "environment.hdr"})},
          {"file_values", "radiance: intensity times texels, linear Rec.709"},
          {"intensity", Components(environment.intensity)},
          {"frame_from_light", RowsJson(turn * environment.frame_from_light)},
          {"mapping",
           "a direction d in the light's own frame is at u = atan2(d.x, -d.z) / (2 pi) mod 1 from "
           "the left and v = acos(d.y) / pi from the top; frame_from_light (rows) turns d into "
           "`frame`"}};
}

// Name of the item, null without one.
template <class List>
Json NameIn(const List& list, int index) {
  return index < 0 ? Json() : Json(list.at(static_cast<std::size_t>(index)).name);
}

Json LightJson(const renderer::Emitter& emitter, const Scene& scene) {
  const Mat3 turn = renderer::RotationFromVector(emitter.rotation);
  if (const auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light)) {
    return EnvironmentJson(*environment, turn);
  }
  if (const auto* point = std::get_if<PointEmitter>(&emitter.light)) {
    return {{"type", "point"},
            {"position_m", Components(point->position)},
            {"intensity_w_per_sr", Components(point->intensity)}};
  }
  if (const auto* directional = std::get_if<DirectionalEmitter>(&emitter.light)) {
    return {{"type", "directional"},
            {"direction", Components(turn * directional->direction)},
            {"irradiance_w_per_m2", Components(directional->irradiance)}};
  }
  if (const auto* spot = std::get_if<renderer::SpotEmitter>(&emitter.light)) {
    return {{"type", "spot"},
            {"position_m", Components(spot->position)},
            {"direction", Components(turn * -spot->frame_from_light.z)},
            {"inner_angle_rad", spot->inner_angle},
            {"outer_angle_rad", spot->outer_angle},
            {"intensity_w_per_sr", Components(spot->intensity)}};
  }
  if (const auto* projector = std::get_if<renderer::ProjectorEmitter>(&emitter.light)) {
    return {{"type", "projector"},
            {"position_m", Components(projector->position)},
            {"frame_from_light", RowsJson(turn * projector->frame_from_light)},
            {"tan_half_size", Json::array({projector->tan_half_width, projector->tan_half_height})},
            {"intensity", Components(projector->intensity)},
            {"texture", NameIn(scene.textures, projector->texture)}};
  }
  const auto& area = std::get<renderer::AreaEmitter>(emitter.light);
  return {{"type", "area"},
          {"mesh", NameIn(scene.meshes, area.mesh)},
          {"radiance", Components(area.intensity)},
          {"texture", NameIn(scene.textures, area.texture)},
          {"two_sided", area.two_sided}};
}

renderer::Image TexelImage(int width,
                           int height,
                           const std::vector<Rgb>& texels,
                           const Rgb& scale) {
  renderer::Image image(width, height, 3);
  PATHFIT_CHECK(image.data.size() == 3 * texels.size());
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const Rgb value = scale * texels[i];
    for (int c = 0; c < 3; ++c) {
      image.data[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(value[c]);
    }
  }
  return image;
}

renderer::Image TextureImage(const renderer::Texture& texture) {
  return TexelImage(texture.width, texture.height, texture.texels, {1.0, 1.0, 1.0});
}

/// A mesh where its pose places it, and what formats say of its material.
struct PlacedMesh {
  renderer::Mesh mesh;
  const renderer::Material& material;
  renderer::MetallicRoughnessBsdf bsdf{.roughness = 1.0};
  const renderer::Texture* texture = nullptr;
  const renderer::AreaEmitter* emission = nullptr;  ///< the light that it is
  [[nodiscard]] bool IsUniform() const { return !material.vertex_colors && texture == nullptr; }
};

std::optional<renderer::Texture> TextureAt(int index, const Scene& scene) {
  if (index < 0) return std::nullopt;
  return scene.textures.at(static_cast<std::size_t>(index));
}

PlacedMesh Place(std::size_t index, const Scene& scene) {
  const renderer::SceneMesh& scene_mesh = scene.meshes[index];
  PlacedMesh placed{.mesh = renderer::WorldMesh(scene_mesh),
                    .material = scene.materials.at(static_cast<std::size_t>(scene_mesh.material))};
  const renderer::Material& material = placed.material;
  if (const auto* bsdf = std::get_if<renderer::MetallicRoughnessBsdf>(&material.bsdf)) {
    placed.bsdf = *bsdf;
  } else if (std::holds_alternative<renderer::LambertBsdf>(material.bsdf)) {
    placed.bsdf.specular = 0.0;  // nothing but its colour
  }
  if (!material.vertex_colors) {
    // Colours that the material does not use would be multiplied in by viewers.
    placed.mesh.colors.clear();
    placed.mesh.color_triangles.clear();
    if (material.base_color_texture >= 0) {
      placed.texture = &scene.textures.at(static_cast<std::size_t>(material.base_color_texture));
    }
  }
  placed.emission = AreaLightOf(scene, index);
  return placed;
}

renderer::GlbMaterial GlbMaterialOf(const PlacedMesh& placed, const Scene& scene) {
  renderer::GlbMaterial glb{
      .name = placed.material.name, .bsdf = placed.bsdf, .double_sided = placed.material.two_sided};
  if (placed.texture != nullptr) glb.base_color_texture = *placed.texture;
  if (placed.IsUniform()) glb.base_color = placed.material.base_color;
  if (std::holds_alternative<renderer::MetallicRoughnessBsdf>(placed.material.bsdf)) {
    glb.roughness_texture = TextureAt(placed.material.roughness_texture, scene);
    glb.metallic_texture = TextureAt(placed.material.metallic_texture, scene);
  }
  glb.normal_texture = TextureAt(placed.material.normal_texture, scene);
  glb.normal_scale = placed.material.normal_scale;
  if (placed.emission != nullptr) {
    glb.emission = placed.emission->intensity;
    glb.emission_texture = TextureAt(placed.emission->texture, scene);
  }
  return glb;
}

std::vector<fs::path> WritePlacedGlb(const fs::path& stem,
                                     const PlacedMesh& placed,
                                     const Scene& scene,
                                     double metres_per_unit) {
  const fs::path path = fs::path(stem) += ".glb";
  renderer::WriteGlb(path, placed.mesh, GlbMaterialOf(placed, scene), metres_per_unit);
  return {path};
}

std::vector<fs::path> WritePlacedPly(const fs::path& stem, PlacedMesh placed) {
  std::vector<fs::path> written = {fs::path(stem) += ".ply"};
  if (placed.texture != nullptr) {
    written.push_back(fs::path(stem) += ".png");
    renderer::WritePng8(written.back(), EncodedImage(TextureImage(*placed.texture)));
  } else if (placed.IsUniform()) {
    renderer::SetUniformVertexColors(placed.material.base_color, placed.mesh);
  }
  renderer::WritePly(written.front(),
                     placed.mesh,
                     placed.texture != nullptr ? written.back().filename().string() : "");
  return written;
}

std::vector<fs::path> WritePlacedObj(const fs::path& stem,
                                     const PlacedMesh& placed,
                                     const Scene& scene) {
  ObjMaterial material{
      .name = placed.material.name, .base_color = placed.material.base_color, .bsdf = placed.bsdf};
  const auto image = [&](int index) {
    return index < 0 ? std::nullopt : std::optional(TextureImage(*TextureAt(index, scene)));
  };
  if (placed.texture != nullptr) material.texture = TextureImage(*placed.texture);
  material.roughness_texture = image(placed.material.roughness_texture);
  material.metallic_texture = image(placed.material.metallic_texture);
  material.normal_texture = image(placed.material.normal_texture);
  material.normal_scale = placed.material.normal_scale;
  return WriteObj(stem, placed.mesh, material);
}

bool IsUsed(const Scene& scene, int texture) {
  return !renderer::MeshesOfTexture(scene, texture).empty() || IsTextureOfLight(scene, texture);
}

std::vector<std::string> MeshFileNames(const Scene& scene) {
  std::vector<std::string> names;
  for (const renderer::SceneMesh& mesh : scene.meshes) names.push_back(mesh.name);
  return ViewFolderNames(names);
}

}  // namespace

std::vector<renderer::Camera> CamerasOfPhotos(const Scene& scene,
                                              const std::vector<ExportedView>& views) {
  PATHFIT_CHECK(scene.sensors.size() == views.size());
  std::vector<renderer::Camera> cameras = scene.sensors;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].width == 0) continue;
    cameras[i] = renderer::ScaledCamera(cameras[i], views[i].width, views[i].height);
  }
  return cameras;
}

std::vector<fs::path> WriteMeshes(const fs::path& folder,
                                  const Scene& scene,
                                  MeshFormat format,
                                  double metres_per_unit) {
  renderer::CreateFolders(folder);
  std::vector<fs::path> written;
  const std::vector<std::string> names = MeshFileNames(scene);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const PlacedMesh placed = Place(i, scene);
    const fs::path stem = folder / names[i];
    const std::vector<fs::path> files =
        format == MeshFormat::kGlb   ? WritePlacedGlb(stem, placed, scene, metres_per_unit)
        : format == MeshFormat::kPly ? WritePlacedPly(stem, placed)
                                     : WritePlacedObj(stem, placed, scene);
    written.insert(written.end(), files.begin(), files.end());
  }
  return written;
}

fs::path WriteSceneGlb(const fs::path& folder, const Scene& scene, double metres_per_unit) {
  std::vector<renderer::GlbMesh> meshes;
  std::vector<renderer::GlbMaterial> materials;
  std::map<std::pair<int, const renderer::AreaEmitter*>, std::size_t> known;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const PlacedMesh placed = Place(i, scene);
    // A light is part of the material.
    const auto [entry, is_new] =
        known.try_emplace({scene.meshes[i].material, placed.emission}, materials.size());
    if (is_new) materials.push_back(GlbMaterialOf(placed, scene));
    meshes.push_back({scene.meshes[i].name, placed.mesh, entry->second});
  }
  std::string stem = "scene";
  for (const std::vector<std::string> names = MeshFileNames(scene);
       std::ranges::find(names, stem) != names.end();) {
    stem += "-all";
  }
  const fs::path path = folder / (stem + ".glb");
  renderer::CreateFolders(folder);
  renderer::WriteGlb(path, meshes, materials, metres_per_unit);
  return path;
}

std::vector<fs::path> WriteEnvironment(const fs::path& folder, const Scene& scene) {
  for (const renderer::Emitter& emitter : scene.emitters) {
    const auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light);
    if (environment == nullptr) continue;
    renderer::CreateFolders(folder);
    const renderer::Image image = TexelImage(
        environment->width, environment->height, environment->texels, environment->intensity);
    renderer::WriteExr(folder / "environment.exr", image);
    renderer::WriteHdr(folder / "environment.hdr", image);
    return {folder / "environment.exr", folder / "environment.hdr"};
  }
  return {};
}

void WriteTexelSights(const fs::path& folder,
                      const Scene& scene,
                      const optim::FitSpec& fit,
                      const optim::ObservationSet& observations) {
  std::optional<optim::FitViews> views;
  std::vector<std::string> names;
  for (const renderer::Texture& texture : scene.textures) names.push_back(texture.name);
  const std::vector<std::string> files = ViewFolderNames(names);
  for (const optim::UnknownSpec& unknown : fit.unknowns) {
    if (!unknown.promotion || unknown.kind != renderer::ParameterKind::kTextureTexels ||
        optim::IsReplaced(scene, unknown, fit.unknowns) ||
        !renderer::IsAtlas(scene, unknown.object)) {
      continue;
    }
    if (!views) views = optim::MakeFitViews(observations, fit.stages.back().image_scale);
    const auto index = static_cast<std::size_t>(unknown.object);
    renderer::Image image(scene.textures[index].width, scene.textures[index].height, 1);
    std::size_t next = 0;
    for (const optim::TexelSight sight : optim::SightOfTexels(scene, unknown.object, *views)) {
      image.data[next++] = sight == optim::TexelSight::kSeen     ? 1.0F
                           : sight == optim::TexelSight::kUnseen ? 0.5F
                                                                 : 0.0F;
    }
    renderer::CreateFolders(folder / "textures");
    renderer::WritePng8(folder / "textures" / (files[index] + "_seen.png"), image);
  }
}

void WriteTexelErrors(const fs::path& folder,
                      const Scene& scene,
                      const optim::FitSpec& fit,
                      const StandardErrorsByName& errors) {
  std::vector<std::string> names;
  for (const renderer::Texture& texture : scene.textures) names.push_back(texture.name);
  const std::vector<std::string> files = ViewFolderNames(names);
  for (const optim::UnknownSpec& unknown : fit.unknowns) {
    if (unknown.kind != renderer::ParameterKind::kTextureTexels ||
        optim::IsReplaced(scene, unknown, fit.unknowns)) {
      continue;
    }
    const auto index = static_cast<std::size_t>(unknown.object);
    const renderer::Texture& texture = scene.textures[index];
    const std::vector<double> roots =
        BlockErrors(scene, unknown.kind, unknown.object, texture.texels.size(), errors);
    if (roots.empty()) continue;
    renderer::Image image(texture.width, texture.height, 1);
    for (std::size_t i = 0; i < roots.size(); ++i) {
      image.data[i] = std::isfinite(roots[i]) ? static_cast<float>(roots[i]) : 1.0F;
    }
    renderer::CreateFolders(folder / "textures");
    renderer::WriteExr(folder / "textures" / (files[index] + "_standard_error.exr"), image);
  }
}

std::string LightsJson(const Scene& scene, double metres_per_unit) {
  Json lights = Json::array();
  for (int e = 0; e < static_cast<int>(scene.emitters.size()); ++e) {
    const renderer::Emitter& emitter = scene.emitters[static_cast<std::size_t>(e)];
    Json light = {{"name", emitter.name},
                  {"frame", emitter.frame == renderer::LightFrame::kWorld ? "world" : "camera"}};
    Json photos = Json::array();
    for (const renderer::Camera& sensor : scene.sensors) {
      if (!renderer::IsOff(sensor.lights_off, e)) photos.push_back(sensor.name);
    }
    if (photos.size() < scene.sensors.size()) light["photos"] = std::move(photos);
    light.update(LightJson(emitter, scene));
    lights.push_back(std::move(light));
  }
  const bool is_in_metres = metres_per_unit <= 0.0 || metres_per_unit == 1.0;
  Json file = {{"axes",
                fmt::format("right-handed, {}; camera frame: x right, y up, looking along -z",
                            is_in_metres ? "metres" : "units of metres_per_unit")},
               {"lights", std::move(lights)}};
  if (!is_in_metres) file["metres_per_unit"] = metres_per_unit;
  return JsonText(file) + "\n";
}

std::string ExposureCsv(const Scene& scene, const std::vector<ExportedView>& views) {
  PATHFIT_CHECK(scene.sensors.size() == views.size());
  std::string csv = "image,validation,gain,exposure_ev,gain_standard_error,red,blue\n";
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double gain = scene.sensors[i].gain;
    csv += fmt::format("{},{},{},{},{},{},{}\n",
                       CsvCell(views[i].name),
                       views[i].validation ? 1 : 0,
                       CsvCell(gain),
                       CsvCell(std::log2(gain)),
                       CsvCell(views[i].gain_error),
                       CsvCell(scene.sensors[i].red),
                       CsvCell(scene.sensors[i].blue));
  }
  return csv;
}

void ExportResult(const fs::path& folder,
                  const Scene& scene,
                  const std::vector<ExportedView>& views,
                  const std::vector<ParameterSummary>& parameters,
                  double metres_per_unit) {
  PATHFIT_CHECK(scene.sensors.size() == views.size());
  renderer::CreateFolders(folder / "cameras");
  std::vector<std::string> image_names, image_paths;
  WriteMeshes(folder, scene, MeshFormat::kGlb, metres_per_unit);
  if (!scene.meshes.empty()) WriteSceneGlb(folder, scene, metres_per_unit);
  WriteMeshes(folder, scene, MeshFormat::kPly);
  std::vector<std::string> texture_names;
  for (const renderer::Texture& texture : scene.textures) texture_names.push_back(texture.name);
  const std::vector<std::string> texture_files = ViewFolderNames(texture_names);
  for (std::size_t i = 0; i < texture_files.size(); ++i) {
    if (scene.textures[i].texels.size() == 1 && !IsUsed(scene, static_cast<int>(i))) continue;
    renderer::CreateFolders(folder / "textures");
    renderer::WriteExr(folder / "textures" / (texture_files[i] + ".exr"),
                       TextureImage(scene.textures[i]));
  }
  WriteEnvironment(folder, scene);
  for (const ExportedView& view : views) {
    image_names.push_back(view.name);
    image_paths.push_back(NearPath(view.image_path, folder / "cameras").generic_string());
  }
  WriteCameras(
      folder / "cameras", CamerasOfPhotos(scene, views), image_names, image_paths, metres_per_unit);
  renderer::WriteFileAtomically(folder / "lights.json", LightsJson(scene, metres_per_unit));
  renderer::WriteFileAtomically(folder / "exposure.csv", ExposureCsv(scene, views));
  renderer::WriteFileAtomically(folder / "parameters.csv", CsvTable(parameters));
}

}  // namespace pathfit::app
