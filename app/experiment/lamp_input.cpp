#include "app/experiment/lamp_input.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "app/experiment/folder_search.h"
#include "app/experiment/start_check.h"
#include "optim/observation/camera_import.h"
#include "optim/observation/lamp_list.h"
#include "optim/observation/mirror_ball.h"
#include "optim/observation/photo_file.h"
#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"
#include "renderer/core/parallel.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/color_segmentation.h"
#include "renderer/io/image_filter.h"
#include "renderer/io/text_scanner.h"
#include "renderer/math/median.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using optim::LampList;
using optim::PhotoLamp;
using optim::Transfer;
using renderer::Image;
using renderer::IoError;
using renderer::Vec3;

constexpr int kShadingPx = 160;         // longer side of photos by whose shading things are told
constexpr double kDarkShare = 0.08;     // of the bright end of the median photo: background
constexpr double kBrightEnd = 0.99;     // quantile
constexpr double kFilledHole = 0.02;    // of a made mask
constexpr double kClearlyBetter = 0.9;  // residual of one transfer over that of the other
constexpr double kDistance = 3.0;       // of the camera, in longer sides of the picture
constexpr double kTurned = 0.3;         // correlation of normals at the rim with the way out

bool SpeaksOfOthers(const fs::path& path) {
  return SpeaksOfMasks(path) || SpeaksOf(path, {"normal", "albedo", "depth", "ambient"});
}

/// "img_" of img_12.png.
std::string BeforeNumber(const fs::path& path) {
  std::string stem = path.stem().string();
  while (!stem.empty() && std::isdigit(static_cast<unsigned char>(stem.back())) != 0) {
    stem.pop_back();
  }
  return stem + path.extension().string();
}

/// The number at the end of a name, and the name: so that 2 comes before 10.
std::pair<double, std::string> NumberOf(const fs::path& path) {
  const std::string stem = path.stem().string();
  std::size_t first = stem.size();
  while (first > 0 && std::isdigit(static_cast<unsigned char>(stem[first - 1])) != 0) --first;
  const auto number = renderer::ParseReal(stem.substr(first));
  return {number.value_or(-1.0), stem};
}

/// Pictures of a folder by their numbers, but for masks and normals.
std::vector<fs::path> NumberedPhotos(const fs::path& folder) {
  std::vector<fs::path> pictures = optim::WithoutRawTwins(optim::PicturesIn(folder));
  std::erase_if(pictures, SpeaksOfOthers);
  std::ranges::stable_sort(pictures, {}, NumberOf);
  return pictures;
}
/// So many of them: all, else those whose names differ by their numbers alone. Empty: there are
/// others.
std::vector<fs::path> NumberedPhotos(const fs::path& folder, std::size_t count) {
  std::vector<fs::path> pictures = NumberedPhotos(folder);
  if (pictures.size() != count) {
    std::map<std::string, std::vector<fs::path>> groups;
    for (const fs::path& picture : pictures) groups[BeforeNumber(picture)].push_back(picture);
    std::erase_if(groups, [&](const auto& group) { return group.second.size() != count; });
    if (groups.size() != 1) return {};
    pictures = groups.begin()->second;
  }
  return pictures;
}

/// The photo of this name or, without extension, stem.
fs::path PhotoNamed(const fs::path& folder, const std::string& name) {
  std::string plain = name;
  std::ranges::replace(plain, '\\', '/');
  const fs::path file = fs::path(plain).filename();
  if (optim::IsPicture(folder / file)) return folder / file;
  const std::vector<fs::path> alike = EntriesOf(folder, [&](const fs::path& path) {
    return optim::IsPicture(path) && (path.stem() == file || path.stem() == file.stem());
  });
  return alike.size() == 1 ? alike.front() : fs::path();
}

/// Names in a filenames.txt, one for each lamp; empty without it.
std::vector<std::string> ListedNames(const fs::path& lamp_file) {
  const fs::path path = lamp_file.parent_path() / "filenames.txt";
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  const std::string text = renderer::ReadWholeFile(path);
  std::vector<std::string> names;
  renderer::LineReader lines(text);
  for (std::string_view line; lines.Next(line);) {
    if (const std::string_view name = renderer::NextToken(line); !name.empty()) {
      names.emplace_back(name);
    }
  }
  return names;
}

/// Of the photos; empty where their numbers tell.
std::vector<std::string> NamesOfLamps(const LampList& list, const fs::path& lamp_file) {
  std::vector<std::string> names;
  for (const PhotoLamp& lamp : list.lamps) names.push_back(lamp.photo);
  const bool by_ball = IsFolder(lamp_file);
  if (!by_ball && std::ranges::all_of(names, [](const std::string& n) { return n.empty(); })) {
    names = ListedNames(lamp_file);
  }
  if (names.size() != list.lamps.size() || names.front().empty()) names.clear();
  return names;
}

/// One for each lamp, all in one folder: that of the photos or one in it.
std::vector<fs::path> PhotosOfLamps(const fs::path& top,
                                    const LampList& list,
                                    const fs::path& lamp_file) {
  if (!IsFolder(top)) throw IoError(top.string() + ": no such folder");
  std::vector<fs::path> folders = EntriesOf(top, IsFolder);
  folders.insert(folders.begin(), top);
  const std::vector<std::string> names = NamesOfLamps(list, lamp_file);
  std::vector<std::vector<fs::path>> found;
  std::string missing;
  for (const fs::path& folder : folders) {
    if (names.empty()) {
      found.push_back(NumberedPhotos(folder, list.lamps.size()));
    } else {
      auto& photos = found.emplace_back();
      for (const std::string& name : names) {
        const fs::path photo = PhotoNamed(folder, name);
        if (photo.empty() && folder == top) missing = name;
        if (photo.empty()) break;
        photos.push_back(photo);
      }
      if (photos.size() != names.size()) photos.clear();
    }
    if (found.back().empty()) found.pop_back();
    if (!found.empty() && folder == top) return found.front();
  }
  if (found.size() == 1) return found.front();
  if (found.size() > 1) {
    throw IoError(top.string() + ": several folders in it have a photo for each of the " +
                  std::to_string(list.lamps.size()) + " lamps; name one");
  }
  throw IoError(fmt::format(
      "{}: has {} lamps, but {} has {} pictures{}. There must be one photo for each lamp: by the "
      "names in that file or in a filenames.txt beside it, else in the order of their numbers",
      lamp_file.string(),
      list.lamps.size(),
      top.string(),
      optim::PicturesIn(top).size(),
      missing.empty() ? "" : ", none of them " + missing));
}

/// What the names begin with and a star, if no other picture begins so; else empty.
std::string PatternOf(const std::vector<std::string>& names,
                      const std::vector<fs::path>& pictures) {
  std::string common = names.front();
  for (const std::string& name : names) {
    const auto end = std::ranges::mismatch(common, name).in1;
    common.erase(end, common.end());
  }
  const auto count = std::ranges::count_if(pictures, [&](const fs::path& picture) {
    return picture.filename().string().starts_with(common);
  });
  const bool is_plain = common.find_first_of("*?[\\") == std::string::npos;
  return is_plain && !common.empty() && count == static_cast<std::ptrdiff_t>(names.size())
             ? common + "*"
             : "";
}

double MeanOf(const renderer::Rgb& rgb) { return (rgb.r + rgb.g + rgb.b) / 3.0; }

/// A mask file for all photos beside them or above; empty if there is none, or more than one.
fs::path FindMaskFile(const fs::path& photos) {
  for (const fs::path& folder : {photos, photos.parent_path()}) {
    const std::vector<fs::path> masks = EntriesOf(
        folder, [](const fs::path& path) { return optim::IsPicture(path) && SpeaksOfMasks(path); });
    if (masks.size() == 1) return masks.front();
    if (!masks.empty()) break;
  }
  return {};
}

/// Photos of the same size, by name of file.
std::map<std::string, Image> SmallPhotos(const optim::ObservationSet& observations) {
  std::map<std::string, Image> small;
  for (const optim::View& view : observations.views) {
    const double scale = std::min(
        1.0, static_cast<double>(kShadingPx) / std::max(view.camera.width, view.camera.height));
    small[view.name] = renderer::ResizeArea(
        view.photo.Unpack(),
        std::max(1, static_cast<int>(std::lround(scale * view.camera.width))),
        std::max(1, static_cast<int>(std::lround(scale * view.camera.height))));
  }
  return small;
}

/// What is not black in the median of the photos.
Image MaskByBrightness(const optim::ObservationSet& observations) {
  const optim::View& first = observations.views.front();
  std::vector<Image> photos;
  for (const optim::View& view : observations.views) photos.push_back(view.photo.Unpack());
  Image middle(first.camera.width, first.camera.height, 1);
  std::vector<double> all, values(photos.size());
  for (int y = 0; y < middle.height; ++y) {
    for (int x = 0; x < middle.width; ++x) {
      std::ranges::transform(
          photos, values.begin(), [&](const Image& photo) { return MeanOf(photo.ColorAt(x, y)); });
      middle.At(x, y, 0) = static_cast<float>(renderer::Median(values));
      all.push_back(static_cast<double>(middle.At(x, y, 0)));
    }
  }
  const auto place = static_cast<std::ptrdiff_t>(kBrightEnd * static_cast<double>(all.size() - 1));
  std::ranges::nth_element(all, all.begin() + place);
  const auto least = static_cast<float>(kDarkShare * all[static_cast<std::size_t>(place)]);
  for (float& value : middle.data) value = value > least ? 1.0F : 0.0F;
  Image mask = renderer::LargestPart(middle, kFilledHole);
  if (WhiteBorder(mask) > 0.5 * kWhiteBorder || !(least > 0.0F)) {
    throw IoError(
        "the photos have no mask, and their background is not dark, so that it cannot be told from "
        "the object: --masks FILE (white = object)");
  }
  return mask;
}

/// By the highlights of a shiny ball, in photos of its own or in those of the object (`photos`).
LampList LampsOfBall(const fs::path& ball, const fs::path& photos) {
  const bool has_photos = IsFolder(ball);
  const fs::path folder = has_photos ? ball : photos;
  fs::path mask_file = ball;
  if (has_photos) {
    const std::vector<fs::path> masks = EntriesOf(
        ball, [](const fs::path& path) { return optim::IsPicture(path) && SpeaksOfMasks(path); });
    if (masks.size() != 1) {
      throw IoError(ball.string() + ": has " + std::to_string(masks.size()) +
                    " masks of the ball; one is needed (white = ball, a name with 'mask' in it)");
    }
    mask_file = masks.front();
  }
  const std::vector<fs::path> pictures = NumberedPhotos(folder);
  if (pictures.empty()) throw IoError(folder.string() + ": has no photo of the ball");
  const Image mask = optim::ReadMaskFile(mask_file, false);
  LampList list;
  list.lamps.resize(pictures.size());
  std::vector<std::string> problems(pictures.size());
  try {
    const optim::BallOutline outline = optim::FindBall(mask);
    renderer::ParallelFor(static_cast<std::int64_t>(pictures.size()), [&](std::int64_t i) {
      const auto place = static_cast<std::size_t>(i);
      const Image photo = optim::ReadPhotoFile(pictures[place], {}).photo;
      PhotoLamp& lamp = list.lamps[place];
      if (!has_photos) lamp.photo = pictures[place].filename().string();
      if (photo.width != mask.width || photo.height != mask.height) {
        problems[place] = pictures[place].string() + ": is not of the size of the ball's mask";
        return;
      }
      try {
        lamp.towards = optim::LampOfHighlight(photo, outline);
      } catch (const renderer::SceneError& error) {
        problems[place] = pictures[place].string() + ": " + error.what();
      }
    });
  } catch (const renderer::SceneError& error) {
    throw IoError(mask_file.string() + ": " + error.what());
  }
  std::string text;
  for (const std::string& problem : problems) {
    if (!problem.empty()) text += (text.empty() ? "" : "\n") + problem;
  }
  if (!text.empty()) throw IoError(text);
  return list;
}

class LampFinder {
 public:
  explicit LampFinder(const LampPlaces& places) : places_(places) {}

  FoundLamps Run() {
    found_.by_ball = places_.lamps.empty();
    found_.lamp_source = AbsolutePath(found_.by_ball ? places_.ball : places_.lamps);
    list_ = found_.by_ball ? LampsOfBall(found_.lamp_source, AbsolutePath(places_.photos))
                           : optim::ReadLampList(found_.lamp_source);
    if (!found_.by_ball) ReadStrengths();
    FindPhotos();
    FindMask();
    LoadPhotos();
    ChooseAxes();
    const auto scale = 1.0 / MeanStrength();
    for (std::size_t i = 0; i < list_.lamps.size(); ++i) {
      const PhotoLamp& lamp = list_.lamps[i];
      found_.lamps.push_back({photos_[i].filename().string(),
                              lamp.towards,
                              lamp.strength
                                  ? *lamp.strength * scale
                                  : renderer::Rgb::Constant(found_.shading.strengths[i])});
    }
    Describe();
    return std::move(found_);
  }

 private:
  void ReadStrengths() {
    const fs::path beside = found_.lamp_source.parent_path() / "light_intensities.txt";
    std::error_code error;
    if (!list_.lamps.front().strength && fs::is_regular_file(beside, error)) {
      optim::ReadLampStrengths(beside, list_);
    }
    found_.strengths_known = list_.lamps.front().strength.has_value();
  }

  [[nodiscard]] double MeanStrength() const {
    if (!found_.strengths_known) return 1.0;
    double sum = 0.0;
    for (const PhotoLamp& lamp : list_.lamps) sum += MeanOf(*lamp.strength);
    return sum / static_cast<double>(list_.lamps.size());
  }

  void FindPhotos() {
    photos_ = PhotosOfLamps(AbsolutePath(places_.photos), list_, found_.lamp_source);
    optim::ObservationOptions& options = found_.options;
    options.images_dir = photos_.front().parent_path();
    std::vector<std::string>& names = options.fixed_photos;
    for (const fs::path& photo : photos_) names.push_back(photo.filename().string());
    std::vector<std::string> sorted = names;
    std::ranges::sort(sorted);
    if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end()) {
      throw IoError(found_.lamp_source.string() + ": gives the photo " + *twice + " two lamps");
    }
    const std::vector<fs::path> pictures = optim::PicturesIn(options.images_dir);
    found_.all_pictures = optim::WithoutRawTwins(pictures).size() == photos_.size();
    found_.pattern = PatternOf(names, pictures);
    const optim::PhotoFile first = optim::ReadPhotoFile(photos_.front(), options);
    is_linear_file_ = first.bits > 16 || first.raw.has_value();
    has_alpha_ = std::ranges::any_of(first.alpha.data, [](float a) { return a < 0.5F; });
    renderer::Camera camera;
    camera.name = "front";
    camera.width = first.photo.width;
    camera.height = first.photo.height;
    camera.projection = renderer::ProjectionKind::kOrthographic;
    camera.fx = camera.fy = 1.0 / FoundLamps::kPixel;
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
    camera.world_from_camera.translation.z =
        kDistance * FoundLamps::kPixel * std::max(camera.width, camera.height);
    options.fixed_camera = camera;
  }

  void FindMask() {
    optim::MaskOptions& masks = found_.options.masks;
    masks.folder =
        places_.mask.empty() ? FindMaskFile(found_.options.images_dir) : AbsolutePath(places_.mask);
    masks.alpha = masks.folder.empty() && has_alpha_;
    if (!masks.folder.empty() || masks.alpha) masks.meaning = optim::MaskMeaning::kSilhouette;
  }

  optim::ObservationSet Load(Transfer transfer) {
    optim::ObservationOptions options = found_.options;
    options.transfer = transfer;
    optim::ObservationSet set = optim::LoadObservations(options);
    if (found_.mask.Empty()) {
      found_.mask_made = options.masks.meaning == optim::MaskMeaning::kNone;
      found_.mask = found_.mask_made ? MaskByBrightness(set) : set.views.front().mask.Unpack();
    }
    return set;
  }

  optim::ShadingFit Fit(const optim::ObservationSet& set) const {
    std::map<std::string, Image> small = SmallPhotos(set);
    std::vector<Image> photos;
    std::vector<Vec3> towards;
    std::vector<double> strengths;
    for (std::size_t i = 0; i < list_.lamps.size(); ++i) {
      photos.push_back(std::move(small.at(photos_[i].filename().string())));
      towards.push_back(list_.lamps[i].towards);
      if (found_.strengths_known) strengths.push_back(MeanOf(*list_.lamps[i].strength));
    }
    return optim::FitShading(
        photos,
        renderer::ResizeArea(found_.mask, photos.front().width, photos.front().height),
        towards,
        strengths);
  }

  /// With what photos' numbers mean, where two things are possible.
  void LoadPhotos() {
    optim::ObservationSet linear = Load(Transfer::kLinear);
    found_.shading = Fit(linear);
    found_.options.transfer = Transfer::kLinear;
    if (!is_linear_file_) {
      optim::ObservationSet encoded = Load(Transfer::kSrgb);
      const optim::ShadingFit fit = Fit(encoded);
      const double as_stored = found_.shading.residual;
      const bool is_encoded = fit.residual < as_stored;
      const double ratio = std::min(fit.residual, as_stored) / std::max(fit.residual, as_stored);
      transfer_reason_ = fmt::format(
          "a matt surface leaves {:.1f} % of the values as they are stored, {:.1f} % after undoing "
          "the sRGB curve{}",
          100.0 * as_stored,
          100.0 * fit.residual,
          ratio > kClearlyBetter ? ", which hardly differ" : "");
      if (is_encoded) {
        found_.options.transfer = Transfer::kSrgb;
        found_.shading = fit;
        linear = std::move(encoded);
      }
    }
    found_.observations = std::move(linear);
  }

  void ChooseAxes() {
    if (list_.reversed) {
      found_.guesses.emplace_back(
          "all vectors of the lamps have z < 0: taken for where the light goes");
    }
    optim::ShadingFit& fit = found_.shading;
    const bool is_y_down = fit.has_rim && fit.outward.y < -kTurned && fit.outward.x > kTurned;
    if (is_y_down) {
      for (PhotoLamp& lamp : list_.lamps) lamp.towards.y = -lamp.towards.y;
      fit.outward.y = -fit.outward.y;
      found_.guesses.emplace_back(
          "y of the lamps is taken as pointing down: only so the surface bends back along the "
          "mask's rim");
    } else if (fit.has_rim && std::min(fit.outward.x, fit.outward.y) < -kTurned) {
      found_.guesses.emplace_back(
          "the surface seems to bend towards the camera along the mask's rim: are the lamps "
          "those of these photos, in their order, with x right and y up?");
    }
  }

  void Describe() {
    if (!is_linear_file_) {
      found_.guesses.push_back(
          fmt::format("photos are taken as {}: {}",
                      found_.options.transfer == Transfer::kLinear ? "linear" : "sRGB",
                      transfer_reason_));
    }
    if (!found_.strengths_known) {
      found_.guesses.emplace_back(
          "the lamps' strengths are not known: those by which a matt surface explains the "
          "photos best");
    }
    if (list_.num_unused > 0) {
      found_.guesses.emplace_back("the last column of the lamps' file is not used");
    }
    if (found_.mask_made) {
      found_.guesses.emplace_back(
          "the photos have no mask: the object is what is not black in most of them");
    }
  }

  const LampPlaces& places_;
  LampList list_;
  std::vector<fs::path> photos_;  // of the lamps
  bool is_linear_file_ = false;
  bool has_alpha_ = false;
  std::string transfer_reason_;
  FoundLamps found_;
};

}  // namespace

fs::path FindLampFile(const fs::path& photos) {
  const fs::path top = AbsolutePath(photos);
  for (const fs::path& folder : {top, top.parent_path()}) {
    if (optim::HasCameras(folder)) return {};
    std::vector<fs::path> found = EntriesOf(folder, [](const fs::path& path) {
      const std::string name = renderer::LowerCase(path.filename().string());
      std::error_code error;
      return fs::is_regular_file(path, error) &&
             (path.extension() == ".lp" || name == "light_directions.txt" || name == "lights.txt" ||
              name == "lamps.txt");
    });
    if (!found.empty()) return found.size() == 1 ? found.front() : fs::path();
  }
  return {};
}

FoundLamps FindLamps(const LampPlaces& places) { return LampFinder(places).Run(); }

}  // namespace pathfit::app
