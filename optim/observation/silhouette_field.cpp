#include "optim/observation/silhouette_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/io/image_file.h"
#include "renderer/math/median.h"

namespace pathfit::optim {
namespace {

using renderer::Mat3;
using renderer::Projection;
using renderer::SceneError;
using renderer::Vec2;
using renderer::Vec3;

constexpr double kFarOutside = -std::numeric_limits<double>::max();
/// Least determinant of the mean of (1 - d d^T) over the rays; it is sin^2 of their typical angle
/// times 1/4 or so.
constexpr double kMinSpread = 1e-5;

}  // namespace

SilhouetteField::SilhouetteView SilhouetteField::MakeView(const View& view) {
  const renderer::Image mask = view.mask.Unpack();
  SilhouetteView out{.camera = renderer::CameraModel(view.camera),
                     .distance = renderer::SignedDistanceToMask(mask),
                     .focal = std::sqrt(view.camera.fx * view.camera.fy),
                     .low = {1e9, 1e9},
                     .high = {-1e9, -1e9},
                     .centroid = {},
                     .is_cut = false};
  double count = 0.0;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (mask.At(x, y, 0) <= 0.5F) continue;
      out.low = {std::min(out.low.x, static_cast<double>(x)),
                 std::min(out.low.y, static_cast<double>(y))};
      out.high = {std::max(out.high.x, x + 1.0), std::max(out.high.y, y + 1.0)};
      out.centroid = out.centroid + Vec2{x + 0.5, y + 0.5};
      out.is_cut |= x == 0 || y == 0 || x == mask.width - 1 || y == mask.height - 1;
      count += 1.0;
    }
  }
  if (count == 0.0) {
    throw SceneError(
        "visual hull: the mask of " + view.name +
        " is black everywhere, so the hull would be empty; leave the photo out, or check whether "
        "the masks must be inverted");
  }
  out.centroid = out.centroid * (1.0 / count);
  return out;
}

SilhouetteField::SilhouetteField(const ObservationSet& observations, double dissent) {
  std::vector<const View*> masked;
  for (const View& view : observations.views) {
    if (!view.validation && !view.mask.Empty()) masked.push_back(&view);
  }
  if (masked.size() < 2 || observations.mask_meaning != MaskMeaning::kSilhouette) {
    throw SceneError(
        "visual hull: " + std::to_string(masked.size()) +
        " fitted photos have a silhouette mask, and at least two from different sides are needed; "
        "give masks with meaning 'silhouette', or start from a mesh file");
  }
  std::vector<std::optional<SilhouetteView>> slots(masked.size());
  renderer::ParallelFor(static_cast<std::int64_t>(masked.size()), [&](std::int64_t i) {
    slots[static_cast<std::size_t>(i)] = MakeView(*masked[static_cast<std::size_t>(i)]);
  });
  views_.reserve(slots.size());
  for (std::optional<SilhouetteView>& slot : slots) views_.push_back(std::move(*slot));
  num_dissenting_ = static_cast<std::size_t>(dissent * static_cast<double>(views_.size()));
}

bool SilhouetteField::TrustBorders() {
  bool any = false;
  for (SilhouetteView& view : views_) any |= std::exchange(view.is_cut, false);
  return any;
}

int SilhouetteField::NumCells(std::size_t view, int cells_along) const {
  const SilhouetteView& v = views_[view];
  int count = 0;
  for (int y = 0; y < cells_along; ++y) {
    for (int x = 0; x < cells_along; ++x) {
      const double column = v.low.x + (x + 0.5) / cells_along * (v.high.x - v.low.x);
      const double row = v.low.y + (y + 0.5) / cells_along * (v.high.y - v.low.y);
      count += Lookup(v, column, row).value > 0.0 ? 1 : 0;
    }
  }
  return count;
}

int SilhouetteField::CellOf(std::size_t view, int cells_along, const renderer::Vec3& x) const {
  const SilhouetteView& v = views_[view];
  const auto p = v.camera.Project(x);
  if (!p) return -1;
  const double column = std::floor((p->u - v.low.x) / (v.high.x - v.low.x) * cells_along);
  const double row = std::floor((p->v - v.low.y) / (v.high.y - v.low.y) * cells_along);
  const bool is_inside = column >= 0.0 && column < cells_along && row >= 0.0 && row < cells_along;
  return is_inside ? static_cast<int>(row) * cells_along + static_cast<int>(column) : -1;
}

SilhouetteField::PixelDistance SilhouetteField::Lookup(const SilhouetteView& view,
                                                       double u,
                                                       double v) {
  const int width = view.distance.width;
  const int height = view.distance.height;
  const double x = std::clamp(u - 0.5, 0.0, width - 1.0);
  const double y = std::clamp(v - 0.5, 0.0, height - 1.0);
  const int x0 = std::clamp(static_cast<int>(x), 0, std::max(0, width - 2));
  const int y0 = std::clamp(static_cast<int>(y), 0, std::max(0, height - 2));
  const int x1 = std::min(x0 + 1, width - 1);
  const int y1 = std::min(y0 + 1, height - 1);
  const double a = static_cast<double>(view.distance.At(x0, y0, 0));
  const double b = static_cast<double>(view.distance.At(x1, y0, 0));
  const double c = static_cast<double>(view.distance.At(x0, y1, 0));
  const double d = static_cast<double>(view.distance.At(x1, y1, 0));
  const double s = x - x0;
  const double t = y - y0;
  PixelDistance out{
      .value = (a + (b - a) * s) * (1.0 - t) + (c + (d - c) * s) * t,
      .gradient = {(b - a) * (1.0 - t) + (d - c) * t, (c - a) * (1.0 - s) + (d - b) * s}};
  if (view.is_cut) {  // far enough beyond the frame anything may be
    const double beyond_u = u < 0.0 ? u : std::max(0.0, u - width);
    const double beyond_v = v < 0.0 ? v : std::max(0.0, v - height);
    const double beyond = std::hypot(beyond_u, beyond_v);
    out.value += beyond;
    if (beyond_u != 0.0) out.gradient.x = beyond_u / beyond;
    if (beyond_v != 0.0) out.gradient.y = beyond_v / beyond;
    return out;
  }
  // The frame is an outline too: distance to its nearest side, positive inside.
  const double left = std::min(u, width - u);
  const double top = std::min(v, height - v);
  const double inside = std::min(left, top);
  const double frame =
      inside >= 0.0 ? inside : -std::hypot(std::min(left, 0.0), std::min(top, 0.0));
  const double distance = inside >= 0.0 ? frame : frame + std::min(out.value, 0.0);
  if (inside < 0.0 || distance < out.value) {
    out.value = distance;
    out.gradient =
        left < top ? Vec2{u < width - u ? 1.0 : -1.0, 0.0} : Vec2{0.0, v < height - v ? 1.0 : -1.0};
  }
  return out;
}

class SilhouetteField::Outermost {
 public:
  struct Entry {
    double value = std::numeric_limits<double>::max();
    std::size_t view = 0;
  };

  explicit Outermost(std::size_t num_dissenting) : entries_(num_dissenting + 1) {}

  void Add(double value, std::size_t view) {
    if (!(value < entries_.back().value)) return;
    const auto place = std::ranges::upper_bound(entries_, value, {}, &Entry::value);
    std::move_backward(place, entries_.end() - 1, entries_.end());
    *place = {value, view};
  }
  [[nodiscard]] const Entry& Telling() const { return entries_.back(); }

 private:
  std::vector<Entry> entries_;
};

std::optional<double> SilhouetteField::Distance(const SilhouetteView& view, const Vec3& x) {
  if (const std::optional<Projection> p = view.camera.Project(x)) {
    return Lookup(view, p->u, p->v).value * p->depth / view.focal;
  }
  return view.is_cut ? std::nullopt : std::optional(kFarOutside);
}

double SilhouetteField::Value(const Vec3& x, double enough) const {
  Outermost outermost(num_dissenting_);
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (const auto distance = Distance(views_[i], x)) outermost.Add(*distance, i);
    if (outermost.Telling().value < enough) break;
  }
  return outermost.Telling().value;
}

SilhouetteField::Sample SilhouetteField::ValueAndGradient(const Vec3& x) const {
  Outermost outermost(num_dissenting_);
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (const auto distance = Distance(views_[i], x)) outermost.Add(*distance, i);
  }
  const SilhouetteView& view = views_[outermost.Telling().view];
  const std::optional<Projection> p = view.camera.Project(x);
  if (!p) return {.value = kFarOutside, .gradient = {}};
  const PixelDistance d = Lookup(view, p->u, p->v);
  const Vec3 depth_gradient = -view.camera.Pose().linear.z;
  return {.value = outermost.Telling().value,
          .gradient = ((p->du * d.gradient.x + p->dv * d.gradient.y) * p->depth +
                       depth_gradient * d.value) /
                      view.focal};
}

Vec3 SilhouetteField::Center() const {
  // Normal equations of sum |(1 - d d^T)(x - o)|^2.
  Mat3 a{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  Vec3 b;
  for (const SilhouetteView& view : views_) {
    const renderer::Ray ray = view.camera.RayThrough(view.centroid.x, view.centroid.y);
    const Vec3& d = ray.direction;
    a.x += Vec3{1.0, 0.0, 0.0} - d * d.x;
    a.y += Vec3{0.0, 1.0, 0.0} - d * d.y;
    a.z += Vec3{0.0, 0.0, 1.0} - d * d.z;
    b += ray.origin - d * Dot(d, ray.origin);
  }
  const double count = static_cast<double>(views_.size());
  const double determinant = Determinant(a);
  if (!(determinant > kMinSpread * count * count * count)) {
    throw SceneError(
        "visual hull: all photos with masks look in nearly the same direction, so they do not say "
        "how deep the "
        "object is; add views from other sides, or start from a mesh file");
  }
  // a is symmetric: Cramer's rule by columns.
  return {Dot(b, Cross(a.y, a.z)) / determinant,
          Dot(a.x, Cross(b, a.z)) / determinant,
          Dot(a.x, Cross(a.y, b)) / determinant};
}

double SilhouetteField::PixelWidth(const Vec3& at) const {
  std::vector<double> widths;
  for (const SilhouetteView& view : views_) {
    if (const auto p = view.camera.Project(at)) widths.push_back(p->depth / view.focal);
  }
  return renderer::Median(widths);
}

double SilhouetteField::Radius(const Vec3& center) const {
  double radius = 0.0;
  for (const SilhouetteView& view : views_) {
    const std::optional<Projection> p = view.camera.Project(center);
    if (!p) {
      throw SceneError("visual hull: the point where the views meet is not seen by " +
                       view.camera.camera().name +
                       "; the cameras and the masks do not belong together");
    }
    const double du = std::max(p->u - view.low.x, view.high.x - p->u);
    const double dv = std::max(p->v - view.low.y, view.high.y - p->v);
    radius = std::max(radius, std::hypot(du, dv) * p->depth / view.focal);
  }
  return radius;
}

}  // namespace pathfit::optim
