#include "app/experiment/lamp_draft.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "optim/observation/cushion.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

constexpr double kThickness = 0.5;   // of the start, over its width
constexpr double kStartColor = 0.5;  // of a surface of median brightness

/// Names of the photos that tell them from each other: without extensions if these are enough.
std::vector<std::string> ShortNames(const FoundLamps& found) {
  std::set<std::string> stems;
  std::vector<std::string> names;
  for (const FoundLamps::Lamp& lamp : found.lamps) {
    names.push_back(fs::path(lamp.photo).stem().string());
    stems.insert(names.back());
  }
  const bool are_different = stems.size() == names.size();
  for (std::size_t i = 0; i < names.size(); ++i) {
    // A whole name is that file, whatever letters are in it.
    const bool is_glob = names[i].find_first_of("*?[\\") != std::string::npos;
    if (is_glob || !are_different) names[i] = found.lamps[i].photo;
  }
  return names;
}

std::string LampLines(const FoundLamps& found) {
  const std::vector<std::string> photos = ShortNames(found);
  const double scale = std::numbers::pi * found.shading.brightness / kStartColor;
  const auto digits = static_cast<int>(std::to_string(photos.size()).size());
  std::string text;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const FoundLamps::Lamp& lamp = found.lamps[i];
    const auto rounded = [](double v) { return std::round(-1e5 * v) * 1e-5 + 0.0; };  // no -0
    const renderer::Vec3 away{
        rounded(lamp.towards.x), rounded(lamp.towards.y), rounded(lamp.towards.z)};
    text += fmt::format(
        "    lamp_{:0{}}: {{type: directional, direction: [{:.5f}, {:.5f}, {:.5f}], irradiance: "
        "[{:.4g}, {:.4g}, {:.4g}], photos: [{}]}}\n",
        i + 1,
        digits,
        away.x,
        away.y,
        away.z,
        scale * lamp.strength.r,
        scale * lamp.strength.g,
        scale * lamp.strength.b,
        YamlWord(photos[i]));
  }
  return text;
}

/// "" if the camera took every picture of the folder.
std::string PhotoList(const FoundLamps& found) {
  if (found.all_pictures) return "";
  if (!found.pattern.empty()) return ", photos: [" + YamlWord(found.pattern) + "]";
  std::string text;
  for (const FoundLamps::Lamp& lamp : found.lamps) {
    text += (text.empty() ? "" : ", ") + YamlWord(lamp.photo);
  }
  return ", photos: [" + text + "]";
}

}  // namespace

renderer::Mesh LampStart(const FoundLamps& found) {
  return optim::MakeCushion(found.mask, FoundLamps::kPixel, kThickness);
}

std::string DraftLampConfig(const FoundLamps& found,
                            const LampDraftFiles& files,
                            const std::string& name,
                            DraftSurface surface) {
  const fs::path folder = files.config.parent_path();
  const renderer::Camera& camera = found.observations.views.front().camera;
  const bool is_linear = found.options.transfer == optim::Transfer::kLinear;
  std::string text = DraftBeginning(name);
  text += fmt::format(
      "  images: {}  # {} photos of {} x {} pixels by one camera that stood still\n"
      "  cameras: {{sensor: front{}}}\n"
      "  masks: {{path: {}, meaning: silhouette}}  # of all photos{}\n"
      "  colour: {{transfer: {}}}\n",
      YamlPath(found.options.images_dir, folder),
      found.lamps.size(),
      camera.width,
      camera.height,
      PhotoList(found),
      found.options.masks.alpha ? "alpha" : YamlPath(files.mask, folder),
      found.mask_made ? "; made from brightness by pathfit init, to be looked at" : "",
      is_linear ? "linear" : "srgb");
  text += SplitLine(found.options);
  text += fmt::format(
      "\nscene:\n  geometry:\n"
      "    # The start: the mask, filled like a cushion. A mesh of your own: {{file: mesh.ply, "
      "material: surface}}\n"
      "    object: {{file: {}, material: surface}}\n"
      "  materials:\n"
      "{}"
      "  sensors:\n"
      "    # Taken as far away: its rays are parallel, a pixel is {} wide. From near: type: "
      "perspective with focal_px in place of\n"
      "    # height_m, from where the object fills the picture as it does in the photos.\n"
      "    front: {{type: orthographic, size_px: [{}, {}], height_m: {:.6g}, pose: {{look_at: "
      "{{origin_m: [0, 0, {:.4g}], target_m: [0, 0, 0]}}}}}}\n"
      "  lights:\n",
      YamlPath(files.mesh, folder),
      SurfaceLines(surface, ""),
      FoundLamps::kPixel,
      camera.width,
      camera.height,
      FoundLamps::kPixel * camera.height,
      camera.world_from_camera.translation.z);
  text += CommentLines(
      fmt::format("Directions {} {}; where the light goes.{}",
                  found.by_ball ? "by the highlights of the ball in" : "of",
                  NearPath(found.lamp_source, folder).generic_string(),
                  found.strengths_known ? " Strengths as it says." : " Strengths by the photos."),
      "    # ");
  for (const std::string& guess : found.guesses)
    text += CommentLines("Guess: " + guess + ".", "    # ");
  text += LampLines(found);
  text +=
      "\n# What may change, in these stages one after the other.\n"
      "unknowns:\n"
      "  object.vertices: {}\n"
      "  object.colors: {}\n";
  if (Shines(surface)) text += "  surface.roughness: {}\n";
  text +=
      "  # Lamps that are not known well may change, too, one by one or all:\n"
      "  # lamp_*.intensity: {}\n"
      "  # lamp_*.rotation: {priors: [{gaussian: {mean: start, sigma: 0.02}}]}\n"
      "\nstages:\n"
      "  - {name: shape, free: all}\n";
  return text;
}

}  // namespace pathfit::app
