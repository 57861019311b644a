#include "optim/observation/manifold_repair.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

using renderer::Mesh;
using renderer::Triangle;
using renderer::Vec3;

std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Disjoint sets of integers.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  std::size_t Find(std::size_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }
  /// The smaller number stands for the union, so results do not depend on the order.
  void Unite(std::size_t a, std::size_t b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

/// One side of a triangle: from its corner k to corner k + 1.
struct Side {
  std::int32_t low, high;  ///< vertices, ascending
  std::size_t face;
  std::size_t corner;
  bool ascending;  ///< runs from low to high
  double angle;    ///< of the face around the edge, only where there are more than two
};

std::size_t Corner(std::size_t face, std::size_t corner) { return 3 * face + corner % 3; }

/// Sides of all triangles, those of one edge together.
std::vector<Side> SortedSides(const Mesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles[f][k];
      const std::int32_t b = mesh.triangles[f][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), f, k, a < b, 0.0});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::pair(std::pair(a.low, a.high), a.face) <
           std::pair(std::pair(b.low, b.high), b.face);
  });
  return sides;
}

[[noreturn]] void FailOpen() {
  throw renderer::SceneError(
      "visual hull: the carved surface is not closed; try another resolution");
}

/// Around an edge with many faces, brings each face next to the one across the body between them:
/// turning positively about the direction from low to high, body follows a face that runs
/// downwards.
void SortAroundEdge(const Mesh& mesh,
                    std::vector<Side>::iterator first,
                    std::vector<Side>::iterator last) {
  const Vec3& low = mesh.positions[Index(first->low)];
  const Vec3 axis = Normalized(mesh.positions[Index(first->high)] - low);
  Vec3 reference;
  for (auto side = first; side != last; ++side) {
    const Vec3 to_apex =
        mesh.positions[Index(mesh.triangles[side->face][(side->corner + 2) % 3])] - low;
    const Vec3 across = to_apex - axis * Dot(axis, to_apex);
    if (side == first) {
      reference = across;
    }
    side->angle = std::atan2(Dot(axis, Cross(reference, across)), Dot(reference, across));
  }
  std::sort(first, last, [](const Side& a, const Side& b) {
    return std::pair(a.angle, a.face) < std::pair(b.angle, b.face);
  });
  std::rotate(first, std::find_if(first, last, [](const Side& s) { return !s.ascending; }), last);
}

/// Corners that stay together: those of triangles that are neighbours across an edge.
void UniteAcross(const Side& a, const Side& b, DisjointSets& corners) {
  if (a.ascending == b.ascending) {
    FailOpen();
  }
  corners.Unite(Corner(a.face, a.corner), Corner(b.face, b.corner + 1));
  corners.Unite(Corner(a.face, a.corner + 1), Corner(b.face, b.corner));
}

DisjointSets ConnectCorners(const Mesh& mesh) {
  DisjointSets corners(3 * mesh.triangles.size());
  std::vector<Side> sides = SortedSides(mesh);
  for (auto first = sides.begin(); first != sides.end();) {
    const auto last = std::find_if(first, sides.end(), [&](const Side& s) {
      return s.low != first->low || s.high != first->high;
    });
    const auto count = last - first;
    if (count % 2 != 0) {
      FailOpen();
    }
    if (count > 2) {
      SortAroundEdge(mesh, first, last);
    }
    for (auto side = first; side != last; side += 2) {
      UniteAcross(*side, *(side + 1), corners);
    }
    first = last;
  }
  return corners;
}

/// Vertices and triangles of the parts listed by `keep` (one entry per triangle).
void KeepTriangles(const std::vector<bool>& keep, Mesh& mesh) {
  std::vector<std::int32_t> new_index(mesh.positions.size(), -1);
  Mesh out;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    if (!keep[f]) {
      continue;
    }
    Triangle triangle = mesh.triangles[f];
    for (std::int32_t& v : triangle) {
      std::int32_t& target = new_index[Index(v)];
      if (target < 0) {
        target = static_cast<std::int32_t>(out.positions.size());
        out.positions.push_back(mesh.positions[Index(v)]);
      }
      v = target;
    }
    out.triangles.push_back(triangle);
  }
  mesh = std::move(out);
}

}  // namespace

void SeparateTouchingParts(double inset, Mesh& mesh) {
  DisjointSets corners = ConnectCorners(mesh);
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> first_fan(mesh.positions.size(), kNone);
  std::vector<std::int32_t> vertex_of_fan(3 * mesh.triangles.size(), -1);
  std::vector<bool> is_split(mesh.positions.size(), false);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t& vertex = mesh.triangles[f][k];
      const std::size_t fan = corners.Find(Corner(f, k));
      std::int32_t& target = vertex_of_fan[fan];
      if (target < 0) {
        target = vertex;
        if (first_fan[Index(vertex)] == kNone) {
          first_fan[Index(vertex)] = fan;
        } else {
          target = static_cast<std::int32_t>(mesh.positions.size());
          const Vec3 copy = mesh.positions[Index(vertex)];
          mesh.positions.push_back(copy);
          is_split[Index(vertex)] = true;
          is_split.push_back(true);
        }
      }
      vertex = target;
    }
  }
  std::vector<Vec3> normals(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    const Vec3 n = Cross(mesh.positions[Index(t[1])] - mesh.positions[Index(t[0])],
                         mesh.positions[Index(t[2])] - mesh.positions[Index(t[0])]);
    for (const std::int32_t v : t) {
      normals[Index(v)] += n;
    }
  }
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (const double length = Norm(normals[v]); is_split[v] && length > 0.0) {
      mesh.positions[v] -= normals[v] * (inset / length);
    }
  }
}

void KeepLargestPart(Mesh& mesh) {
  DisjointSets parts(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    parts.Unite(Index(t[0]), Index(t[1]));
    parts.Unite(Index(t[1]), Index(t[2]));
  }
  std::vector<double> volume(mesh.positions.size(), 0.0);
  const Vec3 origin = mesh.positions.empty() ? Vec3{} : mesh.positions.front();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.positions[Index(t[0])] - origin;
    const Vec3 b = mesh.positions[Index(t[1])] - origin;
    const Vec3 c = mesh.positions[Index(t[2])] - origin;
    volume[parts.Find(Index(t[0]))] += Dot(a, Cross(b, c)) / 6.0;
  }
  const auto largest =
      static_cast<std::size_t>(std::max_element(volume.begin(), volume.end()) - volume.begin());
  std::vector<bool> keep(mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    keep[f] = parts.Find(Index(mesh.triangles[f][0])) == largest;
  }
  KeepTriangles(keep, mesh);
}

}  // namespace pathfit::optim
