#include "app/experiment/draft_config.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "optim/parameter/unknown_spec.h"
#include "renderer/core/error.h"
#include "renderer/io/raw_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

constexpr double kSphereShare = 0.5;  // of the ball that fills the pictures
constexpr double kFlashShare = 0.04;  // of the distance: from the lens
constexpr double kFlashIrradiance = 2.0;
constexpr double kLightBesideFlash = 0.05;

std::string MaskLines(const FoundInput& input, const fs::path& folder) {
  const optim::MaskOptions& masks = input.options.masks;
  if (masks.meaning == optim::MaskMeaning::kNone) {
    return "  # No masks were found: the whole photos count, background too. With masks of the "
           "object the shape is found\n  # far more surely: masks: {path: FOLDER}, for a.jpg a "
           "file a.jpg.png or a.png, black = the object is not there.\n";
  }
  std::string keys;
  if (masks.alpha) {
    keys = "path: alpha, ";
  } else if (!masks.folder.empty()) {
    keys = "path: " + YamlPath(masks.folder, folder) + ", ";
  }
  if (input.start_of_points) {
    return fmt::format(
        "  # Colours did not tell the object from its background. Photos count where the start is "
        "seen; with masks of the object its\n  # outline does, too: masks: {{path: FOLDER}}, for "
        "a.jpg a file a.jpg.png or a.png, black = the object is not there.\n"
        "  masks: {{{}meaning: ignore}}\n",
        keys);
  }
  keys += "meaning: silhouette";
  if (masks.invert) keys += ", invert: true";
  if (masks.require == optim::MaskRequirement::kSome) keys += ", require: some";
  return fmt::format("  masks: {{{}}}  # {} of {} photos have one{}\n",
                     keys,
                     input.num_masks,
                     input.observations.views.size(),
                     masks.invert           ? "; white along the border, so taken as the background"
                     : input.mask_agreement ? "; made from colours by pathfit init, to be looked at"
                                            : "");
}

std::string GeometryLines(const FoundInput& input, const fs::path& folder, const fs::path& mesh) {
  if (!mesh.empty()) {
    return std::string(input.start_of_points
                           ? "    # The start: what the sparse points of the cameras lie on.\n"
                           : "") +
           "    object: {file: " + YamlPath(mesh, folder) + ", material: surface}\n";
  }
  if (input.options.masks.meaning == optim::MaskMeaning::kSilhouette) {
    // Made masks are rough: one that misses a part must not carve it away.
    return fmt::format(
        "    # The start, carved from the masks{}. A mesh of your own: {{file: mesh.ply, material: "
        "surface}}\n    object: {{visual_hull: {{{}}}, material: surface}}\n",
        input.mask_agreement ? " (one in ten may miss something)" : "",
        input.mask_agreement ? fmt::format("dissent: {}", kDissent) : "");
  }
  if (!input.layout || input.layout->radius <= 0.0) {
    throw renderer::SceneError(
        "without masks the start is a sphere where the cameras look, but they look at no common "
        "point; give a start mesh (--mesh FILE) or masks (--masks DIR)");
  }
  const CameraLayout& layout = *input.layout;
  // Places to a hundredth of the radius: the centre may be far away from the frame's origin.
  const int digits =
      std::clamp(static_cast<int>(std::ceil(2.0 - std::log10(layout.radius))), 0, 300);
  return fmt::format(
      "    # The start: a sphere where the cameras look. A mesh of your own, in the frame of the "
      "cameras, is better:\n"
      "    # {{file: mesh.ply, material: surface}}\n"
      "    object:\n      primitive: {{sphere: {{radius_m: {:.4g}}}}}\n      transform: "
      "{{translate_m: [{:.{}f}, "
      "{:.{}f}, {:.{}f}]}}\n      material: surface\n",
      kSphereShare * layout.radius,
      layout.centre.x,
      digits,
      layout.centre.y,
      digits,
      layout.centre.z,
      digits);
}

std::string LightLines(const FoundInput& input, DraftLight light, bool masked, bool shines) {
  const char* size = shines ? "[32, 16]" : "[8, 4]";
  if (light != DraftLight::kFlash) {
    return fmt::format("    surroundings: {{type: envmap, size_px: {}, frame: {}, visible: {}}}\n",
                       size,
                       light == DraftLight::kCamera ? "camera" : "world",
                       !masked);
  }
  if (!input.layout) {
    throw renderer::SceneError(
        "a flash on the camera starts as bright as its distance from the object asks, but the "
        "cameras look at no common point; take --light camera");
  }
  const double distance = input.layout->distance;
  const bool is_turned = input.background && input.background->ShowsThatItIsStill();
  return fmt::format(
      "    # The flash starts a little above the lens; photos tell its place and strength.\n"
      "    flash: {{type: point, frame: camera, position_m: [0, {:.3g}, 0], intensity: [{:.3g}, "
      "{:.3g}, {:.3g}]}}\n"
      "    surroundings: {{type: envmap, size_px: {}, frame: {}, visible: {}, init: "
      "{{constant: [{}, {}, {}]}}}}\n",
      kFlashShare * distance,
      kFlashIrradiance * distance * distance,
      kFlashIrradiance * distance * distance,
      kFlashIrradiance * distance * distance,
      size,
      is_turned ? "camera" : "world",
      !masked,
      kLightBesideFlash,
      kLightBesideFlash,
      kLightBesideFlash);
}

}  // namespace

std::string DraftConfig(const FoundInput& input,
                        const LightChoice& light,
                        const fs::path& path,
                        const std::string& name,
                        const fs::path& mesh,
                        DraftSurface surface) {
  const fs::path folder = path.parent_path();
  const auto& views = input.observations.views;
  const renderer::Camera& first = views.front().camera;
  const bool masked = input.options.masks.meaning == optim::MaskMeaning::kSilhouette;
  const bool has_flash = light.light == DraftLight::kFlash;
  const bool shines = Shines(surface);
  std::string text = DraftBeginning(name);
  const auto num_raw = std::ranges::count_if(
      views, [](const optim::View& view) { return renderer::HasRawExtension(view.files.photo); });
  text += fmt::format(
      "  images: {}  # {} photos, the first of {} x {} pixels{}\n",
      YamlPath(input.options.images_dir, folder),
      views.size(),
      first.width,
      first.height,
      num_raw > 0 ? fmt::format("; {} RAW, white balance: colour: {{white_balance: camera}}, or "
                                "daylight, none",
                                num_raw)
                  : "");
  text += fmt::format("  cameras: {{path: {}{}{}}}  # {}{}\n",
                      YamlPath(input.options.cameras, folder),
                      input.options.calibration.empty()
                          ? ""
                          : ", calibration: " + YamlPath(input.options.calibration, folder),
                      input.options.apply_exif_orientation ? ", orientation: exif" : "",
                      input.camera_format,
                      input.metres_per_unit > 0.0
                          ? fmt::format("; 1 unit = {:.4g} m", input.metres_per_unit)
                          : "; it does not say how long its unit is");
  if (input.metres_per_unit <= 0.0) {
    text +=
        "  # For results in metres, two marks a known distance apart, each by its pixels in two "
        "photos:\n  # scale: {two_points: [{a.jpg: [x, y], b.jpg: [x, y]}, {a.jpg: [x, y], b.jpg: "
        "[x, y]}], distance_m: 0.1}\n";
  }
  text += MaskLines(input, folder);
  text += SplitLine(input.options);
  text += fmt::format(
      "  exposure: {{model: gain}}  # each photo has a brightness of its own{}; none: all the "
      "same\n",
      std::ranges::any_of(views, [](const optim::View& v) { return v.exif_ev != 0.0F; })
          ? ", which starts as EXIF says"
          : "");
  text +=
      "\nscene:\n  geometry:\n" + GeometryLines(input, folder, mesh) + "  materials:\n" +
      SurfaceLines(surface,
                   shines ? "; it sees coarse light only: size_px [8, 4]"
                          : "; it sees finer light: size_px [32, 16]") +
      "  lights:\n" + CommentLines("Guess: " + light.reason + ".", "    # ") +
      "    # frame: world = the light stands still around the object; camera = it goes with the "
      "camera (turntable, flash).\n" +
      (shines ? "" : "    # A matt surface sees no finer light than this.\n") +
      LightLines(input, light.light, masked, shines);
  text += fmt::format(
      "\n# What may change, in these stages one after the other.\n"
      "unknowns:\n"
      "  object.vertices: {{}}{}\n"
      "  object.colors: {{}}\n"
      "{}"
      "  # Photos tell a tinted light on a pale thing badly from a white light on a coloured one: "
      "the "
      "light is kept near\n  # grey where they do not say. Leave `neutral` out where the light is "
      "coloured.\n"
      "  surroundings.texels: {{priors: [{{log_smooth: {{weight: {}}}}}, {{neutral: {{weight: "
      "0.001}}}}]}}\n"
      "{}"
      "  exposure: {{}}\n"
      "  # A lens that is not known to a pixel may change, too: one for all photos of a size.\n"
      "  # camera.focal: {{}}\n"
      "  # camera.principal_point: {{}}\n"
      "  # camera.vignetting: {{}}\n"
      "\nstages:\n"
      "  - {{name: light, free: [{}surroundings.texels, exposure]}}\n"
      "  - {{name: all, free: all}}\n",
      mesh.empty() || input.start_of_points
          ? ""
          : "  # leave it out where the mesh has the right shape already",
      shines ? "  surface.roughness: {}\n" : "",
      optim::kDefaultLogSmooth,
      has_flash ? "  flash.intensity: {}\n  flash.position: {}\n" : "",
      has_flash ? "flash.intensity, " : "");
  return text;
}

}  // namespace pathfit::app
