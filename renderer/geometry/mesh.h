#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "renderer/core/shared_vector.h"
#include "renderer/math/rgb.h"
#include "renderer/math/transform.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

using Triangle = std::array<std::int32_t, 3>;

/// Triangle mesh. Positions, normals, UVs and colours are indexed separately, so a UV or colour
/// seam never splits the surface: topology lives on positions, which are unique after
/// WeldPositions. Copies share the lists that neither changes.
struct Mesh {
  SharedVector<Vec3> positions;  ///< metres of the world
  SharedVector<Vec3> normals;    ///< shading normals, not zero, of any length; may be empty
  SharedVector<Vec2> uvs;        ///< may be empty
  SharedVector<Rgb> colors;      ///< linear base colour; may be empty

  SharedVector<Triangle> triangles;  ///< indices into positions, counter-clockwise from outside
  SharedVector<Triangle> normal_triangles;  ///< into normals; empty, or one per triangle
  SharedVector<Triangle> uv_triangles;      ///< into uvs; empty, or one per triangle
  SharedVector<Triangle> color_triangles;   ///< into colors; empty, or one per triangle

  [[nodiscard]] bool HasColors() const { return !color_triangles.empty(); }
};

/// Merges positions with bit-equal coordinates (in order of first appearance) and drops unused
/// ones.
void WeldPositions(Mesh& mesh);

/// Throws SceneError naming `name` and the first offending element: no triangle, non-finite number,
/// index out of range, a normal of length zero, position without triangle, repeated index in a
/// triangle, zero area, two triangles with the same corners, edge with more than two triangles,
/// inconsistent winding. RepairMesh (mesh_repair.h) mends what can be mended.
void ValidateMesh(const Mesh& mesh, const std::string& name);

/// Normals turn with the inverse transpose and become unit again; a reflection reverses the winding
/// of all triangles, so that a closed mesh keeps its inside. Fails: SceneError unless the transform
/// is finite and invertible.
void ApplyTransform(const Transform& world_from_object, Mesh& mesh);

/// Sphere of given radius about the origin from an icosahedron, `subdivisions` times split in four.
Mesh MakeIcosphere(int subdivisions, double radius);

/// One colour per position, all equal to `color`.
void SetUniformVertexColors(const Rgb& color, Mesh& mesh);

/// Signed volume by the divergence theorem (positive for outward winding of a closed mesh).
double SignedVolume(const Mesh& mesh);

}  // namespace pathfit::renderer
