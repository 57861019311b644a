#pragma once

#include <optional>

#include "renderer/geometry/mesh.h"

namespace pathfit::optim {

/// A closed mesh with edges of about the length `edge`, metres in the mesh's own frame, on the
/// surface of the closed mesh `mesh`: long edges are split, short ones collapsed, edges turned
/// towards six neighbours each, vertices slid along the surface and put back onto it [Botsch and
/// Kobbelt 2004]. The pieces and handles of the surface stay; what is thinner than an edge gets
/// coarse. Colours are those of the nearest points, one per vertex; normals become smooth ones if
/// there were any; UVs are dropped. Same mesh, same bits. Precondition: ValidateMesh passed, every
/// edge has two triangles, edge > 0.
renderer::Mesh Remesh(const renderer::Mesh& mesh, double edge);

/// The same with edges as much shorter, down to 1/16, as it takes for the surface to stay: no place
/// of it is farther than kMostLost of `edge` from a part of the new one that looks to the same
/// side, and nothing is folded that was not. So tubes that are thinner than an edge stay tubes.
renderer::Mesh RemeshKeepingThinParts(const renderer::Mesh& mesh, double edge);

inline constexpr double kMostLost = 0.5;

/// As Remesh does, but only around edges far from the length `edge` and thin triangles, as steps of
/// an optimisation leave them; all other vertices stay as they are, and so do parts with far
/// shorter edges all over. Empty: there are none.
std::optional<renderer::Mesh> MendEdges(const renderer::Mesh& mesh, double edge);

/// Largest distance of vertices, middles of edges and of triangles of one mesh from the surface of
/// the other, both ways.
double SurfaceDistance(const renderer::Mesh& a, const renderer::Mesh& b);

}  // namespace pathfit::optim
