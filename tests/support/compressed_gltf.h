#pragma once

#include <string>

namespace pathfit::tests {

/// The GLB with all vertex data by EXT_meshopt_compression, what is not compressed being left out.
/// `filtered`: positions and UVs by the exponential filter, 15 bits, and normals by the octahedral
/// one as normalised shorts.
std::string WithMeshopt(const std::string& glb, bool filtered);

/// The GLB with all meshes by KHR_draco_mesh_compression, positions in `bits` bits (0: as they are,
/// in the order they have).
std::string WithDraco(const std::string& glb, int bits);

}  // namespace pathfit::tests
