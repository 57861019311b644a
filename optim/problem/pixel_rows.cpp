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

}  // namespace

HalvesMerger::HalvesMerger(const ViewHalves& halves,
                           const ViewLevel& level,
                           const RowScales& scales,
                           const ParameterSet& set,
                           const std::vector<double>& values,
                           const std::string& view_name)
    : halves_(halves),
      level_(level),
      scales_(scales),
      set_(set),
      values_(values),
      view_name_(view_name) {}

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
  Residuals r;
  double square = 0.0;
  for (int row = 0; row < unit.NumRows(); ++row) {
    const auto channel = static_cast<std::size_t>(unit.Channel(row));
    r.u[static_cast<std::size_t>(row)] = 0.5 * (r_a[channel] + r_b[channel]);
    const double v = 0.5 * (r_a[channel] - r_b[channel]);
    r.v[static_cast<std::size_t>(row)] = v;
    unit.noise_squared += v * v;
    square += r.u[static_cast<std::size_t>(row)] * r.u[static_cast<std::size_t>(row)];
  }
  // What each half's Jacobian and residuals give differs as the mean of both does, the covariance
  // of a half's Jacobian and residuals included. That holds single bright samples to the fourth
  // power, too, where the residual is little else: there the halves' are exchanged.
  r.sign_of_v = square > kStandsOut * kStandsOut * unit.noise_squared ? 1.0 : -1.0;
  unit.residual = r.u;
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
      AddEntry(unit, r, block, ByCone(da, slopes), ByCone(db, slopes), rows);
    } else if (const ParameterSet::Turn* turn = set_.TurnOf(block)) {
      AddEntry(unit, r, block, WithoutAxis(da, turn->axis), WithoutAxis(db, turn->axis), rows);
    } else {
      AddEntry(unit, r, block, da, db, rows);
    }
  }
  unit.num_entries = static_cast<std::int32_t>(rows.entries.size() - unit.first_entry);
  if (unit.num_entries > 0) {
    rows.units.push_back(unit);
  }
}

void HalvesMerger::AddEntry(const RowUnit& unit,
                            const Residuals& r,
                            std::int32_t block,
                            const PixelDerivative& a,
                            const PixelDerivative& b,
                            PixelRows& rows) const {
  RowEntry entry;
  EntrySpread spread;
  entry.block = block;
  const int size = set_.BlockSize(block);
  const std::size_t offset = set_.BlockOffset(block);
  bool is_zero = true;
  for (int component = 0; component < size; ++component) {
    const auto c = static_cast<std::size_t>(component);
    const double slope = set_.Slope(offset + c, values_[offset + c]);
    double noise = 0.0;
    double gradient_spread = 0.0;
    double gradient = 0.0;
    for (int row = 0; row < unit.NumRows(); ++row) {
      const auto channel = static_cast<std::size_t>(unit.Channel(row));
      const auto pixel = static_cast<std::size_t>(unit.pixel);
      const double scale = 0.5 * slope * static_cast<double>(scales_[pixel][channel]);
      const auto d_a = static_cast<double>(a.d[c * 4 + channel]);
      const auto d_b = static_cast<double>(b.d[c * 4 + channel]);
      const double mean = scale * (d_a + d_b);
      const double difference = scale * (d_a - d_b);
      const auto cell = static_cast<std::size_t>(row * size + component);
      entry.jacobian[cell] = static_cast<float>(mean);
      spread.jacobian[cell] = static_cast<float>(difference);
      noise += r.v[static_cast<std::size_t>(row)] * difference;
      gradient += mean * r.u[static_cast<std::size_t>(row)];
      gradient_spread += difference * r.u[static_cast<std::size_t>(row)] +
                         r.sign_of_v * mean * r.v[static_cast<std::size_t>(row)];
      is_zero = is_zero && mean == 0.0 && difference == 0.0;
      // Rows are kept in single precision, where huge colours overflow first.
      if (!std::isfinite(static_cast<float>(mean)) || !std::isfinite(static_cast<float>(noise))) {
        throw renderer::NumericalError(
            Place(view_name_, pixel, halves_.film_a.width) + ": the derivative by " +
            set_.layout().ScalarName(block, component) + " is not finite or too large");
      }
    }
    entry.noise[c] = static_cast<float>(noise);
    spread.gradient[c] = static_cast<float>(gradient_spread);
    spread.mean_gradient[c] = static_cast<float>(gradient - noise);
  }
  if (!is_zero) {
    rows.entries.push_back(entry);
    rows.spreads.push_back(spread);
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

void HalvesMerger::Append(Band& band, PixelRows& rows) {
  for (PixelRows& piece : band) {
    for (RowUnit& unit : piece.units) {
      unit.first_entry += rows.entries.size();
    }
    rows.units.insert(rows.units.end(), piece.units.begin(), piece.units.end());
    rows.entries.insert(rows.entries.end(), piece.entries.begin(), piece.entries.end());
    rows.spreads.insert(rows.spreads.end(), piece.spreads.begin(), piece.spreads.end());
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
