// How far two surfaces are apart: surface_distance A B [--points N] prints one line of JSON.

#include "renderer/geometry/surface_distance.h"

#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "renderer/io/mesh_file.h"
#include "renderer/math/box.h"

namespace pathfit::bench {
namespace {

nlohmann::json ToJson(const renderer::SurfaceGap& gap) {
  return {{"mean", gap.mean}, {"rms", gap.rms}, {"most", gap.most}};
}

int Main(const std::vector<std::string>& words) {
  int count = 200000;
  if (words.size() == 4 && words[2] == "--points") {
    count = std::stoi(words[3]);
  } else if (words.size() != 2) {
    throw std::invalid_argument("usage: surface_distance A B [--points N]");
  }
  if (count < 1) throw std::invalid_argument("--points: a number above 0 is needed");
  const renderer::Mesh a = renderer::ReadMesh(words[0]), b = renderer::ReadMesh(words[1]);
  if (a.triangles.empty() || b.triangles.empty()) throw std::invalid_argument("no triangles");
  const renderer::SurfaceGap ab = renderer::GapBetween(a, renderer::UniformPoints(a, count), b);
  const renderer::SurfaceGap ba = renderer::GapBetween(b, renderer::UniformPoints(b, count), a);
  const double diagonal = Norm(renderer::BoxAround(b.positions).Size());
  const nlohmann::json result = {{"a_to_b", ToJson(ab)},
                                 {"b_to_a", ToJson(ba)},
                                 {"diagonal_of_b", diagonal},
                                 {"mean_percent", 50.0 * (ab.mean + ba.mean) / diagonal}};
  std::cout << result.dump() << "\n";
  return 0;
}

}  // namespace
}  // namespace pathfit::bench

int main(int argc, char** argv) {
  try {
    return pathfit::bench::Main({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << "surface_distance: " << error.what() << "\n";
    return 1;
  }
}
