#include "renderer/boundary/pixel_boundary.h"

#include <algorithm>
#include <cmath>

#include "renderer/boundary/visible_point.h"

namespace pathfit::renderer {
namespace {

/// Pixels that may see anything move relative to the image.
PixelBounds BoundsOfMotion(const BoundaryContext& context) {
  const ActiveParameters& active = context.active;
  const Camera& camera = context.camera.camera();
  if (active.camera.Any() || SkyMoves(context)) {
    return {0, 0, camera.width, camera.height};
  }
  return BoundsOfMeshes(*context.path.world, context.camera, active.MovingMeshes());
}

}  // namespace

PixelBoundary::PixelBoundary(const BoundaryContext& context) : context_(context) {
  const Camera& camera = context.camera.camera();
  if (context.options.form != DerivativeForm::kMaterial ||
      camera.filter.shape != PixelFilter::Shape::kBox) {
    return;
  }
  bounds_ = BoundsOfMotion(context);
  columns_ = LinesOf(bounds_.x0, bounds_.x1, camera.filter.radius);
  rows_ = LinesOf(bounds_.y0, bounds_.y1, camera.filter.radius);
}

std::vector<PixelBoundary::Line> PixelBoundary::LinesOf(int first, int end, double radius) {
  // Supports of a whole number of pixels end where others start.
  const double width = 2.0 * radius;
  const bool shared = width == std::floor(width);
  const int step = shared ? static_cast<int>(width) : 0;
  std::vector<Line> lines;
  lines.reserve(2 * static_cast<std::size_t>(end - first));
  for (int i = first; i < end; ++i) {
    lines.push_back({i + 0.5 - radius, i, shared && i >= first + step ? i - step : -1});
  }
  for (int i = shared ? std::max(first, end - step) : first; i < end; ++i) {
    lines.push_back({i + 0.5 + radius, -1, i});
  }
  return lines;
}

std::vector<BoundaryWay> PixelBoundary::Ways() const {
  if (columns_.empty() || rows_.empty()) {
    return {};
  }
  return {{1, false, static_cast<int>(columns_.size())},
          {1, false, static_cast<int>(rows_.size())}};
}

std::int64_t PixelBoundary::NumSamples() const {
  const double pixels = static_cast<double>(bounds_.NumPixels());
  const auto lines = static_cast<double>(columns_.size() + rows_.size());
  return 2 * static_cast<std::int64_t>(std::ceil(context_.options.spp_pixel * pixels / lines));
}

void PixelBoundary::Sample(std::size_t way, const BoundaryDraw& draw, SplatBuffer& splats) const {
  const double radius = context_.camera.camera().filter.radius;
  const bool is_column = way == 0;
  const int first = is_column ? bounds_.y0 : bounds_.x0;
  const int end = is_column ? bounds_.y1 : bounds_.x1;
  const double length = end - first + 2.0 * radius - 1.0;
  const double along = first + 0.5 - radius + length * draw.u[0];
  for (const Line& line : is_column ? columns_ : rows_) {
    SamplePoint(is_column, line, along, length * draw.weight, draw.Lattice(), splats);
  }
}

void PixelBoundary::SamplePoint(bool is_column,
                                const Line& line,
                                double along,
                                double length,
                                LatticeSampler sampler,
                                SplatBuffer& splats) const {
  const Camera& camera = context_.camera.camera();
  const PixelFilter& filter = camera.filter;
  const Ray ray = is_column ? context_.camera.RayThrough(line.at, along)
                            : context_.camera.RayThrough(along, line.at);
  const PathContext& path = context_.path;
  const auto hit = path.world->caster().Intersect(ray);
  const bool dark = !hit && !path.lights.ShowsEnvironment();
  if (dark || IsInImageForm(context_, hit)) {
    return;
  }
  MotionRow row;
  AddMotionOfVisiblePoint(context_, hit, ray, is_column ? Vec2{1.0, 0.0} : Vec2{0.0, 1.0}, row);
  if (row.Empty()) {
    return;
  }
  Rgb radiance;
  if (hit) {
    NullListener listener;
    radiance = TraceRadiance(
        path, MakeSurfacePoint(*path.world, *hit, ray), sampler, listener, {path.max_bounces});
  } else {
    radiance = EnvironmentRadianceInWorld(*path.lights.environment, ray.direction);
  }
  const Rgb amount = radiance * (length * FilterProfile(filter, 0.0));
  const auto add = [&](int across, int pixel_along, double weight) {
    if (across >= 0) {
      const int x = is_column ? across : pixel_along;
      const int y = is_column ? pixel_along : across;
      splats.AddToPixel(
          static_cast<std::int64_t>(y) * camera.width + x, Rgba(amount * weight, 0.0), row);
    }
  };
  const CoveringRange covered =
      CoveringPixels(filter, along, is_column ? camera.height : camera.width);
  for (int i = covered.first; i < covered.end; ++i) {
    const double weight = FilterProfile(filter, along - (i + 0.5));
    add(line.gains, i, weight);
    add(line.loses, i, -weight);
  }
}

}  // namespace pathfit::renderer
