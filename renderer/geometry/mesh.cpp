#include "renderer/geometry/mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/ray.h"

namespace pathfit::renderer {
namespace {

constexpr int kMaxSubdivisions = 9;

std::uint64_t MixBits(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// The bits of a coordinate; the two zeros are one position.
std::uint64_t CoordinateBits(double v) { return std::bit_cast<std::uint64_t>(v == 0.0 ? 0.0 : v); }

using PositionKey = std::array<std::uint64_t, 3>;

struct PositionKeyHash {
  std::size_t operator()(const PositionKey& key) const {
    return MixBits(key[0] + MixBits(key[1] + MixBits(key[2])));
  }
};

std::string TextOf(const Triangle& t) {
  return "(" + std::to_string(t[0]) + ", " + std::to_string(t[1]) + ", " + std::to_string(t[2]) +
         ")";
}

Mesh MakeIcosahedron() {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  Mesh mesh;
  // Three golden rectangles, one in each coordinate plane.
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) {
      mesh.positions.push_back({0.0, a, b});
      mesh.positions.push_back({a, b, 0.0});
      mesh.positions.push_back({b, 0.0, a});
    }
  }
  // Faces are the triples of vertices at the edge length, 2; wound away from the origin.
  const auto adjacent = [&mesh](std::int32_t i, std::int32_t j) {
    return SquaredNorm(mesh.positions[Index(i)] - mesh.positions[Index(j)]) < 4.5;
  };
  for (std::int32_t i = 0; i < 12; ++i) {
    for (std::int32_t j = i + 1; j < 12; ++j) {
      for (std::int32_t k = j + 1; k < 12; ++k) {
        if (!adjacent(i, j) || !adjacent(j, k) || !adjacent(k, i)) continue;
        const double orientation = Dot(mesh.positions[Index(i)],
                                       Cross(mesh.positions[Index(j)], mesh.positions[Index(k)]));
        mesh.triangles.push_back(orientation > 0.0 ? Triangle{i, j, k} : Triangle{i, k, j});
      }
    }
  }
  return mesh;
}

/// Splits each triangle in four at the midpoints of its edges.
void SplitTriangles(Mesh& mesh) {
  std::unordered_map<std::uint64_t, std::int32_t> midpoints;
  const auto midpoint = [&](std::int32_t a, std::int32_t b) {
    const auto next = static_cast<std::int32_t>(mesh.positions.size());
    const auto [entry, is_new] = midpoints.try_emplace(EdgeKey(a, b), next);
    if (is_new) {
      mesh.positions.push_back((mesh.positions[Index(a)] + mesh.positions[Index(b)]) * 0.5);
    }
    return entry->second;
  };
  std::vector<Triangle> finer;
  finer.reserve(mesh.triangles.size() * 4);
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::int32_t ab = midpoint(a, b);
    const std::int32_t bc = midpoint(b, c);
    const std::int32_t ca = midpoint(c, a);
    finer.push_back({a, ab, ca});
    finer.push_back({ab, b, bc});
    finer.push_back({ca, bc, c});
    finer.push_back({ab, bc, ca});
  }
  mesh.triangles = std::move(finer);
}

std::string TextOf(const Vec3& p) {
  std::ostringstream text;
  text.precision(6);
  text << "(" << p.x << ", " << p.y << ", " << p.z << ")";
  return text.str();
}

/// Checks of one mesh; each Check function throws at its first offending element.
class Validator {
 public:
  Validator(const Mesh& mesh, const std::string& name) : mesh_(mesh), name_(name) {}

  void CheckAll() const {
    CheckArrays();
    CheckNormalLengths();
    CheckUse();
    CheckShapes();
    CheckDuplicates();
    CheckEdges();
  }

  void CheckArrays() const {
    if (mesh_.triangles.empty()) Fail("it has no triangle");
    CheckNumbers();
    CheckIndices(mesh_.triangles, mesh_.positions.size(), "position");
    CheckAttribute(mesh_.normal_triangles, mesh_.normals.size(), "normal");
    CheckAttribute(mesh_.uv_triangles, mesh_.uvs.size(), "uv");
    CheckAttribute(mesh_.color_triangles, mesh_.colors.size(), "color");
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw SceneError("mesh '" + name_ + "': " + what);
  }

  void CheckNumbers() const {
    for (std::size_t i = 0; i < mesh_.positions.size(); ++i) {
      const Vec3& p = mesh_.positions[i];
      if (IsWithinBounds(p)) continue;
      Fail("position " + std::to_string(i) +
           (IsFinite(p) ? " is beyond 1e12 metres: " : " is not finite: ") + TextOf(p));
    }
    for (std::size_t i = 0; i < mesh_.normals.size(); ++i) {
      if (!IsFinite(mesh_.normals[i])) Fail("normal " + std::to_string(i) + " is not finite");
    }
    for (std::size_t i = 0; i < mesh_.uvs.size(); ++i) {
      if (!std::isfinite(mesh_.uvs[i].x) || !std::isfinite(mesh_.uvs[i].y)) {
        Fail("uv " + std::to_string(i) + " is not finite");
      }
    }
    for (std::size_t i = 0; i < mesh_.colors.size(); ++i) {
      if (!IsFinite(mesh_.colors[i])) Fail("color " + std::to_string(i) + " is not finite");
    }
  }

  void CheckIndices(const std::vector<Triangle>& triangles,
                    std::size_t count,
                    const char* kind) const {
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      if (!IsInRange(triangles[f], count)) {
        Fail("triangle " + std::to_string(f) + " has " + kind + " indices " + TextOf(triangles[f]) +
             ", allowed are 0 to below " + std::to_string(count));
      }
    }
  }

  void CheckAttribute(const std::vector<Triangle>& triangles,
                      std::size_t count,
                      const char* kind) const {
    if (!triangles.empty() && triangles.size() != mesh_.triangles.size()) {
      Fail(std::string("it has ") + std::to_string(triangles.size()) + " " + kind +
           " triangles for " + std::to_string(mesh_.triangles.size()) +
           " triangles; allowed are none or one for each");
    }
    CheckIndices(triangles, count, kind);
  }

  void CheckNormalLengths() const {
    for (std::size_t f = 0; f < mesh_.normal_triangles.size(); ++f) {
      for (const std::int32_t i : mesh_.normal_triangles[f]) {
        if (SquaredNorm(mesh_.normals[Index(i)]) == 0.0) {
          Fail("normal " + std::to_string(i) + " of triangle " + std::to_string(f) + " is zero");
        }
      }
    }
  }

  void CheckUse() const {
    std::vector<bool> is_used(mesh_.positions.size(), false);
    for (const Triangle& triangle : mesh_.triangles) {
      for (const std::int32_t i : triangle) is_used[Index(i)] = true;
    }
    const auto unused = std::find(is_used.begin(), is_used.end(), false);
    if (unused == is_used.end()) return;
    const auto i = static_cast<std::size_t>(unused - is_used.begin());
    Fail("position " + std::to_string(i) + ", " + TextOf(mesh_.positions[i]) +
         ", is used by no triangle");
  }

  void CheckDuplicates() const {
    std::vector<std::pair<Triangle, std::size_t>> sorted;
    sorted.reserve(mesh_.triangles.size());
    for (std::size_t f = 0; f < mesh_.triangles.size(); ++f) {
      sorted.emplace_back(SortedCorners(mesh_.triangles[f]), f);
    }
    std::sort(sorted.begin(), sorted.end());
    std::size_t copy = mesh_.triangles.size();
    std::size_t original = 0;
    for (std::size_t i = 1, first = 0; i < sorted.size(); ++i) {
      if (sorted[i].first != sorted[first].first) {
        first = i;
      } else if (sorted[i].second < copy) {
        copy = sorted[i].second;
        original = sorted[first].second;
      }
    }
    if (copy == mesh_.triangles.size()) return;
    Fail("triangle " + std::to_string(copy) + " has the corners of triangle " +
         std::to_string(original) + ": " + TextOf(mesh_.triangles[copy]) + ", at " +
         TextOf(mesh_.positions[Index(mesh_.triangles[copy][0])]));
  }

  void CheckShapes() const {
    for (std::size_t f = 0; f < mesh_.triangles.size(); ++f) {
      const Triangle& t = mesh_.triangles[f];
      const Vec3& a = mesh_.positions[Index(t[0])];
      const Vec3& b = mesh_.positions[Index(t[1])];
      const Vec3& c = mesh_.positions[Index(t[2])];
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        Fail("triangle " + std::to_string(f) + " repeats a vertex: " + TextOf(t) + ", at " +
             TextOf(a));
      }
      const double longest = SquaredLongestEdge(mesh_, t);
      const double twice_area = Norm(TwiceArea(mesh_, t));
      if (!(twice_area > kMinRelativeArea * longest)) {
        Fail("triangle " + std::to_string(f) + " has zero area: " + TextOf(a) + ", " + TextOf(b) +
             ", " + TextOf(c));
      }
    }
  }

  void CheckEdges() const {
    const std::vector<MeshSide> sides = SortedSides(mesh_);
    const MeshSide* bad = nullptr;
    bool is_third = false;
    ForEachEdge(sides, [&](auto first, auto last) {
      for (auto side = first + 1; side < last; ++side) {
        const bool beyond_two = side - first > 1;
        if (!beyond_two && side->From(mesh_) != first->From(mesh_)) continue;
        if (bad != nullptr && bad->side < side->side) return;
        bad = &*side;
        is_third = beyond_two;
        return;
      }
    });
    if (bad == nullptr) return;
    const std::int32_t from = bad->From(mesh_);
    const std::int32_t to = bad->To(mesh_);
    Fail("edge (" + std::to_string(from) + ", " + std::to_string(to) + ") of triangle " +
         std::to_string(bad->Face()) + ", from " + TextOf(mesh_.positions[Index(from)]) + " to " +
         TextOf(mesh_.positions[Index(to)]) +
         (is_third ? ", has more than two triangles"
                   : ", has two triangles of inconsistent winding"));
  }

  const Mesh& mesh_;
  const std::string& name_;
};

}  // namespace

void WeldPositions(Mesh& mesh) {
  std::vector<bool> is_used(mesh.positions.size(), false);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    if (!IsInRange(mesh.triangles[f], mesh.positions.size())) {
      throw SceneError("triangle " + std::to_string(f) + " has position indices " +
                       TextOf(mesh.triangles[f]) + ", allowed are 0 to below " +
                       std::to_string(mesh.positions.size()));
    }
    for (const std::int32_t i : mesh.triangles[f]) is_used[Index(i)] = true;
  }
  std::unordered_map<PositionKey, std::int32_t, PositionKeyHash> welded;
  welded.reserve(mesh.positions.size());
  std::vector<std::int32_t> new_index(mesh.positions.size(), -1);
  std::vector<Vec3> positions;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    if (!is_used[i]) continue;
    const Vec3& p = mesh.positions[i];
    const PositionKey key = {CoordinateBits(p.x), CoordinateBits(p.y), CoordinateBits(p.z)};
    const auto [entry, is_new] =
        welded.try_emplace(key, static_cast<std::int32_t>(positions.size()));
    if (is_new) positions.push_back(p);
    new_index[i] = entry->second;
  }
  for (Triangle& triangle : mesh.triangles) {
    for (std::int32_t& i : triangle) i = new_index[Index(i)];
  }
  mesh.positions = std::move(positions);
}

void ValidateMeshArrays(const Mesh& mesh, const std::string& name) {
  Validator(mesh, name).CheckArrays();
}

void ValidateMesh(const Mesh& mesh, const std::string& name) { Validator(mesh, name).CheckAll(); }

void ApplyTransform(const Transform& world_from_object, Mesh& mesh) {
  const Mat3& m = world_from_object.linear;
  const double determinant = Determinant(m);
  if (!std::isfinite(determinant) || determinant == 0.0 ||
      !IsFinite(world_from_object.translation)) {
    throw SceneError("a mesh transform must be finite and invertible");
  }
  for (Vec3& p : mesh.positions) p = world_from_object.Point(p);
  // The inverse transpose up to a positive factor.
  const double sign = determinant > 0.0 ? 1.0 : -1.0;
  const Mat3 cofactors = {Cross(m.y, m.z) * sign, Cross(m.z, m.x) * sign, Cross(m.x, m.y) * sign};
  for (Vec3& n : mesh.normals) {
    const Vec3 moved = cofactors * n;
    const double length = Norm(moved);
    if (length > 0.0) n = moved / length;
  }
  if (determinant > 0.0) return;
  // A reflection turns triangles inside out.
  ForEachTriangleList(mesh, [](std::vector<Triangle>& triangles) {
    for (Triangle& triangle : triangles) std::swap(triangle[1], triangle[2]);
  });
}

Mesh MakeIcosphere(int subdivisions, double radius) {
  if (subdivisions < 0 || subdivisions > kMaxSubdivisions) {
    throw SceneError("icosphere: subdivisions is " + std::to_string(subdivisions) +
                     ", allowed are 0 to " + std::to_string(kMaxSubdivisions));
  }
  if (!std::isfinite(radius) || radius <= 0.0) {
    throw SceneError("icosphere: radius must be positive and finite");
  }
  Mesh mesh = MakeIcosahedron();
  for (int i = 0; i < subdivisions; ++i) {
    SplitTriangles(mesh);
    for (Vec3& p : mesh.positions) p = Normalized(p);
  }
  for (Vec3& p : mesh.positions) p = Normalized(p) * radius;
  return mesh;
}

void SetUniformVertexColors(const Rgb& color, Mesh& mesh) {
  mesh.colors.assign(mesh.positions.size(), color);
  mesh.color_triangles = mesh.triangles;
}

double SignedVolume(const Mesh& mesh) {
  double six_volumes = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    six_volumes +=
        Dot(mesh.positions[Index(a)], Cross(mesh.positions[Index(b)], mesh.positions[Index(c)]));
  }
  return six_volumes / 6.0;
}

}  // namespace pathfit::renderer
