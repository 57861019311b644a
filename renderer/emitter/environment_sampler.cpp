#include "renderer/emitter/environment_sampler.h"

#include <algorithm>
#include <numbers>

#include "renderer/math/frame.h"
#include "renderer/math/warp.h"

namespace pathfit::renderer {
namespace {

constexpr double kEnvironmentFloor = 0.1;

// Cells are the squares between texel centres' midlines; cos theta is linear inside, so a cell's
// solid angle is exact.
double CosAtRow(int row, int height) { return std::cos(std::numbers::pi * row / height); }
double CellSolidAngle(int row, int width, int height) {
  return 2.0 * std::numbers::pi / width * (CosAtRow(row, height) - CosAtRow(row + 1, height));
}

}  // namespace

EnvironmentSampler::EnvironmentSampler(const EnvironmentEmitter& environment)
    : width_(environment.width), height_(environment.height), texels_(environment.texels.data()) {
  if (width_ * height_ == 1) return;
  const auto radiance = [&](int x, int y) {
    const int wx = (x + width_) % width_;
    const int cy = std::clamp(y, 0, height_ - 1);
    const Rgb& t = environment.texels[static_cast<std::size_t>(cy * width_ + wx)];
    return std::max(0.0, Luminance(environment.intensity * t));
  };
  std::vector<double> weights(environment.texels.size());
  double power = 0.0;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      // Mean over the cell of the bilinear function, by the weights of its 3x3 neighbourhood.
      double mean = 0.0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          mean += (dx == 0 ? 0.75 : 0.125) * (dy == 0 ? 0.75 : 0.125) * radiance(x + dx, y + dy);
        }
      }
      const double solid_angle = CellSolidAngle(y, width_, height_);
      weights[static_cast<std::size_t>(y * width_ + x)] = mean * solid_angle;
      power += mean * solid_angle;
    }
  }
  const double floor = power > 0.0 ? kEnvironmentFloor * power / (4.0 * std::numbers::pi) : 1.0;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      weights[static_cast<std::size_t>(y * width_ + x)] +=
          floor * CellSolidAngle(y, width_, height_);
    }
  }
  // Rows first, then columns: both numbers move the direction evenly, which lattices and guides
  // build on.
  std::vector<double> row_weights;
  for (int y = 0; y < height_; ++y) {
    const auto row = weights.begin() + static_cast<std::ptrdiff_t>(y) * width_;
    columns_.emplace_back(std::vector<double>(row, row + width_));
    row_weights.push_back(columns_.back().Total());
  }
  rows_ = Distribution1D(row_weights);
  for (int y = 0; y <= height_; ++y) row_cos_.push_back(CosAtRow(y, height_));
  density_.resize(weights.size());
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const int texel = y * width_ + x;
      density_[static_cast<std::size_t>(texel)] =
          rows_.Probability(y) * columns_[static_cast<std::size_t>(y)].Probability(x) /
          CellSolidAngle(y, width_, height_);
    }
  }
}

DirectionSample EnvironmentSampler::Sample(const Vec3& normal, double u0, double u1) const {
  if (width_ * height_ == 1) {
    const Vec3 local = SampleUniformHemisphere(u0, u1);
    return {Frame::FromNormal(normal).ToWorld(local), UniformHemispherePdf(), {}};
  }
  Draft draft = ChooseRow(u0, u1);
  ChooseColumn(draft);
  return Finish(draft);
}

EnvironmentSampler::Draft EnvironmentSampler::ChooseRow(double u0, double u1) const {
  Draft draft;
  draft.u0 = u0;
  draft.row = rows_.Sample(u1, draft.in_row);
  columns_[static_cast<std::size_t>(draft.row)].PrefetchBucket(u0);
  return draft;
}

void EnvironmentSampler::LookForColumn(const Draft& draft) const {
  columns_[static_cast<std::size_t>(draft.row)].PrefetchSums(draft.u0);
}

void EnvironmentSampler::ChooseColumn(Draft& draft) const {
  draft.column = columns_[static_cast<std::size_t>(draft.row)].Sample(draft.u0, draft.in_column);
  const int x = draft.column;
  const int y = draft.row;
  const int texel = y * width_ + x;
  // Maps do not fit into fast memory.
  const int left = texel - (draft.in_column < 0.5 && x > 0 ? 1 : 0);
  const int other_row =
      draft.in_row < 0.5 ? std::max(y - 1, 0) - y : std::min(y + 1, height_ - 1) - y;
  __builtin_prefetch(&density_[static_cast<std::size_t>(texel)]);
  __builtin_prefetch(texels_ + left);
  __builtin_prefetch(texels_ + left + other_row * width_);
}

DirectionSample EnvironmentSampler::Finish(const Draft& draft) const {
  const auto row = static_cast<std::size_t>(draft.row);
  const double top = row_cos_[row];
  const double bottom = row_cos_[row + 1];
  const double cos_theta = std::clamp(top + draft.in_row * (bottom - top), -1.0, 1.0);
  const double sin_theta = std::sqrt(1.0 - cos_theta * cos_theta);
  const double turn = (draft.column + draft.in_column) / width_;
  const auto [sine, cosine] = SineCosineOfTurn(turn);
  return {{sin_theta * sine, cos_theta, -sin_theta * cosine},
          density_[static_cast<std::size_t>(draft.row * width_ + draft.column)],
          {turn, PolarShare(cos_theta)}};
}

double EnvironmentSampler::Pdf(const Vec2& uv, bool above) const {
  if (width_ * height_ == 1) return above ? UniformHemispherePdf() : 0.0;
  const int x = std::min(static_cast<int>(uv.x * width_), width_ - 1);
  const int y = std::min(static_cast<int>(uv.y * height_), height_ - 1);
  return density_[static_cast<std::size_t>(y * width_ + x)];
}

}  // namespace pathfit::renderer
