#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "optim/parameter/unknown_spec.h"
#include "renderer/scene/parameter_layout.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Prior and bound of the photos' gains: g = start * 2^ev with |ev| <= max_ev. Factors of white
/// balance begin at 1 and have the same.
struct ExposureModel {
  std::vector<double> start_gains;  ///< by sensor; the gains the run began with
  ExposurePrior prior;
};

/// Logarithm of the gain, or of white balances' factors, that the run began with.
double StartOfGain(const ExposureModel& exposure, renderer::ParameterKind kind, int sensor);

/// Sensors that have what an unknown of all sensors frees in common: the first, and the others.
struct SensorGroup {
  int first;
  std::vector<int> sharing;
};
/// Those with one of `sensors` among them, in the order of these.
std::vector<SensorGroup> GroupsOfSensors(const UnknownSpec& unknown,
                                         const std::vector<int>& sensors);

/// The scalars that move in a stage. Two flat vectors with the same offsets: values x in units of
/// the scene (ParameterLayout's order) and unknowns theta, what the solver moves
/// (Parameterization). Groups are ordered by kind, vertices first, so that a pixel's nearest
/// vertices lead its sorted block list.
class ParameterSet {
 public:
  /// `active`: indices into `unknowns`; those held or replaced (IsReplaced) are left out.
  /// `sensors`: those that an unknown of all sensors frees, with others that share it. Throws
  /// SceneError for an index out of range or an unknown the scene does not have.
  ParameterSet(const renderer::Scene& scene,
               const std::vector<UnknownSpec>& unknowns,
               const std::vector<int>& active,
               const std::vector<int>& sensors,
               const ExposureModel& exposure);

  [[nodiscard]] const renderer::ParameterLayout& layout() const { return layout_; }
  [[nodiscard]] std::size_t NumScalars() const { return mapping_.size(); }
  [[nodiscard]] std::size_t NumBlocks() const { return block_offset_.size(); }
  [[nodiscard]] int BlockSize(std::int32_t block) const {
    return block_size_[static_cast<std::size_t>(block)];
  }
  [[nodiscard]] std::size_t BlockOffset(std::int32_t block) const {
    return block_offset_[static_cast<std::size_t>(block)];
  }
  /// Index of the unknown that group `group` of the layout belongs to.
  [[nodiscard]] int UnknownOfGroup(std::size_t group) const { return unknown_of_group_[group]; }
  [[nodiscard]] bool IsLog(std::size_t scalar) const { return mapping_[scalar] == Mapping::kLog; }
  /// Whether the block holds spot angles, whose unknowns are (u_inner / u_outer, outer), u = 1 -
  /// cos.
  [[nodiscard]] bool IsCone(std::int32_t block) const {
    return mapping_[BlockOffset(block)] == Mapping::kCone;
  }
  /// How a light turns that is the same all around: rotations about `axis` (unit, as it points
  /// unturned, in its frame) are left out, for they change nothing. Without them, rotation vectors
  /// are at right angles to the axis, and each direction has one.
  struct Turn {
    std::int32_t block;
    renderer::Vec3 axis;
  };
  /// By block.
  [[nodiscard]] const std::vector<Turn>& turns() const { return turns_; }
  /// Null: the block is none.
  [[nodiscard]] const Turn* TurnOf(std::int32_t block) const {
    if (turns_.empty()) {
      return nullptr;
    }
    const auto turn = std::ranges::lower_bound(turns_, block, {}, &Turn::block);
    return turn != turns_.end() && turn->block == block ? &*turn : nullptr;
  }
  /// Takes back what the step from one point to another (values) turns about these axes: solvers
  /// that scale unknowns one by one leave the plane.
  void DropTurnsAboutAxes(const std::vector<double>& from, std::vector<double>& to) const;
  /// d inner / d ratio and d inner / d outer of a cone at these angles.
  static std::array<double, 2> ConeSlopes(double inner, double outer);
  /// Bounds of theta, infinite where there is none.
  [[nodiscard]] double Lower(std::size_t scalar) const { return RunOf(scalar).lower; }
  [[nodiscard]] double Upper(std::size_t scalar) const { return RunOf(scalar).upper; }
  /// ParameterTraits::largest_factor, of the value.
  [[nodiscard]] double LargestFactor(std::size_t scalar) const { return RunOf(scalar).factor; }

  /// By scalar: whether theta is at none of its bounds.
  [[nodiscard]] std::vector<bool> InsideBounds(const std::vector<double>& theta) const;

  /// Theta of the scene's values, moved into the bounds.
  [[nodiscard]] std::vector<double> ThetaFromValues(const std::vector<double>& values) const;
  [[nodiscard]] std::vector<double> ValuesFromTheta(const std::vector<double>& theta) const;
  /// d x / d theta of one scalar, by its value; not of cones.
  [[nodiscard]] double Slope(std::size_t scalar, double value) const {
    return IsLog(scalar) ? value : 1.0;
  }

 private:
  enum class Mapping : char {
    kIdentity,
    kLog,
    kCone,  ///< of the inner angle; the outer one follows
  };

  /// Scalars with the same bounds: from the end of the run before on.
  struct Run {
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();
    std::size_t end = 0;
    double lower = 0.0, upper = 0.0;
    double factor = kInfinity;
    /// Bounds of the value of a logarithm, which rounding must not leave.
    double least = 0.0, most = kInfinity;
  };
  [[nodiscard]] const Run& RunOf(std::size_t scalar) const {
    return *std::ranges::upper_bound(runs_, scalar, {}, &Run::end);
  }

  void AddGroup(const renderer::Scene& scene,
                const UnknownSpec& unknown,
                int index,
                int object,
                std::vector<int> sharing,
                const ExposureModel& exposure);

  renderer::ParameterLayout layout_;
  std::vector<int> unknown_of_group_;
  // Of many texels: small numbers.
  std::vector<std::uint8_t> block_size_;
  std::vector<std::uint32_t> block_offset_;
  std::vector<Mapping> mapping_;
  std::vector<Run> runs_;
  std::vector<Turn> turns_;
};

/// Moves what lies outside of its unknown's bounds to the nearest of them.
void MoveIntoBounds(const std::vector<UnknownSpec>& unknowns, renderer::Scene& scene);

/// The free group that scales emitter `object`, -1 if it is fixed.
int GroupOfStrength(const ParameterSet& set, int object);

}  // namespace pathfit::optim
