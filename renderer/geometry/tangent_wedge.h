#pragma once

#include "renderer/geometry/edge_tree.h"

namespace pathfit::renderer {

/// Angle between the two face normals: the measure of the tangent directions of an edge is four
/// times it; pi for a border.
double WedgeAngle(const BoundaryEdge& edge);

/// A direction for which the edge is a silhouette, uniform over the solid angle of all of them
/// (both orientations): density 1 / (4 WedgeAngle) per steradian. Borders: the whole sphere.
/// [path_space 2.4]
Vec3 SampleWedge(const BoundaryEdge& edge, double u0, double u1);

}  // namespace pathfit::renderer
