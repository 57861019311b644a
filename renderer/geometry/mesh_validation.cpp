#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>
#include <unordered_map>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh.h"
#include "renderer/geometry/mesh_checks.h"

namespace pathfit::renderer {
namespace {

std::string TextOf(const Vec3& p) {
  std::ostringstream text;
  text.precision(6);
  text << "(" << p.x << ", " << p.y << ", " << p.z << ")";
  return text.str();
}

std::string TextOf(const Triangle& t) {
  return "(" + std::to_string(t[0]) + ", " + std::to_string(t[1]) + ", " + std::to_string(t[2]) +
         ")";
}

struct TriangleHash {
  std::size_t operator()(const Triangle& t) const {
    std::uint64_t hash = 0;
    for (const std::int32_t i : t) {
      hash = (hash ^ static_cast<std::uint64_t>(i)) * 0x9e3779b97f4a7c15ULL;
      hash ^= hash >> 32;
    }
    return hash;
  }
};

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
      if (!IsFinite(mesh_.positions[i])) {
        Fail("position " + std::to_string(i) + " is not finite: " + TextOf(mesh_.positions[i]));
      }
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
    std::unordered_map<Triangle, std::size_t, TriangleHash> first;
    first.reserve(mesh_.triangles.size());
    for (std::size_t f = 0; f < mesh_.triangles.size(); ++f) {
      const auto [entry, is_new] = first.try_emplace(SortedCorners(mesh_.triangles[f]), f);
      if (is_new) continue;
      Fail("triangle " + std::to_string(f) + " has the corners of triangle " +
           std::to_string(entry->second) + ": " + TextOf(mesh_.triangles[f]) + ", at " +
           TextOf(mesh_.positions[Index(mesh_.triangles[f][0])]));
    }
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
      if (!std::isfinite(twice_area) || !std::isfinite(longest)) {
        Fail("triangle " + std::to_string(f) + " is too large to compute its area, at " +
             TextOf(a));
      }
      if (!(twice_area > kMinRelativeArea * longest)) {
        Fail("triangle " + std::to_string(f) + " has zero area: " + TextOf(a) + ", " + TextOf(b) +
             ", " + TextOf(c));
      }
    }
  }

  void CheckEdges() const {
    struct EdgeUse {
      std::int32_t from = 0;  ///< first vertex in the winding of the first triangle
      int count = 0;
    };
    std::unordered_map<std::uint64_t, EdgeUse> uses;
    uses.reserve(mesh_.triangles.size() * 2);
    for (std::size_t f = 0; f < mesh_.triangles.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t from = mesh_.triangles[f][k];
        const std::int32_t to = mesh_.triangles[f][(k + 1) % 3];
        EdgeUse& use = uses[EdgeKey(from, to)];
        if (++use.count == 1) {
          use.from = from;
          continue;
        }
        const std::string edge = "edge (" + std::to_string(from) + ", " + std::to_string(to) +
                                 ") of triangle " + std::to_string(f) + ", from " +
                                 TextOf(mesh_.positions[Index(from)]) + " to " +
                                 TextOf(mesh_.positions[Index(to)]);
        if (use.count > 2) Fail(edge + ", has more than two triangles");
        if (use.from == from) Fail(edge + ", has two triangles of inconsistent winding");
      }
    }
  }

  const Mesh& mesh_;
  const std::string& name_;
};

}  // namespace

void ValidateMeshArrays(const Mesh& mesh, const std::string& name) {
  Validator(mesh, name).CheckArrays();
}

void ValidateMesh(const Mesh& mesh, const std::string& name) { Validator(mesh, name).CheckAll(); }

}  // namespace pathfit::renderer
