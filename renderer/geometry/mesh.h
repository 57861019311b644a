#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "renderer/core/shared_vector.h"
#include "renderer/math/rgb.h"
#include "renderer/math/transform.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Indices of the three corners into a list, from 0.
using Triangle = std::array<std::int32_t, 3>;

/// Triangle mesh. Positions, normals, UVs and colours are indexed separately, so a UV or colour
/// seam never splits the surface: topology lives on positions, which are unique after
/// WeldPositions. Corner i of triangle f is at positions[triangles[f][i]] and has the UV
/// uvs[uv_triangles[f][i]], and likewise the others; inside a triangle all of them are interpolated
/// linearly. Two triangles are neighbours if they share two positions by index.
///
/// Coordinates are in metres, in the frame of whoever holds the mesh: the object's in a SceneMesh,
/// the world's in a World. Outside is where the corners are seen counter-clockwise.
///
/// A default mesh is empty and not valid. Copies share the lists that neither changes.
struct Mesh {
  SharedVector<Vec3> positions;  ///< metres
  SharedVector<Vec3> normals;    ///< shading normals, not zero, of any length; empty: flat
  SharedVector<Vec2> uvs;        ///< of Texture: u right, v up; empty: no texture can be used
  SharedVector<Rgb> colors;      ///< linear base colour, 0..1; may be empty

  SharedVector<Triangle> triangles;         ///< into positions, counter-clockwise from outside
  SharedVector<Triangle> normal_triangles;  ///< into normals; empty, or one per triangle
  SharedVector<Triangle> uv_triangles;      ///< into uvs; empty, or one per triangle
  SharedVector<Triangle> color_triangles;   ///< into colors; empty, or one per triangle

  [[nodiscard]] bool HasColors() const { return !color_triangles.empty(); }
};

/// Merges positions with bit-equal coordinates (0 and -0 are equal) and drops unused ones; the rest
/// keep their order. Normals, UVs and colours are left as they are. Fails: SceneError for an index
/// out of range.
void WeldPositions(Mesh& mesh);

/// Throws SceneError naming `name` and the first offending element: no triangle, non-finite number,
/// index out of range, a normal of length zero, position without triangle, repeated index in a
/// triangle, zero area, two triangles with the same corners, edge with more than two triangles,
/// inconsistent winding. RepairMesh (mesh_repair.h) mends what can be mended.
void ValidateMesh(const Mesh& mesh, const std::string& name);

/// Positions become world_from_object.Point(position). Normals turn with the inverse transpose and
/// become unit again; a reflection reverses the winding of all triangles, so that a closed mesh
/// keeps its inside. Fails: SceneError unless the transform is finite and invertible.
void ApplyTransform(const Transform& world_from_object, Mesh& mesh);

/// Sphere about the origin from an icosahedron, each triangle split in four `subdivisions` times:
/// 20 * 4^subdivisions triangles, positions only. Fails: SceneError unless the radius is finite and
/// positive and the subdivisions are from 0 to 9.
Mesh MakeIcosphere(int subdivisions, double radius);

/// Replaces the colours by one per position, all equal to `color`.
void SetUniformVertexColors(const Rgb& color, Mesh& mesh);

/// Volume inside a closed mesh in cubic metres, by the divergence theorem: negative if the winding
/// is inside out. Of an open mesh it depends on where the origin is and means nothing.
double SignedVolume(const Mesh& mesh);

}  // namespace pathfit::renderer
