#pragma once

#include <filesystem>

#include "app/output/fields.h"
#include "app/output/parameter_table.h"
#include "optim/observation/observation.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

/// Longest side of textures in the 3-D view.
inline constexpr int kViewedTexturePx = 1024;

/// What the report's 3-D view draws of a scene whose sensors are the observations' views, in their
/// order:
///
/// `meshes`, placed in the world: `name`, `num_vertices` and `num_triangles` (a position is there
/// again where normals, UVs or colours differ), `box` (two corners, metres), and buffers in base64,
/// little-endian:
/// `positions` (3 uint16 each, 65535 being the box's far side), `triangles` (3 indices each, uint16
/// up to 65536 vertices, else uint32), `normals` (3 int8 each; absent: flat), `colors` (3 uint8
/// each, sRGB-encoded base colour) or `uvs` (2 float32 each, v up) with `texture`, else `color`
/// (one, 0..255); `roughness` (number, absent where the material has none), `roughness_texture`,
/// and the same of `metallic`; `photos` (uint8: how many fitted photos show the vertex, at most
/// 255), and where they are known of any vertex `position_error` and `color_error`: float32 root of
/// the summed squares of the components' standard errors, infinite where photos do not tell, NaN
/// where only that is not so. Textures are data URIs of JPEG, at most kViewedTexturePx large, with
/// their given `size_px`.
///
/// `cameras`: `name`, `validation`, `size_px`, `fx`, `fy`, `cx`, `cy`, `parallel`, and the rows of
/// `world_from_camera` (3 x 4); `environment`, if there is one: `frame`, `frame_from_light` (rows).
Json ViewedModel(const renderer::Scene& scene,
                 const optim::ObservationSet& observations,
                 const StandardErrorsByName& errors);

/// Through a temporary file. Throws IoError when not writable.
void WriteViewedModel(const std::filesystem::path& path, const Json& model);
/// null without a file. Throws IoError when it is none of WriteViewedModel.
Json ReadViewedModel(const std::filesystem::path& path);

}  // namespace pathfit::app
