#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Wavefront OBJ. Read: v x y z (w is ignored) or v x y z r g b (linear, for all vertices or none),
/// vt (v up), vn, f with every index form including negative. Polygons become fans. Groups,
/// materials, smoothing, lines and points are ignored. Positions are welded; uvs and normals stay
/// only if every face has them; normals become unit, those of length zero the smooth normals of
/// their positions. Fails: IoError with file:line for other statements, numbers that are not
/// finite, indices out of range.
Mesh ReadObj(const std::filesystem::path& path);

/// The statement that names the parts of a file: o, g or usemtl.
enum class ObjGrouping { kObject, kGroup, kMaterial };

struct ObjGroup {
  std::string name;  ///< as in the file; empty for faces before the first such statement
  Mesh mesh;         ///< with its own positions
};

/// Like ReadObj, but one mesh for each name, in the order of their first faces; faces of one name
/// belong together wherever they stand. A surface that is cut by this is open there: both parts get
/// borders at the same place. Where such a cut lies on a silhouette, both would count it, so parts
/// should end at creases or gaps, or the file be read as a whole.
std::vector<ObjGroup> ReadObjGroups(const std::filesystem::path& path,
                                    ObjGrouping grouping = ObjGrouping::kMaterial);

}  // namespace pathfit::renderer
