#pragma once

#include <vector>

#include "renderer/derivative/appearance_adjoint.h"
#include "renderer/derivative/path_adjoint.h"

namespace pathfit::renderer {

/// Moves the adjoint of a unit vector (b - a) / r to its end point b; the start point receives the
/// negative.
inline ColorGradient EndPointAdjoint(const Vec3& unit, double r, const ColorGradient& adjoint) {
  return (adjoint - Outer(unit, Dot(unit, adjoint))) * (1.0 / r);
}

/// Adds the adjoint of the place where the ray to the next vertex starts: beside its vertex, with
/// whose normal it turns. Without that what moves as a whole has a derivative of the lift's size.
inline void MoveStart(const RayCaster& caster, PathRecorder::Vertex& v, const ColorGradient& d) {
  v.d_x += d;
  v.d_ng += d * RayLift(caster, v.p, v.on.wi);
}

/// Turns the adjoints that a sweep left in a path's vertices (positions, normals, directions) into
/// parameters: image points up to the first rough vertex, material points behind it.
class GeometryScatter {
 public:
  using Motion = MotionAdjoint<ColorGradient, AccumulatorTarget>;
  struct Refers {
    AdjointContext context;
    const PixelSample& pixel;
    std::vector<PathRecorder::Vertex>& vertices;
    Motion& motion;
    const AppearanceAdjoint& appearance;
  };
  explicit GeometryScatter(const Refers& refers)
      : context_(refers.context.path),
        camera_(refers.context.camera),
        active_(refers.context.active),
        form_(refers.context.form),
        pixel_(refers.pixel),
        vertices_(refers.vertices),
        motion_(refers.motion),
        appearance_(refers.appearance) {}

  /// `radiance`: of the whole path; vertices from `end` on do not move.
  void Run(const Rgb& radiance, std::size_t first_rough, std::size_t end);

 private:
  using Vertex = PathRecorder::Vertex;

  void ScatterMaterialPoint(const Vertex& v);
  [[nodiscard]] bool FlatMesh(const Vertex& v) const;
  void ScatterNormals(const Vertex& v);
  void ScatterImagePoint(std::size_t k);
  static void PullThroughDelta(Vertex& v);
  void PullThroughMirrorNormal(Vertex& v) const;
  void ScatterCameraVertexInMaterialForm(const Rgb& radiance);

  const PathContext& context_;
  const CameraModel& camera_;
  const ActiveParameters& active_;
  DerivativeForm form_;
  const PixelSample& pixel_;
  std::vector<Vertex>& vertices_;
  Motion& motion_;
  const AppearanceAdjoint& appearance_;
};

}  // namespace pathfit::renderer
