#include "optim/problem/pixel_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/core/error.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

constexpr double kStandsOut = 2.0;  // of a residual, in units of half its halves' difference
constexpr std::size_t kMaxEntries = 1 << 19;  // of a part, and a band more

std::string Place(const std::string& view_name, std::size_t pixel, int width) {
  const auto w = static_cast<std::size_t>(width);
  return "view '" + view_name + "', pixel (" + std::to_string(pixel % w) + ", " +
         std::to_string(pixel / w) + ")";
}

// Derivatives by a cone's unknowns from those by its angles.
PixelDerivative ByCone(const PixelDerivative& by_angles, const std::array<double, 2>& slopes) {
  PixelDerivative out = by_angles;
  for (std::size_t channel = 0; channel < 4; ++channel) {
    const auto d_inner = static_cast<double>(by_angles.d[channel]);
    const auto d_outer = static_cast<double>(by_angles.d[4 + channel]);
    out.d[channel] = static_cast<float>(slopes[0] * d_inner);
    out.d[4 + channel] = static_cast<float>(slopes[1] * d_inner + d_outer);
  }
  return out;
}

/// Derivatives by a rotation without those about its axis.
PixelDerivative WithoutAxis(const PixelDerivative& by_rotation, const renderer::Vec3& axis) {
  PixelDerivative out = by_rotation;
  const std::array<double, 3> a = {axis.x, axis.y, axis.z};
  for (std::size_t channel = 0; channel < 4; ++channel) {
    double along = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      along += a[c] * static_cast<double>(by_rotation.d[4 * c + channel]);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      out.d[4 * c + channel] =
          static_cast<float>(static_cast<double>(by_rotation.d[4 * c + channel]) - a[c] * along);
    }
  }
  return out;
}

double SquaredNorm(const std::array<double, 3>& values) {
  double sum = 0.0;
  for (const double x : values) {
    sum += x * x;
  }
  return sum;
}

}  // namespace

double RowUnit::NoiseSquared() const { return SquaredNorm(difference); }

void RowUnit::SetResiduals(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  for (std::size_t row = 0; row < 3; ++row) {
    residual[row] = 0.5 * (a[row] + b[row]);
    difference[row] = 0.5 * (a[row] - b[row]);
  }
  stands_out = SquaredNorm(residual) > kStandsOut * kStandsOut * NoiseSquared();
}

void PixelRows::AddEntry(const RowUnit& unit, const HalvesEntry& halves, int size) {
  // What each half's Jacobian and residuals give differs as the mean of both does, the covariance
  // of a half's Jacobian and residuals included. That holds single bright samples to the fourth
  // power, too, where the residual is little else: there the halves' are exchanged.
  const double sign_of_v = unit.stands_out ? 1.0 : -1.0;
  RowEntry entry;
  EntrySpread spread;
  entry.block = halves.block;
  bool is_zero = true;
  for (int component = 0; component < size; ++component) {
    double noise = 0.0;
    double gradient_spread = 0.0;
    double gradient = 0.0;
    for (int r = 0; r < unit.NumRows(); ++r) {
      const auto row = static_cast<std::size_t>(r);
      const auto cell = static_cast<std::size_t>(r * size + component);
      const double mean = 0.5 * (halves.a[cell] + halves.b[cell]);
      const double difference = 0.5 * (halves.a[cell] - halves.b[cell]);
      entry.jacobian[cell] = static_cast<float>(mean);
      spread.jacobian[cell] = static_cast<float>(difference);
      noise += unit.difference[row] * difference;
      gradient += mean * unit.residual[row];
      gradient_spread += difference * unit.residual[row] + sign_of_v * mean * unit.difference[row];
      is_zero = is_zero && mean == 0.0 && difference == 0.0;
    }
    const auto c = static_cast<std::size_t>(component);
    entry.noise[c] = static_cast<float>(noise);
    spread.gradient[c] = static_cast<float>(gradient_spread);
    spread.mean_gradient[c] = static_cast<float>(gradient - noise);
  }
  if (!is_zero) {
    entries.push_back(entry);
    spreads.push_back(spread);
  }
}

HalvesMerger::HalvesMerger(const ViewHalves& halves,
                           const ViewLevel& level,
                           const RowScales& scales,
                           const ParameterSet& set,
                           const std::vector<double>& values,
                           const std::string& view_name,
                           bool keeps_all)
    : halves_(halves),
      level_(level),
      scales_(scales),
      set_(set),
      values_(values),
      view_name_(view_name),
      keeps_all_(keeps_all) {}

/// Appends the units of one pixel.
void HalvesMerger::AddPixel(std::size_t pixel, PixelRows& rows) const {
  const std::array<float, 4>& scale = scales_[pixel];
  if (scale[0] != 0.0F || scale[1] != 0.0F || scale[2] != 0.0F) {
    AddUnit(pixel, false, rows);
  }
  if (scale[3] != 0.0F) {
    AddUnit(pixel, true, rows);
  }
}

void HalvesMerger::AddUnit(std::size_t pixel, bool is_coverage, PixelRows& rows) const {
  RowUnit unit;
  unit.pixel = static_cast<std::int32_t>(pixel);
  unit.is_coverage = is_coverage;
  unit.first_entry = rows.entries.size();
  const auto r_a = PixelResidual(level_, scales_[pixel], halves_.film_a.pixels[pixel], pixel);
  const auto r_b = PixelResidual(level_, scales_[pixel], halves_.film_b.pixels[pixel], pixel);
  std::array<double, 3> rows_a{}, rows_b{};
  for (int row = 0; row < unit.NumRows(); ++row) {
    const auto channel = static_cast<std::size_t>(unit.Channel(row));
    rows_a[static_cast<std::size_t>(row)] = r_a[channel];
    rows_b[static_cast<std::size_t>(row)] = r_b[channel];
  }
  unit.SetResiduals(rows_a, rows_b);
  const JacobianSink::Entries entries_a = halves_.sink_a.Pixel(pixel);
  const JacobianSink::Entries entries_b = halves_.sink_b.Pixel(pixel);
  const auto end_a = entries_a.end(), end_b = entries_b.end();
  for (auto a = entries_a.begin(), b = entries_b.begin(); a != end_a || b != end_b;) {
    const bool take_a = b == end_b || (a != end_a && a.block() <= b.block());
    const bool take_b = a == end_a || (b != end_b && b.block() <= a.block());
    const std::int32_t block = take_a ? a.block() : b.block();
    const PixelDerivative da = take_a ? *a++ : PixelDerivative();
    const PixelDerivative db = take_b ? *b++ : PixelDerivative();
    if (set_.IsCone(block)) {
      const double* angles = values_.data() + set_.BlockOffset(block);
      const std::array<double, 2> slopes = ParameterSet::ConeSlopes(angles[0], angles[1]);
      AddEntry(unit, block, ByCone(da, slopes), ByCone(db, slopes), rows);
    } else if (const ParameterSet::Turn* turn = set_.TurnOf(block)) {
      AddEntry(unit, block, WithoutAxis(da, turn->axis), WithoutAxis(db, turn->axis), rows);
    } else {
      AddEntry(unit, block, da, db, rows);
    }
  }
  unit.num_entries = static_cast<std::int32_t>(rows.entries.size() - unit.first_entry);
  if (unit.num_entries > 0 || keeps_all_) {
    rows.units.push_back(unit);
  }
}

void HalvesMerger::AddEntry(const RowUnit& unit,
                            std::int32_t block,
                            const PixelDerivative& a,
                            const PixelDerivative& b,
                            PixelRows& rows) const {
  HalvesEntry halves{block, {}, {}};
  const int size = set_.BlockSize(block);
  const std::size_t offset = set_.BlockOffset(block);
  const auto pixel = static_cast<std::size_t>(unit.pixel);
  for (int row = 0; row < unit.NumRows(); ++row) {
    const auto channel = static_cast<std::size_t>(unit.Channel(row));
    for (int component = 0; component < size; ++component) {
      const auto c = static_cast<std::size_t>(component);
      const double scale = set_.Slope(offset + c, values_[offset + c]) *
                           static_cast<double>(scales_[pixel][channel]);
      const auto cell = static_cast<std::size_t>(row * size + component);
      halves.a[cell] = scale * static_cast<double>(a.d[c * 4 + channel]);
      halves.b[cell] = scale * static_cast<double>(b.d[c * 4 + channel]);
    }
  }
  const std::size_t before = rows.entries.size();
  rows.AddEntry(unit, halves, size);
  if (rows.entries.size() == before) {
    return;
  }
  // Rows are kept in single precision, where huge colours overflow first.
  const RowEntry& entry = rows.entries.back();
  for (int component = 0; component < size; ++component) {
    bool is_finite = std::isfinite(entry.noise[static_cast<std::size_t>(component)]);
    for (int row = 0; row < unit.NumRows(); ++row) {
      is_finite &= std::isfinite(entry.jacobian[static_cast<std::size_t>(row * size + component)]);
    }
    if (!is_finite) {
      throw renderer::NumericalError(
          Place(view_name_, pixel, halves_.film_a.width) + ": the derivative by " +
          set_.layout().ScalarName(block, component) + " is not finite or too large");
    }
  }
}

void CheckFinite(const renderer::Film& film, const std::string& view_name) {
  for (std::size_t p = 0; p < film.pixels.size(); ++p) {
    const renderer::Rgba& c = film.pixels[p];
    if (!std::isfinite(c.r) || !std::isfinite(c.g) || !std::isfinite(c.b) || !std::isfinite(c.a)) {
      throw renderer::NumericalError(Place(view_name, p, film.width) +
                                     ": the rendered colour is not finite");
    }
  }
}

void PixelRows::Append(const PixelRows& other) {
  const std::size_t first = units.size();
  const std::size_t first_entry = entries.size();
  units.insert(units.end(), other.units.begin(), other.units.end());
  for (std::size_t i = first; i < units.size(); ++i) {
    units[i].first_entry += first_entry;
  }
  entries.insert(entries.end(), other.entries.begin(), other.entries.end());
  spreads.insert(spreads.end(), other.spreads.begin(), other.spreads.end());
}

void HalvesMerger::Append(Band& band, PixelRows& rows) {
  for (PixelRows& piece : band) {
    rows.Append(piece);
    piece.Clear();
  }
}

void HalvesMerger::Next(PixelRows& rows) {
  const auto width = static_cast<std::size_t>(level_.photo.width);
  rows.Clear();
  for (std::size_t num_entries = 0; HasNext() && num_entries < kMaxEntries;) {
    const int count = std::min(kBand, level_.photo.height - line_);
    renderer::ParallelFor(count + 1, [&](std::int64_t i) {
      if (i == 0) {
        Append(ready_, rows);
        return;
      }
      PixelRows& piece = made_[static_cast<std::size_t>(i - 1)];
      const std::size_t first = static_cast<std::size_t>(line_ + i - 1) * width;
      for (std::size_t x = 0; x < width; ++x) {
        AddPixel(first + x, piece);
      }
    });
    std::swap(made_, ready_);
    for (const PixelRows& piece : ready_) {
      num_entries += piece.entries.size();
    }
    line_ += count;
  }
  Append(ready_, rows);
}

}  // namespace pathfit::optim
