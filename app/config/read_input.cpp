#include <charconv>
#include <optional>

#include "app/config/map_reader.h"
#include "app/config/read_config.h"

namespace pathfit::app {
namespace {

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

void ReadValidation(const YamlNode* node, InputConfig& input, ConfigReading& reading) {
  if (node == nullptr) return;
  if (node->IsList()) {
    input.validation_every = 0;
    for (const YamlNode& item : node->items) input.validation_names.push_back(item.text);
  } else if (node->text == "none") {
    input.validation_every = 0;
  } else if (const std::optional<int> every = EveryOf(node->text)) {
    input.validation_every = *every;
  } else {
    reading.Report(node->place,
                   "input.split.validation",
                   DescribeNode(*node) +
                       " is not understood; write every 8 (a number of at least 2), a list of "
                       "file names, or none");
  }
}

void ReadMasks(const MapReader& masks, InputConfig& input) {
  input.has_masks = true;
  const std::string path = masks.TextOf("path");
  input.masks_alpha = path == "alpha";
  if (!input.masks_alpha) input.masks = path;
  input.masks_silhouette = masks.TextOf("meaning") != "ignore";
  masks.Get("invert", input.masks_invert);
  masks.Get("erode_px", input.masks_erode_px);
  masks.Get("require", input.masks_require);
}

}  // namespace

void ReadInput(ConfigReading& reading) {
  const YamlNode* node = reading.root.Find("input");
  if (node == nullptr) return;
  const MapReader map(node);
  InputConfig& input = reading.config.input.emplace();
  map.Get("images", input.images);
  if (input.images.string().find_first_of("*?") != std::string::npos) {
    reading.Report(map.Find("images")->place,
                   "input.images",
                   "file name patterns are not supported; give the folder");
  }
  const MapReader cameras = map.Map("cameras");
  cameras.Get("path", input.cameras);
  cameras.Get("format", input.cameras_format);
  input.refuse_distortion = cameras.TextOf("distortion") == "refuse";
  input.exif_orientation = cameras.TextOf("orientation") == "exif";
  if (map.Has("masks")) ReadMasks(map.Map("masks"), input);
  map.Map("colour").Get("transfer", input.transfer);
  map.Map("colour").Get("clip_above", input.clip_above);
  const MapReader exposure = map.Map("exposure");
  input.exposure_gain = exposure.TextOf("model") == "gain";
  exposure.Get("prior_sigma_ev", input.exposure_sigma_ev);
  exposure.Get("max_ev", input.exposure_max_ev);
  ReadValidation(map.Map("split").Find("validation"), input, reading);
  map.Get("max_size_px", input.max_size_px);
}

}  // namespace pathfit::app
