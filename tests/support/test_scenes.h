#pragma once

#include "renderer/scene/scene.h"

namespace pathfit::tests {

/// [-1,1]^2 in z = 0, normal +z.
renderer::Mesh Rectangle();
/// [-1,1]^3, outward.
renderer::Mesh Cube();

renderer::Camera CameraAt(const renderer::Vec3& origin,
                          const renderer::Vec3& target,
                          double focal_px,
                          int width,
                          int height);

/// Smooth colourful environment of w x h texels.
renderer::Emitter GradientEnvironment(int width, int height);
renderer::Emitter ConstantEnvironment(const renderer::Rgb& radiance);

/// An icosphere with varying vertex colours (mesh 0, material 0) in front of a large tilted
/// rectangle (mesh 1, material 1: metallic-roughness), lit by an environment, a point and a
/// directional light; one 24 x 24 sensor.
renderer::Scene BallAndWall();

/// A wavy square over [-1, 1]^2 facing +z, smooth, metallic-roughness, with crooked UVs and the
/// normal texture 'bumps', under a directional light; nothing of it turns away from viewers near
/// the z axis.
renderer::Scene Waves();

}  // namespace pathfit::tests
