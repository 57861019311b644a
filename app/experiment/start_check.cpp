#include "app/experiment/start_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "app/experiment/camera_layout.h"
#include "optim/parameter/promotion.h"
#include "renderer/core/error.h"
#include "renderer/io/image_filter.h"
#include "renderer/math/box.h"
#include "renderer/math/median.h"
#include "renderer/renderer.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::app {
namespace {

using optim::MaskMeaning;
using renderer::Image;
using renderer::Vec3;

constexpr int kSpp = 4;
constexpr double kSize = 256.0;  // pixels of the longer side

// What is so far off that a fit hardly finds back.
constexpr double kPoorIou = 0.3;
constexpr double kPoorCarvedIou = 0.9;  // a body carved from masks reaches 0.95 of real photos
constexpr double kOpenIou = 0.75;       // of held-out photos, where a carved body is not bounded
constexpr double kInvertedIou = 0.5;
constexpr double kOtherSize = 4.0;       // in area
constexpr double kLittleLeft = 0.1;      // of a mask, by erosion
constexpr double kSmallerThanPx = 2.0;   // at the size of this check
constexpr double kOddIou = 0.6;          // of the median: a photo that agrees less is not like them
constexpr double kOddLeast = 0.6;        // median from which on the start can tell
constexpr double kMostlyClipped = 0.9;   // of what is evidence
constexpr double kLittleOutside = 0.02;  // of the bounds' width: white where 0.99 is allowed
constexpr double kTexelsOfPixel = 4.0;   // two each way
constexpr std::size_t kNamed = 5;

/// What a view's picture says beyond ViewStart, for the reasons.
struct ViewFacts {
  double inverted_iou = 0.0;
  double white_border = 0.0;  ///< share of the mask's border that is white
  double brightest = 0.0;     ///< colour that is evidence
  double clipped = 0.0;       ///< share of what is evidence
};

double Share(const Image& image) {
  if (image.Empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto above = std::ranges::count_if(image.data, [](float value) { return value > 0.5F; });
  return static_cast<double>(above) / static_cast<double>(image.data.size());
}

double KnownMedian(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : renderer::Median(values);
}

/// "5 of 24 photos: a.jpg, b.jpg, ..."
std::string Counted(const std::vector<std::string>& names, std::size_t of) {
  std::string text = fmt::format("{} of {} fitted photos (", names.size(), of);
  for (std::size_t i = 0; i < std::min(kNamed, names.size()); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  return text + (names.size() > kNamed ? ", ...)" : ")");
}

/// "axe.yaml:12:5: " of a key of the config.
Place PlaceOf(const ExperimentConfig& config, std::initializer_list<const char*> keys) {
  const YamlNode* node = &config.resolved;
  Place place;
  for (const char* key : keys) {
    node = node->Find(key);
    if (node == nullptr) return place;
    place = node->place;
  }
  return place;
}

class StartChecker {
 public:
  StartChecker(const ExperimentConfig& config, const Experiment& experiment)
      : config_(config), experiment_(experiment), observations_(experiment.observations) {
    for (const renderer::Mesh& mesh : renderer::WorldMeshes(experiment.scene)) {
      check_.box.Include(renderer::BoxAround(mesh.positions));
    }
  }

  StartCheck Run() {
    LookAtViews();
    if (num_fitted_ == 0) return std::move(check_);
    RefuseBlackMasks();
    RefuseEroded();
    RefuseBlackPhotos();
    RefuseUnseen();
    WarnOfMasks();
    WarnOfPlace();
    WarnOfOpenSides();
    WarnOfOddPhotos();
    WarnOfBounds();
    WarnOfFineTextures();
    WarnOfClipping();
    return std::move(check_);
  }

 private:
  void LookAtViews() {
    const renderer::Renderer renderer(experiment_.scene);
    const bool silhouettes = observations_.mask_meaning == MaskMeaning::kSilhouette;
    renderer::RenderOptions options;
    options.spp = kSpp;
    options.max_bounces = 0;
    for (const optim::View& view : observations_.views) {
      const double scale = std::min(1.0, kSize / std::max(view.camera.width, view.camera.height));
      const optim::ViewLevel level = optim::PackedLevel(view, observations_, scale).Unpack();
      const Image coverage = renderer::CoverageImage(renderer.RenderPrimal(level.camera, options));
      ViewStart start;
      start.name = view.name;
      start.validation = view.validation;
      start.width = coverage.width;
      start.height = coverage.height;
      start.outline = Outline(coverage);
      if (!level.mask.Empty()) start.mask_outline = Outline(level.mask);
      for (const float c : coverage.data) start.covered += static_cast<double>(c);
      start.covered /= static_cast<double>(coverage.data.size());
      for (const float w : level.color_weight.data) start.evidence += static_cast<double>(w);
      start.evidence /= static_cast<double>(coverage.data.size());
      start.masked = Share(view.mask.Unpack());  // thin things vanish at the size of this check
      const bool has_mask = silhouettes && !level.mask.Empty();
      start.iou = has_mask ? optim::MaskIou(coverage, level.mask)
                           : std::numeric_limits<double>::quiet_NaN();
      ViewFacts facts;
      LookAtColours(level, facts);
      if (has_mask) {
        facts.white_border = WhiteBorder(level.mask);
        Image inverted = level.mask;
        for (float& v : inverted.data) v = 1.0F - v;
        facts.inverted_iou = optim::MaskIou(coverage, inverted);
      }
      num_fitted_ += view.validation ? 0 : 1;
      check_.views.push_back(std::move(start));
      facts_.push_back(facts);
    }
  }

  static void LookAtColours(const optim::ViewLevel& level, ViewFacts& facts) {
    double weight = 0.0;
    for (std::size_t p = 0; p < level.color_weight.data.size(); ++p) {
      const auto w = static_cast<double>(level.color_weight.data[p]);
      if (w <= 0.0) continue;
      weight += w;
      for (std::size_t c = 0; c < 3; ++c) {
        facts.brightest =
            std::max(facts.brightest, static_cast<double>(level.photo.data[3 * p + c]));
      }
      if (!level.clipped.Empty()) facts.clipped += w * static_cast<double>(level.clipped.data[p]);
    }
    if (weight > 0.0) facts.clipped /= weight;
  }

  template <class Predicate>
  [[nodiscard]] std::vector<std::string> FittedWhere(Predicate predicate) const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < check_.views.size(); ++i) {
      if (!check_.views[i].validation && predicate(check_.views[i], facts_[i])) {
        names.push_back(check_.views[i].name);
      }
    }
    return names;
  }

  template <class Figure>
  [[nodiscard]] double MedianOfFitted(Figure figure) const {
    std::vector<double> values;
    for (std::size_t i = 0; i < check_.views.size(); ++i) {
      if (!check_.views[i].validation) values.push_back(figure(check_.views[i], facts_[i]));
    }
    return KnownMedian(std::move(values));
  }

  [[nodiscard]] double MedianIou(bool of_held_out = false) const {
    std::vector<double> values;
    for (const ViewStart& view : check_.views) {
      if (view.validation == of_held_out) values.push_back(view.iou);
    }
    return KnownMedian(std::move(values));
  }

  [[nodiscard]] std::string Where(std::initializer_list<const char*> keys) const {
    return FormatPlace(config_.source, PlaceOf(config_, keys));
  }

  void RefuseBlackMasks() const {
    const std::size_t black =
        FittedWhere([](const ViewStart& v, const ViewFacts&) { return v.masked == 0.0; }).size();
    if (black < num_fitted_) return;
    const optim::MaskOptions& options = config_.input->photos.masks;
    throw optim::ObservationError(
        {Where({"input", "masks"}) + ": the masks of all " + std::to_string(black) +
         " fitted photos are black: nothing is left to fit to. " +
         (options.invert ? "They are inverted, so the files are white throughout; is invert meant?"
          : options.alpha || options.folder.empty()
              ? "Is the alpha channel, or what the camera file names, meant?"
              : "Is " + options.folder.string() + " the right folder?")});
  }

  void RefuseBlackPhotos() {
    const auto black = FittedWhere([](const ViewStart& v, const ViewFacts& f) {
      return v.evidence > 0.0 && f.brightest <= 0.0;
    });
    if (black.empty()) return;
    const std::string where = observations_.mask_meaning == MaskMeaning::kNone
                                  ? "are black"
                                  : "are black inside their masks";
    if (black.size() < num_fitted_) {
      Warn(Counted(black, num_fitted_) + " " + where);
      return;
    }
    throw optim::ObservationError({Where({"input", "images"}) + ": all " +
                                   std::to_string(black.size()) + " fitted photos " + where +
                                   ": there is nothing to fit to"});
  }

  /// The largest erosion that leaves a pixel of some mask.
  [[nodiscard]] int LargestErosion() const {
    float largest = 0.0F;
    for (const optim::View& view : observations_.views) {
      if (view.mask.Empty()) continue;
      largest = std::max(largest,
                         std::ranges::max(renderer::SignedDistanceToMask(view.mask.Unpack()).data));
    }
    return static_cast<int>(largest);
  }

  void RefuseEroded() const {
    const std::size_t eaten = FittedWhere([](const ViewStart& v, const ViewFacts&) {
                                return v.masked > 0.0 && v.evidence == 0.0;
                              }).size();
    if (eaten == 0 || eaten < num_fitted_) return;
    throw ConfigError(config_.source,
                      {{PlaceOf(config_, {"input", "masks", "erode_px"}),
                        "input.masks.erode_px",
                        fmt::format("{} pixels leave nothing of any mask, so no colour could be "
                                    "compared; the widest place of the object allows {}, and 1 or "
                                    "2 are usual",
                                    observations_.mask_erode_px,
                                    std::max(0, LargestErosion() - 1))}});
  }

  /// Why no camera sees the meshes.
  [[nodiscard]] std::string ReasonUnseen() const {
    const auto& sensors = experiment_.scene.sensors;
    const Vec3 middle = check_.box.Middle();
    const double size = 2.0 * check_.box.HalfDiagonal();
    std::size_t behind = 0;
    double pixels = 0.0;
    for (const renderer::Camera& camera : sensors) {
      const double depth = -renderer::RigidInverse(renderer::CameraPose(camera)).Point(middle).z;
      behind += depth <= 0.0 ? 1 : 0;
      pixels = std::max(
          pixels,
          depth > 0.0 ? size / depth * camera.fx * kSize / std::max(camera.width, camera.height)
                      : 0.0);
    }
    const std::string extent =
        fmt::format("the meshes are {:.3g} units across, about [{:.3g}, {:.3g}, {:.3g}]",
                    size,
                    middle.x,
                    middle.y,
                    middle.z);
    if (2 * behind > sensors.size()) {
      return fmt::format(
          "{} of {} cameras look away from it: {}. Poses of another convention show so (here "
          "cameras look along -z, y up), and so does a mesh in another frame than the cameras'",
          behind,
          sensors.size(),
          extent);
    }
    if (pixels < kSmallerThanPx) {
      return "it is smaller than a pixel: " + extent +
             ". Is its unit that of the cameras (transform: {scale: ...})?";
    }
    const std::optional<CameraLayout> layout = FindCameraLayout(sensors);
    return "it is beside all pictures: " + extent +
           (layout ? fmt::format(", while the cameras look at about [{:.3g}, {:.3g}, {:.3g}] from "
                                 "a distance of {:.3g}",
                                 layout->centre.x,
                                 layout->centre.y,
                                 layout->centre.z,
                                 layout->distance)
                   : "") +
           ". Is the mesh in the frame of the cameras (transform: {translate_m: ...})?";
  }

  void RefuseUnseen() {
    const std::vector<std::string> unseen =
        FittedWhere([](const ViewStart& v, const ViewFacts&) { return v.covered == 0.0; });
    if (unseen.empty() || experiment_.scene.meshes.empty()) return;
    if (unseen.size() < num_fitted_) {
      Warn("the start is not seen in " + Counted(unseen, num_fitted_) +
           ": nothing draws it there. Are their cameras right?");
      return;
    }
    const std::string text = "the object is in no fitted photo; " + ReasonUnseen();
    // Pictures of the surroundings alone can be fitted by them.
    if (renderer::ShowsEnvironment(experiment_.scene) &&
        observations_.mask_meaning != MaskMeaning::kSilhouette) {
      Warn(text);
      return;
    }
    throw renderer::SceneError(Where({"scene", "geometry"}) + ": " + text);
  }

  void WarnOfMasks() {
    const auto black =
        FittedWhere([](const ViewStart& v, const ViewFacts&) { return v.masked == 0.0; });
    if (!black.empty()) {
      Warn("the mask is black in " + Counted(black, num_fitted_) +
           (observations_.mask_meaning == MaskMeaning::kSilhouette
                ? ": the object is taken to be absent there"
                : ": nothing there is evidence"));
    }
    const auto eaten = FittedWhere([](const ViewStart& v, const ViewFacts&) {
      return v.masked > 0.0 && v.evidence < kLittleLeft * v.masked;
    });
    if (!eaten.empty()) {
      Warn(fmt::format(
          "{}: input.masks.erode_px: {} pixels leave less than a tenth of the mask in {}",
          Where({"input", "masks", "erode_px"}),
          observations_.mask_erode_px,
          Counted(eaten, num_fitted_)));
    }
    const double white =
        MedianOfFitted([](const ViewStart&, const ViewFacts& f) { return f.white_border; });
    const double inverted =
        MedianOfFitted([](const ViewStart&, const ViewFacts& f) { return f.inverted_iou; });
    // A floor or wall may fill the pictures. What is carved from masks agrees with them anyway.
    const double iou = MedianIou();
    const std::size_t full =
        FittedWhere([](const ViewStart& v, const ViewFacts&) { return v.masked >= 1.0; }).size();
    if (full == num_fitted_ && iou < kInvertedIou) {
      Warn(Where({"input", "masks"}) +
           ": the masks are white throughout: they do not tell the object from what is around it. "
           "Leave masks out if there are none");
      return;
    }
    const bool white_object = !IsCarved() && iou > kInvertedIou;
    inverted_ = (white > kWhiteBorder && !white_object) || inverted > kInvertedIou;
    if (inverted_) {
      Warn(
          fmt::format("{}: the masks look inverted: they are white along {:.0f} % of the pictures' "
                      "borders, and their black agrees with the start to IoU {:.2f}. Where black "
                      "is the object, write input.masks.invert: {}",
                      Where({"input", "masks"}),
                      100.0 * white,
                      inverted,
                      !config_.input->photos.masks.invert));
    }
  }

  [[nodiscard]] bool IsCarved() const {
    return std::ranges::any_of(config_.geometry, [](const GeometryConfig& mesh) {
      return std::holds_alternative<VisualHullGeometry>(mesh.geometry);
    });
  }

  void WarnOfPlace() {
    const double iou = MedianIou();
    if (!inverted_ && IsCarved() && iou < kPoorCarvedIou) {
      const auto white = FittedWhere(
          [](const ViewStart&, const ViewFacts& f) { return f.white_border > kWhiteBorder; });
      Warn(fmt::format(
          "the body carved from the masks agrees with them to a median IoU of {:.2f} "
          "only, where more than 0.95 is usual: {}",
          iou,
          white.empty() ? "a mask misses a part of the object or is of another photo, "
                          "or cameras are not those of these photos, or these are turned "
                          "(input.cameras.orientation); the check page shows where"
                        : "masks look inverted, as they are white along the border, in " +
                              Counted(white, num_fitted_)));
      return;
    }
    if (inverted_ || !(iou < kPoorIou)) return;
    const double ratio =
        MedianOfFitted([](const ViewStart& v, const ViewFacts&) { return v.covered / v.masked; });
    std::string reason =
        "it lies elsewhere than the masks. Are mesh (transform) and cameras of one frame, and the "
        "masks those of these photos?";
    if (ratio > kOtherSize || ratio < 1.0 / kOtherSize) {
      reason = fmt::format(
          "it covers {:.2g} times the area of the masks. Is its unit that of the cameras "
          "(transform: {{scale: ...}})?",
          ratio);
    }
    Warn(
        fmt::format("the start hardly agrees with the masks (median IoU {:.2f}), and a fit may "
                    "not find back; likely {}",
                    iou,
                    reason));
  }

  /// What fitted photos leave open, held-out ones show.
  void WarnOfOpenSides() {
    const double iou = MedianIou(true);
    const double fitted = MedianIou();
    if (!IsCarved() || !(fitted >= kPoorCarvedIou) || !(iou < kOpenIou)) return;
    Warn(fmt::format(
        "the body carved from the fitted photos' masks agrees with those of held-out "
        "photos to a median IoU of {:.2f} only, with its own to {:.2f}: seen from there "
        "nothing bounds it. More photos from more sides help; input.split: {{validation: "
        "none}} fits all that there are",
        iou,
        fitted));
  }

  /// One that is far from the start while the others agree is of another place, or has the mask of
  /// another.
  void WarnOfOddPhotos() {
    const double median = MedianIou();
    if (inverted_ || !(median > kOddLeast)) return;
    const auto odd = FittedWhere([&](const ViewStart& v, const ViewFacts&) {
      return v.covered > 0.0 && v.masked > 0.0 && v.iou < kOddIou * median;
    });
    if (odd.empty()) return;
    Warn(
        fmt::format("the start agrees with the masks to a median IoU of {:.2f}, but hardly in {}: "
                    "are these masks and cameras those of these photos?",
                    median,
                    Counted(odd, num_fitted_)));
  }

  /// What a fit would bring inside its bounds before it begins.
  void WarnOfBounds() {
    for (const optim::UnknownSpec& unknown : experiment_.fit.unknowns) {
      const renderer::Scene& scene = experiment_.scene;
      if (unknown.hold || optim::IsReplaced(scene, unknown, experiment_.fit.unknowns)) continue;
      renderer::ParameterLayout layout(scene);
      layout.Add(unknown.kind, unknown.object);
      const double width = unknown.upper - unknown.lower;
      const double slack = std::isfinite(width) ? kLittleOutside * width : 0.0;
      const std::vector<double> values = layout.Gather(scene);
      const auto outside = [&](double v) {
        return v < unknown.lower - slack || v > unknown.upper + slack;
      };
      const auto first = std::ranges::find_if(values, outside);
      if (first == values.end()) continue;
      Warn(
          fmt::format("unknowns.{}: {} of {} numbers start outside of their bounds ({:.3g}, "
                      "allowed are {:.3g} to {:.3g}); the fit begins with the nearest ones",
                      unknown.name,
                      std::ranges::count_if(values, outside),
                      values.size(),
                      *first,
                      unknown.lower,
                      unknown.upper));
    }
  }

  /// Texels that no pixel tells keep their start; those of which one pixel tells several go to the
  /// bounds with its noise.
  void WarnOfFineTextures() {
    double pixels = 0.0;
    for (std::size_t i = 0; i < check_.views.size(); ++i) {
      const renderer::Camera& camera = observations_.views[i].camera;
      if (check_.views[i].validation) continue;
      pixels += check_.views[i].covered * camera.width * camera.height;
    }
    for (const optim::UnknownSpec& unknown : experiment_.fit.unknowns) {
      if (unknown.kind != renderer::ParameterKind::kTextureTexels || unknown.hold ||
          unknown.smooth_weight + unknown.total_variation_weight > 0.0 ||
          optim::IsReplaced(experiment_.scene, unknown, experiment_.fit.unknowns)) {
        continue;
      }
      renderer::ParameterLayout layout(experiment_.scene);
      layout.Add(unknown.kind, unknown.object);
      const auto texels = static_cast<double>(layout.groups().front().num_blocks);
      if (texels <= kTexelsOfPixel * pixels) continue;
      Warn(
          fmt::format("unknowns.{}: {:.0f} texels, but objects fill {:.0f} pixels of the fitted "
                      "photos: no pixel tells most of them, and its noise the others. Write a "
                      "smaller size_px, the prior total_variation, or {{as: texture}} for the "
                      "colours of vertices, which makes a texture as fine as the photos",
                      unknown.name,
                      texels,
                      pixels));
    }
  }

  void WarnOfClipping() {
    const auto clipped = FittedWhere(
        [](const ViewStart&, const ViewFacts& f) { return f.clipped > kMostlyClipped; });
    if (clipped.empty()) return;
    Warn(
        fmt::format("more than {:.0f} % of what is to be fitted is clipped in {}: there photos "
                    "only say \"at least so bright\" (input.colour.clip_above)",
                    100.0 * kMostlyClipped,
                    Counted(clipped, num_fitted_)));
  }

  void Warn(std::string text) { check_.warnings.push_back(std::move(text)); }

  const ExperimentConfig& config_;
  const Experiment& experiment_;
  const optim::ObservationSet& observations_;
  std::size_t num_fitted_ = 0;
  StartCheck check_;
  std::vector<ViewFacts> facts_;
  bool inverted_ = false;
};

}  // namespace

std::vector<OutlinePiece> Outline(const Image& image) {
  constexpr float kLevel = 0.5F;
  const auto value = [&](int x, int y) {
    const bool inside = x >= 0 && y >= 0 && x < image.width && y < image.height;
    return inside ? image.At(x, y, 0) : 0.0F;
  };
  std::vector<OutlinePiece> pieces;
  // Squares between the centres of pixels, and of those beside the picture.
  for (int y = -1; y < image.height; ++y) {
    for (int x = -1; x < image.width; ++x) {
      constexpr int kCorners[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
      renderer::Vec2 crossings[4];
      int count = 0;
      for (int side = 0; side < 4; ++side) {
        const auto& [ax, ay] = kCorners[side];
        const auto& [bx, by] = kCorners[side + 1];
        const float a = value(x + ax, y + ay);
        const float b = value(x + bx, y + by);
        if ((a > kLevel) == (b > kLevel)) continue;
        const double t = static_cast<double>(kLevel - a) / static_cast<double>(b - a);
        crossings[count++] = {x + 0.5 + ax + t * (bx - ax), y + 0.5 + ay + t * (by - ay)};
      }
      for (int i = 0; i + 1 < count; i += 2) pieces.push_back({crossings[i], crossings[i + 1]});
    }
  }
  return pieces;
}

double WhiteBorder(const Image& mask) {
  std::int64_t white = 0, all = 0;
  const auto count = [&](int x, int y) {
    white += mask.At(x, y, 0) > 0.5F ? 1 : 0;
    ++all;
  };
  for (int x = 0; x < mask.width; ++x) {
    count(x, 0);
    count(x, mask.height - 1);
  }
  for (int y = 0; y < mask.height; ++y) {
    count(0, y);
    count(mask.width - 1, y);
  }
  return static_cast<double>(white) / static_cast<double>(all);
}

StartCheck CheckStart(const ExperimentConfig& config, const Experiment& experiment) {
  return StartChecker(config, experiment).Run();
}

}  // namespace pathfit::app
