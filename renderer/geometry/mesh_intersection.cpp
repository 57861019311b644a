#include "renderer/geometry/mesh_intersection.h"

#include <algorithm>

#include "renderer/geometry/ray_caster.h"

namespace pathfit::renderer {
namespace {

struct Box {
  Vec3 low, high;
};

Box BoxOf(const Mesh& mesh) {
  Box box{mesh.positions.front(), mesh.positions.front()};
  for (const Vec3& p : mesh.positions) {
    for (int i = 0; i < 3; ++i) {
      box.low[i] = std::min(box.low[i], p[i]);
      box.high[i] = std::max(box.high[i], p[i]);
    }
  }
  return box;
}

bool Overlap(const Box& a, const Box& b) {
  const double slack = kTouchDepth * (Norm(a.high - a.low) + Norm(b.high - b.low));
  for (int i = 0; i < 3; ++i) {
    if (a.high[i] + slack < b.low[i] || b.high[i] + slack < a.low[i]) {
      return false;
    }
  }
  return true;
}

double LongestSide(const TriangleGeometry& t) {
  return std::max({Norm(t.e1), Norm(t.e2), Norm(t.e2 - t.e1)});
}

/// Whether the edge from a to b passes through the one mesh of `other`.
bool Pierces(const Vec3& a, const Vec3& b, double depth, const RayCaster& other) {
  const double length = Norm(b - a);
  const auto hit = other.Intersect({a, (b - a) * (1.0 / length)});
  if (!hit || hit->distance >= length) {
    return false;
  }
  const TriangleGeometry& face = other.Geometry(hit->id);
  const Vec3 x = face.Point(hit->b1, hit->b2);
  // Edges of a solid that stands on another lie in the border of its faces.
  const double inside =
      std::min({hit->b1, hit->b2, 1.0 - hit->b1 - hit->b2}) * face.double_area / LongestSide(face);
  const double at_a = Dot(face.n, a - x);
  const double at_b = Dot(face.n, b - x);
  return at_a * at_b < 0.0 && std::min({std::abs(at_a), std::abs(at_b), inside}) > depth;
}

/// Whether the edge, longer by `depth` at both ends, meets the one mesh of `other`.
bool Reaches(const Vec3& a, const Vec3& b, double depth, const RayCaster& other) {
  const double length = Norm(b - a);
  const Vec3 along = (b - a) * (1.0 / length);
  const auto hit = other.Intersect({a - along * depth, along});
  return hit && hit->distance <= length + 2.0 * depth;
}

enum class Contact { kNone, kTouch, kCut };

/// What the edges of `mesh` do to the one mesh of `other`.
Contact ContactOfEdges(const Mesh& mesh, const RayCaster& other, double depth) {
  Contact contact = Contact::kNone;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = mesh.positions[static_cast<std::size_t>(t[i])];
      const Vec3& b = mesh.positions[static_cast<std::size_t>(t[(i + 1) % 3])];
      if (!(Norm(b - a) > 0.0)) {
        continue;
      }
      if (Pierces(a, b, depth, other)) {
        return Contact::kCut;
      }
      if (contact == Contact::kNone && Reaches(a, b, std::max(depth, other.Offset(a)), other)) {
        contact = Contact::kTouch;
      }
    }
  }
  return contact;
}

}  // namespace

std::vector<MeshContact> MeshContacts(const std::vector<const Mesh*>& meshes) {
  std::vector<Box> boxes;
  for (const Mesh* mesh : meshes) {
    boxes.push_back(BoxOf(*mesh));
  }
  std::vector<RayCaster> casters(meshes.size());
  std::vector<bool> built(meshes.size(), false);
  const auto caster = [&](std::size_t i) -> const RayCaster& {
    if (!built[i]) {
      casters[i].Build({meshes[i]});
      built[i] = true;
    }
    return casters[i];
  };
  std::vector<MeshContact> contacts;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    for (std::size_t j = i + 1; j < meshes.size(); ++j) {
      if (!Overlap(boxes[i], boxes[j])) {
        continue;
      }
      const double depth = kTouchDepth * std::min(caster(i).Extent(), caster(j).Extent());
      Contact contact = ContactOfEdges(*meshes[i], caster(j), depth);
      if (contact != Contact::kCut) {
        contact = std::max(contact, ContactOfEdges(*meshes[j], caster(i), depth));
      }
      if (contact != Contact::kNone) {
        contacts.push_back({static_cast<int>(i), static_cast<int>(j), contact == Contact::kCut});
      }
    }
  }
  return contacts;
}

}  // namespace pathfit::renderer
