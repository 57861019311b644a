#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Triangles of one polygon as indices into its corners, wound as the polygon.
using FanTriangles = std::vector<std::array<std::size_t, 3>>;

/// Fan from the first corner that sees the whole polygon: corner 0 when it is convex. Corners of
/// polygons (not of triangles) that coincide with the one before count once. Degenerate polygons
/// are kept for ValidateMesh to name. Empty when no corner sees the whole polygon.
std::optional<FanTriangles> TriangulatePolygon(std::span<const Vec3> corners);

/// What every reader does at the end: welds positions, then colours (without colour seams
/// color_triangles becomes equal to triangles), and makes normals unit. Fails: SceneError when an
/// index is out of range.
void FinishMesh(Mesh& mesh);

/// Adds the triangles of `other`. Normals, UVs and colours stay only if both have them; positions
/// are not welded.
void AppendMesh(const Mesh& other, Mesh& mesh);

/// One vertex of a file format with a single index: indices into the mesh's arrays, -1 for an
/// absent attribute.
struct SplitVertex {
  std::int32_t position = -1;
  std::int32_t normal = -1;
  std::int32_t uv = -1;
  std::int32_t color = -1;
  friend auto operator<=>(const SplitVertex&, const SplitVertex&) = default;
};

struct SplitMesh {
  std::vector<SplitVertex> vertices;  ///< ascending: one per position keeps the positions' order
  std::vector<Triangle> triangles;    ///< indices into vertices
};

/// Repeats a position where normals, UVs or colours differ between its triangles. Fails: SceneError
/// when indices are out of range or attribute triangles do not match.
SplitMesh SplitVertices(const Mesh& mesh);

/// `value` as float. Fails: IoError naming `path` when it is not finite or too large.
float StoredFloat(double value, const std::filesystem::path& path);

}  // namespace pathfit::renderer
