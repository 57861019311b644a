#include "app/experiment/input_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>

#include <fmt/format.h>

#include "app/experiment/folder_search.h"
#include "app/experiment/start_check.h"
#include "optim/observation/camera_import.h"
#include "optim/observation/object_masks.h"
#include "optim/observation/photo_file.h"
#include "optim/observation/point_body.h"
#include "optim/observation/reduced_camera.h"
#include "optim/observation/visual_hull.h"
#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/image_filter.h"
#include "renderer/io/ply_file.h"
#include "renderer/io/raw_file.h"
#include "renderer/math/median.h"
#include "renderer/renderer.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using optim::ImportedCamera;
using optim::ImportedCameras;
using renderer::Image;
using renderer::IoError;

constexpr std::size_t kMaskSamples = 8;
// Longest side of the picture that tells where a start of sparse points is seen, and how far its
// outline may be off, of that.
constexpr double kRegionPx = 640.0, kOutlineShare = 0.02;
constexpr double kUsefulMasks = 0.5;  // share of the photos
constexpr int kSmallPx = 48;          // width at which backgrounds are compared
constexpr double kRim = 0.12;         // of the width: background of photos without masks
constexpr std::size_t kFewestNumbers = 120;
constexpr std::size_t kFewViews = 5;     // of less, none is held out
constexpr std::size_t kPartsOfRow = 24;  // photos are taken in a row, often once around
constexpr double kDark = 0.1;            // linear: below, noise would be a change
constexpr double kBlack = 0.005;         // linear: nothing is there, or it was cut out

void AddOnce(const fs::path& path, std::vector<fs::path>& list) {
  const fs::path normal = (path.has_filename() ? path : path.parent_path()).lexically_normal();
  if (IsFolder(normal) && std::ranges::find(list, normal) == list.end()) list.push_back(normal);
}

/// "" unless there are pictures of formats that are not read.
std::string OtherPictures(const std::vector<fs::path>& folders) {
  static const std::set<std::string> kOthers = {".heic", ".heif", ".avif", ".webp", ".bmp", ".gif"};
  std::set<std::string> seen;
  for (const fs::path& folder : folders) {
    for (const fs::path& path : EntriesOf(folder, [](const fs::path&) { return true; })) {
      const std::string extension = renderer::LowerCase(path.extension().string());
      if (kOthers.contains(extension)) seen.insert(extension);
    }
  }
  if (seen.empty()) return "";
  std::string text;
  for (const std::string& extension : seen) text += (text.empty() ? "" : ", ") + extension;
  return ". There are pictures that are not read (" + text +
         "); convert them to JPEG, PNG, TIFF or EXR";
}

/// The file or folder of the cameras.
fs::path FindCameras(const InputPlaces& places) {
  if (!places.cameras.empty()) return AbsolutePath(places.cameras);
  const fs::path top = AbsolutePath(places.photos);
  if (!IsFolder(top)) throw IoError(top.string() + ": no such folder");
  std::vector<fs::path> tried;
  const auto has_cameras = [&tried](const fs::path& folder) {
    AddOnce(folder, tried);
    return optim::HasCameras(folder);
  };
  for (const fs::path& folder : {top, top / "colmap", top / "cameras"}) {
    if (has_cameras(folder)) return folder;
  }
  // Sets that are divided for learning and testing.
  if (const fs::path file = top / "transforms_train.json"; optim::HasCameras(file)) return file;
  // Several sets in one folder are not to be guessed among.
  const std::vector<fs::path> sets =
      EntriesOf(top, [&](const fs::path& path) { return IsFolder(path) && has_cameras(path); });
  if (sets.size() > 1) {
    throw IoError(top.string() + ": holds several sets of cameras; name one: " + PathList(sets));
  }
  if (sets.size() == 1) return sets.front();
  // What is above a folder without any picture is of other photos.
  const bool has_pictures =
      !optim::PicturesIn(top).empty() || !EntriesOf(top, [](const fs::path& path) {
                                            return !optim::PicturesIn(path).empty();
                                          }).empty();
  for (const fs::path& folder : {top.parent_path(), top.parent_path().parent_path()}) {
    for (const fs::path& place : {folder, folder / "colmap", folder / "cameras"}) {
      if (has_pictures && has_cameras(place)) return place;
    }
  }
  throw IoError(
      top.string() + ": no cameras were found. Looked for " + optim::CameraFormatList() +
      " in: " + PathList(tried) +
      ". Photos need cameras first: --sfm colmap finds them (apt install colmap), or give "
      "their file or folder as second argument. One camera that stood still while the lamps "
      "changed needs none, but their directions: --lamps FILE, or a shiny ball that tells them: "
      "--ball DIR" +
      OtherPictures({top}));
}

// Beside masks that were made, so that nobody takes them for better ones.
constexpr const char* kMadeFile = "made_masks.txt";

/// Of masks that MakeMasks made; empty: somebody else did.
std::optional<double> AgreementOfMade(const fs::path& folder) {
  const fs::path path = folder / kMadeFile;
  double agreement = 0.0;
  if (!(std::ifstream(path) >> agreement)) return std::nullopt;
  return agreement;
}

bool IsMaskFolder(const fs::path& path) { return IsFolder(path) && SpeaksOfMasks(path); }

/// Whether the photo of each camera is in a folder (empty: where the camera file says), and not
/// that of an earlier one: photos of two folders may have the same names.
std::vector<bool> AreFound(const ImportedCameras& cameras, const fs::path& folder) {
  std::set<fs::path> photos;
  std::vector<bool> found;
  for (const ImportedCamera& camera : cameras.cameras) {
    const auto photo = optim::FindPhoto(camera.image, cameras, folder).found;
    found.push_back(photo && photos.insert(*photo).second);
  }
  return found;
}
std::size_t NumFound(const ImportedCameras& cameras, const fs::path& folder) {
  return static_cast<std::size_t>(std::ranges::count(AreFound(cameras, folder), true));
}

/// The folder in which all photos are; refuses when some are missing everywhere.
fs::path FindPhotos(const InputPlaces& places, const ImportedCameras& cameras) {
  std::vector<fs::path> folders;
  if (!places.photos.empty()) {
    const fs::path top = AbsolutePath(places.photos);
    AddOnce(top, folders);
    for (const fs::path& child : EntriesOf(top, IsFolder)) {
      if (!IsMaskFolder(child)) AddOnce(child, folders);
    }
  }
  if (!cameras.cameras.empty()) {
    const optim::FileSearch said = optim::FindPhoto(cameras.cameras.front().image, cameras, {});
    if (said.found) AddOnce(said.found->parent_path(), folders);
  }
  const fs::path around = cameras.folder.parent_path();
  for (const fs::path& folder : {cameras.folder, around, around.parent_path()}) {
    for (const char* name : {"images", "photos", "rgb", "input"}) AddOnce(folder / name, folders);
  }
  fs::path best;
  std::size_t most = 0;
  for (const fs::path& folder : folders) {
    const std::size_t found = NumFound(cameras, folder);
    if (found > most) {
      most = found;
      best = folder;
    }
  }
  if (most < cameras.cameras.size()) {
    const std::vector<bool> found = AreFound(cameras, best);
    const auto missing =
        cameras.cameras.begin() + (std::ranges::find(found, false) - found.begin());
    throw IoError(fmt::format(
        "{}: {} of its {} photos are missing, the first is {} ({}). Looked in: {}{}. Name the "
        "folder "
        "that holds all of them, or leave out the cameras of photos that are gone: `pathfit "
        "convert "
        "cameras` makes a list (cameras.yaml) that can be edited",
        cameras.files.empty() ? cameras.folder.string() : cameras.files.front().string(),
        cameras.cameras.size() - most,
        cameras.cameras.size(),
        missing->image,
        missing->place,
        folders.empty() ? "no folder" : PathList(folders),
        OtherPictures(folders)));
  }
  // The very folder of the photos, if it is one.
  std::set<fs::path> parents;
  for (const ImportedCamera& camera : cameras.cameras) {
    parents.insert(optim::FindPhoto(camera.image, cameras, best).found->parent_path());
  }
  const fs::path one = parents.begin()->lexically_normal();
  return parents.size() == 1 && NumFound(cameras, one) == most ? one : best;
}

/// In how many photos a mask is found so.
std::size_t NumMasks(const ImportedCameras& cameras, const optim::ObservationOptions& options) {
  return static_cast<std::size_t>(
      std::ranges::count_if(cameras.cameras, [&](const ImportedCamera& camera) {
        const auto photo = optim::FindPhoto(camera.image, cameras, options.images_dir).found;
        return photo && optim::FindMask(camera, *photo, cameras, options).found;
      }));
}

/// A small copy and what of it is background.
struct Small {
  Image photo, background;
};
Small MakeSmall(const optim::View& view) {
  const int height = std::max(1, kSmallPx * view.camera.height / std::max(1, view.camera.width));
  Small small{renderer::ResizeArea(view.photo.Unpack(), kSmallPx, height),
              Image(kSmallPx, height, 1)};
  const int rim = std::max(1, static_cast<int>(kRim * kSmallPx));
  Image mask;
  if (!view.mask.Empty()) mask = renderer::ResizeArea(view.mask.Unpack(), kSmallPx, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < kSmallPx; ++x) {
      const bool at_rim =
          std::min({x, y, kSmallPx - 1 - x, height - 1 - y}) < std::min(rim, height / 3);
      const bool free = mask.Empty() ? at_rim : mask.At(x, y, 0) < 0.01F;
      small.background.At(x, y, 0) = free ? 1.0F : 0.0F;
    }
  }
  return small;
}

/// Medians over pairs of views. Neighbours in a long row are taken from almost the same place.
std::optional<Background> FindBackground(const optim::ObservationSet& observations) {
  const auto& views = observations.views;
  const auto gain = [&](std::size_t view) {
    return std::exp2(static_cast<double>(views[view].exif_ev));
  };
  std::vector<Small> smalls;
  for (const optim::View& view : views) smalls.push_back(MakeSmall(view));
  const std::size_t apart = std::max<std::size_t>(1, views.size() / kPartsOfRow);
  std::vector<double> changes, structures;
  for (std::size_t i = 0; i + apart < views.size(); ++i) {
    const Small& a = smalls[i];
    const Small& b = smalls[i + apart];
    if (a.photo.data.size() != b.photo.data.size()) continue;
    std::vector<double> differences, brightness, deviations;
    std::array<std::vector<double>, 3> channels;
    for (std::size_t p = 0; p < a.background.data.size(); ++p) {
      if (a.background.data[p] * b.background.data[p] == 0.0F) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto u = static_cast<double>(a.photo.data[3 * p + c]) / gain(i);
        const auto v = static_cast<double>(b.photo.data[3 * p + c]) / gain(i + apart);
        channels[c].push_back(u);
        differences.push_back(std::abs(u - v));
        brightness.push_back(0.5 * (u + v));
      }
    }
    if (differences.size() < kFewestNumbers) continue;
    const double middle_brightness = renderer::Median(brightness);
    if (middle_brightness < kBlack) continue;
    for (std::vector<double>& values : channels) {
      const double middle = renderer::Median(values);
      for (const double value : values) deviations.push_back(std::abs(value - middle));
    }
    const double bright = std::max(kDark, middle_brightness);
    changes.push_back(renderer::Median(differences) / bright);
    structures.push_back(renderer::Median(deviations) / bright);
  }
  if (changes.empty()) return std::nullopt;
  return Background{renderer::Median(changes), renderer::Median(structures)};
}

class InputFinder {
 public:
  explicit InputFinder(const InputPlaces& places) : places_(places) {}

  FoundInput Run() {
    input_.options.cameras = FindCameras(places_);
    const bool has_pictures = !places_.photos.empty() && !optim::PicturesIn(places_.photos).empty();
    cameras_ = optim::ImportCameras(
        input_.options.cameras, "auto", has_pictures ? AbsolutePath(places_.photos) : fs::path());
    if (!places_.calibration.empty()) {
      input_.options.calibration = AbsolutePath(places_.calibration);
      optim::UseCalibration(input_.options.calibration, cameras_);
    }
    if (cameras_.cameras.empty()) {
      throw IoError(input_.options.cameras.string() + ": has no posed photo");
    }
    input_.camera_format = cameras_.format;
    input_.metres_per_unit = cameras_.metres_per_unit;
    input_.points = cameras_.points;
    input_.options.images_dir = FindPhotos(places_, cameras_);
    FindMasks();
    CountUnused();
    if (cameras_.cameras.size() < kFewViews) input_.options.validation_every = 0;
    Load();
    std::vector<renderer::Camera> sensors;
    for (const optim::View& view : input_.observations.views) sensors.push_back(view.camera);
    input_.layout = FindCameraLayout(sensors);
    input_.background = FindBackground(input_.observations);
    return std::move(input_);
  }

 private:
  /// Masks may be beside the photos: a.mask.png, a.jpg.png.
  void CountUnused() {
    std::set<fs::path> used, stems;
    for (const ImportedCamera& camera : cameras_.cameras) {
      const auto photo = optim::FindPhoto(camera.image, cameras_, input_.options.images_dir).found;
      if (!photo) continue;
      used.insert(photo->lexically_normal());
      stems.insert(photo->lexically_normal().replace_extension());
      const auto mask = optim::FindMask(camera, *photo, cameras_, input_.options).found;
      if (mask) used.insert(mask->lexically_normal());
    }
    const std::vector<fs::path> pictures = optim::PicturesIn(input_.options.images_dir);
    input_.num_without_camera =
        static_cast<std::size_t>(std::ranges::count_if(pictures, [&](const fs::path& picture) {
          const fs::path stem = picture.stem();
          const fs::path normal = picture.lexically_normal();
          const bool is_twin = stems.contains(fs::path(normal).replace_extension()) &&
                               renderer::HasRawExtension(normal);
          return !used.contains(normal) && !is_twin && stem.extension() != ".mask" &&
                 !optim::IsPicture(picture.parent_path() / stem);
        }));
  }

  void UseMasks(std::size_t count) {
    optim::MaskOptions& masks = input_.options.masks;
    masks.meaning = optim::MaskMeaning::kSilhouette;
    masks.require = count == cameras_.cameras.size() ? optim::MaskRequirement::kAll
                                                     : optim::MaskRequirement::kSome;
    input_.num_masks = count;
  }

  void FindMasks() {
    optim::ObservationOptions options = input_.options;
    const auto wanted =
        static_cast<std::size_t>(kUsefulMasks * static_cast<double>(cameras_.cameras.size()));
    if (!places_.masks.empty()) {
      options.masks.folder = AbsolutePath(places_.masks);
      const std::size_t count = NumMasks(cameras_, options);
      if (count == 0) {
        throw IoError(options.masks.folder.string() +
                      ": holds no mask of a photo (for a.jpg: a.jpg.png, a.png or a.mask.png)");
      }
      input_.options = options;
      return UseMasks(count);
    }
    if (const std::size_t count = NumMasks(cameras_, options); count > wanted) {
      return UseMasks(count);  // as the camera file says
    }
    const fs::path& photos = input_.options.images_dir;
    std::vector<fs::path> folders = EntriesOf(photos, IsMaskFolder);
    for (const fs::path& above : {photos.parent_path(), cameras_.folder}) {
      for (const fs::path& folder : EntriesOf(above, IsMaskFolder)) AddOnce(folder, folders);
    }
    folders.push_back(photos);  // a.mask.png beside a.jpg
    // What an earlier run made from colours comes after what anybody else says.
    const auto made = std::ranges::stable_partition(
        folders, [](const fs::path& folder) { return !AgreementOfMade(folder); });
    const auto use_one_of = [&](auto first, auto last) {
      for (; first != last; ++first) {
        options.masks.folder = *first;
        const std::size_t count = NumMasks(cameras_, options);
        if (count <= wanted) continue;
        input_.options = options;
        input_.mask_agreement = AgreementOfMade(*first);
        UseMasks(count);
        return true;
      }
      return false;
    };
    if (use_one_of(folders.begin(), made.begin())) return;
    if (const std::size_t count = NumTransparent()) {
      input_.options.masks.alpha = true;
      return UseMasks(count);
    }
    static_cast<void>(use_one_of(made.begin(), made.end()));
  }

  /// Photos whose alpha channel tells the object. Where none of a few does, all are not read.
  [[nodiscard]] std::size_t NumTransparent() const {
    const std::size_t all = cameras_.cameras.size();
    const auto is_transparent = [&](std::size_t i) {
      const auto photo =
          optim::FindPhoto(cameras_.cameras[i].image, cameras_, input_.options.images_dir).found;
      static const std::set<std::string> kWithAlpha = {".png", ".tif", ".tiff", ".exr"};
      if (!kWithAlpha.contains(renderer::LowerCase(photo->extension().string()))) return false;
      const Image alpha = optim::ReadPhotoFile(*photo, input_.options).alpha;
      return std::ranges::any_of(alpha.data, [](float a) { return a < 0.5F; });
    };
    const std::size_t step = std::max<std::size_t>(1, all / kMaskSamples);
    bool any = false;
    // Odd steps: of photos in turn with and without, both kinds.
    for (std::size_t i = 0; i < all && !any; i += step | 1U) any = is_transparent(i);
    std::size_t count = 0;
    for (std::size_t i = 0; i < all && any; ++i) count += is_transparent(i) ? 1 : 0;
    return count;
  }

  void Load() {
    optim::ObservationOptions& options = input_.options;
    try {
      input_.observations = optim::LoadObservations(options);
    } catch (const optim::ObservationError&) {
      // Cameras that were found on upright pictures; if that is not it, the first message counts.
      optim::ObservationOptions upright = options;
      upright.apply_exif_orientation = true;
      try {
        input_.observations = optim::LoadObservations(upright);
      } catch (const optim::ObservationError&) {
        input_.observations = optim::LoadObservations(options);
      }
      options = upright;
    }
    if (MasksLookInverted()) {
      options.masks.invert = true;
      input_.observations = optim::LoadObservations(options);
    }
  }

  [[nodiscard]] bool MasksLookInverted() const {
    if (input_.options.masks.alpha) return false;
    double white = 0.0, num_seen = 0.0;
    std::size_t left = kMaskSamples;
    for (const optim::View& view : input_.observations.views) {
      if (view.mask.Empty() || left == 0) continue;
      --left;
      white += WhiteBorder(renderer::ResizeArea(view.mask.Unpack(), kSmallPx, kSmallPx));
      num_seen += 1.0;
    }
    return white > kWhiteBorder * num_seen;
  }

  const InputPlaces& places_;
  ImportedCameras cameras_;
  FoundInput input_;
};

void WriteMask(const fs::path& folder, const optim::View& view, const Image& mask) {
  const fs::path path =
      folder / fs::path(view.name).parent_path() / (view.files.photo.filename().string() + ".png");
  renderer::CreateFolders(path.parent_path());
  renderer::WritePng8(path, mask);
}

/// Goes on with the masks that were written for all photos.
void TakeMasks(const fs::path& folder, optim::MaskMeaning meaning, FoundInput& input) {
  input.num_masks = input.observations.views.size();
  input.options.masks.folder = folder;
  input.options.masks.meaning = meaning;
  input.observations = optim::LoadObservations(input.options);
}

/// White where a body is seen, but along its outline, which is not yet that of the photo.
Image SeenWell(const renderer::Renderer& body, const renderer::Camera& camera) {
  const renderer::Camera small = optim::ReducedCamera(camera, kRegionPx);
  renderer::RenderOptions options;
  options.spp = 1;
  options.max_bounces = 0;
  const Image seen = renderer::CoverageImage(body.RenderPrimal(small, options));
  const double outline_px = kOutlineShare * std::max(small.width, small.height);
  return renderer::ResizeArea(renderer::Erode(seen, static_cast<int>(std::lround(outline_px))),
                              camera.width,
                              camera.height);
}

}  // namespace

FoundInput FindInput(const InputPlaces& places) { return InputFinder(places).Run(); }

bool HasCamerasNear(const InputPlaces& places) {
  try {
    static_cast<void>(FindCameras(places));
    return true;
  } catch (const IoError&) {
    return false;
  }
}

bool MakeMasks(const fs::path& folder, FoundInput& input) {
  if (!input.layout) return false;
  const std::vector<optim::View>& views = input.observations.views;
  const std::optional<optim::ObjectMasks> made =
      optim::MakeObjectMasks(input.observations, input.layout->centre, input.layout->radius);
  if (!made) return false;
  optim::ObservationSet masked = input.observations;
  masked.mask_meaning = optim::MaskMeaning::kSilhouette;
  for (std::size_t i = 0; i < views.size(); ++i) masked.views[i].mask = made->masks[i];
  try {
    static_cast<void>(optim::CarveVisualHull(
        masked, {.resolution = optim::VisualHullOptions::kMinResolution, .dissent = kDissent}));
  } catch (const renderer::SceneError&) {
    return false;  // they bound nothing
  }
  for (std::size_t i = 0; i < views.size(); ++i) WriteMask(folder, views[i], made->masks[i]);
  renderer::WriteFileAtomically(
      folder / kMadeFile,
      fmt::format("{:.3f}\nSo much do these masks overlap, which pathfit init made from colours. "
                  "Correct them as you like; without this file they count as yours.\n",
                  made->agreement));
  input.mask_agreement = made->agreement;
  TakeMasks(folder, optim::MaskMeaning::kSilhouette, input);
  input.background = FindBackground(input.observations);
  return true;
}

bool MakeStart(const fs::path& mesh, const fs::path& folder, FoundInput& input) {
  if (!input.layout || input.points.empty()) return false;
  const std::vector<optim::View>& views = input.observations.views;
  std::vector<renderer::Camera> cameras;
  for (const optim::View& view : views) cameras.push_back(view.camera);
  const std::optional<renderer::Mesh> body = optim::BodyOfPoints(
      optim::ReadSparsePoints(input.points), cameras, input.layout->centre, input.layout->radius);
  if (!body) return false;
  renderer::WritePly(mesh, *body);
  renderer::Scene scene;
  scene.materials.emplace_back();
  scene.meshes.push_back({.name = "body", .mesh = *body, .material = 0});
  const renderer::Renderer renderer(std::move(scene));
  for (const optim::View& view : views) WriteMask(folder, view, SeenWell(renderer, view.camera));
  input.start_of_points = true;
  TakeMasks(folder, optim::MaskMeaning::kIgnore, input);
  return true;
}

}  // namespace pathfit::app
