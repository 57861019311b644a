#pragma once

#include <array>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Frame of a normal map at a corner: u runs along `along_u` (unit, at right angles to the normal),
/// v along sign * cross(normal, along_u).
struct Tangent {
  Vec3 along_u{1.0, 0.0, 0.0};
  double sign = 1.0;  ///< 1 or -1
};

/// By triangle and corner: the mean of the directions of u in the triangles that share position,
/// normal and UV, weighted by their angles there, as MikkTSpace has it. Precondition: the mesh has
/// normals and UVs.
std::vector<std::array<Tangent, 3>> MakeTangents(const Mesh& mesh);

/// Normal and tangent frame inside a triangle: rows u, v, normal, each unit.
struct ShadingFrame {
  Vec3 u, v, normal;
};
ShadingFrame InterpolateFrame(const Mesh& mesh,
                              std::int32_t triangle,
                              const std::array<Tangent, 3>& tangents,
                              const std::array<double, 3>& weights);

}  // namespace pathfit::renderer
