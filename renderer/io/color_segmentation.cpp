#include "renderer/io/color_segmentation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "renderer/core/error.h"
#include "renderer/io/image_check.h"

namespace pathfit::renderer {
namespace {

constexpr int kSameEveryTime = 1;    // seed of the thread's numbers, which start the mixtures
constexpr int kBySides = 4;          // neighbours of a pixel
constexpr double kLeastPart = 0.05;  // of the largest

unsigned char ToByte(float encoded) {
  return static_cast<unsigned char>(
      std::lround(255.0 * std::clamp(static_cast<double>(encoded), 0.0, 1.0)));
}

unsigned char ToMark(ObjectHint hint) {
  switch (hint) {
    case ObjectHint::kBackground:
      return cv::GC_BGD;
    case ObjectHint::kMaybeBackground:
      return cv::GC_PR_BGD;
    case ObjectHint::kMaybeObject:
      return cv::GC_PR_FGD;
    case ObjectHint::kObject:
      return cv::GC_FGD;
  }
  return cv::GC_BGD;
}

bool IsObject(unsigned char mark) { return mark == cv::GC_FGD || mark == cv::GC_PR_FGD; }

/// The parts of an image's pixels of one value.
struct Parts {
  std::vector<int> labels;  ///< of each pixel; -1: of another value
  std::vector<int> areas;   ///< pixels
  std::vector<bool> at_border;
};

Parts PartsOf(const Image& image, float value) {
  cv::Mat kind(image.height, image.width, CV_8U);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      kind.at<unsigned char>(y, x) = image.At(x, y, 0) == value ? 1 : 0;
    }
  }
  cv::Mat labels, figures, centres;
  const int count = cv::connectedComponentsWithStats(kind, labels, figures, centres, kBySides);
  Parts parts;
  for (int i = 1; i < count; ++i) {  // 0 is of other values
    const int left = figures.at<int>(i, cv::CC_STAT_LEFT);
    const int top = figures.at<int>(i, cv::CC_STAT_TOP);
    parts.areas.push_back(figures.at<int>(i, cv::CC_STAT_AREA));
    parts.at_border.push_back(left == 0 || top == 0 ||
                              left + figures.at<int>(i, cv::CC_STAT_WIDTH) == image.width ||
                              top + figures.at<int>(i, cv::CC_STAT_HEIGHT) == image.height);
  }
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) parts.labels.push_back(labels.at<int>(y, x) - 1);
  }
  return parts;
}

}  // namespace

Image SegmentByColor(const Image& encoded, const std::vector<ObjectHint>& hints, int num_turns) {
  CheckImageSize(encoded.width, encoded.height, "image to segment");
  if (encoded.channels != 3) throw IoError("an image to segment must have three channels");
  cv::Mat pixels(encoded.height, encoded.width, CV_8UC3);
  cv::Mat marks(encoded.height, encoded.width, CV_8U);
  int num_object = 0;
  for (int y = 0; y < encoded.height; ++y) {
    for (int x = 0; x < encoded.width; ++x) {
      auto& pixel = pixels.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c) pixel[c] = ToByte(encoded.At(x, y, c));
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(encoded.width) +
                     static_cast<std::size_t>(x);
      marks.at<unsigned char>(y, x) = ToMark(hints[i]);
      num_object += IsObject(ToMark(hints[i])) ? 1 : 0;
    }
  }
  if (num_object > 0 && num_object < encoded.width * encoded.height) {
    cv::setRNGSeed(kSameEveryTime);
    cv::Mat background, object;
    cv::grabCut(pixels, marks, cv::Rect(), background, object, num_turns, cv::GC_INIT_WITH_MASK);
  }
  Image result(encoded.width, encoded.height, 1);
  for (int y = 0; y < encoded.height; ++y) {
    for (int x = 0; x < encoded.width; ++x) {
      result.At(x, y, 0) = IsObject(marks.at<unsigned char>(y, x)) ? 1.0F : 0.0F;
    }
  }
  return result;
}

Image LargestPart(const Image& mask, double hole) {
  return PartsWithin(mask, Image(mask.width, mask.height, 1), hole);
}

Image PartsWithin(const Image& mask, const Image& expected, double hole) {
  CheckImageSize(mask.width, mask.height, "mask");
  if (expected.width != mask.width || expected.height != mask.height) {
    throw IoError("where parts of a mask are expected must have its size");
  }
  Image result(mask.width, mask.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    result.data[i] = mask.data[i] > 0.5F ? 1.0F : 0.0F;
  const Parts inside = PartsOf(result, 1.0F);
  const auto largest = std::ranges::max_element(inside.areas);
  std::vector<double> num_expected(inside.areas.size());
  for (std::size_t i = 0; i < result.data.size(); ++i) {
    if (inside.labels[i] >= 0 && expected.data[i] > 0.5F) {
      num_expected[static_cast<std::size_t>(inside.labels[i])] += 1.0;
    }
  }
  std::vector<bool> is_kept;
  for (std::size_t part = 0; part < inside.areas.size(); ++part) {
    const double area = inside.areas[part];
    is_kept.push_back(inside.areas.begin() + static_cast<std::ptrdiff_t>(part) == largest ||
                      (area >= kLeastPart * *largest && num_expected[part] > 0.5 * area));
  }
  for (std::size_t i = 0; i < result.data.size(); ++i) {
    const int part = inside.labels[i];
    if (part < 0 || !is_kept[static_cast<std::size_t>(part)]) result.data[i] = 0.0F;
  }
  const Parts outside = PartsOf(result, 0.0F);
  const double most = hole * (inside.areas.empty() ? 0.0 : *largest);
  for (std::size_t i = 0; i < result.data.size(); ++i) {
    const int part = outside.labels[i];
    if (part >= 0 && !outside.at_border[static_cast<std::size_t>(part)] &&
        outside.areas[static_cast<std::size_t>(part)] <= most) {
      result.data[i] = 1.0F;
    }
  }
  return result;
}

}  // namespace pathfit::renderer
