#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/jacobian_sink.h"

namespace pathfit::optim {

/// Derivatives of one unit by one block: `jacobian` is rows x components, row-major, of the mean of
/// both halves by theta; `noise` is v^T dv/dtheta with v half the difference of the halves'
/// residuals.
struct RowEntry {
  std::int32_t block = -1;
  std::array<float, 9> jacobian{};
  std::array<float, 3> noise{};
};

/// What the halves disagree on, of one entry: half the difference of their Jacobians (rows x
/// components, row-major), and of what they give as gradient: each half's Jacobian and residuals
/// where the mean residual stands out of the noise, else each half's Jacobian and the other's
/// residuals. The mean of the latter is `mean_gradient`, unbiased. Products of differences have the
/// expectation of the mean's noise; that of exchanged halves lacks what Jacobian and residuals of a
/// half have in common, which counts where residuals are large.
struct EntrySpread {
  std::array<float, 9> jacobian{};
  std::array<float, 3> gradient{};
  std::array<float, 3> mean_gradient{};
};

/// Where noise hides the square of J, this share of it is taken as true.
inline constexpr double kLeastTrueShare = 0.1;

/// Square of the row that stands for the noise, over the noise seen: the row's share of J^T J is
/// its inverse.
inline constexpr double kNoiseRowFactor = 1e4;
/// Share of the mean squared residual that is added to the noise seen, which may be none by luck.
inline constexpr double kNoiseFloorShare = 1e-3;

/// Rows of one pixel with the same sparsity: its three colours, or its coverage.
struct RowUnit {
  std::int32_t pixel = 0;
  bool is_coverage = false;
  bool stands_out = false;  ///< the mean residual, of the renderings' noise
  std::size_t first_entry = 0;
  std::int32_t num_entries = 0;
  std::array<double, 3> residual{};    ///< mean of the halves', by row
  std::array<double, 3> difference{};  ///< half of theirs

  [[nodiscard]] int NumRows() const { return is_coverage ? 1 : 3; }
  [[nodiscard]] int Channel(int row) const { return is_coverage ? 3 : row; }
  /// |difference|^2.
  [[nodiscard]] double NoiseSquared() const;
  /// Sets what depends on the residuals of both halves, by row.
  void SetResiduals(const std::array<double, 3>& a, const std::array<double, 3>& b);
};

/// Derivatives of one unit by one block, of both halves: rows x components, row-major.
struct HalvesEntry {
  std::int32_t block = -1;
  std::array<double, 9> a{}, b{};
};

/// Sparse weighted rows of one view or a part of it, both halves merged.
struct PixelRows {
  std::vector<RowUnit> units;
  std::vector<RowEntry> entries;
  std::vector<EntrySpread> spreads;  ///< by entry; empty if unknown

  /// Appends an entry of `size` components, unless all are zero, to those of `unit`, which has its
  /// residuals.
  void AddEntry(const RowUnit& unit, const HalvesEntry& halves, int size);
  /// Appends other rows of the same view.
  void Append(const PixelRows& other);
  /// Keeps its memory.
  void Clear() {
    units.clear();
    entries.clear();
    spreads.clear();
  }
  [[nodiscard]] std::size_t MemoryBytes() const {
    return units.size() * sizeof(RowUnit) + entries.size() * sizeof(RowEntry) +
           spreads.size() * sizeof(EntrySpread);
  }
};

/// The two renderings of a view that share nothing but the parameters.
struct ViewHalves {
  const renderer::Film& film_a;
  const renderer::Film& film_b;
  const JacobianSink& sink_a;
  const JacobianSink& sink_b;
};

/// Makes the rows of a view, without those whose derivative is zero everywhere.
class HalvesMerger {
 public:
  /// All arguments must outlive it. `keeps_all`: units whose derivative is zero, too.
  HalvesMerger(const ViewHalves& halves,
               const ViewLevel& level,
               const RowScales& scales,
               const ParameterSet& set,
               const std::vector<double>& values,
               const std::string& view_name,
               bool keeps_all = false);

  /// Whether lines of pixels are left.
  [[nodiscard]] bool HasNext() const { return line_ < level_.photo.height; }
  /// Replaces `rows` by those of the next lines, as many as a part of bounded memory holds; its
  /// memory is used again. Throws renderer::NumericalError naming view, pixel and parameter if a
  /// derivative is not finite.
  void Next(PixelRows& rows);

 private:
  void AddPixel(std::size_t pixel, PixelRows& rows) const;
  void AddUnit(std::size_t pixel, bool is_coverage, PixelRows& rows) const;
  void AddEntry(const RowUnit& unit,
                std::int32_t block,
                const PixelDerivative& a,
                const PixelDerivative& b,
                PixelRows& rows) const;

  /// Lines that are made at once.
  static constexpr int kBand = 16;
  using Band = std::array<PixelRows, kBand>;
  static void Append(Band& band, PixelRows& rows);

  const ViewHalves halves_;
  const ViewLevel& level_;
  const RowScales& scales_;
  const ParameterSet& set_;
  const std::vector<double>& values_;
  const std::string& view_name_;
  const bool keeps_all_;
  int line_ = 0;
  /// What is being made, and what was made before and is put together meanwhile.
  Band made_, ready_;
};

/// Throws renderer::NumericalError naming view and pixel if a colour is not finite.
void CheckFinite(const renderer::Film& film, const std::string& view_name);

}  // namespace pathfit::optim
