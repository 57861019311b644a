#include "app/experiment/lamp_input.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "app/experiment/folder_search.h"
#include "app/experiment/start_check.h"
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

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using optim::LampList;
using optim::PhotoLamp;
using optim::Transfer;
using renderer::Image;
using renderer::IoError;
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

bool SpeaksOfOthers(const fs::path& path) {
  return SpeaksOfMasks(path) || SpeaksOf(path, {"normal", "albedo", "depth", "ambient"});
}

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// "img_#.png" of img_12.png.
std::string WithoutNumbers(const fs::path& path) {
  std::string text;
  for (const char c : path.filename().string()) {
    if (!IsDigit(c)) {
      text += c;
    } else if (text.empty() || text.back() != '#') {
      text += '#';
    }
  }
  return text;
}

/// As people count: 2 before 10, wherever the number stands.
bool NaturalLess(const fs::path& first, const fs::path& second) {
  const std::string a = first.filename().string(), b = second.filename().string();
  std::size_t i = 0, j = 0;
  const auto run = [](const std::string& text, std::size_t& at) {
    while (at + 1 < text.size() && text[at] == '0' && IsDigit(text[at + 1])) ++at;
    const std::size_t begin = at;
    while (at < text.size() && IsDigit(text[at])) ++at;
    return text.substr(begin, at - begin);
  };
  while (i < a.size() && j < b.size()) {
    if (IsDigit(a[i]) && IsDigit(b[j])) {
      const std::string m = run(a, i), n = run(b, j);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

/// Pictures of a folder by their numbers.
std::vector<fs::path> NumberedPictures(const fs::path& folder) {
  std::vector<fs::path> pictures = optim::WithoutRawTwins(optim::PicturesIn(folder));
  std::ranges::sort(pictures, NaturalLess);
  return pictures;
}
/// The same but for masks, normals and the like.
std::vector<fs::path> NumberedPhotos(const fs::path& folder) {
  std::vector<fs::path> pictures = NumberedPictures(folder);
  std::erase_if(pictures, SpeaksOfOthers);
  return pictures;
}
/// So many of them: all, all photos, else those whose names differ by their numbers alone. Empty:
/// there are others.
std::vector<fs::path> NumberedPhotos(const fs::path& folder, std::size_t count) {
  const std::vector<fs::path> all = NumberedPictures(folder);
  for (const std::vector<fs::path>& some : {NumberedPhotos(folder), all}) {
    if (some.size() == count) return some;
  }
  std::map<std::string, std::vector<fs::path>> groups;
  for (const fs::path& picture : all) groups[WithoutNumbers(picture)].push_back(picture);
  std::erase_if(groups, [&](const auto& group) { return group.second.size() != count; });
  return groups.size() == 1 ? groups.begin()->second : std::vector<fs::path>();
}

/// The photo of this name or, without extension, stem.
fs::path PhotoNamed(const fs::path& folder, const std::string& name) {
  std::string plain = name;
  std::ranges::replace(plain, '\\', '/');
  const fs::path file = fs::path(plain).filename();
  if (optim::IsPicture(folder / file)) return folder / file;
  std::vector<fs::path> alike = optim::WithoutRawTwins(optim::PicturesIn(folder));
  std::erase_if(alike, [&](const fs::path& path) {
    return path.stem() != file && path.stem() != file.stem();
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
    if (!names.empty() && names.size() != list.lamps.size()) {
      throw IoError(fmt::format("{}: has {} names for {} lamps",
                                (lamp_file.parent_path() / "filenames.txt").string(),
                                names.size(),
                                list.lamps.size()));
    }
  }
  if (!names.empty() && names.front().empty()) names.clear();
  return names;
}

/// One for each lamp, all in one folder: that of the photos or one in it.
std::vector<fs::path> PhotosOfLamps(const fs::path& top,
                                    const LampList& list,
                                    const fs::path& lamp_file) {
  if (!IsFolder(top)) throw IoError(top.string() + ": no such folder");
  std::vector<fs::path> folders =
      EntriesOf(top, [&](const fs::path& path) { return IsFolder(path) && path != lamp_file; });
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
  // Not within a letter of several bytes.
  while (!common.empty() && static_cast<unsigned char>(common.back()) >= 0x80U) common.pop_back();
  const auto count = std::ranges::count_if(pictures, [&](const fs::path& picture) {
    return picture.filename().string().starts_with(common);
  });
  const bool is_plain = common.find_first_of("*?[\\") == std::string::npos;
  return is_plain && !common.empty() && count == static_cast<std::ptrdiff_t>(names.size())
             ? common + "*"
             : "";
}

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

/// A part of an image.
struct ImagePart {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Where a mask is more than half of its brightest, and a little around it.
ImagePart PartAround(const Image& mask) {
  const float half = 0.5F * *std::ranges::max_element(mask.data);
  int x0 = mask.width, y0 = mask.height, x1 = -1, y1 = -1;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (!(mask.At(x, y, 0) > half)) continue;
      x0 = std::min(x0, x);
      y0 = std::min(y0, y);
      x1 = std::max(x1, x);
      y1 = std::max(y1, y);
    }
  }
  if (x1 < 0) return {0, 0, mask.width, mask.height};
  x0 = std::max(0, x0 - kMargin);
  y0 = std::max(0, y0 - kMargin);
  return {x0,
          y0,
          std::min(mask.width, x1 + 1 + kMargin) - x0,
          std::min(mask.height, y1 + 1 + kMargin) - y0};
}

/// The part, no larger than shading needs.
Image SmallPart(const Image& image, const ImagePart& part) {
  Image cut(part.width, part.height, image.channels);
  for (int y = 0; y < part.height; ++y) {
    const auto* from = image.data.data() + image.Offset(part.x, part.y + y);
    std::copy_n(from, part.width * image.channels, cut.data.data() + cut.Offset(0, y));
  }
  const double scale =
      std::min(1.0, static_cast<double>(kShadingPx) / std::max(part.width, part.height));
  return renderer::ResizeArea(cut,
                              std::max(1, static_cast<int>(std::lround(scale * part.width))),
                              std::max(1, static_cast<int>(std::lround(scale * part.height))));
}

/// What is not black in the mean of the photos.
Image MaskByBrightness(const optim::ObservationSet& observations) {
  const optim::View& first = observations.views.front();
  Image mean(first.camera.width, first.camera.height, 1);
  for (const optim::View& view : observations.views) {
    const Image photo = view.photo.Unpack();
    for (int y = 0; y < mean.height; ++y) {
      for (int x = 0; x < mean.width; ++x) {
        mean.At(x, y, 0) += static_cast<float>(MeanOf(photo.ColorAt(x, y)));
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

/// A folder with photos: this one, or the only one in it that has some beside `other`.
fs::path PhotoFolder(const fs::path& top, const fs::path& other) {
  if (!NumberedPhotos(top).empty()) return top;
  const std::vector<fs::path> with = EntriesOf(top, [&](const fs::path& path) {
    return IsFolder(path) && path != other && !NumberedPhotos(path).empty();
  });
  return with.size() == 1 ? with.front() : top;
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
    if (photos_.size() < FoundLamps::kFewPhotos) options.validation_every = 0;
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

  optim::ObservationSet Load(Transfer transfer) {
    optim::ObservationOptions options = found_.options;
    options.transfer = transfer;
    optim::ObservationSet set = optim::LoadObservations(options);
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
      found_.mask_made = options.masks.meaning == optim::MaskMeaning::kNone;
      found_.mask = found_.mask_made ? MaskByBrightness(set) : first.mask.Unpack();
    }
    return set;
  }

  [[nodiscard]] optim::ShadingFit Fit(const optim::ObservationSet& set) const {
    const ImagePart part = PartAround(found_.mask);
    std::map<std::string, const optim::View*> views;
    for (const optim::View& view : set.views) views[view.name] = &view;
    std::vector<Image> photos;
    std::vector<Vec3> towards;
    std::vector<double> strengths;
    for (std::size_t i = 0; i < list_.lamps.size(); ++i) {
      const optim::View& view = *views.at(photos_[i].filename().string());
      photos.push_back(SmallPart(view.photo.Unpack(), part));
      towards.push_back(list_.lamps[i].towards);
      if (found_.strengths_known) strengths.push_back(MeanOf(*list_.lamps[i].strength));
    }
    return optim::FitShading(photos, SmallPart(found_.mask, part), towards, strengths);
  }

  /// With what photos' numbers mean, where two things are possible.
  void LoadPhotos() {
    Transfer& transfer = found_.options.transfer;
    transfer = Transfer::kLinear;
    found_.observations = Load(transfer);
    found_.shading = Fit(found_.observations);
    if (is_linear_file_) return;
    const double as_stored = found_.shading.residual;
    found_.observations = Load(Transfer::kSrgb);
    const optim::ShadingFit encoded = Fit(found_.observations);
    const double least = std::min(encoded.residual, as_stored);
    const double most = std::max(encoded.residual, as_stored);
    const bool is_told = most > kTold;
    transfer_reason_ =
        is_told ? fmt::format(
                      "a matt surface leaves {:.1f} % of the values as they are stored, "
                      "{:.1f} % after undoing the sRGB curve{}",
                      100.0 * as_stored,
                      100.0 * encoded.residual,
                      least > kHardlyDiffer * most ? ", which hardly differ" : "")
                : "so few lamps do not tell whether that is so; else colour: {transfer: linear}";
    if (!is_told || encoded.residual < as_stored) {
      transfer = Transfer::kSrgb;
      found_.shading = encoded;
    } else {
      found_.observations = Load(transfer);
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
