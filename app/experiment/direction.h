#pragma once

#include <string>
#include <vector>

#include "renderer/scene/parameter_layout.h"

namespace pathfit::app {

/// A direction in which a scene can be changed: what `render --derivative` and `gradcheck`
/// differentiate by.
struct Direction {
  std::string name;
  renderer::ParameterLayout layout;  ///< one group, or one of every sensor
  std::vector<double> values;        ///< over the layout's scalars, per unit of the parameter
};

/// Of all numbers of many blocks together.
enum class FieldDirection {
  kOnes,    ///< 1 each
  kRandom,  ///< a fixed pseudo-random number in [-1, 1] each: one check of all of them
};

/// Directions by name. Units are those of ParameterKind: metres, radians (rotation vectors),
/// pixels.
///   OBJECT.PROPERTY       all scalars of the group, as `field` says where it has many blocks
///                         (vertices, texels ...), else 1 each. Places and rotations need a
///                         component
///   OBJECT.PROPERTY.c     this component of all blocks; c is x y z, r g b, u v, x y (focal,
///                         principal_point), 1 2 3 (distortion), 1 2 (tangential), i o (angles:
///                         inner, outer). vertices.x: the mesh moves along x
///   MESH.vertices.scale   grows about the mean of its vertices, per relative scale
///   OBJECT.PROPERTY[i]    block i alone, and OBJECT.PROPERTY[i].c one scalar
///   camera.PROPERTY...    of every sensor, unless something is called camera
///   exposure              the gain of every sensor
///   white_balance.r       the factor of red of every sensor; .b of blue
/// Throws SceneError naming what does not exist.
Direction ParseDirection(const renderer::Scene& scene,
                         const std::string& name,
                         FieldDirection field = FieldDirection::kOnes);

/// Names of directions that together move all of an unknown: its own, or one for each component
/// where it needs one. Throws SceneError as ParseDirection.
std::vector<std::string> DirectionNames(const renderer::Scene& scene, const std::string& unknown);

}  // namespace pathfit::app
