#include "app/output/export_obj.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "app/output/report_images.h"
#include "app/output/run_directory.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using renderer::Image;
using renderer::Mesh;
using renderer::Rgb;
using renderer::Triangle;
using renderer::Vec2;

/// Texels on a side of a triangle's patch. Its corners are the centres of texels, one off the rim:
/// samples inside weigh texels of the patch alone, with one to spare for inexact filters.
constexpr int kPatch = 4;

struct Unwrapped {
  std::vector<Vec2> uvs;  ///< three for each triangle
  Image texture;          ///< linear
};

/// A patch for every triangle, filled with the plane through its corners' colours.
Unwrapped UnwrapColors(const Mesh& mesh) {
  const int count = static_cast<int>(mesh.triangles.size());
  const int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(count))));
  const int rows = (count + columns - 1) / columns;
  Unwrapped out{{}, Image(columns * kPatch, rows * kPatch, 3)};
  for (int f = 0; f < count; ++f) {
    const int x0 = f % columns * kPatch;
    const int y0 = f / columns * kPatch;
    const Triangle& corners = mesh.color_triangles[static_cast<std::size_t>(f)];
    const auto color = [&](std::size_t i) {
      return mesh.colors[static_cast<std::size_t>(corners[i])];
    };
    constexpr double kSpan = kPatch - 3;  // texels between corners
    for (int y = 0; y < kPatch; ++y) {
      for (int x = 0; x < kPatch; ++x) {
        const double s = (x - 1) / kSpan, t = (y - 1) / kSpan;
        const Rgb value = color(0) * (1.0 - s - t) + color(1) * s + color(2) * t;
        for (int c = 0; c < 3; ++c) {
          out.texture.At(x0 + x, y0 + y, c) = static_cast<float>(std::clamp(value[c], 0.0, 1.0));
        }
      }
    }
    for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {kSpan, 0.0}, {0.0, kSpan}}) {
      out.uvs.push_back(
          {(x0 + 1.5 + dx) / out.texture.width, 1.0 - (y0 + 1.5 + dy) / out.texture.height});
    }
  }
  return out;
}

std::string FaceCorner(int position, int uv, int normal) {
  const std::string v = std::to_string(position + 1);
  if (uv < 0 && normal < 0) return v;
  return v + "/" + (uv < 0 ? "" : std::to_string(uv + 1)) +
         (normal < 0 ? "" : "/" + std::to_string(normal + 1));
}

/// Beside its base colour's: what the MTL says before a picture's name, the end of that name, and
/// the picture.
struct DataMap {
  std::string words;
  const char* suffix;
  const std::optional<Image>& image;
};
std::array<DataMap, 3> DataMaps(const ObjMaterial& material) {
  const bool scaled = material.normal_scale != 1.0;
  return {{{"map_Pr", "_roughness.png", material.roughness_texture},
           {"map_Pm", "_metallic.png", material.metallic_texture},
           {scaled ? fmt::format("norm -bm {}", material.normal_scale) : "norm",
            "_normal.png",
            material.normal_texture}}};
}

std::string MtlText(const ObjMaterial& material, const std::string& name, const std::string& map) {
  const Rgb& color = material.base_color;
  const double roughness = material.bsdf.roughness;
  std::string text = "newmtl " + name + "\n";
  text += map.empty() ? fmt::format("Kd {} {} {}\n", color.r, color.g, color.b)
                      : "Kd 1 1 1\nmap_Kd " + map + "\n";
  // Blinn's exponent of the same roughness, for programs that know no Pr and Pm.
  const double alpha = std::max(1e-3, roughness * roughness);
  text += fmt::format("Ks 0 0 0\nNs {:.6g}\nd 1\nillum 1\nPr {}\nPm {}\n",
                      std::clamp(2.0 / (alpha * alpha) - 2.0, 0.0, 1000.0),
                      roughness,
                      material.bsdf.metallic);
  return text;
}

}  // namespace

std::vector<fs::path> WriteObj(const fs::path& stem,
                               const Mesh& mesh,
                               const ObjMaterial& material) {
  const std::string file = stem.filename().string();
  const std::string name = SafeFileName(material.name);
  std::vector<Vec2> uvs(mesh.uvs.begin(), mesh.uvs.end());
  std::optional<Image> texture = material.texture;
  const bool unwraps = mesh.HasColors();
  if (unwraps) {
    Unwrapped unwrapped = UnwrapColors(mesh);
    uvs = std::move(unwrapped.uvs);
    texture = std::move(unwrapped.texture);
  }
  const bool has_uvs = unwraps || !mesh.uv_triangles.empty();
  std::string text = "mtllib " + file + ".mtl\no " + file + "\n";
  for (const auto& p : mesh.positions) text += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (const Vec2& uv : uvs) text += fmt::format("vt {} {}\n", uv.x, uv.y);
  for (const auto& n : mesh.normals) text += fmt::format("vn {} {} {}\n", n.x, n.y, n.z);
  text += "usemtl " + name + "\n";
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    text += "f";
    for (std::size_t i = 0; i < 3; ++i) {
      const int uv = unwraps ? static_cast<int>(3 * f + i) : has_uvs ? mesh.uv_triangles[f][i] : -1;
      const int normal = mesh.normal_triangles.empty() ? -1 : mesh.normal_triangles[f][i];
      text += " " + FaceCorner(mesh.triangles[f][i], uv, normal);
    }
    text += "\n";
  }
  std::vector<fs::path> written = {fs::path(stem) += ".obj", fs::path(stem) += ".mtl"};
  renderer::WriteFileAtomically(written[0], text);
  std::string mtl = MtlText(material, name, texture ? file + ".png" : "");
  if (texture) {
    written.push_back(fs::path(stem) += ".png");
    renderer::WritePng8(written.back(), EncodedImage(*texture));
  }
  for (const DataMap& map : DataMaps(material)) {
    if (!map.image || unwraps || !has_uvs) continue;
    written.push_back(fs::path(stem) += map.suffix);
    renderer::WritePng8(written.back(), *map.image);
    mtl += map.words + " " + file + map.suffix + "\n";
  }
  renderer::WriteFileAtomically(written[1], mtl);
  return written;
}

}  // namespace pathfit::app
