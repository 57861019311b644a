#pragma once

#include <limits>
#include <vector>

#include "renderer/derivative/appearance_adjoint.h"
#include "renderer/derivative/derivative_accumulator.h"
#include "renderer/derivative/motion_adjoint.h"
#include "renderer/derivative/near_motion.h"
#include "renderer/derivative/path_recorder.h"
#include "renderer/render_options.h"

namespace pathfit::renderer {

/// Adds adjoints to a DerivativeAccumulator: the target of MotionAdjoint for interior paths.
class AccumulatorTarget {
 public:
  explicit AccumulatorTarget(DerivativeAccumulator& sum) : sum_(sum) {}
  void Add(std::int32_t block, const ColorGradient& g) {
    auto& entry = sum_.Entry(block);
    for (int c = 0; c < 3; ++c) {
      entry[0][c] += g[c].x;
      entry[1][c] += g[c].y;
      entry[2][c] += g[c].z;
    }
  }
  void AddScalar(std::int32_t block, int component, const Rgb& d) {
    sum_.Entry(block)[static_cast<std::size_t>(component)] += Rgba(d, 0.0);
  }

 private:
  DerivativeAccumulator& sum_;
};

/// Where a path starts: the sensor ray and, in material form, the slope of the pixel's filter.
struct PixelSample {
  Ray ray;
  double u = 0.0, v = 0.0;  ///< pixel coordinates
  double weight = 1.0;      ///< filter over sampling density; 1 where the filter is sampled
  double slope_u = 0.0, slope_v = 0.0;  ///< material form: derivative of log filter by u, v,
                                        ///< times weight
};

/// What the interior derivative refers to.
struct AdjointContext {
  const PathContext& path;
  const CameraModel& camera;
  const ActiveParameters& active;
  DerivativeForm form = DerivativeForm::kImage;
  const NearMotion* near_motion = nullptr;  ///< pixel estimates only
};

/// Adds the derivative of pixel.weight times a path's radiance by every active parameter to a sum,
/// by one reverse sweep over the recorded path.
///
/// Image form: the pixel is fixed, so the camera vertex slides along the camera ray when its
/// triangle or the camera moves; so do the vertices behind mirrors and glass up to the first vertex
/// that is not. All later vertices are in material form: barycentrics fixed, the factor G J of each
/// segment attached, sampling densities and MIS weights detached. Material form: all vertices are
/// material points; the camera vertex has the factors H(u), pixel area per surface area and J.
/// Behind a mirror or glass that follows a rough vertex directions are kept fixed, and motion is
/// not differentiated. Visibility is constant here; its change is the boundary estimators' part.
/// Source: path_space 1.4, 1.5, 1.12; [Zhang2020].
class PathAdjoint {
 public:
  /// All must outlive the object.
  PathAdjoint(const AdjointContext& context, DerivativeAccumulator& sum);
  PathAdjoint(const PathAdjoint&) = delete;
  PathAdjoint& operator=(const PathAdjoint&) = delete;

  static constexpr std::size_t kNoContact = std::numeric_limits<std::size_t>::max();
  /// Directions away from vertex `contact` to surfaces are kept fixed, and vertices behind it do
  /// not move. Those away from `stand_ins`, and what is behind, count NearMotion::kStandInWeight
  /// times. `first`: if not null, and SharesFirst(path), the first vertex' share goes there
  /// instead, for AddFirst.
  void AddPath(const PixelSample& pixel,
               const PathRecord& path,
               std::size_t contact = kNoContact,
               NearMotion::VertexBits stand_ins = 0,
               VertexAdjoint* first = nullptr);
  /// Whether what the first vertex of a path adds is linear in its adjoint and independent of the
  /// rest of the path, so that paths that begin alike may add it together.
  [[nodiscard]] bool SharesFirst(const PathRecord& path) const {
    return form_ == DerivativeForm::kImage && !IsDelta(path.vertices.front().p.material->bsdf);
  }
  /// Adds what paths with the first vertex of this one have left for it.
  void AddFirst(const PixelSample& pixel, const PathRecord& path, const VertexAdjoint& first);
  /// Of a camera ray that meets nothing but the environment.
  void AddMiss(const PixelSample& pixel);

 private:
  using Vertex = PathRecord::Vertex;

  // The sweep: what leaves each vertex, last vertex first.
  [[nodiscard]] bool IsMoving() const;
  [[nodiscard]] bool Moves(std::size_t k) const { return moving_ && k < frozen_; }
  /// Whether directions to surfaces, away from the sensor, turn with the vertex' and its target's
  /// motion.
  [[nodiscard]] bool Turns(std::size_t k) const { return Moves(k) && k != contact_; }
  /// How often a vertex' motion counts, and that of directions away from it to surfaces.
  [[nodiscard]] double MotionWeight(std::size_t k) const { return motion_weights_[k]; }
  [[nodiscard]] double TurnWeight(std::size_t k) const { return motion_weights_[k + 1]; }
  void FindStages();
  Rgb AdjointOfVertex(std::size_t k, const Rgb& beyond);
  Rgb AdjointOfDirect(std::size_t k, const DirectContribution& direct);
  Rgb AdjointOfEscape(std::size_t k, const DirectContribution& direct);
  Rgb AdjointOfSegment(std::size_t k, const Rgb& beyond);
  Rgb AdjointOfDelta(std::size_t k, const Rgb& beyond);
  Rgb AdjointOfBsdf(std::size_t k, const Vec3& wi, const Rgb& weight, ColorGradient& d_wi);
  Rgb AdjointOfDeltaWeight(std::size_t k, const Rgb& weight);

  // Then the places: image points up to the first rough vertex, material points behind it.
  void Scatter(const Rgb& radiance, bool with_first);
  void MoveStart(std::size_t k, const ColorGradient& d);
  void ScatterMaterialPoint(std::size_t k);
  void ScatterNormals(std::size_t k);
  void ScatterMappedNormal(std::size_t k);
  void ScatterImagePoint(std::size_t k);
  void ScatterCameraVertexInMaterialForm(const Rgb& radiance);
  void PullThroughDelta(std::size_t k);
  void PullThroughMirrorNormal(std::size_t k);
  [[nodiscard]] bool IsFlat(const Vertex& v) const {
    return world_.mesh(v.p.id.mesh).normal_triangles.empty();
  }

  const PathContext& context_;
  const World& world_;
  const CameraModel& camera_;
  const ActiveParameters& active_;
  const DerivativeForm form_;
  AccumulatorTarget target_;
  MotionAdjoint<ColorGradient, AccumulatorTarget> motion_;
  AppearanceAdjoint appearance_;

  // Of the path at hand.
  const PixelSample* pixel_ = nullptr;
  const PathRecord* path_ = nullptr;
  std::vector<VertexAdjoint> adjoints_;  // one per vertex
  std::size_t contact_ = kNoContact;
  NearMotion::VertexBits stand_ins_ = 0;
  std::vector<double> motion_weights_;  // by vertex, and of what is behind the last one
  bool moving_ = false;                 // anything that moves or bends touches the path
  std::size_t first_rough_ = 0;         // the first vertex that is no mirror or glass
  std::size_t frozen_ = 0;              // vertices from here on do not move
};

}  // namespace pathfit::renderer
