#include <charconv>
#include <optional>

#include "app/config/experiment_config.h"
#include "app/config/schema_builders.h"
#include "optim/observation/camera_import.h"

namespace pathfit::app {
namespace {

using optim::DistortionPolicy;
using optim::MaskMeaning;
using optim::MaskOptions;
using optim::MaskRequirement;
using optim::ObservationOptions;
using optim::Transfer;
using renderer::RawWhiteBalance;

constexpr auto kPhotos = &InputConfig::photos;

WordsOf<std::string> CameraFormats() {
  WordsOf<std::string> words;
  for (const std::string& word : optim::CameraFormatWords()) words.emplace_back(word, word);
  return words;
}

SchemaNode CamerasSchema() {
  return MapOf("cameras",
               {Key("path", &ObservationOptions::cameras) |
                    Doc("File or folder of the cameras: " + optim::CameraFormatList() + ".") |
                    OneOf("cameras"),
                ByCheck(binding::Make(SchemaNode::Type::kName, "sensor") |
                        Doc("One of `scene.sensors`: a camera that stood still and took every "
                            "picture in `images`.")) |
                    OneOf("cameras"),
                ByCheck(ListNode("photos", TextNode("")) | Items(1, 0) |
                        Doc("Which pictures in `images` they are: names or globs, extensions may "
                            "be left out.")) |
                    Needs("sensor") | DefaultIs("all"),
                Choice("format", CameraFormats(), &ObservationOptions::camera_format) |
                    Doc("Kind of the camera file.") | Refuse({{"bundler", ""}}),
                Key("calibration", &ObservationOptions::calibration) |
                    Doc("A calibration of OpenCV (YAML or XML; also camera_info of ROS) that gives "
                        "all cameras their size, focal lengths, principal point and lens, in place "
                        "of the camera file's.") |
                    Needs("path") | DefaultIs("as the camera file says"),
                Choice("distortion",
                       {{"model", DistortionPolicy::kModel}, {"refuse", DistortionPolicy::kRefuse}},
                       &ObservationOptions::distortion) |
                    Doc("`model`: rays are bent as the lens does; `refuse`: a camera with "
                        "distortion is an error.") |
                    Refuse({{"undistort", "; write model, which needs no resampled photos"}}),
                Choice("orientation",
                       {{"sensor", false}, {"exif", true}},
                       &ObservationOptions::apply_exif_orientation) |
                    Doc("`sensor`: pixels as stored, which is what camera programs work on; "
                        "`exif`: turned as the EXIF tag says.")},
               kPhotos) |
         Doc("Where the photos were taken from, and through what lens.") | Required() |
         Refuse({{"refine", "; free camera.position and camera.rotation in unknowns"},
                 {"scale", "; write input.scale"},
                 {"up", ""}});
}

// Not of MaskOptions alone: what is the default is that of InputConfig.
SchemaNode MasksSchema() {
  constexpr auto kMasks = &ObservationOptions::masks;
  return Map("masks",
             {Key("path", kPhotos, kMasks, &MaskOptions::folder) |
                  Doc("Folder with `a.jpg.png`, `a.png` or `a.mask.png` for the photo `a.jpg`, a "
                      "picture: the mask of all photos, or `alpha`: the photos' own alpha "
                      "channel.") |
                  Words({"alpha"}) | DefaultIs("as the camera file names them, else alpha"),
              Choice("meaning",
                     {{"silhouette", MaskMeaning::kSilhouette}, {"ignore", MaskMeaning::kIgnore}},
                     kPhotos,
                     kMasks,
                     &MaskOptions::meaning) |
                  Doc("Black means: the object is not there (`silhouette`), or nothing is known "
                      "(`ignore`)."),
              Key("invert", kPhotos, kMasks, &MaskOptions::invert) |
                  Doc("The files have white where black is meant."),
              Key("erode_px", kPhotos, kMasks, &MaskOptions::erode_px) |
                  Doc("Width of the rim around the mask's edge that is not used.") | From(0, 100) |
                  Unit("pixels"),
              Choice("require",
                     {{"all", MaskRequirement::kAll},
                      {"some", MaskRequirement::kSome},
                      {"none", MaskRequirement::kNone}},
                     kPhotos,
                     kMasks,
                     &MaskOptions::require) |
                  Doc("Which photos must have a mask.")}) |
         Doc("Where the object is in each photo. Absent: the photos are used whole.");
}

SchemaNode ColourSchema() {
  return MapOf(
             "colour",
             {Choice("transfer",
                     {{"auto", Transfer::kAuto},
                      {"srgb", Transfer::kSrgb},
                      {"linear", Transfer::kLinear}},
                     &ObservationOptions::transfer) |
                  Doc("What the numbers in the files mean; `auto`: 8 and 16 bit are what their "
                      "colour profile or EXIF says, else sRGB; EXR and HDR are linear.") |
                  Refuse({{"rec709", ""}, {"gamma", ""}}),
              Key("clip_above", &ObservationOptions::clip_above) |
                  Doc("Brighter pixels (share of the file's range), and those beside them that "
                      "nearly are, count as clipped: their bright channels may pull the model up, "
                      "where it is surely darker, and never down. 1 = none.") |
                  From(0.5, 1.0),
              Choice("white_balance",
                     {{"camera", RawWhiteBalance::kCamera},
                      {"daylight", RawWhiteBalance::kDaylight},
                      {"none", RawWhiteBalance::kNone}},
                     &ObservationOptions::white_balance) |
                  Doc("Of RAW photos, which are developed linear: `camera`: as it noted it for "
                      "each photo; `daylight`: that of its colour matrix, alike for all photos; "
                      "`none`. Other files have theirs already.") |
                  Refuse({{"as_shot", "; write camera"}, {"grey_card", ""}})},
             kPhotos) |
         Doc("From file values to light.") | Always() |
         Refuse({{"working", "; it is linear Rec.709"}, {"grey_card", ""}});
}

SchemaNode ExposureSchema() {
  SchemaNode known =
      ByCheck(binding::Make(SchemaNode::Type::kNamedMap, "ev") |
              Doc("Exposures that are known, of photos by name or glob: the brightness factor is 2 "
                  "to this. With `gain` they are where it starts; the photos' EXIF is not used "
                  "then (`{\"*\": 0}` if it is wrong)."));
  known.children = {binding::Make(SchemaNode::Type::kNumber, "PHOTO") | Doc("Its exposure.") |
                    From(-20, 20) | Unit("EV")};
  return Map("exposure",
             {Choice("model",
                     {{"none", ExposureUnknown::kNone},
                      {"gain", ExposureUnknown::kGain},
                      {"gain_rgb", ExposureUnknown::kGainRgb}},
                     &InputConfig::exposure_model) |
                  Doc("`gain`: each photo has its own brightness factor, the unknown `exposure`. "
                      "It "
                      "starts as EXIF says (exposure time, aperture, ISO), where all photos have "
                      "it "
                      "and differ. `gain_rgb`: and factors of red and blue, the unknown "
                      "`white_balance`, for cameras that choose their own.") |
                  Refuse({{"gain_rgb_vignette", "; write gain_rgb, and free camera.vignetting"}}),
              Key("prior_sigma_ev", &InputConfig::exposure, &optim::ExposurePrior::sigma_ev) |
                  Doc("How far from its start an exposure is believed to be, and a factor of white "
                      "balance; where a light is known, how far from what they have in common.") |
                  Above(0.0) | Unit("EV"),
              Key("max_ev", &InputConfig::exposure, &optim::ExposurePrior::max_ev) |
                  Doc("Largest distance from its start.") | Above(0.0) | Unit("EV"),
              known | FreeNames()}) |
         Doc("Differences of exposure between the photos; their mean is kept where the "
             "strengths of all lights are unknown, and found where a light is known.") |
         Always() |
         Refuse({{"init", "; write ev"},
                 {"gauge", "; the mean is kept at 0 EV"},
                 {"bounds_ev", "; write max_ev"}});
}

/// Values that were refused are null here.
void CheckScale(ScaleConfig& scale, const CheckedMap& map) {
  const YamlNode* points = map.Find("two_points");
  if (points == nullptr || points->items.size() != scale.two_points.size()) return;
  for (std::size_t i = 0; i < scale.two_points.size(); ++i) {
    const YamlNode& node = points->items[i];
    ScalePoint& point = scale.two_points[i];
    if (node.IsList()) binding::Read(node, point.position);
    if (!node.IsMap()) continue;
    for (const YamlEntry& entry : node.entries) {
      binding::Read(entry.value, point.picks.emplace_back(entry.key, std::array{0.0, 0.0}).second);
    }
    if (point.picks.size() < 2) {
      map.Report(fmt::format("two_points[{}]", i),
                 node,
                 "one photo does not tell how far away a point is; pick it in two at least");
    }
  }
  const auto& [a, b] = scale.two_points;
  if (points->items[0].IsList() && points->items[1].IsList() && a.position == b.position) {
    map.Report("two_points", "both points are the same");
  }
}

SchemaNode ScaleSchema() {
  SchemaNode picks = binding::Make(SchemaNode::Type::kNamedMap, "");
  picks.children = {ListNode("PHOTO", binding::Make(SchemaNode::Type::kNumber, "")) | Items(2, 2)};
  SchemaNode point =
      Either("",
             {ListNode("", binding::Make(SchemaNode::Type::kNumber, "")) | Items(3, 3),
              picks | FreeNames()});
  return MapOf("scale",
               {ByCheck(ListNode("two_points", std::move(point)) | Items(2, 2) |
                        Doc("Two points: each three numbers, in units of the camera file, or the "
                            "photos in which it is seen, two at least, with its pixel there, "
                            "counted to the right and down from the corner of the picture as the "
                            "file has it (turned as `input.cameras.orientation` says): `[{a.jpg: "
                            "[512, 300], b.jpg: [480, 310]}, {...}]`.")) |
                    Required(),
                Key("distance_m", &ScaleConfig::distance_m) | Doc("How far they are apart.") |
                    Required() | Above(0.0) | Unit("metres")},
               &InputConfig::scale) |
         Doc("A known distance, which says how long the unit of the camera file is, whatever the "
             "file says: results are in metres then. The scene stays in units of the file.") |
         DefaultIs("as the camera file says") | Check(CheckScale);
}

// The number of "every 8".
std::optional<int> EveryOf(const std::string& text) {
  constexpr const char* kEvery = "every ";
  constexpr std::size_t kLength = 6;
  if (text.rfind(kEvery, 0) != 0) return std::nullopt;
  int every = 0;
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data() + kLength, last, every);
  if (error != std::errc() || end != last || every < 2) return std::nullopt;
  return every;
}

void CheckInput(InputConfig& input, const CheckedMap& map) {
  ObservationOptions& photos = input.photos;
  if (photos.images_dir.string().find_first_of("*?") != std::string::npos) {
    map.Report("images", "file name patterns are not supported; give the folder");
  }
  const YamlNode* cameras = map.Find("cameras");
  if (const YamlNode* sensor = cameras == nullptr ? nullptr : cameras->Find("sensor")) {
    input.sensor = sensor->text;
    if (const YamlNode* taken = cameras->Find("photos")) {
      for (const YamlNode& item : taken->items) input.sensor_photos.push_back(item.text);
    }
    if (map.Find("images") == nullptr) {
      map.Report("cameras.sensor", *sensor, "give the folder of the photos: input.images");
    }
  }
  if (const YamlNode* exposure = map.Find("exposure")) {
    if (const YamlNode* known = exposure->Find("ev")) {
      for (const YamlEntry& entry : known->entries) {
        input.known_ev.emplace_back(entry.key, 0.0);
        binding::Read(entry.value, input.known_ev.back().second);
      }
    }
  }
  if (!input.sensor.empty() && map.Find("scale") != nullptr) {
    map.Report("scale", "is of camera files; sensors of the scene are in metres");
  }
  const YamlNode* masks = map.Find("masks");
  if (masks == nullptr) {
    photos.masks = {};
  } else if (const YamlNode* folder = masks->Find("path");
             folder != nullptr && folder->text == "alpha") {
    photos.masks.alpha = true;
    photos.masks.folder.clear();
  }
  const YamlNode* split = map.Find("split");
  const YamlNode* validation = split == nullptr ? nullptr : split->Find("validation");
  if (validation == nullptr) return;
  const std::optional<int> every = EveryOf(validation->text);
  photos.validation_every = every.value_or(0);
  for (const YamlNode& item : validation->items) photos.validation_names.push_back(item.text);
  if (validation->IsList() || every || validation->text == "none") return;
  map.Report("split.validation",
             *validation,
             DescribeNode(*validation) +
                 " is not understood; write every 8 (a number of at least 2), a list of file "
                 "names, or none");
}

}  // namespace

SchemaNode InputSchema() {
  return MapOf("input",
               {Key("images", kPhotos, &ObservationOptions::images_dir) |
                    Doc("Folder of the photos.") | DefaultIs("as the camera file says"),
                CamerasSchema(),
                MasksSchema(),
                ColourSchema(),
                ExposureSchema(),
                ScaleSchema(),
                Map("split",
                    {ByCheck(Either("validation",
                                    {TextNode(""), ListNode("", TextNode("")) | Items(1, 0)}) |
                             Doc("Photos that are never fitted and always reported: `every N` (by "
                                 "name, the first included), a list of file names, or `none`.")) |
                     Default(fmt::format("every {}", ObservationOptions{}.validation_every))}) |
                    Doc("Which photos are held out: nothing is fitted to them, but stages of many "
                        "unknowns "
                        "end when they gain no more.") |
                    Always(),
                Key("max_size_px", kPhotos, &ObservationOptions::max_size_px) |
                    Doc("Longest side of the photos after area averaging; `none` = as they are.") |
                    From(16, 65536) | Unit("pixels") | OrWord("none")},
               &ExperimentConfig::input) |
         Doc("The photos. Absent for a scene that is described completely here.") |
         Check(CheckInput);
}

}  // namespace pathfit::app
