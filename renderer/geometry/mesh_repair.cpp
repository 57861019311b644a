#include "renderer/geometry/mesh_repair.h"

#include <cmath>
#include <cstddef>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_topology.h"

namespace pathfit::renderer {
namespace {

/// Welds and counts.
void WeldCounted(Mesh& mesh, MeshRepairs& repairs) {
  std::vector<bool> is_used(mesh.positions.size(), false);
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::int32_t i : triangle) is_used[Index(i)] = true;
  }
  const auto num_used = static_cast<int>(std::count(is_used.begin(), is_used.end(), true));
  repairs.unused_positions += static_cast<int>(mesh.positions.size()) - num_used;
  WeldPositions(mesh);
  repairs.merged_positions += num_used - static_cast<int>(mesh.positions.size());
}

bool IsDegenerate(const Mesh& mesh, const Triangle& t) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  return Norm(TwiceArea(mesh, t)) <= kMinRelativeArea * SquaredLongestEdge(mesh, t);
}

void KeepTriangles(const std::vector<bool>& keep, Mesh& mesh) {
  ForEachTriangleList(mesh, [&keep](std::vector<Triangle>& list) {
    std::size_t kept = 0;
    for (std::size_t f = 0; f < list.size(); ++f) {
      if (keep[f]) list[kept++] = list[f];
    }
    list.resize(kept);
  });
}

void DropDegenerate(Mesh& mesh, MeshRepairs& repairs) {
  std::vector<bool> keep(mesh.triangles.size());
  for (std::size_t f = 0; f < keep.size(); ++f) {
    keep[f] = !IsDegenerate(mesh, mesh.triangles[f]);
    repairs.degenerate_triangles += keep[f] ? 0 : 1;
  }
  KeepTriangles(keep, mesh);
}

/// Whether two triangles with the same corners are a fold that hangs on a surface which closes
/// without it: on each edge there is nothing else, or just two single triangles that fit.
class FoldFinder {
 public:
  FoldFinder(const Mesh& mesh, const std::vector<bool>& is_single)
      : mesh_(mesh), is_single_(is_single), sides_(SortedSides(mesh)) {}

  [[nodiscard]] bool IsFold(std::size_t a, std::size_t b) const {
    bool hangs = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = mesh_.triangles[a][k];
      const std::uint64_t edge = EdgeKey(from, mesh_.triangles[a][(k + 1) % 3]);
      std::vector<MeshSide> others;
      for (auto side = std::lower_bound(
               sides_.begin(),
               sides_.end(),
               edge,
               [](const MeshSide&s, std::uint64_t wanted) { return s.edge < wanted; });
           side != sides_.end() && side->edge == edge;
           ++side) {
        // A pair of equal winding is a copy, not a fold.
        if (side->Face() == b && side->From(mesh_) == from) return false;
        if (side->Face() != a && side->Face() != b) others.push_back(*side);
        if (others.size() > 2) return false;
      }
      if (others.empty()) continue;
      if (others.size() != 2 || others[0].From(mesh_) == others[1].From(mesh_) ||
          !is_single_[others[0].Face()] || !is_single_[others[1].Face()]) {
        return false;
      }
      hangs = true;
    }
    return hangs;
  }

 private:
  const Mesh& mesh_;
  const std::vector<bool>& is_single_;
  std::vector<MeshSide> sides_;
};

void DropDuplicates(Mesh& mesh, MeshRepairs& repairs) {
  std::map<Triangle, std::vector<std::size_t>> copies;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    copies[SortedCorners(mesh.triangles[f])].push_back(f);
  }
  if (copies.size() == mesh.triangles.size()) return;
  std::vector<bool> is_single(mesh.triangles.size(), false);
  for (const auto& [corners, faces] : copies) {
    if (faces.size() == 1) is_single[faces[0]] = true;
  }
  const FoldFinder folds(mesh, is_single);
  std::vector<bool> keep(mesh.triangles.size(), true);
  for (const auto& [corners, faces] : copies) {
    const bool is_fold = faces.size() == 2 && folds.IsFold(faces[0], faces[1]);
    for (std::size_t i = is_fold ? 0 : 1; i < faces.size(); ++i) keep[faces[i]] = false;
    (is_fold ? repairs.folded_triangles : repairs.duplicate_triangles) +=
        static_cast<int>(faces.size()) - (is_fold ? 0 : 1);
  }
  KeepTriangles(keep, mesh);
}

/// Triangles joined by edges with exactly two triangles.
struct Neighbor {
  std::size_t face;
  bool is_opposed;  ///< the two windings disagree
};

std::vector<std::vector<Neighbor>> ManifoldNeighbors(const Mesh& mesh) {
  std::vector<std::vector<Neighbor>> neighbors(mesh.triangles.size());
  const std::vector<MeshSide> sides = SortedSides(mesh);
  ForEachEdge(sides, [&](auto first, auto last) {
    if (last - first != 2) return;
    const auto second = first + 1;
    const bool is_opposed = first->From(mesh) == second->From(mesh);
    neighbors[first->Face()].push_back({second->Face(), is_opposed});
    neighbors[second->Face()].push_back({first->Face(), is_opposed});
  });
  return neighbors;
}

/// Reverses triangles so that each connected surface is wound one way.
void OrientTriangles(const std::string& name, Mesh& mesh, MeshRepairs& repairs) {
  const std::vector<std::vector<Neighbor>> neighbors = ManifoldNeighbors(mesh);
  enum class State : char { kUnseen, kKept, kTurned };
  std::vector<State> states(mesh.triangles.size(), State::kUnseen);
  for (std::size_t seed = 0; seed < states.size(); ++seed) {
    if (states[seed] != State::kUnseen) continue;
    states[seed] = State::kKept;
    std::vector<std::size_t> surface = {seed};
    std::size_t num_turned = 0;
    for (std::size_t next = 0; next < surface.size(); ++next) {
      const std::size_t face = surface[next];
      for (const Neighbor& neighbor : neighbors[face]) {
        const bool turn = (states[face] == State::kTurned) != neighbor.is_opposed;
        const State wanted = turn ? State::kTurned : State::kKept;
        if (states[neighbor.face] == State::kUnseen) {
          states[neighbor.face] = wanted;
          num_turned += turn ? 1 : 0;
          surface.push_back(neighbor.face);
        } else if (states[neighbor.face] != wanted) {
          throw SceneError("mesh '" + name +
                           "': a surface has one side only, its windings cannot agree");
        }
      }
    }
    const bool turn_others = 2 * num_turned > surface.size();
    repairs.turned_triangles +=
        static_cast<int>(turn_others ? surface.size() - num_turned : num_turned);
    for (const std::size_t face : surface) {
      if ((states[face] == State::kTurned) == turn_others) continue;
      ForEachTriangleList(mesh, [face](std::vector<Triangle>& list) {
        if (!list.empty()) std::swap(list[face][1], list[face][2]);
      });
    }
  }
}

/// Gives each sheet its own positions on edges with more than two triangles.
void CutSheets(Mesh& mesh, MeshRepairs& repairs) {
  const CornerFans fans = CornerFans::Build(mesh);
  if (fans.non_manifold_edges.empty()) return;
  repairs.cut_edges += static_cast<int>(fans.non_manifold_edges.size());
  std::vector<bool> is_cut(mesh.positions.size(), false);
  for (const auto& [low, high] : fans.non_manifold_edges) {
    is_cut[Index(low)] = is_cut[Index(high)] = true;
  }
  struct Sheet {
    std::int32_t position;
    Vec3 sum;  ///< of the middles of its triangles
    int count = 0;
  };
  std::vector<std::size_t> first_fan(mesh.positions.size(), fans.fan.size());
  std::unordered_map<std::size_t, Sheet> sheets;
  const std::vector<Vec3> old = mesh.positions;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle before = mesh.triangles[f];
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t& position = mesh.triangles[f][k];
      if (!is_cut[Index(position)]) continue;
      const std::size_t fan = fans.fan[3 * f + k];
      std::size_t& first = first_fan[Index(position)];
      if (first == fans.fan.size()) first = fan;
      if (first == fan) continue;
      const auto [entry, is_new] =
          sheets.try_emplace(fan, Sheet{static_cast<std::int32_t>(mesh.positions.size()), {}, 0});
      if (is_new) mesh.positions.push_back(old[Index(position)]);
      for (const std::int32_t corner : before) {
        // The copies move towards the middle of where the sheet was before any cut.
        entry->second.sum += (old[Index(corner)] - old[Index(position)]) / 3.0;
      }
      ++entry->second.count;
      position = entry->second.position;
    }
  }
  for (const auto& [fan, sheet] : sheets) {
    mesh.positions[Index(sheet.position)] += sheet.sum * (kCutGap / sheet.count);
  }
  repairs.added_positions += static_cast<int>(sheets.size());
}

}  // namespace

std::string Describe(const MeshRepairs& repairs) {
  std::string text;
  const auto add = [&text](int count, const char* one, const char* many, const char* what) {
    if (count == 0) return;
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + (count == 1 ? one : many) +
            " " + what;
  };
  add(repairs.merged_positions, "position", "positions", "merged");
  add(repairs.unused_positions, "unused position", "unused positions", "dropped");
  add(repairs.replaced_normals, "normal", "normals", "of length zero replaced");
  add(repairs.degenerate_triangles, "triangle", "triangles", "without area dropped");
  add(repairs.duplicate_triangles, "duplicate triangle", "duplicate triangles", "dropped");
  add(repairs.folded_triangles, "triangle", "triangles", "in folds dropped");
  add(repairs.turned_triangles, "triangle", "triangles", "turned to agree with the others");
  add(repairs.cut_edges, "edge", "edges", "with more than two triangles cut");
  add(repairs.added_positions, "position", "positions", "added by that");
  return text;
}

Mesh RepairMesh(Mesh mesh, const std::string& name, MeshRepairs* repairs) {
  ValidateMeshArrays(mesh, name);
  MeshRepairs done;
  WeldCounted(mesh, done);
  done.replaced_normals = NormalizeVertexNormals(mesh);
  DropDegenerate(mesh, done);
  DropDuplicates(mesh, done);
  OrientTriangles(name, mesh, done);
  CutSheets(mesh, done);
  const auto before = static_cast<int>(mesh.positions.size());
  WeldPositions(mesh);
  done.unused_positions += before - static_cast<int>(mesh.positions.size());
  ValidateMesh(mesh, name);
  if (repairs != nullptr) *repairs = done;
  return mesh;
}

}  // namespace pathfit::renderer
