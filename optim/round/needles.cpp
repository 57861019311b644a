#include "optim/round/needles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Eigenvalues>

#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_topology.h"

namespace pathfit::optim {
namespace {

using renderer::Index;
using renderer::Vec3;

// Of the sum of a vertex's areas, as vectors, over the sum of their sizes: 1 where flat, .58 at a
// box's corner.
constexpr double kLeastSum = 0.55;
// Of the mean square of its normals in the second of their main directions: 0 at sharp ridges.
constexpr double kSecondShare = 0.25;
constexpr int kPasses = 12;
constexpr int kPassesPerRing = 3;  // after so many passes one more ring of neighbours moves, too

}  // namespace

std::vector<char> FindNeedles(const renderer::Mesh& mesh) {
  struct Around {
    Vec3 sum{0.0, 0.0, 0.0};
    double area = 0.0;
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  };
  std::vector<Around> around(mesh.positions.size());
  for (const renderer::Triangle& triangle : mesh.triangles.Items()) {
    const Vec3 area = TwiceArea(mesh, triangle);
    const double size = Norm(area);
    if (!(size > 0.0)) continue;
    const Eigen::Vector3d n = Eigen::Vector3d(area.x, area.y, area.z) / size;
    for (const std::int32_t v : triangle) {
      Around& at = around[Index(v)];
      at.sum += area;
      at.area += size;
      at.squares += size * n * n.transpose();
    }
  }
  std::vector<char> marks(around.size());
  for (std::size_t v = 0; v < around.size(); ++v) {
    const Around& at = around[v];
    if (!(Norm(at.sum) < kLeastSum * at.area)) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(at.squares / at.area,
                                                               Eigen::EigenvaluesOnly);
    marks[v] = eigen.eigenvalues()(1) > kSecondShare ? 1 : 0;
  }
  return marks;
}

bool SmoothNeedles(renderer::Mesh& mesh) {
  std::vector<char> marks = FindNeedles(mesh);
  const auto any = [&marks] { return std::find(marks.begin(), marks.end(), 1) != marks.end(); };
  if (!any()) return false;
  const auto topology = renderer::MeshTopology::Build(mesh);
  const std::vector<std::vector<std::int32_t>> rings = topology.Neighbors(mesh);
  for (int pass = 0; pass < kPasses && any(); ++pass) {
    for (int ring = 0; ring < pass / kPassesPerRing; ++ring) topology.MarkRing(marks);
    const std::vector<Vec3> old = mesh.positions;
    std::vector<Vec3>& positions = mesh.positions.Edit();
    for (std::size_t v = 0; v < old.size(); ++v) {
      if (marks[v] == 0 || rings[v].empty()) continue;
      Vec3 sum{0.0, 0.0, 0.0};
      for (const std::int32_t neighbor : rings[v]) sum += old[Index(neighbor)];
      // Half of the way: whole steps may swing to and fro.
      positions[v] = (old[v] + sum / static_cast<double>(rings[v].size())) * 0.5;
    }
    marks = FindNeedles(mesh);
  }
  return true;
}

}  // namespace pathfit::optim
