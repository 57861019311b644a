// How far two surfaces are apart: surface_distance A B [--points N] prints one line of JSON.
//
// Uniform points of each surface, and of each the distance to the nearest point of the other
// surface (not of points on it, which would add half their spacing).

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/embree_compat.h"
#include "renderer/geometry/mesh.h"
#include "renderer/io/mesh_file.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::bench {
namespace {

using renderer::Mesh;
using renderer::TriangleGeometry;
using renderer::Vec3;

TriangleGeometry TriangleOf(const Mesh& mesh, std::size_t i) {
  const renderer::Triangle& t = mesh.triangles[i];
  const auto corner = [&](int k) {
    return mesh.positions[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
  };
  return TriangleGeometry::Make(corner(0), corner(1), corner(2));
}

/// Nearest points of a mesh.
class Surface {
 public:
  explicit Surface(const Mesh& mesh)
      : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      triangles_.push_back(TriangleOf(mesh, i));
    }
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(triangles_.size()));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, Bounds, this);
    rtcSetGeometryPointQueryFunction(geometry, Closer);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;
  ~Surface() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  [[nodiscard]] double Distance(const Vec3& x) const {
    Query query{this, x, std::numeric_limits<double>::infinity()};
    RTCPointQuery at{static_cast<float>(x.x),
                     static_cast<float>(x.y),
                     static_cast<float>(x.z),
                     0.0F,
                     std::numeric_limits<float>::infinity()};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &at, &context, nullptr, &query);
    return query.distance;
  }

 private:
  struct Query {
    const Surface* surface;
    Vec3 x;
    double distance;
  };

  // Boxes and radii are widened by more than the rounding to float.
  static void Bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& surface = *static_cast<const Surface*>(arguments->geometryUserPtr);
    const TriangleGeometry& t = surface.triangles_[arguments->primID];
    const Vec3 p1 = t.p0 + t.e1, p2 = t.p0 + t.e2;
    const auto set = [](double a, double b, double c, float& lower, float& upper) {
      const double margin = 1e-6 * std::max({std::abs(a), std::abs(b), std::abs(c)});
      lower = static_cast<float>(std::min({a, b, c}) - margin);
      upper = static_cast<float>(std::max({a, b, c}) + margin);
    };
    RTCBounds& box = *arguments->bounds_o;
    set(t.p0.x, p1.x, p2.x, box.lower_x, box.upper_x);
    set(t.p0.y, p1.y, p2.y, box.lower_y, box.upper_y);
    set(t.p0.z, p1.z, p2.z, box.lower_z, box.upper_z);
  }
  static bool Closer(RTCPointQueryFunctionArguments* arguments) {
    auto& query = *static_cast<Query*>(arguments->userPtr);
    const TriangleGeometry& t = query.surface->triangles_[arguments->primID];
    const double distance = Norm(renderer::ClosestPointOfTriangle(query.x, t) - query.x);
    if (!(distance < query.distance)) return false;
    query.distance = distance;
    arguments->query->radius = static_cast<float>(distance * (1.0 + 1e-6));
    return true;
  }

  RTCDevice device_;
  RTCScene scene_;
  std::vector<TriangleGeometry> triangles_;
};

/// Points of a mesh, the same number from each piece of the same area: only the place within a
/// piece is random.
std::vector<Vec3> UniformPoints(const Mesh& mesh, int count) {
  std::vector<double> areas;
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const TriangleGeometry t = TriangleOf(mesh, i);
    area += 0.5 * Norm(Cross(t.e1, t.e2));
    areas.push_back(area);
  }
  renderer::CounterRng rng(1);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double at = (i + rng.Next()) / count * area;
    const auto found = std::upper_bound(areas.begin(), areas.end() - 1, at);
    const TriangleGeometry t = TriangleOf(mesh, static_cast<std::size_t>(found - areas.begin()));
    const double root = std::sqrt(rng.Next());
    const double v = rng.Next() * root;
    points.push_back(t.p0 + t.e1 * (root - v) + t.e2 * v);
  }
  return points;
}

struct OneWay {
  double mean = 0.0, rms = 0.0, most = 0.0;
};

OneWay Distances(const Mesh& from, const Mesh& to, int count) {
  const Surface surface(to);
  OneWay result;
  for (const Vec3& x : UniformPoints(from, count)) {
    const double distance = surface.Distance(x);
    result.mean += distance / count;
    result.rms += distance * distance / count;
    result.most = std::max(result.most, distance);
  }
  result.rms = std::sqrt(result.rms);
  return result;
}

double Diagonal(const Mesh& mesh) {
  Vec3 low = mesh.positions[0], high = low;
  for (const Vec3& x : mesh.positions) {
    low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
    high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
  }
  return Norm(high - low);
}

nlohmann::json ToJson(const OneWay& d) {
  return {{"mean", d.mean}, {"rms", d.rms}, {"most", d.most}};
}

int Main(const std::vector<std::string>& words) {
  int count = 200000;
  if (words.size() == 4 && words[2] == "--points") {
    count = std::stoi(words[3]);
  } else if (words.size() != 2) {
    throw std::invalid_argument("usage: surface_distance A B [--points N]");
  }
  if (count < 1) throw std::invalid_argument("--points: a number above 0 is needed");
  const Mesh a = renderer::ReadMesh(words[0]), b = renderer::ReadMesh(words[1]);
  if (a.triangles.empty() || b.triangles.empty()) throw std::invalid_argument("no triangles");
  const OneWay ab = Distances(a, b, count), ba = Distances(b, a, count);
  const double diagonal = Diagonal(b);
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
    std::fprintf(stderr, "surface_distance: %s\n", error.what());
    return 1;
  }
}
