// Times primal and derivative renderings on one thread and prints JSON: core-nanoseconds per path
// (minimum and median of the repeats), their ratio, and the variance of the derivative.
// render_bench [--mesh FILE.ply] [--repeats N]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "optim/problem/jacobian_sink.h"
#include "renderer/core/parallel.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/io/mesh_file.h"
#include "renderer/renderer.h"
#include "tests/bench/bench_scenes.h"

namespace pathfit::bench {
namespace {

using renderer::ParameterKind;
using renderer::ParameterLayout;
using renderer::Renderer;
using renderer::RenderOptions;

constexpr int kSpp = 64;

struct Timing {
  double min_ns = 0.0, median_ns = 0.0;
};

template <class Body>
Timing NanosecondsPerPath(int repeats, double paths, Body body) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    body();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    times.push_back(seconds.count() * 1e9 / paths);
  }
  std::sort(times.begin(), times.end());
  return {times.front(), times[times.size() / 2]};
}

nlohmann::json ToJson(const Timing& t) {
  return {{"min_ns", t.min_ns}, {"median_ns", t.median_ns}};
}

/// Mean over pixels and channels of the variance of one derivative image (all vertices of mesh 0
/// moved along x).
double DerivativeVariance(const Renderer& renderer,
                          const ParameterLayout& layout,
                          RenderOptions options) {
  constexpr int kReplicates = 8;
  const auto& camera = renderer.scene().sensors[0];
  std::vector<double> direction(static_cast<std::size_t>(layout.NumScalars()));
  for (std::size_t i = 0; i < direction.size(); i += 3) {
    direction[i] = 1.0;
  }
  std::vector<double> sum;
  std::vector<double> sum_squares;
  for (int r = 0; r < kReplicates; ++r) {
    options.seed = 1000 + static_cast<std::uint64_t>(r);
    renderer::FilmSink sink(layout, direction, camera.width, camera.height);
    renderer.RenderDerivative(camera, -1, options, layout, sink);
    const auto& pixels = sink.film().pixels;
    sum.resize(3 * pixels.size());
    sum_squares.resize(3 * pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const double d = pixels[i][c];
        sum[3 * i + static_cast<std::size_t>(c)] += d;
        sum_squares[3 * i + static_cast<std::size_t>(c)] += d * d;
      }
    }
  }
  double variance = 0.0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    variance += (sum_squares[i] - sum[i] * sum[i] / kReplicates) / (kReplicates - 1);
  }
  return variance / static_cast<double>(sum.size());
}

nlohmann::json BenchScene(const renderer::Scene& scene, int max_bounces, int repeats) {
  const Renderer renderer(scene);
  const auto& camera = scene.sensors[0];
  RenderOptions options;
  options.spp = kSpp;
  options.max_bounces = max_bounces;
  const double paths = static_cast<double>(camera.width) * camera.height * kSpp;

  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kVertexPositions, 0);
  if (scene.meshes[0].mesh.HasColors()) {
    layout.Add(ParameterKind::kVertexColors, 0);
  }
  double checksum = 0.0;
  const Timing primal = NanosecondsPerPath(
      repeats, paths, [&] { checksum += renderer.RenderPrimal(camera, options).pixels.front().g; });
  double jacobian_bytes = 0.0;
  const Timing jacobian = NanosecondsPerPath(repeats, paths, [&] {
    optim::JacobianSink sink(camera.width, camera.height);
    renderer.RenderDerivative(camera, -1, options, layout, sink);
    sink.Finish();
    jacobian_bytes = static_cast<double>(sink.MemoryBytes());
  });
  ParameterLayout vertices(scene);
  vertices.Add(ParameterKind::kVertexPositions, 0);
  const double variance = DerivativeVariance(renderer, vertices, options);
  return {{"max_bounces", max_bounces},
          {"spp", kSpp},
          {"sppe", options.sppe},
          {"checksum", checksum / repeats},
          {"primal", ToJson(primal)},
          {"jacobian", ToJson(jacobian)},
          {"jacobian_over_primal", jacobian.min_ns / primal.min_ns},
          {"jacobian_mb", jacobian_bytes / 1048576.0},
          {"derivative_variance", variance},
          {"derivative_efficiency", 1.0 / (variance * jacobian.min_ns * 1e-9 * paths)}};
}

}  // namespace
}  // namespace pathfit::bench

int main(int argc, char** argv) {
  int repeats = 5;
  pathfit::renderer::Mesh mesh;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--repeats") == 0) {
      repeats = std::max(1, std::stoi(argv[i + 1]));
    } else if (std::strcmp(argv[i], "--mesh") == 0) {
      mesh = pathfit::renderer::ReadMesh(argv[i + 1]);
    }
  }
  const pathfit::renderer::ThreadLimit one_thread(1);
  nlohmann::json result;
  result["box_four_bounces"] = pathfit::bench::BenchScene(pathfit::bench::BoxScene(), 4, repeats);
  result["mesh_two_bounces"] =
      pathfit::bench::BenchScene(pathfit::bench::MeshOnFloorScene(mesh), 2, repeats);
  std::printf("%s\n", result.dump(2).c_str());
  return 0;
}
