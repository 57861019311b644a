#include "optim/observation/object_masks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "renderer/core/parallel.h"
#include "renderer/image/color.h"
#include "renderer/io/color_segmentation.h"
#include "renderer/io/image_filter.h"

namespace pathfit::optim {
namespace {

using renderer::CameraModel;
using renderer::Image;
using renderer::ObjectHint;
using renderer::Projection;
using renderer::Vec3;

// Sizes of the photos, longest side in pixels: while the body is sought, and for its outline.
constexpr int kSearchPx = 200, kOutlinePx = 640;
constexpr int kSearches = 3;
constexpr int kFirstTurns = 4, kTurns = 2;  // of colours and cut

// The ball, in units of its radius: what is in the middle of the pictures may be object, what is
// outside is not. A large middle is for objects that fill the pictures, whose colour must not
// count as the background's.
constexpr double kMiddles[] = {0.5, 0.9};
constexpr double kOutside = 1.25;
constexpr int kVoxels = 80;       // along the ball's diameter
constexpr double kVotes = 0.85;   // of the photos that see a voxel call it object
constexpr double kSeen = 0.4;     // of all photos see it
constexpr double kReach = 0.12;   // around the body's silhouette colours may overrule it, outwards
constexpr double kInwards = 3.0;  // and so many times as far inwards
constexpr double kHole = 0.005;   // of the object: smaller ones are dark or bright spots
constexpr double kAgreement = 0.8, kUnmoved = 0.9;

double LongestSide(const renderer::Camera& camera) {
  return static_cast<double>(std::max(camera.width, camera.height));
}

/// A view at a size of its own.
struct SmallView {
  SmallView(const View& view, int longest_px, const Vec3& centre, double radius)
      : scale(std::min(1.0, longest_px / LongestSide(view.camera))), camera(view.camera) {
    const auto reduced = [this](int size) {
      return std::max(1, static_cast<int>(std::lround(scale * size)));
    };
    photo = renderer::ResizeArea(
        view.photo.Unpack(), reduced(view.camera.width), reduced(view.camera.height));
    for (float& value : photo.data) {
      value = static_cast<float>(renderer::ClampedSrgb(static_cast<double>(value)));
    }
    if (const std::optional<Projection> p = camera.Project(centre)) {
      u = p->u * scale;
      v = p->v * scale;
      const double focal = std::sqrt(view.camera.fx * view.camera.fy) * scale;
      ball_px = radius * focal / (camera.IsOrthographic() ? 1.0 : p->depth);
    }
  }

  /// Pixel that a point is seen in; -1 outside of the picture.
  [[nodiscard]] std::int64_t PixelOf(const Vec3& x) const {
    const std::optional<Projection> p = camera.Project(x);
    if (!p) return -1;
    const double column = std::floor(p->u * scale);
    const double row = std::floor(p->v * scale);
    if (!(column >= 0.0 && column < photo.width && row >= 0.0 && row < photo.height)) return -1;
    return static_cast<std::int64_t>(row) * photo.width + static_cast<std::int64_t>(column);
  }

  double scale;
  CameraModel camera;                      ///< at full size
  Image photo;                             ///< encoded
  double u = 0.0, v = 0.0, ball_px = 0.0;  ///< the ball in the picture; 0: it is behind
};

/// Negative: narrowed.
Image Widened(const Image& mask, double px) {
  Image result = renderer::SignedDistanceToMask(mask);
  for (float& value : result.data) value = static_cast<double>(value) > -px ? 1.0F : 0.0F;
  return result;
}

std::vector<ObjectHint> HintsOfBall(const SmallView& view, double middle) {
  const int width = view.photo.width, height = view.photo.height;
  std::vector<ObjectHint> hints;
  hints.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double from_middle =
          std::hypot(x + 0.5 - view.u, y + 0.5 - view.v) / std::max(view.ball_px, 1e-9);
      const bool at_border = x == 0 || y == 0 || x == width - 1 || y == height - 1;
      hints.push_back(at_border || from_middle > kOutside ? ObjectHint::kBackground
                      : from_middle < middle              ? ObjectHint::kMaybeObject
                                                          : ObjectHint::kMaybeBackground);
    }
  }
  return hints;
}

/// The body's silhouette: its voxels' centres, and what is between them.
Image SilhouetteOf(const std::vector<Vec3>& body, const SmallView& view) {
  Image dots(view.photo.width, view.photo.height, 1);
  for (const Vec3& x : body) {
    const std::int64_t pixel = view.PixelOf(x);
    if (pixel >= 0) dots.data[static_cast<std::size_t>(pixel)] = 1.0F;
  }
  const double gap = 2.0 * kOutside / kVoxels * view.ball_px + 1.0;
  return Widened(Widened(dots, gap), -gap);
}

/// What a silhouette says of the pixels around its outline, and away from it.
std::vector<ObjectHint> HintsOfBody(const Image& silhouette, const SmallView& view) {
  const double reach = std::max(2.0, kReach * view.ball_px);
  const Image distance = renderer::SignedDistanceToMask(silhouette);
  std::vector<ObjectHint> hints;
  hints.reserve(distance.data.size());
  for (const float pixel : distance.data) {
    const auto inside = static_cast<double>(pixel);
    hints.push_back(inside <= -reach             ? ObjectHint::kBackground
                    : inside <= 0.0              ? ObjectHint::kMaybeBackground
                    : inside <= kInwards * reach ? ObjectHint::kMaybeObject
                                                 : ObjectHint::kObject);
  }
  return hints;
}

class MaskMaker {
 public:
  MaskMaker(const ObservationSet& observations, const Vec3& centre, double radius)
      : observations_(observations), centre_(centre), radius_(radius) {
    const std::size_t count = observations.views.size();
    views_.reserve(count);
    for (const View& view : observations.views) {
      views_.emplace_back(view, kSearchPx, centre, radius);
    }
    masks_.resize(count);
  }

  std::optional<ObjectMasks> Run() {
    for (const double middle : kMiddles) {
      if (!Search(middle)) continue;
      ObjectMasks result;
      result.agreement = Agreement([&](std::size_t i) { return masks_[i]; });
      if (result.agreement < kAgreement || IsWhatItBeganWith(middle)) continue;
      result.masks.resize(views_.size());
      ForEachView([&](std::size_t i) { result.masks[i] = FinalMask(observations_.views[i]); });
      return result;
    }
    return std::nullopt;
  }

 private:
  /// False if there is no body.
  bool Search(double middle) {
    for (int search = 0; search < kSearches; ++search) {
      ForEachView([&](std::size_t i) {
        const SmallView& view = views_[i];
        masks_[i] =
            search == 0
                ? SegmentByColor(view.photo, HintsOfBall(view, middle), kFirstTurns)
                : SegmentByColor(view.photo, HintsOfBody(SilhouetteOf(body_, view), view), kTurns);
      });
      FindBody();
      if (body_.empty()) return false;
    }
    return true;
  }

  /// No colour moved its outline.
  [[nodiscard]] bool IsWhatItBeganWith(double middle) const {
    return Agreement([&](std::size_t i) {
             const std::vector<ObjectHint> hints = HintsOfBall(views_[i], middle);
             Image disc(views_[i].photo.width, views_[i].photo.height, 1);
             std::ranges::transform(hints, disc.data.begin(), [](ObjectHint hint) {
               return hint == ObjectHint::kMaybeObject ? 1.0F : 0.0F;
             });
             return disc;
           }) > kUnmoved;
  }

  void ForEachView(const auto& visit) const {
    renderer::ParallelFor(static_cast<std::int64_t>(views_.size()),
                          [&](std::int64_t i) { visit(static_cast<std::size_t>(i)); });
  }

  /// The voxels that most photos call object.
  void FindBody() {
    std::vector<std::vector<Vec3>> layers(kVoxels);
    const auto place = [](std::int64_t k) {
      return (2.0 * static_cast<double>(k) + 1.0) / kVoxels - 1.0;
    };
    renderer::ParallelFor(kVoxels, [&](std::int64_t z) {
      for (std::int64_t y = 0; y < kVoxels; ++y) {
        for (std::int64_t x = 0; x < kVoxels; ++x) {
          const Vec3 offset{place(x), place(y), place(z)};
          if (SquaredNorm(offset) > 1.0) continue;
          const Vec3 point = centre_ + offset * (kOutside * radius_);
          if (IsBody(point)) layers[static_cast<std::size_t>(z)].push_back(point);
        }
      }
    });
    body_.clear();
    for (const std::vector<Vec3>& layer : layers) {
      body_.insert(body_.end(), layer.begin(), layer.end());
    }
  }

  [[nodiscard]] bool IsBody(const Vec3& point) const {
    double num_seen = 0.0, votes = 0.0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const std::int64_t pixel = views_[i].PixelOf(point);
      if (pixel < 0) continue;
      num_seen += 1.0;
      votes += static_cast<double>(masks_[i].data[static_cast<std::size_t>(pixel)]);
    }
    return num_seen >= kSeen * static_cast<double>(views_.size()) && votes >= kVotes * num_seen;
  }

  /// Mean overlap of the body's silhouettes with other masks.
  [[nodiscard]] double Agreement(const auto& mask_of) const {
    std::vector<double> overlaps(views_.size());
    ForEachView(
        [&](std::size_t i) { overlaps[i] = MaskIou(SilhouetteOf(body_, views_[i]), mask_of(i)); });
    double sum = 0.0;
    for (const double overlap : overlaps) sum += overlap;
    return sum / static_cast<double>(overlaps.size());
  }

  /// By the photo's colours near the body's outline, at the camera's size.
  [[nodiscard]] Image FinalMask(const View& full) const {
    const SmallView view(full, kOutlinePx, centre_, radius_);
    const Image silhouette = SilhouetteOf(body_, view);
    const std::vector<ObjectHint> hints = HintsOfBody(silhouette, view);
    Image mask = renderer::PartsWithin(
        renderer::SegmentByColor(view.photo, hints, kTurns), silhouette, kHole);
    // In a photo whose colours do not tell, what the others say.
    if (MaskIou(silhouette, mask) < kAgreement) mask = silhouette;
    const Image distance = renderer::SignedDistanceToMask(mask);
    Image result(full.camera.width, full.camera.height, 1);
    for (int y = 0; y < result.height; ++y) {
      for (int x = 0; x < result.width; ++x) {
        // Linear between the small pixels' centres, so that the outline has no stairs.
        const double u = std::clamp((x + 0.5) * view.scale - 0.5, 0.0, mask.width - 1.0);
        const double v = std::clamp((y + 0.5) * view.scale - 0.5, 0.0, mask.height - 1.0);
        const int column = std::min(static_cast<int>(u), std::max(0, mask.width - 2));
        const int row = std::min(static_cast<int>(v), std::max(0, mask.height - 2));
        const auto at = [&](int dx, int dy) {
          return static_cast<double>(distance.At(
              std::min(column + dx, mask.width - 1), std::min(row + dy, mask.height - 1), 0));
        };
        const double s = u - column, t = v - row;
        const double inside = (at(0, 0) * (1.0 - s) + at(1, 0) * s) * (1.0 - t) +
                              (at(0, 1) * (1.0 - s) + at(1, 1) * s) * t;
        result.At(x, y, 0) = static_cast<float>(std::clamp(0.5 + inside / view.scale, 0.0, 1.0));
      }
    }
    return result;
  }

  const ObservationSet& observations_;
  const Vec3 centre_;
  const double radius_;
  std::vector<SmallView> views_;
  std::vector<Image> masks_;
  std::vector<Vec3> body_;
};

}  // namespace

std::optional<ObjectMasks> MakeObjectMasks(const ObservationSet& observations,
                                           const renderer::Vec3& centre,
                                           double radius) {
  if (observations.views.empty() || !(radius > 0.0)) return std::nullopt;
  return MaskMaker(observations, centre, radius).Run();
}

}  // namespace pathfit::optim
