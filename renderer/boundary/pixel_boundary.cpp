#include "renderer/boundary/pixel_boundary.h"

#include <algorithm>
#include <cmath>

#include "renderer/boundary/visible_point.h"
#include "renderer/core/check.h"
#include "renderer/sampler/lattice_sampler.h"

namespace pathfit::renderer {
namespace {

constexpr std::uint64_t kPixelDomain = 7;
constexpr std::uint64_t kShiftDomain = 9;

/// Pixels that may see anything move relative to the image.
PixelBounds BoundsOfMotion(const BoundaryContext& context) {
  const ActiveParameters& active = context.active;
  const Camera& camera = context.camera.camera();
  if (active.camera.Any() || SkyMoves(context)) {
    return {0, 0, camera.width, camera.height};
  }
  std::vector<bool> moving;
  for (const auto& mesh : active.meshes) {
    moving.push_back(mesh.moves);
  }
  return BoundsOfMeshes(*context.path.world, context.camera, moving);
}

}  // namespace

PixelBoundary::PixelBoundary(const BoundaryContext& context) : context_(context) {
  const Camera& camera = context.camera.camera();
  PATHFIT_CHECK(camera.filter.shape == PixelFilter::Shape::kBox);
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

std::int64_t PixelBoundary::NumSamples(double spp_pixel) const {
  if (NumLines() == 0) {
    return 0;
  }
  const double pixels = static_cast<double>(bounds_.x1 - bounds_.x0) * (bounds_.y1 - bounds_.y0);
  const double per_line = spp_pixel * pixels / static_cast<double>(NumLines());
  return static_cast<std::int64_t>(std::ceil(per_line)) * NumLines();
}

void PixelBoundary::Sample(std::int64_t index,
                           std::int64_t count,
                           RenderStats& /*stats*/,
                           SplatBuffer& splats) const {
  PATHFIT_CHECK(count % NumLines() == 0);
  const Camera& camera = context_.camera.camera();
  const PixelFilter& filter = camera.filter;
  const std::int64_t stratum = index / NumLines();
  const auto place = static_cast<std::size_t>(index % NumLines());
  const bool is_column = place < columns_.size();
  const Line& line = is_column ? columns_[place] : rows_[place - columns_.size()];
  const int first_along = is_column ? bounds_.y0 : bounds_.x0;
  const int end_along = is_column ? bounds_.y1 : bounds_.x1;

  CounterRng rng(context_.options.seed,
                 kPixelDomain,
                 context_.options.view,
                 static_cast<std::uint64_t>(stratum),
                 is_column ? 0 : 1);
  const double length = end_along - first_along + 2.0 * filter.radius - 1.0;
  const double stratum_length =
      length * static_cast<double>(NumLines()) / static_cast<double>(count);
  const double along = first_along + 0.5 - filter.radius +
                       stratum_length * (static_cast<double>(stratum) + rng.Next());
  const Ray ray = is_column ? context_.camera.RayThrough(line.at, along)
                            : context_.camera.RayThrough(along, line.at);
  const PathContext& path = context_.path;
  const auto hit = path.world->caster().Intersect(ray);
  const bool dark = !hit && !(path.lights.environment && path.lights.environment_visible);
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
    const CounterRng shift(
        context_.options.seed, kShiftDomain, context_.options.view, is_column ? 0 : 1, 0);
    LatticeSampler sampler(shift, rng, static_cast<std::uint64_t>(stratum));
    NullPathRecorder recorder;
    radiance = TraceRadiance(
        path, MakeSurfacePoint(*path.world, *hit, ray), sampler, recorder, {path.max_bounces});
  } else {
    radiance = EnvironmentRadianceInWorld(*path.lights.environment, ray.direction);
  }
  const Rgb amount = radiance * (stratum_length * FilterProfile(filter, 0.0));
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
