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

constexpr int kSameEveryTime = 1;  // seed of the thread's numbers, which start the mixtures
constexpr int kBySides = 4;        // neighbours of a pixel

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

Image LargestPart(const Image& mask) {
  CheckImageSize(mask.width, mask.height, "mask");
  cv::Mat kind(mask.height, mask.width, CV_8U);
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      kind.at<unsigned char>(y, x) = mask.At(x, y, 0) > 0.5F ? 1 : 0;
    }
  }
  cv::Mat labels, figures, centres;
  const int count = cv::connectedComponentsWithStats(kind, labels, figures, centres, kBySides);
  int largest = 0;
  for (int i = 1; i < count; ++i) {  // 0 is what is outside
    if (largest == 0 ||
        figures.at<int>(i, cv::CC_STAT_AREA) > figures.at<int>(largest, cv::CC_STAT_AREA)) {
      largest = i;
    }
  }
  Image result(mask.width, mask.height, 1);
  for (int y = 0; largest > 0 && y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      result.At(x, y, 0) = labels.at<int>(y, x) == largest ? 1.0F : 0.0F;
    }
  }
  return result;
}

}  // namespace pathfit::renderer
