#include "renderer/geometry/uv_charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/math/frame.h"

namespace pathfit::renderer {
namespace {

// Most that 1 - |mean normal| may be: that of a cap of 45 degrees around its middle.
constexpr double kMostTurning = 0.15;
// What a round border counts against turning, when pieces are joined.
constexpr double kBorderWeight = 0.1;
// Least cosine between a triangle and the plane it is projected to: it gets this share of its size.
constexpr double kLeastCosine = 0.25;
constexpr int kTurns = 16;  // tried for the smallest rectangle, of a right angle

using Neighbors = std::vector<std::array<std::int32_t, 3>>;  // across each side, -1: none

/// Triangles across the sides of each triangle, with the lengths of the sides.
Neighbors NeighborsOf(const Mesh& mesh) {
  Neighbors neighbors(mesh.triangles.size(), {-1, -1, -1});
  const std::vector<MeshSide> sides = SortedSides(mesh);
  ForEachEdge(sides, [&](auto first, auto last) {
    if (last - first != 2) return;
    const auto second = first + 1;
    neighbors[first->Face()][first->side % 3] = static_cast<std::int32_t>(second->Face());
    neighbors[second->Face()][second->side % 3] = static_cast<std::int32_t>(first->Face());
  });
  return neighbors;
}

double SideLength(const Mesh& mesh, std::size_t face, std::size_t side) {
  const Triangle& t = mesh.triangles[face];
  return Norm(mesh.positions[Index(t[(side + 1) % 3])] - mesh.positions[Index(t[side])]);
}

/// Pieces of the surface, joined two by two.
class Clusters {
 public:
  Clusters(const Mesh& mesh, const Neighbors& neighbors) : sets_(mesh.triangles.size()) {
    const std::size_t count = mesh.triangles.size();
    clusters_.resize(count);
    for (std::size_t f = 0; f < count; ++f) {
      Cluster& cluster = clusters_[f];
      cluster.normal = TwiceArea(mesh, mesh.triangles[f]) * 0.5;
      cluster.area = Norm(cluster.normal);
      for (std::size_t side = 0; side < 3; ++side) {
        const double length = SideLength(mesh, f, side);
        cluster.perimeter += length;
        const std::int32_t other = neighbors[f][side];
        if (other >= 0) cluster.shared[Index(other)] += length;
      }
    }
    for (std::size_t f = 0; f < count; ++f) {
      for (const auto& [other, length] : clusters_[f].shared) {
        if (f < other) Propose(f, other);
      }
    }
    JoinAll();
  }

  /// Number of the cluster of a triangle: its smallest triangle.
  [[nodiscard]] std::size_t Of(std::size_t face) { return sets_.Find(face); }

 private:
  struct Cluster {
    Vec3 normal;  ///< sum of area vectors
    double area = 0.0, perimeter = 0.0;
    std::map<std::size_t, double> shared;  ///< length of the border with each neighbour
    int version = 0;
  };
  struct Proposal {
    double cost;
    std::size_t a, b;
    int version_a, version_b;
    bool operator>(const Proposal& other) const {
      return std::tie(cost, a, b) > std::tie(other.cost, other.a, other.b);
    }
  };

  void Propose(std::size_t a, std::size_t b) {
    const Cluster& one = clusters_[a];
    const Cluster& two = clusters_[b];
    const double area = one.area + two.area;
    const double turning = 1.0 - Norm(one.normal + two.normal) / area;
    if (turning > kMostTurning) return;
    const double perimeter = one.perimeter + two.perimeter - 2.0 * one.shared.at(b);
    const double cost = turning / kMostTurning +
                        kBorderWeight * perimeter / std::sqrt(4.0 * std::numbers::pi * area);
    proposals_.push({cost, a, b, one.version, two.version});
  }

  void JoinAll() {
    while (!proposals_.empty()) {
      const Proposal best = proposals_.top();
      proposals_.pop();
      if (clusters_[best.a].version != best.version_a ||
          clusters_[best.b].version != best.version_b) {
        continue;
      }
      Join(best.a, best.b);
    }
  }

  /// `a` < `b`, so that `a` goes on to stand for both.
  void Join(std::size_t a, std::size_t b) {
    sets_.Unite(a, b);
    Cluster& kept = clusters_[a];
    Cluster gone = std::exchange(clusters_[b], {});
    clusters_[b].version = -1;
    kept.normal += gone.normal;
    kept.area += gone.area;
    kept.perimeter += gone.perimeter - 2.0 * kept.shared.at(b);
    kept.shared.erase(b);
    for (const auto& [other, length] : gone.shared) {
      if (other == a) continue;
      kept.shared[other] += length;
      std::map<std::size_t, double>& of_other = clusters_[other].shared;
      of_other.erase(b);
      of_other[a] += length;
    }
    ++kept.version;
    for (const auto& [other, length] : kept.shared) Propose(std::min(a, other), std::max(a, other));
  }

  DisjointSets sets_;
  std::vector<Cluster> clusters_;
  std::priority_queue<Proposal, std::vector<Proposal>, std::greater<>> proposals_;
};

FlatTriangle Turned(const FlatTriangle& t, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  FlatTriangle out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = {c * t[k].x - s * t[k].y, s * t[k].x + c * t[k].y};
  return out;
}

struct Extent {
  Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Vec2 high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  void Include(const FlatTriangle& t) {
    for (const Vec2& p : t) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  [[nodiscard]] Vec2 Size() const { return high - low; }
};

/// Turned so that its rectangle is small and wider than high, with the surface's area.
void Straighten(double surface_area, UvChart& chart) {
  double best_area = std::numeric_limits<double>::infinity();
  double best_angle = 0.0;
  for (int i = 0; i < kTurns; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / kTurns;
    Extent extent;
    for (const FlatTriangle& t : chart.corners) extent.Include(Turned(t, angle));
    const Vec2 size = extent.Size();
    if (size.x * size.y < best_area) {
      best_area = size.x * size.y;
      best_angle = angle + (size.y > size.x ? 0.5 * std::numbers::pi : 0.0);
    }
  }
  Extent extent;
  double flat_area = 0.0;
  for (FlatTriangle& t : chart.corners) {
    t = Turned(t, best_angle);
    extent.Include(t);
    flat_area += 0.5 * TwiceArea(t);
  }
  const double scale = std::sqrt(surface_area / flat_area);
  for (FlatTriangle& t : chart.corners) {
    for (Vec2& p : t) p = (p - extent.low) * scale;
  }
  chart.size = extent.Size() * scale;
}

class ChartMaker {
 public:
  ChartMaker(const Mesh& mesh, const Neighbors& neighbors)
      : mesh_(mesh), neighbors_(neighbors), cluster_(mesh.triangles.size(), 0) {}

  std::vector<UvChart> Run() {
    Clusters clusters(mesh_, neighbors_);
    std::map<std::size_t, std::vector<std::int32_t>> pieces;
    for (std::size_t f = 0; f < mesh_.triangles.size(); ++f) {
      pieces[clusters.Of(f)].push_back(static_cast<std::int32_t>(f));
      cluster_[f] = 1 + clusters.Of(f);
    }
    std::vector<std::vector<std::int32_t>> open;
    for (auto& [number, piece] : pieces) open.push_back(std::move(piece));
    while (!open.empty()) {
      const std::vector<std::int32_t> piece = std::move(open.back());
      open.pop_back();
      for (auto& rest : Flatten(piece)) open.push_back(std::move(rest));
    }
    return std::move(charts_);
  }

 private:
  [[nodiscard]] Vec3 AreaVector(std::int32_t f) const {
    return TwiceArea(mesh_, mesh_.triangles[Index(f)]) * 0.5;
  }

  /// Makes one chart of the connected triangles; what could not be part of it, in connected pieces.
  std::vector<std::vector<std::int32_t>> Flatten(const std::vector<std::int32_t>& piece) {
    Vec3 sum;
    for (const std::int32_t f : piece) sum += AreaVector(f);
    // Around the largest triangle that looks along with the rest.
    std::int32_t seed = piece.front();
    double most = -1.0;
    for (const std::int32_t f : piece) {
      const double along = Dot(AreaVector(f), sum);
      if (along > most) {
        most = along;
        seed = f;
      }
    }
    const Vec3 of_seed = AreaVector(seed);
    const bool fits = Dot(of_seed, sum) > 2.0 * kLeastCosine * Norm(of_seed) * Norm(sum);
    const Frame frame = Frame::FromNormal(Normalized(fits ? sum : of_seed));

    Extent extent;
    for (const std::int32_t f : piece) extent.Include(Project(f, frame));
    FlatTriangles placed(extent.low, extent.high, piece.size());
    UvChart chart;
    double area = 0.0;
    const std::size_t number = cluster_[Index(seed)];
    std::queue<std::int32_t> next;
    const auto visit = [&](std::int32_t f) {
      if (f < 0 || cluster_[Index(f)] != number) return;
      const Vec3 n = AreaVector(f);
      if (Dot(n, frame.n) < kLeastCosine * Norm(n)) return;
      const FlatTriangle flat = Project(f, frame);
      if (TwiceArea(flat) <= 0.0 || placed.Meets(flat)) return;
      placed.Add(flat);
      cluster_[Index(f)] = 0;  // done
      chart.triangles.push_back(f);
      chart.corners.push_back(flat);
      area += Norm(n);
      next.push(f);
    };
    visit(seed);
    while (!next.empty()) {
      const std::int32_t f = next.front();
      next.pop();
      for (const std::int32_t other : neighbors_[Index(f)]) visit(other);
    }
    Straighten(area, chart);
    charts_.push_back(std::move(chart));
    return Pieces(piece);
  }

  [[nodiscard]] FlatTriangle Project(std::int32_t f, const Frame& frame) const {
    FlatTriangle flat;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh_.positions[Index(mesh_.triangles[Index(f)][k])];
      flat[k] = {Dot(frame.s, p), Dot(frame.t, p)};
    }
    return flat;
  }

  /// Those of the triangles that are in no chart yet, in connected pieces with new numbers.
  std::vector<std::vector<std::int32_t>> Pieces(const std::vector<std::int32_t>& triangles) {
    std::vector<std::vector<std::int32_t>> pieces;
    for (const std::int32_t first : triangles) {
      const std::size_t old = cluster_[Index(first)];
      if (old == 0 || old > mesh_.triangles.size() + before_) continue;
      const std::size_t number = mesh_.triangles.size() + ++last_number_;
      std::vector<std::int32_t>& piece = pieces.emplace_back();
      std::vector<std::int32_t> open = {first};
      cluster_[Index(first)] = number;
      while (!open.empty()) {
        const std::int32_t f = open.back();
        open.pop_back();
        piece.push_back(f);
        for (const std::int32_t other : neighbors_[Index(f)]) {
          if (other < 0 || cluster_[Index(other)] != old) continue;
          cluster_[Index(other)] = number;
          open.push_back(other);
        }
      }
      std::ranges::sort(piece);
    }
    before_ = last_number_;
    return pieces;
  }

  const Mesh& mesh_;
  const Neighbors& neighbors_;
  std::vector<std::size_t> cluster_;  ///< number of the piece of each triangle; 0: in a chart
  std::size_t last_number_ = 0, before_ = 0;
  std::vector<UvChart> charts_;
};

}  // namespace

std::vector<UvChart> MakeUvCharts(const Mesh& mesh) {
  const Neighbors neighbors = NeighborsOf(mesh);
  return ChartMaker(mesh, neighbors).Run();
}

}  // namespace pathfit::renderer
