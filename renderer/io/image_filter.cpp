#include "renderer/io/image_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "renderer/core/error.h"
#include "renderer/io/image_check.h"

namespace pathfit::renderer {
namespace {

/// Share of source sample `index` in a target sample.
struct Overlap {
  std::size_t index = 0;
  double weight = 0.0;
};

/// For each target sample the source samples its interval covers; weights sum to one.
std::vector<std::vector<Overlap>> BoxOverlaps(int source_size, int target_size) {
  // In units in which source samples are target_size long and target samples source_size.
  const std::int64_t source = source_size;
  const std::int64_t target = target_size;
  std::vector<std::vector<Overlap>> overlaps(static_cast<std::size_t>(target_size));
  for (std::int64_t j = 0; j < target; ++j) {
    const std::int64_t begin = j * source;
    const std::int64_t end = begin + source;
    for (std::int64_t i = begin / target; i * target < end; ++i) {
      const std::int64_t covered = std::min(end, (i + 1) * target) - std::max(begin, i * target);
      overlaps[static_cast<std::size_t>(j)].push_back(
          {static_cast<std::size_t>(i),
           static_cast<double>(covered) / static_cast<double>(source)});
    }
  }
  return overlaps;
}

void CheckMask(const Image& mask) {
  CheckImageSize(mask.width, mask.height, "mask");
  if (mask.channels != 1) throw IoError("a mask must have one channel");
}

/// Distance between centres to the nearest pixel that is not of the wanted kind.
cv::Mat DistanceFromOthers(const Image& mask, bool inside) {
  cv::Mat kind(mask.height, mask.width, CV_8U);
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      kind.at<unsigned char>(y, x) = (mask.At(x, y, 0) > 0.5F) == inside ? 255 : 0;
    }
  }
  cv::Mat distance;
  cv::distanceTransform(kind, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  return distance;
}

}  // namespace

PixelBox BoxAbove(const Image& image, float level) {
  PixelBox box{image.width, image.height, -1, -1};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (!(image.At(x, y, 0) > level)) continue;
      box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x), std::max(box.y1, y)};
    }
  }
  return box;
}

double MeanOfChannels(const Image& image, int x, int y) {
  double sum = 0.0;
  for (int c = 0; c < image.channels; ++c) sum += static_cast<double>(image.At(x, y, c));
  return sum / image.channels;
}

Image ResizeArea(const Image& image, int width, int height) {
  CheckImageSize(width, height, "resized image");
  if (image.Empty()) throw IoError("an empty image cannot be resized");
  if (width == image.width && height == image.height) return image;
  const std::vector<std::vector<Overlap>> columns = BoxOverlaps(image.width, width);
  const std::vector<std::vector<Overlap>> rows = BoxOverlaps(image.height, height);
  const auto channels = static_cast<std::size_t>(image.channels);
  const std::size_t row_size = static_cast<std::size_t>(image.width) * channels;
  Image result(width, height, image.channels);
  std::vector<double> row(row_size);
  for (std::size_t y = 0; y < rows.size(); ++y) {
    std::ranges::fill(row, 0.0);
    for (const Overlap& source : rows[y]) {
      const float* pixels = image.data.data() + source.index * row_size;
      for (std::size_t i = 0; i < row_size; ++i) {
        row[i] += source.weight * static_cast<double>(pixels[i]);
      }
    }
    float* target = result.data.data() + y * columns.size() * channels;
    for (const std::vector<Overlap>& column : columns) {
      for (std::size_t c = 0; c < channels; ++c) {
        double sum = 0.0;
        for (const Overlap& source : column) {
          sum += source.weight * row[source.index * channels + c];
        }
        *target++ = static_cast<float>(sum);
      }
    }
  }
  return result;
}

Image SignedDistanceToMask(const Image& mask) {
  CheckMask(mask);
  const auto is_inside = [](float value) { return value > 0.5F; };
  Image result(mask.width, mask.height, 1);
  const bool all_inside = std::ranges::all_of(mask.data, is_inside);
  const bool none_inside = std::ranges::none_of(mask.data, is_inside);
  if (all_inside || none_inside) {
    const float far = static_cast<float>(mask.width) + static_cast<float>(mask.height);
    std::ranges::fill(result.data, all_inside ? far : -far);
    return result;
  }
  const cv::Mat to_outside = DistanceFromOthers(mask, true);
  const cv::Mat to_inside = DistanceFromOthers(mask, false);
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      // One of the two is zero; half a pixel leads from a centre to the boundary.
      const float inner = to_outside.at<float>(y, x);
      const float outer = to_inside.at<float>(y, x);
      result.At(x, y, 0) = inner > 0.0F ? inner - 0.5F : 0.5F - outer;
    }
  }
  return result;
}

Image Erode(const Image& mask, int px) {
  if (px < 0) throw IoError("erosion must be by 0 pixels or more");
  Image result = SignedDistanceToMask(mask);
  const bool has_outside =
      std::ranges::any_of(mask.data, [](float value) { return !(value > 0.5F); });
  // Distances between centres are square roots of integers: half of the least gap keeps rounding
  // out.
  const float limit = static_cast<float>(px) - 0.5F + 1e-3F;
  for (float& value : result.data) value = !has_outside || value > limit ? 1.0F : 0.0F;
  return result;
}

}  // namespace pathfit::renderer
