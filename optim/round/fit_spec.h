#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "optim/parameter/unknown_spec.h"
#include "optim/problem/loss_spec.h"
#include "renderer/render_options.h"

namespace pathfit::optim {

/// Samples of a stage's first round, of both halves together (renderer::SampleBudget). A boundary
/// budget without a value is found by the rounds themselves, from measured variances; `spp` is
/// kUsualSpp then, and less where few unknowns see many pixels (SampleFactor).
struct StageBudget : renderer::BoundaryBudgets {
  std::optional<int> spp;

  static constexpr int kUsualSpp = 8;
  [[nodiscard]] int Spp() const { return spp.value_or(kUsualSpp); }
};

struct StageSpec {
  std::string name;
  std::vector<int> free;     ///< indices into FitSpec::unknowns
  double image_scale = 1.0;  ///< of the photos in the end
  /// Whether a stage in which something moves, or that makes a texture, begins with smaller photos
  /// (ScalesOfStage).
  bool coarse_to_fine = true;
  int max_rounds = 60;
  StageBudget samples;
  double spp_growth = 1.5;  ///< of all budgets, from rounds whose noise hides what is gained
  int max_spp = 64;         ///< where they stop growing
  /// Where a fit of many unknowns ends: the averaged cost falls by less than this; 0 = never. Few
  /// unknowns (ImageProblem::kMaxGramScalars) have error bars, by which they end.
  double stop_relative_cost = 0.01;
};

/// Colours and lights share a factor that photos tell badly or not at all.
struct ColorGauge {
  enum class Rule {
    kAuto,      ///< kMeanColor where photos say nothing of the factor, else kPhotos
    kPhotos,    ///< what they say
    kMeanColor  ///< the mean base colour is known, or believed to stay
  };
  Rule rule = Rule::kPhotos;
  std::vector<double> mean;  ///< for all channels or one each; empty: that of the run's start
  std::string material;      ///< name of that whose mean colour it is; empty: of all surfaces
};

struct FitSpec {
  std::vector<UnknownSpec> unknowns;
  std::vector<StageSpec> stages;
  LossSpec loss;
  std::uint64_t seed = 0;
  renderer::EstimatorOptions estimators;
  LinearSolverChoice linear_solver = LinearSolverChoice::kAuto;
  double max_memory_bytes = 0.0;  ///< 0 or infinite = no limit
  ExposurePrior exposure;
  ColorGauge gauge;
  double time_limit_s = 0.0;  ///< 0 = none
};

}  // namespace pathfit::optim
