#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/boundary/splat_buffer.h"
#include "renderer/geometry/edge_contact.h"
#include "renderer/geometry/edge_tree.h"
#include "renderer/path/path_tracer.h"
#include "renderer/render_options.h"
#include "renderer/sampler/path_sampler.h"

namespace pathfit::renderer {

/// What all boundary estimators of one view refer to.
struct BoundaryContext {
  const PathContext& path;
  const CameraModel& camera;
  const ActiveParameters& active;
  const RenderOptions& options;
  const RenderServices& services;
  const EdgeTree& edges;
  const EdgeContacts& contacts;
};

/// One way of a technique to turn uniform numbers into samples.
struct BoundaryWay {
  int dimensions = 3;  ///< how many of the numbers matter, the first ones: 1 to 3
  bool guided = true;  ///< whether looking for the places that count may pay
  int num_rays = 1;    ///< through the sensor or along edges, of one sample: its cost
};

/// The numbers of one boundary sample.
struct BoundaryDraw {
  std::array<double, 3> u{};  ///< in [0, 1); u[0] grows with the index
  double weight = 1.0;        ///< 1 / (number of the way's samples * density of u)
  std::uint64_t index = 0;    ///< of the sample among those of its way
  CounterRng rng;             ///< the sample's own further numbers
  const LatticeSampler::Shift* shift = nullptr;  ///< the same for all samples of the way

  [[nodiscard]] IndependentSampler Independent() const { return IndependentSampler(rng); }
  /// Neighbours in index spread over lights and directions together.
  [[nodiscard]] LatticeSampler Lattice() const { return {*shift, rng, index}; }
};

/// Estimator of one boundary integral by one or several ways to draw its samples. Guiding, random
/// streams, parallel loops and the order of sums are the driver's: boundary_pass.h. The context
/// must outlive it.
class BoundaryTechnique {
 public:
  BoundaryTechnique() = default;
  BoundaryTechnique(const BoundaryTechnique&) = delete;
  BoundaryTechnique& operator=(const BoundaryTechnique&) = delete;
  virtual ~BoundaryTechnique() = default;

  /// Empty if nothing can contribute. The estimate is the sum over all ways.
  [[nodiscard]] virtual std::vector<BoundaryWay> Ways() const = 0;
  /// How many samples the options ask for, of all ways together.
  [[nodiscard]] virtual std::int64_t NumSamples() const = 0;
  /// Adds one sample times draw.weight, for u uniform. Called from several threads at once.
  virtual void Sample(std::size_t way, const BoundaryDraw& draw, SplatBuffer& splats) const = 0;
};

}  // namespace pathfit::renderer
