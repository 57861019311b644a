#include "renderer/renderer.h"

#include <algorithm>
#include <utility>

#include "renderer/boundary/primary_boundary.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/derivative/pixel_estimator.h"

namespace pathfit::renderer {
namespace {

constexpr std::int64_t kEdgeSamplesPerTask = 512;

void Accumulate(const RenderStats& from, RenderStats& to) {
  to.paths += from.paths;
  to.non_finite_samples += from.non_finite_samples;
  to.edge_samples += from.edge_samples;
  to.edge_samples_hidden += from.edge_samples_hidden;
}

void ThrowIfCancelled(const RenderOptions& options) {
  if (options.cancel != nullptr && options.cancel->load(std::memory_order_relaxed)) {
    throw Cancelled();
  }
}

/// Calls row(y, stats) for all rows in parallel and sums the statistics.
template <class Row>
void ForEachRow(int height, const RenderOptions& options, RenderStats* stats, Row row) {
  std::vector<RenderStats> by_row(static_cast<std::size_t>(height));
  ParallelFor(height, [&](std::int64_t y) {
    ThrowIfCancelled(options);
    row(static_cast<int>(y), by_row[static_cast<std::size_t>(y)]);
  });
  if (stats != nullptr) {
    for (const RenderStats& s : by_row) {
      Accumulate(s, *stats);
    }
  }
}

}  // namespace

struct Renderer::Impl {
  Scene scene;
  std::vector<MeshTopology> topologies;
  RayCaster caster;
  std::unique_ptr<EnvironmentSampler> environment_sampler;

  void BuildCaster() {
    std::vector<const Mesh*> meshes;
    for (const SceneMesh& m : scene.meshes) {
      meshes.push_back(&m.mesh);
    }
    caster.Build(meshes);
  }

  void BuildEnvironmentSampler() {
    environment_sampler.reset();
    for (const Emitter& emitter : scene.emitters) {
      if (const auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light)) {
        environment_sampler = std::make_unique<EnvironmentSampler>(*environment);
      }
    }
  }

  [[nodiscard]] PathContext Context(const CameraModel& camera, const RenderOptions& options) const {
    return {&scene,
            &caster,
            LightSet::Make(scene, environment_sampler.get(), camera.camera().world_from_camera),
            BoundsOfMeshes(scene, camera),
            options.max_bounces,
            options.rr_depth};
  }

  void EmitPrimaryBoundary(const PathContext& context,
                           const CameraModel& camera,
                           const RenderOptions& options,
                           const ActiveParameters& active,
                           DerivativeSink& sink,
                           RenderStats* stats) const;
};

Renderer::Renderer(Scene scene) : impl_(std::make_unique<Impl>()) {
  ValidateScene(scene);
  impl_->scene = std::move(scene);
  for (const SceneMesh& m : impl_->scene.meshes) {
    impl_->topologies.push_back(MeshTopology::Build(m.mesh));
  }
  impl_->BuildCaster();
  impl_->BuildEnvironmentSampler();
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

const Scene& Renderer::scene() const { return impl_->scene; }

void Renderer::SetParameters(const ParameterLayout& layout, const std::vector<double>& values) {
  layout.Scatter(values, impl_->scene);
  const auto& groups = layout.groups();
  const auto has = [&](ParameterKind kind) {
    return std::any_of(groups.begin(), groups.end(), [&](const auto& g) { return g.kind == kind; });
  };
  if (has(ParameterKind::kVertexPositions)) {
    impl_->BuildCaster();
  }
  if (has(ParameterKind::kEnvironmentTexels) || has(ParameterKind::kLightIntensity)) {
    impl_->BuildEnvironmentSampler();
  }
}

Film Renderer::RenderPrimal(const PerspectiveCamera& camera,
                            const RenderOptions& options,
                            RenderStats* stats) const {
  PATHFIT_CHECK(options.spp > 0);
  const CameraModel model(camera);
  const PathContext context = impl_->Context(model, options);
  Film film(camera.width, camera.height);
  ForEachRow(camera.height, options, stats, [&](int y, RenderStats& row_stats) {
    for (int x = 0; x < camera.width; ++x) {
      Rgba value = EstimatePixel(context, model, options, x, y, row_stats);
      value = Rgba(value.Color() * camera.gain, value.a);
      film.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                  static_cast<std::size_t>(x)] = value;
    }
  });
  return film;
}

Film Renderer::RenderDerivative(const PerspectiveCamera& camera,
                                int sensor,
                                const RenderOptions& options,
                                const ParameterLayout& layout,
                                DerivativeSink& sink,
                                RenderStats* stats) const {
  PATHFIT_CHECK(options.spp > 0);
  const CameraModel model(camera);
  const PathContext context = impl_->Context(model, options);
  const ActiveParameters active = ActiveParameters::Make(impl_->scene, layout, sensor);
  Film film(camera.width, camera.height);
  ForEachRow(camera.height, options, stats, [&](int y, RenderStats& row_stats) {
    PathRecorder recorder;
    DerivativeAccumulator sum;
    for (int x = 0; x < camera.width; ++x) {
      const std::int64_t pixel = static_cast<std::int64_t>(y) * camera.width + x;
      sum.Clear();
      Rgba value = options.terms.interior
                       ? EstimatePixelWithDerivative(
                             context, model, options, active, x, y, recorder, sum, row_stats)
                       : EstimatePixel(context, model, options, x, y, row_stats);
      for (ParameterDerivative& entry : sum.Entries()) {
        for (Rgba& d : entry.d) {
          d *= camera.gain / options.spp;
        }
      }
      if (active.exposure >= 0 && options.terms.interior && !IsBlack(value.Color())) {
        sum.Entry(active.exposure)[0] = Rgba(value.Color(), 0.0);
      }
      if (!sum.Entries().empty()) {
        sink.Add(pixel, sum.Entries());
      }
      film.pixels[static_cast<std::size_t>(pixel)] = Rgba(value.Color() * camera.gain, value.a);
    }
  });
  if (options.terms.primary && active.any_positions) {
    impl_->EmitPrimaryBoundary(context, model, options, active, sink, stats);
  }
  return film;
}

void Renderer::Impl::EmitPrimaryBoundary(const PathContext& context,
                                         const CameraModel& camera,
                                         const RenderOptions& options,
                                         const ActiveParameters& active,
                                         DerivativeSink& sink,
                                         RenderStats* stats) const {
  std::vector<bool> moves;
  for (const std::int32_t first : active.positions) {
    moves.push_back(first >= 0);
  }
  const ViewEdges edges(scene, topologies, moves, camera);
  if (edges.distribution().Empty()) {
    return;
  }
  const PrimaryBoundary boundary(context, topologies, camera, edges);
  const std::int64_t count = boundary.NumSamples(options.sppe);
  const std::int64_t tasks = (count + kEdgeSamplesPerTask - 1) / kEdgeSamplesPerTask;
  std::vector<std::vector<PrimaryBoundarySample>> samples(static_cast<std::size_t>(tasks));
  std::vector<RenderStats> by_task(static_cast<std::size_t>(tasks));
  ParallelFor(tasks, [&](std::int64_t task) {
    ThrowIfCancelled(options);
    const auto slot = static_cast<std::size_t>(task);
    const std::int64_t end = std::min(count, (task + 1) * kEdgeSamplesPerTask);
    for (std::int64_t i = task * kEdgeSamplesPerTask; i < end; ++i) {
      if (const auto sample = boundary.Sample(options, i, count, by_task[slot])) {
        samples[slot].push_back(*sample);
      }
    }
  });
  const double gain = camera.camera().gain;
  for (const auto& task : samples) {
    for (const PrimaryBoundarySample& s : task) {
      const std::int32_t first = active.positions[static_cast<std::size_t>(s.mesh)];
      const Rgba jump(s.jump.Color() * gain, s.jump.a);
      std::array<ParameterDerivative, 2> entries;
      entries[0].block = first + s.vertex_a;
      entries[1].block = first + s.vertex_b;
      for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<std::size_t>(c);
        entries[0].d[i] = jump * (s.direction[c] * (1.0 - s.t));
        entries[1].d[i] = jump * (s.direction[c] * s.t);
      }
      sink.Add(static_cast<std::int64_t>(s.y) * camera.camera().width + s.x, entries);
    }
  }
  if (stats != nullptr) {
    for (const RenderStats& s : by_task) {
      Accumulate(s, *stats);
    }
  }
}

}  // namespace pathfit::renderer
