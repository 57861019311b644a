#include "app/experiment/lamp_input.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "app/experiment/folder_search.h"
#include "app/experiment/lamp_photos.h"
#include "app/experiment/start_check.h"
#include "optim/observation/lamp_list.h"
#include "optim/observation/mirror_ball.h"
#include "optim/observation/photo_file.h"
#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"
#include "renderer/core/parallel.h"
#include "renderer/image/color.h"
#include "renderer/io/color_segmentation.h"
#include "renderer/io/image_filter.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using optim::LampList;
using optim::PhotoLamp;
using optim::Transfer;
using renderer::Image;
using renderer::IoError;
using renderer::PixelBox;
using renderer::Vec3;

constexpr int kShadingPx = 160;        // longer side of the object by whose shading things are told
constexpr int kMargin = 4;             // pixels around it
constexpr double kDarkShare = 0.08;    // of the bright end of the photos' mean: background
constexpr double kBrightEnd = 0.998;   // quantile
constexpr double kFilledHole = 0.02;   // of a made mask
constexpr double kHardlyDiffer = 0.9;  // residual of one transfer over that of the other
constexpr double kTold = 1e-3;         // residual of either: by less, photos do not tell which
constexpr double kTurned = 0.3;        // correlation of normals at the rim with the way out
constexpr double kPoorlyExplained = 0.1;
constexpr double kCameraDistance = 3.0;  // in longer sides of the picture
constexpr std::size_t kFewestLamps = 3;
constexpr std::size_t kFewPhotos = 8;  // of less, none is held out

double MeanOf(const renderer::Rgb& rgb) { return (rgb.r + rgb.g + rgb.b) / 3.0; }

/// A mask file for all photos: the one beside them, or above one called "mask" or after their
/// folder. Empty if there is none, or more than one. `other`: a mask that is not the object's.
fs::path FindMaskFile(const fs::path& photos, const fs::path& other) {
  const auto is_mask = [&](const fs::path& path) {
    return optim::IsPicture(path) && SpeaksOfMasks(path) && path != other;
  };
  const std::vector<fs::path> beside = EntriesOf(photos, is_mask);
  if (!beside.empty()) return beside.size() == 1 ? beside.front() : fs::path();
  const std::string name = renderer::LowerCase(photos.filename().string());
  const std::vector<fs::path> above = EntriesOf(photos.parent_path(), [&](const fs::path& path) {
    const std::string stem = renderer::LowerCase(path.stem().string());
    return is_mask(path) && (stem == "mask" || stem == name + "_mask" || stem == "mask_" + name);
  });
  return above.size() == 1 ? above.front() : fs::path();
}

/// Where a mask is more than half of its brightest, and a little around it.
PixelBox PartAround(const Image& mask) {
  const PixelBox box = renderer::BoxAbove(mask, 0.5F * *std::ranges::max_element(mask.data));
  if (box.x1 < box.x0) return {0, 0, mask.width - 1, mask.height - 1};
  return {std::max(0, box.x0 - kMargin),
          std::max(0, box.y0 - kMargin),
          std::min(mask.width - 1, box.x1 + kMargin),
          std::min(mask.height - 1, box.y1 + kMargin)};
}

/// The part, no larger than shading needs. `decode`: undoes the sRGB curve before.
Image SmallPart(const Image& image, const PixelBox& part, bool decode = false) {
  Image cut(part.x1 - part.x0 + 1, part.y1 - part.y0 + 1, image.channels);
  for (int y = 0; y < cut.height; ++y) {
    const auto* from = image.data.data() + image.Offset(part.x0, part.y0 + y);
    std::copy_n(from, cut.width * image.channels, cut.data.data() + cut.Offset(0, y));
  }
  if (decode) {
    for (float& value : cut.data) {
      value = static_cast<float>(renderer::LinearFromSrgb(static_cast<double>(value)));
    }
  }
  const double scale =
      std::min(1.0, static_cast<double>(kShadingPx) / std::max(cut.width, cut.height));
  return renderer::ResizeArea(cut,
                              std::max(1, static_cast<int>(std::lround(scale * cut.width))),
                              std::max(1, static_cast<int>(std::lround(scale * cut.height))));
}

/// What is not black in the mean of the photos.
Image MaskByBrightness(const optim::ObservationSet& observations) {
  const optim::View& first = observations.views.front();
  Image mean(first.camera.width, first.camera.height, 1);
  for (const optim::View& view : observations.views) {
    const Image photo = view.photo.Unpack();
    for (int y = 0; y < mean.height; ++y) {
      for (int x = 0; x < mean.width; ++x) {
        mean.At(x, y, 0) += static_cast<float>(renderer::MeanOfChannels(photo, x, y));
      }
    }
  }
  std::vector<float> all = mean.data;
  const auto place = static_cast<std::ptrdiff_t>(kBrightEnd * static_cast<double>(all.size() - 1));
  std::ranges::nth_element(all, all.begin() + place);
  const float least = static_cast<float>(kDarkShare) * all[static_cast<std::size_t>(place)];
  for (float& value : mean.data) value = value > least ? 1.0F : 0.0F;
  Image mask = renderer::LargestPart(mean, kFilledHole);
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
  const fs::path folder = has_photos ? ball : PhotoFolder(photos, ball.parent_path());
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
    if (list_.lamps.size() < kFewestLamps) {
      throw IoError(fmt::format("{}: has {} lamps; shading tells shape by {} or more",
                                found_.lamp_source.string(),
                                list_.lamps.size(),
                                kFewestLamps));
    }
    if (!found_.by_ball) ReadStrengths();
    FindPhotos();
    FindMask();
    LoadPhotos();
    ChooseAxes();
    const double scale = 1.0 / MeanStrength();
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
    if (photos_.size() < kFewPhotos) options.validation_every = 0;
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
        kCameraDistance * FoundLamps::kPixel * std::max(camera.width, camera.height);
    options.fixed_camera = camera;
  }

  void FindMask() {
    optim::MaskOptions& masks = found_.options.masks;
    masks.folder = places_.mask.empty()
                       ? FindMaskFile(found_.options.images_dir, AbsolutePath(places_.ball))
                       : AbsolutePath(places_.mask);
    masks.alpha = masks.folder.empty() && has_alpha_;
    if (!masks.folder.empty() || masks.alpha) masks.meaning = optim::MaskMeaning::kSilhouette;
  }

  optim::ObservationSet Load() {
    optim::ObservationSet set = optim::LoadObservations(found_.options);
    const auto& first = set.views.front();
    for (const optim::View& view : set.views) {
      if (view.photo.width() == first.photo.width() &&
          view.photo.height() == first.photo.height()) {
        continue;
      }
      throw IoError(
          fmt::format("{}: has {} x {} pixels, {} has {} x {}; photos of one camera that "
                      "stood still are of one size",
                      view.files.photo.string(),
                      view.photo.width(),
                      view.photo.height(),
                      first.files.photo.string(),
                      first.photo.width(),
                      first.photo.height()));
    }
    if (found_.mask.Empty()) {
      found_.mask_made = found_.options.masks.meaning == optim::MaskMeaning::kNone;
      found_.mask = found_.mask_made ? MaskByBrightness(set) : first.mask.Unpack();
    }
    return set;
  }

  /// Of the photos as they were loaded, or with the sRGB curve undone.
  [[nodiscard]] optim::ShadingFit Fit(bool decode) const {
    const PixelBox part = PartAround(found_.mask);
    std::map<std::string, const optim::View*> views;
    for (const optim::View& view : found_.observations.views) views[view.name] = &view;
    std::vector<Image> photos;
    std::vector<Vec3> towards;
    std::vector<double> strengths;
    for (std::size_t i = 0; i < list_.lamps.size(); ++i) {
      const optim::View& view = *views.at(photos_[i].filename().string());
      photos.push_back(SmallPart(view.photo.Unpack(), part, decode));
      towards.push_back(list_.lamps[i].towards);
      if (found_.strengths_known) strengths.push_back(MeanOf(*list_.lamps[i].strength));
    }
    return optim::FitShading(photos, SmallPart(found_.mask, part), towards, strengths);
  }

  /// With what photos' numbers mean, where two things are possible.
  void LoadPhotos() {
    found_.options.transfer = Transfer::kLinear;
    found_.observations = Load();
    found_.shading = Fit(false);
    if (is_linear_file_) return;
    const double as_stored = found_.shading.residual;
    const optim::ShadingFit decoded = Fit(true);
    const double least = std::min(decoded.residual, as_stored);
    const double most = std::max(decoded.residual, as_stored);
    const bool is_told = most > kTold;
    transfer_reason_ =
        is_told ? fmt::format(
                      "a matt surface leaves {:.1f} % of the values as they are stored, "
                      "{:.1f} % after undoing the sRGB curve{}",
                      100.0 * as_stored,
                      100.0 * decoded.residual,
                      least > kHardlyDiffer * most ? ", which hardly differ" : "")
                : "so few lamps do not tell whether that is so; else colour: {transfer: linear}";
    if (!is_told || decoded.residual < as_stored) {
      found_.options.transfer = Transfer::kSrgb;
      found_.shading = decoded;
      found_.observations = Load();
    }
  }

  void ChooseAxes() {
    if (list_.reversed) {
      found_.guesses.emplace_back(
          "all vectors of the lamps have z < 0: taken for where the light goes");
    }
    optim::ShadingFit& fit = found_.shading;
    if (!fit.has_rim) return;
    const bool is_x_turned = fit.outward.x < -kTurned, is_y_turned = fit.outward.y < -kTurned;
    if (is_y_turned && fit.outward.x > kTurned) {
      for (PhotoLamp& lamp : list_.lamps) lamp.towards.y = -lamp.towards.y;
      fit.outward.y = -fit.outward.y;
      found_.guesses.emplace_back(
          "y of the lamps is taken as pointing down: only so the surface bends back along the "
          "mask's rim");
    } else if (is_x_turned && fit.outward.y > kTurned) {
      for (PhotoLamp& lamp : list_.lamps) lamp.towards.x = -lamp.towards.x;
      fit.outward.x = -fit.outward.x;
      found_.guesses.emplace_back(
          "x of the lamps is taken as pointing left: only so the surface bends back along the "
          "mask's rim");
    } else if (is_x_turned || is_y_turned) {
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
          found_.shading.strengths_told
              ? "the lamps' strengths are not known: those by which a matt surface explains the "
                "photos best"
              : "the lamps' strengths are not known, and the shading does not tell them: those by "
                "which a surface that faces the camera is as bright as the photos");
    }
    if (found_.shading.residual > kPoorlyExplained) {
      found_.guesses.push_back(fmt::format(
          "a matt surface explains the photos badly ({:.0f} % is left): are the lamps those of "
          "these photos, in their order ({} first, {} last)? Highlights and shadows leave less",
          100.0 * found_.shading.residual,
          photos_.front().filename().string(),
          photos_.back().filename().string()));
    }
    if (list_.num_unused > 0) {
      found_.guesses.emplace_back("the last column of the lamps' file is not used");
    }
    if (found_.mask_made) {
      found_.guesses.emplace_back(
          "the photos have no mask: the object is what is not black in their mean");
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
    const std::vector<fs::path> found = EntriesOf(folder, [](const fs::path& path) {
      const std::string name = renderer::LowerCase(path.filename().string());
      std::error_code error;
      return fs::is_regular_file(path, error) &&
             (name.ends_with(".lp") || name == "light_directions.txt" || name == "lights.txt" ||
              name == "lamps.txt");
    });
    if (!found.empty()) return found.size() == 1 ? found.front() : fs::path();
  }
  return {};
}

FoundLamps FindLamps(const LampPlaces& places) { return LampFinder(places).Run(); }

}  // namespace pathfit::app
