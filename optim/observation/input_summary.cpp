#include "optim/observation/input_summary.h"

#include <algorithm>
#include <cstdio>
#include <map>

namespace pathfit::optim {
namespace {

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string CountOf(std::size_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

template <class Predicate>
std::size_t Count(const std::vector<FrameFacts>& facts, Predicate predicate) {
  return static_cast<std::size_t>(std::count_if(facts.begin(), facts.end(), predicate));
}

void DescribeCameras(const ObservationOptions& options,
                     const ImportedCameras& cameras,
                     const std::vector<FrameFacts>& facts,
                     std::vector<std::string>& out) {
  out.push_back("Cameras: " + std::string(cameras.format) + " (" + options.cameras.string() +
                "), " + CountOf(facts.size(), "image") +
                "; pixel origin at the image corner (centre of the first pixel is 0.5, 0.5), no "
                "shift applied.");
  out.push_back(cameras.metres_per_unit > 0.0
                    ? "Scale: 1 unit of the camera file is " + Short(cameras.metres_per_unit) +
                          " m by metres_per_unit; poses stay in units of the file."
                    : "Scale: the camera file does not say; its unit is taken for a metre.");
  if (const std::size_t distorted = Count(facts, [](const FrameFacts& f) { return f.distorted; })) {
    out.push_back("Lens: " + CountOf(distorted, "camera") +
                  " with distortion; rays are bent by the model, the photos are not resampled.");
  }
  std::map<std::string, std::size_t> rescaled;
  for (const FrameFacts& f : facts) {
    if (!f.rescaled_from.empty()) {
      ++rescaled[f.rescaled_from];
    }
  }
  for (const auto& [size, count] : rescaled) {
    out.push_back("Size: " + CountOf(count, "photo") + " had another size than the " + size +
                  " of its camera by a whole factor; the camera was scaled to the photo.");
  }
}

void DescribePhotos(const ObservationOptions& options,
                    const std::vector<FrameFacts>& facts,
                    std::vector<std::string>& out) {
  std::map<std::pair<int, bool>, std::size_t> kinds;
  std::int64_t clipped = 0;
  std::int64_t pixels = 0;
  for (const FrameFacts& f : facts) {
    ++kinds[{f.bits, f.srgb}];
    clipped += f.clipped_pixels;
    pixels += f.bits <= 16 ? f.pixels : 0;
  }
  for (const auto& [kind, count] : kinds) {
    out.push_back(
        "Colour: " + CountOf(count, "photo") + " of " +
        (kind.first <= 16 ? std::to_string(kind.first) + " bits" : std::string("floating point")) +
        (kind.second ? ", made linear Rec.709 by undoing the sRGB curve."
                     : ", taken as linear Rec.709 as stored."));
  }
  if (const std::size_t turned =
          Count(facts, [](const FrameFacts& f) { return f.exif_orientation > 1; })) {
    out.push_back(
        "Orientation: " + CountOf(turned, "photo") + " with an EXIF rotation, which was " +
        (options.apply_exif_orientation ? "applied." : "ignored: pixels are used as stored."));
  }
  if (options.clip_above < 1.0 && pixels > 0) {
    out.push_back("Clipping: pixels with a channel at or above " + Short(options.clip_above) +
                  " of the encoded range count as clipped; that is " +
                  Short(100.0 * static_cast<double>(clipped) / static_cast<double>(pixels)) +
                  " % of all.");
  }
  if (const std::size_t reduced = Count(facts, [](const FrameFacts& f) { return f.reduced; })) {
    out.push_back("Size: " + CountOf(reduced, "photo") +
                  " averaged over areas in linear light to " + std::to_string(options.max_size_px) +
                  " pixels on the longest side.");
  }
}

void DescribeMasks(const ObservationOptions& options,
                   const ObservationSet& set,
                   const std::vector<FrameFacts>& facts,
                   std::vector<std::string>& out) {
  if (set.mask_meaning == MaskMeaning::kNone) {
    out.emplace_back("Masks: none are used.");
    return;
  }
  const auto from = [&](MaskSource source) {
    return Count(facts, [source](const FrameFacts& f) { return f.mask_source == source; });
  };
  const std::size_t folder = from(MaskSource::kFolder);
  const std::size_t listed = from(MaskSource::kMaskPath);
  const std::size_t alpha = from(MaskSource::kAlpha);
  std::string text = "Masks: " + std::to_string(folder + listed + alpha) + " of " +
                     std::to_string(facts.size()) + " matched (";
  std::string sources;
  const auto add = [&](std::size_t count, const std::string& name) {
    if (count > 0) {
      sources += (sources.empty() ? "" : ", ") + std::to_string(count) + " " + name;
    }
  };
  add(folder, "from " + options.masks.folder.string());
  add(listed, "by mask_path of the camera file");
  add(alpha, "from alpha channels");
  text += sources.empty() ? "none found" : sources;
  text += options.masks.invert ? "); inverted, so white means " : "); black means ";
  text += set.mask_meaning == MaskMeaning::kSilhouette ? "the object is not there." : "no data.";
  out.push_back(text);
  std::string black;
  for (std::size_t i = 0; i < facts.size(); ++i) {
    if (facts[i].mask_is_black) {
      black += (black.empty() ? "" : ", ") + set.views[i].name;
    }
  }
  if (!black.empty()) {
    out.push_back("Masks: these show nothing at all: " + black + ".");
  }
}

}  // namespace

std::vector<std::string> SummariseInput(const ObservationOptions& options,
                                        const ImportedCameras& cameras,
                                        const ObservationSet& set,
                                        const std::vector<FrameFacts>& facts) {
  std::vector<std::string> out;
  DescribeCameras(options, cameras, facts, out);
  DescribePhotos(options, facts, out);
  DescribeMasks(options, set, facts, out);
  const auto validation = static_cast<std::size_t>(std::count_if(
      set.views.begin(), set.views.end(), [](const View& v) { return v.validation; }));
  std::string rule = "none asked for";
  if (!options.validation_names.empty()) {
    rule = "by name";
  } else if (options.validation_every > 0) {
    rule =
        "every " + std::to_string(options.validation_every) + "th by name, starting with the first";
  }
  out.push_back("Split: " + std::to_string(set.views.size() - validation) + " fitted, " +
                std::to_string(validation) + " for validation (" + rule + ").");
  return out;
}

}  // namespace pathfit::optim
