#include "renderer/renderer.h"

#include <algorithm>
#include <utility>

#include "renderer/boundary/boundary_pass.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/derivative/derivative_accumulator.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/derivative/pixel_estimator.h"

namespace pathfit::renderer {
namespace {

/// Calls row(y, stats) for all rows in parallel and sums the statistics.
template <class Row>
void ForEachRow(int height, const RenderServices& services, RenderStats& stats, Row row) {
  const auto by_row = ParallelParts<RenderStats>(height, [&](std::int64_t y, RenderStats& of_row) {
    ThrowIfCancelled(services.cancel);
    row(static_cast<int>(y), of_row);
  });
  for (const RenderStats& s : by_row) {
    stats += s;
  }
}

PathContext MakeContext(const World& world,
                        const CameraModel& camera,
                        const RenderOptions& options) {
  return {&world,
          LightSet::Make(world, camera.Pose(), camera.camera().lights_off),
          BoundsOfMeshes(world, camera),
          options.max_bounces,
          options.rr_depth,
          options.antithetic};
}

/// What a pixel of radiance `value` gains by the camera's response to it.
void AddByGains(const Camera& camera,
                const ActiveParameters::CameraBlocks& blocks,
                int x,
                int y,
                const Rgb& value,
                DerivativeAccumulator& entries) {
  if (!blocks.HasGains() && camera.vignetting.IsNone()) {
    return;
  }
  const double r2 = camera.VignettingRadius2(x, y);
  const double falloff = camera.vignetting.At(r2);
  if (blocks.exposure >= 0) {
    entries.Entry(blocks.exposure)[0] =
        Rgba(value * Rgb{camera.red, 1.0, camera.blue} * falloff, 0.0);
  }
  if (blocks.white_balance >= 0) {
    auto& d = entries.Entry(blocks.white_balance);
    d[0] = Rgba(value.r * camera.gain * falloff, 0.0, 0.0, 0.0);
    d[1] = Rgba(0.0, 0.0, value.b * camera.gain * falloff, 0.0);
  }
  const Rgb seen = value * camera.ChannelGains() * falloff;
  if (blocks.vignetting >= 0) {
    auto& d = entries.Entry(blocks.vignetting);
    d[0] = Rgba(seen * r2, 0.0);
    d[1] = Rgba(seen * (r2 * r2), 0.0);
    d[2] = Rgba(seen * (r2 * r2 * r2), 0.0);
  }
  if (camera.vignetting.IsNone()) {
    return;
  }
  // The radius by what it is measured with, per unit of the sensor's own pixels.
  const Rgb by_r2 = seen * (camera.vignetting.LogSlope(r2) / camera.SquaredHalfDiagonal());
  const double a = (x + 0.5 - camera.cx) / camera.fx, b = (y + 0.5 - camera.cy) / camera.fy;
  const double scale_x = blocks.scale_x / camera.fx, scale_y = blocks.scale_y / camera.fy;
  if (blocks.principal_point >= 0) {
    auto& d = entries.Entry(blocks.principal_point);
    d[0] += Rgba(by_r2 * (-2.0 * a * scale_x), 0.0);
    d[1] += Rgba(by_r2 * (-2.0 * b * scale_y), 0.0);
  }
  if (blocks.focal >= 0) {
    const double width = 0.5 * camera.width / camera.fx, height = 0.5 * camera.height / camera.fy;
    auto& d = entries.Entry(blocks.focal);
    d[0] += Rgba(by_r2 * (2.0 * (r2 * width * width - a * a) * scale_x), 0.0);
    d[1] += Rgba(by_r2 * (2.0 * (r2 * height * height - b * b) * scale_y), 0.0);
  }
}

}  // namespace

Renderer::Renderer(Scene scene) : world_(std::make_unique<World>(std::move(scene))) {}
Renderer::Renderer(Scene scene, const Renderer& alike)
    : world_(std::make_unique<World>(std::move(scene), alike.world_->caster().frame())) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

const Scene& Renderer::scene() const { return world_->scene(); }

void Renderer::SetParameters(const ParameterLayout& layout, const std::vector<double>& values) {
  world_->SetParameters(layout, values);
}
void Renderer::SetCheckedParameters(const ParameterLayout& layout,
                                    const std::vector<double>& values) {
  world_->SetCheckedParameters(layout, values);
}

Film Renderer::RenderPrimal(const Camera& camera,
                            const RenderOptions& options,
                            const RenderServices& services) const {
  PATHFIT_CHECK(options.spp > 0);
  const CameraModel model(camera);
  const PathContext context = MakeContext(*world_, model, options);
  Film film(camera.width, camera.height);
  RenderStats sum;
  ForEachRow(camera.height, services, sum, [&](int y, RenderStats& row_stats) {
    PixelEstimator pixels(context, model, options);
    for (int x = 0; x < camera.width; ++x) {
      Rgba value = pixels.Estimate(x, y, row_stats);
      value = Rgba(value.Color() * camera.PixelGains(x, y), value.a);
      film.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                  static_cast<std::size_t>(x)] = value;
    }
  });
  if (services.stats != nullptr) {
    *services.stats += sum;
  }
  return film;
}

Film Renderer::RenderDerivative(const Camera& camera,
                                int sensor,
                                const RenderOptions& options,
                                const ParameterLayout& layout,
                                DerivativeSink& sink,
                                const RenderServices& services) const {
  PATHFIT_CHECK(options.spp > 0);
  CheckDerivative(scene(), layout, options);
  const CameraModel model(camera);
  const PathContext context = MakeContext(*world_, model, options);
  const ActiveParameters active = ActiveParameters::Make(scene(), layout, model, sensor);
  const NearMotion near_motion(*world_, context.lights, active, options);
  const AdjointContext adjoint{context, model, active, options.form, &near_motion};
  Film film = options.with_image ? Film(camera.width, camera.height) : Film();
  RenderStats sum;
  const bool derives = options.terms.Has(DerivativeTerm::kInterior);
  const bool interior = derives || options.with_image;
  const bool all_paths = options.with_image || active.all_paths;
  // Direct light depends on what the sensor sees alone.
  const PixelBounds bounds = all_paths || options.max_bounces > 1
                                 ? PixelBounds{0, 0, camera.width, camera.height}
                                 : BoundsOfMeshes(*world_, model, active.touches);
  if (derives) {
    sink.BeginTerm(DerivativeTerm::kInterior, options.spp * bounds.NumPixels());
  }
  ForEachRow(interior ? camera.height : 0, services, sum, [&](int y, RenderStats& row_stats) {
    PixelEstimator pixels(context, model, options);
    PixelDerivative interior_of(adjoint, options, all_paths ? nullptr : &active.touches);
    DerivativeAccumulator& entries = interior_of.sum();
    for (int x = 0; x < camera.width; ++x) {
      if (!bounds.Contains(x, y)) {
        continue;
      }
      const std::int64_t pixel = static_cast<std::int64_t>(y) * camera.width + x;
      const Rgba value =
          derives ? interior_of.Estimate(x, y, row_stats) : pixels.Estimate(x, y, row_stats);
      const Rgb gains = camera.PixelGains(x, y);
      const Rgb per_sample = gains / options.spp;
      for (ParameterDerivative& entry : entries.Entries()) {
        for (Rgba& d : entry.d) {
          d = Rgba(d.Color() * per_sample, d.a / options.spp);
        }
      }
      if (derives && !IsBlack(value.Color())) {
        AddByGains(camera, active.camera, x, y, value.Color(), entries);
      }
      if (!entries.Entries().empty()) {
        sink.Add(pixel, entries.Entries());
      }
      if (options.with_image) {
        film.pixels[static_cast<std::size_t>(pixel)] = Rgba(value.Color() * gains, value.a);
      }
    }
  });
  EmitBoundaries(context, model, active, options, services, sink, sum);
  if (services.stats != nullptr) {
    *services.stats += sum;
  }
  return film;
}

}  // namespace pathfit::renderer
