#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

#include "app/config/experiment_config.h"
#include "app/config/resolved_yaml.h"

namespace pathfit::app {

/// A config file in a folder of its own, removed at the end.
class ConfigFile {
 public:
  explicit ConfigFile(const std::string& text) {
    static int count = 0;
    folder_ = std::filesystem::temp_directory_path() /
              ("pathfit_config_" + std::to_string(getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(folder_);
    Write(text);
  }
  ConfigFile(const ConfigFile&) = delete;
  ConfigFile& operator=(const ConfigFile&) = delete;
  ~ConfigFile() {
    std::error_code error;
    std::filesystem::remove_all(folder_, error);
  }

  void Write(const std::string& text) const { std::ofstream(path(), std::ios::binary) << text; }
  [[nodiscard]] std::filesystem::path path() const { return folder_ / "test.yaml"; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

/// `--set` options as the command line passes them on.
inline std::vector<ConfigOverride> Sets(const std::vector<std::string>& assignments) {
  std::vector<ConfigOverride> overrides;
  for (const std::string& assignment : assignments) {
    overrides.push_back({"--set #" + std::to_string(overrides.size() + 1), assignment});
  }
  return overrides;
}

inline ExperimentConfig LoadText(const std::string& text,
                                 const std::vector<std::string>& sets = {}) {
  const ConfigFile file(text);
  return LoadExperimentConfig(file.path(), Sets(sets));
}

/// As far as it is known without the scene.
inline std::string ResolvedText(const ExperimentConfig& config) {
  return WriteResolvedYaml(config.resolved, config.source);
}

/// The lines with problems, "LINE:COLUMN: path: text" or "--set #1: path: text".
inline std::vector<std::string> ProblemsIn(const ConfigError& error, const ConfigFile& file) {
  std::vector<std::string> problems;
  std::istringstream lines(error.what());
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find(": error: ");
    if (at == std::string::npos) continue;
    line.erase(at, std::string(" error:").size());
    const std::string prefix = file.path().string() + ":";
    problems.push_back(line.rfind(prefix, 0) == 0 ? line.substr(prefix.size()) : line);
  }
  return problems;
}

/// Of a config that is read; empty if accepted.
inline std::vector<std::string> ProblemsOf(const std::string& text,
                                           const std::vector<std::string>& sets = {}) {
  const ConfigFile file(text);
  try {
    LoadExperimentConfig(file.path(), Sets(sets));
    return {};
  } catch (const ConfigError& error) {
    return ProblemsIn(error, file);
  }
}

/// One line, or all of them joined by newlines.
inline std::string ProblemOf(const std::string& text, const std::vector<std::string>& sets = {}) {
  std::string out;
  for (const std::string& line : ProblemsOf(text, sets)) out += (out.empty() ? "" : "\n") + line;
  return out;
}

/// A complete fit in which every part occurs.
inline const char* const kFitConfig = R"(schema: 1
name: mug
seed: 7
input:
  images: photos/
  cameras: {path: cameras/transforms.json, format: transforms}
  masks: {path: masks, erode_px: 2}
  exposure: {model: gain}
scene:
  geometry:
    mug:
      visual_hull: {resolution: 64}
      material: glaze
    disc: {primitive: {sphere: {radius_m: 0.1}}, material: paint}
  materials:
    glaze: {model: metallic_roughness, base_color: {vertex: [0.5, 0.4, 0.3]}, roughness: {constant: 0.4}}
    paint: {model: diffuse, base_color: {constant: [0.2, 0.3, 0.4]}}
  lights:
    room: {type: envmap, size_px: [16, 8]}
    lamp: {type: point, position_m: [0, 1, 0]}
unknowns:
  mug.vertices:
    parametrisation: {large_steps: {lambda: 19}}
    priors:
      - {laplacian: {weight: 1e-2}}
  mug.colors: {bounds: [0.02, 0.95]}
  paint.base_color: {priors: [{gaussian: {mean: [0.2, 0.3, 0.4], sigma: 0.1}}]}
  glaze.roughness: {}
  glaze.metallic: {hold: true}
  room.texels: {priors: [{smooth: {weight: 1e-3}}, {neutral: {weight: 1e-2}}]}
  lamp.intensity: {bounds: [0, .inf]}
  exposure: {}
loss: {residual: relative}
stages:
  - {name: light, free: [room.texels, exposure], image_scale: 0.25, max_rounds: 3}
  - {name: all, free: all, spp: 16}
solver: {max_memory: 2 GiB, threads: 2}
gradcheck: {params: ["mug.*"], step: 1e-4}
)";

/// A scene without photos.
inline const char* const kSceneConfig = R"(schema: 1
scene:
  geometry:
    floor: {primitive: {rectangle: {}}, material: grey, transform: {scale: 2, rotate: {axis: [1, 0, 0], angle_deg: -90}}}
  materials: {grey: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}}
  lights: {sky: {type: constant, radiance: [1, 1, 1]}}
  sensors:
    front: {size_px: [64, 32], fov_deg: 90, pose: {look_at: {origin_m: [0, 1, 3], target_m: [0, 0, 0]}}}
)";

/// A scene with every kind of shape, material, texture, light and sensor.
inline const char* const kRichConfig = R"(schema: 1
scene:
  geometry:
    floor: {primitive: {rectangle: {}}, material: wood}
    pane: {primitive: {disk: {segments: 12}}, material: clear}
    room: {file: room.obj, material: wall, materials: {oak.001: wood, "brass lamp": brass}, normals: flat, repair: true}
    tri:
      mesh:
        vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        triangles: [[0, 1, 2]]
        normals: [[0, 0, 1], [0, 0, 2], [1, 0, 1]]
        uvs: [[0, 0], [1, 0], [0, 1]]
      material: chrome
    bulb: {primitive: {sphere: {}}, material: wall, normals: smooth}
  materials:
    wood: {model: metallic_roughness, base_color: {texture: oak}, roughness: {texture: worn}, metallic: {constant: 0.1}}
    wall: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}
    brass: {model: conductor, metal: copper, roughness: {constant: 0.3}}
    alloy: {model: conductor, eta: [1, 2, 3], k: [4, 5, 6], base_color: {constant: [0.9, 0.8, 0.7]}}
    chrome: {model: mirror, metal: chromium}
    plain: {model: mirror}
    frost: {model: dielectric, ior: 1.33, roughness: {constant: 0.2}}
    clear: {model: glass}
  textures:
    oak: {file: oak.png, wrap: clamp}
    worn: {size_px: [8, 4], init: {constant: 0.4}}
    slide: {size_px: [4, 2], init: {constant: [3, 2, 1]}}
  lights:
    sky: {type: constant}
    lamp: {type: spot, position_m: [0, 2, 0], target_m: [0, 0, 0], outer_deg: 40, intensity: [9, 8, 7]}
    torch: {type: spot, position_m: [0, 0, 0], direction: [0, 0, -2], inner_deg: 5, outer_deg: 6, frame: camera}
    beamer: {type: projector, position_m: [0, 0, 3], target_m: [0, 0, 0], fov_deg: 30, fov_axis: x, texture: slide, rotate: {axis: [0, 0, 1], angle_deg: 180}}
    glow: {type: area, mesh: bulb, radiance: [3, 3, 3], texture: oak, two_sided: true}
  sensors:
    front: {size_px: [64, 32], fov_deg: 90, filter: {type: gaussian, sigma_px: 0.6}, pose: {look_at: {origin_m: [0, 1, 3], target_m: [0, 0, 0]}}}
    plan: {type: orthographic, size_px: [40, 20], height_m: 5, filter: tent, pose: {look_at: {origin_m: [0, 9, 0], target_m: [0, 0, 0], up: [0, 0, -1]}}}
render: {spp: 16, sppe: 1, spp_direct: 2, spp_indirect: 3, spp_pixel: 0, max_bounces: 4, form: material, guiding: grid, guide_share: 0.5, terms: [interior, direct]}
unknowns:
  floor.uvs: {}
  tri.normals: {}
  room-oak_001.translation: {bounds: [-0.1, 0.1]}
  bulb.rotation: {priors: [{gaussian: {mean: 0, sigma: 0.1}}]}
  bulb.scale: {}
  brass.eta: {}
  alloy.k: {}
  clear.eta: {}
  oak.texels: {}
  worn.texels: {}
  slide.texels: {}
  lamp.position: {}
  beamer.rotation: {}
  torch.angles: {}
  glow.intensity: {}
  camera.position: {}
  front.distortion: {}
  camera.focal: {}
)";

/// `text` with the first `from` replaced by `to`.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the test's text has no '" + from + "'");
  return text.replace(at, from.size(), to);
}

}  // namespace pathfit::app
