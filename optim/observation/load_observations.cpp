#include "optim/observation/load_observations.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "optim/observation/photo_file.h"
#include "optim/observation/short_number.h"
#include "renderer/core/parallel.h"
#include "renderer/io/image_file.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using renderer::Camera;
using renderer::Image;

constexpr int kFirstSwappingOrientation = 5;  // EXIF: 5 to 8 exchange width and height

std::string Join(const std::vector<std::string>& problems) {
  std::string text = std::to_string(problems.size()) +
                     (problems.size() == 1 ? " problem" : " problems") +
                     " with photos, cameras or masks:";
  for (const std::string& problem : problems) text += "\n  " + problem;
  return text;
}

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

/// Whether `size` is `of` times or divided by a whole number above one, to half a pixel; both sides
/// by the same.
bool IsIntegerRescale(int width, int height, const Camera& camera) {
  const auto near = [](double a, double b) { return std::abs(a - b) <= 0.5; };
  const int up = static_cast<int>(std::lround(static_cast<double>(width) / camera.width));
  const int down = static_cast<int>(std::lround(static_cast<double>(camera.width) / width));
  if (up > 1) {
    return near(width, static_cast<double>(camera.width) * up) &&
           near(height, static_cast<double>(camera.height) * up);
  }
  return down > 1 && near(width, static_cast<double>(camera.width) / down) &&
         near(height, static_cast<double>(camera.height) / down);
}

std::string SizeProblem(const fs::path& path,
                        const PhotoFile& photo,
                        const Camera& camera,
                        const ObservationOptions& options,
                        bool may_differ) {
  const int width = photo.photo.width;
  const int height = photo.photo.height;
  std::string text = path.string() + ": " + SizeText(width, height) +
                     " pixels, but its camera says " + SizeText(camera.width, camera.height);
  if (photo.raw)
    text += " (RAW: all pixels that the sensor shows; JPEG is often cut at its border)";
  if (width != camera.height || height != camera.width) {
    return text + (may_differ
                       ? "; allowed: that size, or that size times or divided by a whole number"
                       : "; reduced copies are used when their folder is named as the images");
  }
  text += "; width and height are swapped. The file carries EXIF orientation " +
          std::to_string(photo.exif_orientation) + " and orientation is '" +
          (options.apply_exif_orientation ? "exif'" : "sensor'");
  if (photo.exif_orientation >= kFirstSwappingOrientation) {
    text += options.apply_exif_orientation
                ? "; most camera programs ignore that tag, so use 'sensor'"
                : "; if the cameras were found on upright pictures, use 'exif'";
  }
  return text;
}

constexpr const char* kRawTurned = " Programs that read RAW photos often turn them.";

/// Said once, not of every photo.
bool LacksMaskFolder(const MaskOptions& masks) {
  std::error_code ignored;
  return masks.meaning != MaskMeaning::kNone && !masks.folder.empty() &&
         !fs::exists(masks.folder, ignored);
}

/// What was met while one photo was loaded.
struct FrameFacts {
  int bits = 0;
  bool grey = false;
  bool srgb = false;
  std::string profile;
  int exif_orientation = 1;
  std::optional<ExifExposure> exif_exposure;
  std::optional<RawDevelopment> raw;
  bool distorted = false;
  bool reduced = false;        ///< area-averaged to the largest size allowed
  std::string rescaled_from;   ///< size of its camera, if that was another
  bool mask_is_black = false;  ///< no value above 1/2
  std::int64_t clipped_pixels = 0;
  std::int64_t pixels = 0;  ///< of the file
};

/// One frame on its way from the camera file to a view; problems instead of exceptions.
struct FrameResult {
  View view;
  FrameFacts facts;
  std::vector<fs::path> files;
  std::vector<std::string> problems;
};

class FrameLoader {
 public:
  FrameLoader(const ObservationOptions& options, const ImportedCameras& cameras)
      : options_(options), cameras_(cameras) {}

  void Load(const ImportedCamera& imported, const std::string& name, FrameResult& result) const {
    const FileSearch search = FindPhoto(imported.image, cameras_, options_.images_dir);
    if (!search.found) {
      result.problems.push_back(imported.place + ": the photo " + imported.image +
                                " is missing (tried: " + TriedNames(search) + ")");
      return;
    }
    result.files.push_back(*search.found);
    result.view.files.photo = *search.found;
    try {
      PhotoFile photo = ReadPhotoFile(*search.found, options_);
      LoadCamera(imported, *search.found, photo, result);
      Image mask = LoadMask(imported, *search.found, photo, result);
      if (result.problems.empty()) FillView(name, std::move(photo), std::move(mask), result);
    } catch (const renderer::IoError& error) {
      result.problems.emplace_back(error.what());
    } catch (const renderer::SceneError& error) {
      result.problems.push_back(imported.place + ": " + error.what());
    }
  }

 private:
  void LoadCamera(const ImportedCamera& imported,
                  const fs::path& path,
                  const PhotoFile& photo,
                  FrameResult& result) const {
    const int width = photo.photo.width;
    const int height = photo.photo.height;
    Camera camera = CompleteCamera(imported, width, height);
    result.facts.distorted = !camera.distortion.IsNone();
    if (result.facts.distorted && options_.distortion == DistortionPolicy::kRefuse) {
      const renderer::LensDistortion& d = camera.distortion;
      result.problems.push_back(
          imported.place + ": the camera of " + imported.image +
          " has lens distortion (k1 = " + std::to_string(d.k1) + ", k2 = " + std::to_string(d.k2) +
          ", ...) and distortion is 'refuse'; use 'model', or undistort the photos");
    }
    if (width != camera.width || height != camera.height) {
      const bool may_differ = !cameras_.has_own_photos || !options_.images_dir.empty();
      if (!may_differ || !IsIntegerRescale(width, height, camera)) {
        result.problems.push_back(SizeProblem(path, photo, camera, options_, may_differ));
        return;
      }
      result.facts.rescaled_from = SizeText(camera.width, camera.height);
      camera = renderer::ScaledCamera(camera, width, height);
    }
    static_cast<void>(
        renderer::CameraModel(camera));  // throws SceneError for a camera that cannot be used
    result.view.camera = std::move(camera);
  }

  /// Empty with a problem recorded, or without one where masks are not required.
  Image LoadMask(const ImportedCamera& imported,
                 const fs::path& path,
                 const PhotoFile& photo,
                 FrameResult& result) const {
    const MaskOptions& options = options_.masks;
    if (options.meaning == MaskMeaning::kNone) return {};
    const FileSearch search =
        options.alpha ? FileSearch{} : FindMask(imported, path, cameras_, options_);
    Image mask;
    if (search.found) {
      mask = ReadMaskFile(*search.found, options_.apply_exif_orientation);
      result.files.push_back(*search.found);
      result.view.files.mask = *search.found;
      result.view.files.mask_source =
          options.folder.empty() ? MaskSource::kMaskPath : MaskSource::kFolder;
      if (mask.width != photo.photo.width || mask.height != photo.photo.height) {
        result.problems.push_back(search.found->string() + ": " +
                                  SizeText(mask.width, mask.height) + " pixels, but its photo " +
                                  path.string() + " has " +
                                  SizeText(photo.photo.width, photo.photo.height));
        return {};
      }
    } else if (UsesAlpha(imported, photo)) {
      mask = photo.alpha;
      result.view.files.mask_source = MaskSource::kAlpha;
    } else {
      if (options.require == MaskRequirement::kAll && !LacksMaskFolder(options)) {
        result.problems.push_back(path.string() + ": has no mask (" +
                                  WhatWasTried(imported, search) + ")");
      }
      return {};
    }
    FinishMask(options, mask);
    result.facts.mask_is_black = std::ranges::none_of(mask.data, [](float v) { return v > 0.5F; });
    return mask;
  }

  /// An alpha channel that is opaque everywhere says nothing: no mask is invented from it, unless
  /// asked for.
  [[nodiscard]] bool UsesAlpha(const ImportedCamera& imported, const PhotoFile& photo) const {
    if (options_.masks.alpha) return !photo.alpha.Empty();
    return options_.masks.folder.empty() && imported.mask.empty() &&
           std::ranges::any_of(photo.alpha.data, [](float v) { return v < 1.0F; });
  }

  [[nodiscard]] std::string WhatWasTried(const ImportedCamera& imported,
                                         const FileSearch& search) const {
    if (options_.masks.alpha) return "the photo has no alpha channel";
    if (!search.tried.empty()) return "tried: " + TriedNames(search);
    return std::string(imported.mask.empty()
                           ? "no mask folder is given, the camera file has no mask_path"
                           : "") +
           ", and the photo has no alpha channel with transparent pixels";
  }

  void FillView(const std::string& name, PhotoFile photo, Image mask, FrameResult& result) const {
    View& view = result.view;
    view.name = name;
    view.camera.name = name;
    view.file_width = photo.photo.width;
    view.file_height = photo.photo.height;
    result.facts.bits = photo.bits;
    result.facts.srgb = photo.srgb;
    result.facts.grey = photo.grey;
    result.facts.profile = photo.profile;
    result.facts.exif_orientation = photo.exif_orientation;
    result.facts.exif_exposure = photo.exif_exposure;
    result.facts.raw = photo.raw;
    for (const float v : photo.clipped.data) result.facts.clipped_pixels += v > 0.0F ? 1 : 0;
    result.facts.pixels = static_cast<std::int64_t>(photo.photo.width) * photo.photo.height;
    const auto [width, height] = ReducedSize(photo.photo.width, photo.photo.height, options_);
    if (width != photo.photo.width || height != photo.photo.height) {
      view.camera = renderer::ScaledCamera(view.camera, width, height);
      ReducePhoto(options_, photo);
      if (!mask.Empty()) mask = renderer::ResizeArea(mask, width, height);
      result.facts.reduced = true;
    }
    view.straight_alpha =
        result.view.files.mask_source == MaskSource::kAlpha && photo.straight_alpha;
    view.photo = photo.photo;
    view.clipped = photo.clipped;
    view.mask = mask;
  }

  const ObservationOptions& options_;
  const ImportedCameras& cameras_;
};

/// Every picture of the folder as taken by the camera that stood still.
ImportedCameras PicturesOfCamera(const ObservationOptions& options) {
  ImportedCameras cameras;
  const Camera& camera = *options.fixed_camera;
  const std::vector<std::string>& wanted = options.fixed_photos;
  for (const fs::path& path : wanted.empty() ? WithoutRawTwins(PicturesIn(options.images_dir))
                                             : PicturesIn(options.images_dir)) {
    if (!wanted.empty() && std::ranges::find(wanted, path.filename().string()) == wanted.end())
      continue;
    ImportedCamera& imported = cameras.cameras.emplace_back();
    imported.image = path.filename().string();
    imported.camera = camera;
    imported.place = path.string();
  }
  if (cameras.cameras.empty()) {
    throw renderer::IoError(options.images_dir.string() + ": has no pictures of camera '" +
                            camera.name + "'");
  }
  return cameras;
}

/// File name of each photo, or its whole path where two photos share a file name.
std::vector<std::string> ViewNames(const ImportedCameras& cameras) {
  std::map<std::string, int> uses;
  std::vector<std::string> names;
  for (const ImportedCamera& camera : cameras.cameras) {
    names.push_back(fs::path(camera.image).filename().string());
    ++uses[names.back()];
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (uses[names[i]] > 1) {
      names[i] = fs::path(cameras.cameras[i].image).lexically_normal().generic_string();
    }
  }
  return names;
}

/// Positions in the camera file, ordered by view name.
std::vector<std::size_t> SortedByName(const std::vector<std::string>& names) {
  std::vector<std::size_t> order(names.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return names[a] < names[b]; });
  return order;
}

void CheckOptions(const ObservationOptions& options, std::vector<std::string>& problems) {
  const auto require = [&](bool condition, const std::string& text) {
    if (!condition) problems.push_back(text);
  };
  require(options.max_size_px >= 0, "the largest image size must be 0 (as it is) or positive");
  require(options.validation_every >= 0, "validation: 'every' must be 0 (none) or positive");
  require(options.masks.erode_px >= 0, "masks: the erosion must not be negative");
  require(!LacksMaskFolder(options.masks),
          "masks: there is no folder (or file) " + options.masks.folder.string());
  require(options.clip_above > 0.0,
          "colour: the clipping level must be above 0 (1 = nothing is clipped)");
}

/// Marks the views that are kept for validation.
void SplitViews(const ObservationOptions& options,
                std::vector<View>& views,
                std::vector<std::string>& problems) {
  for (const std::string& name : options.validation_names) {
    const auto found = std::ranges::find_if(views, [&](const View& v) { return v.name == name; });
    if (found == views.end()) {
      problems.push_back("validation: no photo is called " + name + " (the first is " +
                         views.front().name + ")");
    } else {
      found->validation = true;
    }
  }
  if (options.validation_names.empty() && options.validation_every > 0) {
    for (std::size_t i = 0; i < views.size();
         i += static_cast<std::size_t>(options.validation_every)) {
      views[i].validation = true;
    }
  }
  if (std::ranges::all_of(views, [](const View& v) { return v.validation; })) {
    problems.push_back(
        "validation: all " + std::to_string(views.size()) +
        " photos are validation views and none is left to fit; choose fewer, or none");
  }
}

/// What the sentence about the scale among the assumptions begins with.
constexpr std::string_view kScaleSentence = "Scale: ";

std::string CountOf(std::size_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

template <class Predicate>
std::size_t Count(const std::vector<FrameFacts>& facts, Predicate predicate) {
  return static_cast<std::size_t>(std::ranges::count_if(facts, predicate));
}

void DescribeCameras(const ObservationOptions& options,
                     const ImportedCameras& cameras,
                     const std::vector<FrameFacts>& facts,
                     std::vector<std::string>& out) {
  if (options.fixed_camera) {
    out.push_back("Cameras: one that stood still, " + options.fixed_camera->name + ", took " +
                  CountOf(facts.size(), "photo") + ".");
  } else {
    out.push_back("Cameras: " + std::string(cameras.format) + " (" + options.cameras.string() +
                  "), " + CountOf(facts.size(), "image") +
                  "; pixel origin at the image corner (centre of the first pixel is 0.5, 0.5), " +
                  (cameras.pixel_shift == 0.0
                       ? "no shift applied."
                       : "which OpenCV calls (0, 0): 0.5 was added to principal points."));
    out.push_back(cameras.metres_per_unit > 0.0
                      ? std::string(kScaleSentence) + "1 unit of the camera file is " +
                            ShortNumber(cameras.metres_per_unit) +
                            " m, as it says; poses stay in units of the file."
                      : std::string(kScaleSentence) +
                            "the camera file does not say; its unit is taken for a metre.");
  }
  for (const std::string& note : cameras.notes) out.push_back(note);
  if (const std::size_t distorted = Count(facts, [](const FrameFacts& f) { return f.distorted; })) {
    out.push_back("Lens: " + CountOf(distorted, "camera") +
                  " with distortion; rays are bent by the model, the photos are not resampled.");
  }
  std::map<std::string, std::size_t> rescaled;
  for (const FrameFacts& f : facts) {
    if (!f.rescaled_from.empty()) ++rescaled[f.rescaled_from];
  }
  for (const auto& [size, count] : rescaled) {
    out.push_back("Size: " + CountOf(count, "photo") + " had another size than the " + size +
                  " of its camera by a whole factor; the camera was scaled to the photo.");
  }
}

/// "2.01", or "2 to 2.05".
std::string Span(double low, double high) {
  const std::string first = ShortNumber(low);
  const std::string last = ShortNumber(high);
  return first == last ? first : first + " to " + last;
}

/// One sentence for each white balance that was used.
void DescribeRaw(const std::vector<RawDevelopment>& photos, std::vector<std::string>& out) {
  using renderer::RawWhiteBalance;
  constexpr double kEqualMultipliers = 1.01;
  for (const auto& [used, words] :
       {std::pair{RawWhiteBalance::kCamera, "white balance as the camera noted"},
        {RawWhiteBalance::kDaylight, "white balance of daylight"},
        {RawWhiteBalance::kNone, "no white balance"}}) {
    std::vector<double> red, blue;
    std::size_t without_matrix = 0;
    for (const RawDevelopment& photo : photos) {
      if (photo.white_balance != used) continue;
      red.push_back(photo.multipliers.r);
      blue.push_back(photo.multipliers.b);
      without_matrix += photo.has_color_matrix ? 0 : 1;
    }
    if (red.empty()) continue;
    const auto [least_red, most_red] = std::ranges::minmax(red);
    const auto [least_blue, most_blue] = std::ranges::minmax(blue);
    std::string text = "Colour: " + CountOf(red.size(), "RAW photo") +
                       " developed to linear Rec.709 (LibRaw " + renderer::LibRawVersion() + "), " +
                       words + ": red times " + Span(least_red, most_red) +
                       ", green 1, blue times " + Span(least_blue, most_blue) + ".";
    if (most_red > kEqualMultipliers * least_red || most_blue > kEqualMultipliers * least_blue) {
      text +=
          " The photos differ: white_balance 'daylight' treats all alike, exposure model "
          "'gain_rgb' fits what is left.";
    }
    if (without_matrix > 0) {
      text += " Of " + CountOf(without_matrix, "photo") +
              " the camera's colours are not known; they are taken as Rec.709.";
    }
    out.push_back(text);
  }
}

void DescribePhotos(const ObservationOptions& options,
                    const std::vector<FrameFacts>& facts,
                    std::vector<std::string>& out) {
  std::map<std::tuple<int, bool, std::string>, std::size_t> kinds;
  std::int64_t clipped = 0;
  std::int64_t pixels = 0;
  std::vector<RawDevelopment> raw;
  for (const FrameFacts& f : facts) {
    if (f.raw) {
      raw.push_back(*f.raw);
    } else {
      ++kinds[{f.bits, f.srgb, f.profile}];
    }
    clipped += f.clipped_pixels;
    pixels += f.bits <= 16 ? f.pixels : 0;
  }
  for (const auto& [kind, count] : kinds) {
    const auto& [bits, srgb, profile] = kind;
    out.push_back("Colour: " + CountOf(count, "photo") + " of " +
                  (bits <= 16 ? std::to_string(bits) + " bits" : std::string("floating point")) +
                  (srgb ? ", made linear Rec.709 by undoing the sRGB curve."
                   : profile.empty()
                       ? ", taken as linear Rec.709 as stored."
                       : ", made linear Rec.709 from the colour profile '" + profile + "'."));
  }
  if (const std::size_t grey = Count(facts, [](const FrameFacts& f) { return f.grey; })) {
    out.push_back("Colour: " + CountOf(grey, "photo") +
                  " with one channel, grey: red, green and blue are taken to be alike" +
                  (grey < facts.size() ? ", which they are not in the others." : "."));
  }
  DescribeRaw(raw, out);
  if (raw.empty() && options.white_balance != renderer::RawWhiteBalance::kCamera) {
    out.emplace_back("Colour: white_balance is of RAW photos, and none is one.");
  }
  if (const std::size_t turned =
          Count(facts, [](const FrameFacts& f) { return f.exif_orientation > 1; })) {
    out.push_back(
        "Orientation: " + CountOf(turned, "photo") + " with an EXIF rotation, which was " +
        (options.apply_exif_orientation ? "applied." : "ignored: pixels are used as stored.") +
        (options.apply_exif_orientation ? ""
                                        : std::string(raw.empty() ? "" : kRawTurned) +
                                              " If the cameras were found on upright pictures, "
                                              "use orientation 'exif'."));
  }
  if (options.clip_above < 1.0 && pixels > 0) {
    out.push_back("Clipping: pixels with a channel at or above " + ShortNumber(options.clip_above) +
                  " of the encoded range" + (raw.empty() ? "" : " (RAW: of the sensor's)") +
                  " count as clipped, and those beside them that nearly are; that is " +
                  ShortNumber(100.0 * static_cast<double>(clipped) / static_cast<double>(pixels)) +
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
    return static_cast<std::size_t>(std::ranges::count_if(
        set.views, [source](const View& v) { return v.files.mask_source == source; }));
  };
  const std::size_t folder = from(MaskSource::kFolder);
  const std::size_t listed = from(MaskSource::kMaskPath);
  const std::size_t alpha = from(MaskSource::kAlpha);
  std::string text = "Masks: " + std::to_string(folder + listed + alpha) + " of " +
                     std::to_string(facts.size()) + " matched (";
  std::string sources;
  const auto add = [&](std::size_t count, const std::string& name) {
    if (count > 0) sources += (sources.empty() ? "" : ", ") + std::to_string(count) + " " + name;
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
    if (facts[i].mask_is_black) black += (black.empty() ? "" : ", ") + set.views[i].name;
  }
  if (!black.empty()) out.push_back("Masks: these show nothing at all: " + black + ".");
}

/// One sentence per rule that was applied to the input, for people to check. `facts` belong to
/// `set.views`.
std::vector<std::string> SummariseInput(const ObservationOptions& options,
                                        const ImportedCameras& cameras,
                                        const ObservationSet& set,
                                        const std::vector<FrameFacts>& facts,
                                        const std::string& exif) {
  std::vector<std::string> out;
  DescribeCameras(options, cameras, facts, out);
  DescribePhotos(options, facts, out);
  if (!exif.empty()) out.push_back(exif);
  DescribeMasks(options, set, facts, out);
  const auto validation = static_cast<std::size_t>(
      std::ranges::count_if(set.views, [](const View& v) { return v.validation; }));
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

}  // namespace

ObservationError::ObservationError(std::vector<std::string> problems)
    : IoError(Join(problems)), problems_(std::move(problems)) {}

ObservationSet LoadObservations(const ObservationOptions& options, std::vector<InputFile>* files) {
  ImportedCameras cameras =
      options.fixed_camera
          ? PicturesOfCamera(options)
          : ImportCameras(options.cameras, options.camera_format, options.images_dir);
  if (!options.calibration.empty()) UseCalibration(options.calibration, cameras);
  const std::vector<std::string> names = ViewNames(cameras);
  const std::vector<std::size_t> order = SortedByName(names);
  std::vector<FrameResult> frames(order.size());
  const FrameLoader loader(options, cameras);
  renderer::ParallelFor(static_cast<std::int64_t>(order.size()), [&](std::int64_t i) {
    const std::size_t source = order[static_cast<std::size_t>(i)];
    loader.Load(cameras.cameras[source], names[source], frames[static_cast<std::size_t>(i)]);
  });

  std::vector<std::string> problems;
  CheckOptions(options, problems);
  ObservationSet set;
  set.mask_meaning = options.masks.meaning;
  set.mask_erode_px = options.masks.erode_px;
  std::vector<FrameFacts> facts;
  std::vector<InputFile> used;
  std::map<fs::path, std::size_t> photo_of;
  for (const fs::path& path : cameras.files) used.push_back({path});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i > 0 && names[order[i]] == names[order[i - 1]]) {
      problems.push_back(cameras.cameras[order[i]].place + ": the photo " + names[order[i]] +
                         " is given twice");
    }
    const fs::path& photo = frames[i].view.files.photo;
    const auto [first, is_new] = photo_of.try_emplace(photo, i);
    if (!photo.empty() && !is_new && names[order[i]] != names[order[first->second]]) {
      problems.push_back(cameras.cameras[order[i]].place + ": the photo " +
                         cameras.cameras[order[i]].image + " is missing: what is found for it, " +
                         photo.string() + ", is " + cameras.cameras[order[first->second]].image);
    }
    problems.insert(problems.end(), frames[i].problems.begin(), frames[i].problems.end());
    for (const fs::path& path : frames[i].files) used.push_back({path});
    frames[i].view.name = names[order[i]];
    set.views.push_back(std::move(frames[i].view));
    facts.push_back(frames[i].facts);
  }
  SplitViews(options, set.views, problems);
  const bool wants_masks = options.masks.meaning != MaskMeaning::kNone;
  if (problems.empty() && wants_masks && options.masks.require == MaskRequirement::kSome &&
      std::ranges::all_of(set.views,
                          [](const View& v) { return v.files.mask_source == MaskSource::kNone; })) {
    problems.emplace_back("masks: none of the photos has one, and at least one is required");
  }
  if (!problems.empty()) throw ObservationError(std::move(problems));
  std::vector<std::optional<ExifExposure>> exif;
  for (const FrameFacts& f : facts) exif.push_back(f.exif_exposure);
  const ExifComparison exposures = CompareExifExposures(exif);
  for (std::size_t i = 0; i < exposures.ev.size(); ++i) {
    set.views[i].exif_ev = static_cast<float>(exposures.ev[i]);
  }
  set.metres_per_unit = cameras.metres_per_unit;
  set.num_with_flash = static_cast<int>(
      std::ranges::count_if(exif, [](const auto& photo) { return photo && photo->flash; }));
  set.assumptions = SummariseInput(options, cameras, set, facts, exposures.seen);
  if (files != nullptr) *files = std::move(used);
  return set;
}

void SetMetresPerUnit(double metres_per_unit, const std::string& reason, ObservationSet& set) {
  const auto sentence = std::ranges::find_if(
      set.assumptions, [](const std::string& text) { return text.starts_with(kScaleSentence); });
  const std::string known =
      set.metres_per_unit > 0.0
          ? "the file says " + ShortNumber(set.metres_per_unit) + " m, which is not used"
          : std::string("the file does not say");
  const std::string text = std::string(kScaleSentence) + "1 unit of the camera file is " +
                           ShortNumber(metres_per_unit) + " m, " + reason + "; " + known +
                           "; poses stay in units of the file.";
  if (sentence == set.assumptions.end()) {
    set.assumptions.push_back(text);
  } else {
    *sentence = text;
  }
  set.metres_per_unit = metres_per_unit;
}

}  // namespace pathfit::optim
