// Times what a fit does with a scene between renderings, on one thread, and prints JSON:
// milliseconds of the core (median of the repeats) for a scene with one texture of 2048 x 2048
// texels; and what looks for contacts before a fit takes for 100 000 triangles of balls.
// scene_bench [--repeats N]
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <malloc.h>
#include <nlohmann/json.hpp>
#include <time.h>

#include "renderer/core/parallel.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/renderer.h"
#include "tests/support/test_scenes.h"

namespace pathfit::bench {
namespace {

using renderer::ParameterKind;
using renderer::ParameterLayout;
using renderer::Scene;

constexpr int kSide = 2048;

Scene TexturedScene() {
  Scene scene = tests::BallAndWall();
  renderer::Texture texture;
  texture.name = "paper";
  texture.width = texture.height = kSide;
  texture.texels.assign(static_cast<std::size_t>(kSide) * kSide, {0.5, 0.4, 0.3});
  scene.textures = {texture};
  scene.materials[1].base_color_texture = 0;
  renderer::Mesh& wall = scene.meshes[1].mesh;
  wall.uvs.assign(wall.positions.size(), {0.5, 0.5});
  wall.uv_triangles = wall.triangles;
  return scene;
}

double CoreMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

template <class Body>
double MedianMs(int repeats, Body body) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const double start = CoreMs();
    body();
    times.push_back(CoreMs() - start);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

double HeapMb() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

/// Of a layout with one free group.
nlohmann::json MeasureLayout(const Scene& scene, ParameterKind kind, int repeats) {
  nlohmann::json json;
  const double before = HeapMb();
  ParameterLayout layout(scene);
  layout.Add(kind, 0);
  json["layout_mb"] = HeapMb() - before;
  json["scalars"] = layout.NumScalars();
  json["layout_ms"] = MedianMs(repeats, [&] {
    ParameterLayout made(scene);
    made.Add(kind, 0);
  });
  std::vector<double> values;
  json["gather_new_ms"] = MedianMs(repeats, [&] { values = layout.Gather(scene); });
  json["gather_ms"] = MedianMs(repeats, [&] { layout.Gather(scene, values); });
  Scene own = scene;
  layout.Scatter(values, own);
  json["scatter_ms"] = MedianMs(repeats, [&] { layout.Scatter(values, own); });
  renderer::Renderer renderer(scene);
  renderer.SetParameters(layout, values);
  json["set_parameters_ms"] = MedianMs(repeats, [&] { renderer.SetParameters(layout, values); });
  return json;
}

/// Per 100 000 triangles of two balls, the first of which is free and flat or smooth.
double MeasureLimits(bool smooth, double distance, int repeats) {
  Scene scene = tests::BallAndWall();
  for (std::size_t m = 0; m < 2; ++m) {
    renderer::Mesh ball = renderer::MakeIcosphere(6, 0.5);
    for (renderer::Vec3& p : ball.positions) p.x += static_cast<double>(m) * distance;
    if (smooth) renderer::ComputeVertexNormals(ball);
    scene.meshes[m].mesh = ball;
    scene.meshes[m].pose = {};
  }
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kVertexPositions, 0);
  const double triangles = 2.0 * static_cast<double>(scene.meshes[0].mesh.triangles.size());
  return MedianMs(repeats, [&] { static_cast<void>(DerivativeLimits(scene, layout)); }) * 1e5 /
         triangles;
}

int Main(int argc, char** argv) {
  int repeats = 9;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--repeats") == 0) repeats = std::stoi(argv[i + 1]);
  }
  const renderer::ThreadLimit limit(1);
  const Scene scene = TexturedScene();
  nlohmann::json json;
  const double before = HeapMb();
  const Scene copy = scene;
  json["copy"]["mb"] = HeapMb() - before;
  json["copy"]["ms"] = MedianMs(repeats, [&] { const Scene another = scene; });
  json["vertices"] = MeasureLayout(scene, ParameterKind::kVertexPositions, repeats);
  json["translation"] = MeasureLayout(scene, ParameterKind::kObjectTranslation, repeats);
  json["texels"] = MeasureLayout(scene, ParameterKind::kTextureTexels, repeats);
  json["derivative_limits_ms"] = {{"flat_apart", MeasureLimits(false, 3.0, repeats)},
                                  {"smooth_apart", MeasureLimits(true, 3.0, repeats)},
                                  {"flat_cut", MeasureLimits(false, 0.7, repeats)}};
  std::printf("%s\n", json.dump(2).c_str());
  return copy.textures.size() == 1 ? 0 : 1;
}

}  // namespace
}  // namespace pathfit::bench

int main(int argc, char** argv) { return pathfit::bench::Main(argc, argv); }
