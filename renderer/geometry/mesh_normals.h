#pragma once

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Smooth shading: one unit normal per position, the mean of the unit normals of its triangles
/// weighted by their angles there, so that the result does not depend on how flat parts are
/// triangulated. Where the mean vanishes (opposed triangles) the normal of one of them stands.
/// normal_triangles becomes equal to triangles. Fails: SceneError when an index is out of range.
void ComputeVertexNormals(Mesh& mesh);

/// Flat shading.
void RemoveVertexNormals(Mesh& mesh);

/// Mean over the surface of the largest angle, rad, between a triangle's own normal and those of
/// its corners; 0 for flat shading.
double MeanShadingDeviation(const Mesh& mesh);

/// Makes all normals unit, and replaces those that are zero or not finite, corner by corner, by
/// what ComputeVertexNormals gives there. Returns how many normals were replaced.
int NormalizeVertexNormals(Mesh& mesh);

}  // namespace pathfit::renderer
