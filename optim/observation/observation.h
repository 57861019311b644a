#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "optim/observation/packed_image.h"
#include "renderer/image/image.h"
#include "renderer/sensor/camera.h"

namespace pathfit::optim {

/// What black in a mask says: the object is not there (evidence, compared with rendered coverage),
/// or no data.
enum class MaskMeaning { kNone, kSilhouette, kIgnore };

/// Where a mask comes from.
enum class MaskSource { kNone, kFolder, kMaskPath, kAlpha };

/// The files of a view; empty if its images come from none.
struct ViewFiles {
  std::filesystem::path photo;
  MaskSource mask_source = MaskSource::kNone;
  std::filesystem::path mask;  ///< empty without a file of its own
};

/// One photo with its camera, at the resolution it is fitted at most.
struct View {
  std::string name;  ///< file name of the photo
  renderer::Camera camera;
  /// Of the photo's file, which is area-averaged to the size of the camera; 0: as the camera.
  int file_width = 0, file_height = 0;
  PackedImage photo;  ///< 3 channels, linear Rec.709; size of the camera
  PackedImage mask;   ///< 1 channel, 0..1, 1 = object (or data); empty without masks
  /// 1 channel: share of each pixel that was at or above the clipping level in the file; empty if
  /// none is.
  PackedImage clipped;
  /// The mask is the photo's alpha channel and its colours are not multiplied by it (PNG).
  bool straight_alpha = false;
  bool validation = false;  ///< never fitted, always reported
  /// What EXIF says of its exposure, in EV around the mean of all; 0 unless every photo has a
  /// plausible one.
  float exif_ev = 0.0F;
  ViewFiles files;
};

struct ObservationSet {
  std::vector<View> views;
  MaskMeaning mask_meaning = MaskMeaning::kNone;
  int mask_erode_px = 0;  ///< colours are compared this far inside the mask, at full size
  /// Nothing is rendered behind the object: with silhouettes, photos are compared as they would be
  /// before black, whatever their background.
  bool black_background = false;
  double metres_per_unit = 0.0;          ///< of camera places, as their file says; 0: unknown
  int num_with_flash = 0;                ///< photos in which a flash fired, as EXIF says
  std::vector<std::string> assumptions;  ///< sentences for `check`, run.json and the report
};

/// A view area-averaged to `scale` times its size (rounded, at least 1 px).
/// `photo`: of what masks leave out nothing is averaged into it.
/// `color_weight`: 1 channel, share of the pixel that is valid colour evidence (eroded mask or 1).
struct ViewLevel {
  renderer::Camera camera;
  renderer::Image photo;
  renderer::Image mask;
  renderer::Image clipped;
  renderer::Image color_weight;
};

/// A level in few bytes beside its view's: what is small is kept, a photo of nearly full size is
/// averaged again whenever it is unpacked. Of a view that is read later (PackedImage::Later), it is
/// made when it is first unpacked.
class PackedLevel {
 public:
  /// `view` and `observations` must outlive it.
  PackedLevel(const View& view, const ObservationSet& observations, double scale);
  explicit PackedLevel(const ViewLevel& level);

  [[nodiscard]] const renderer::Camera& camera() const { return camera_; }
  [[nodiscard]] ViewLevel Unpack() const;
  [[nodiscard]] renderer::Image ColorWeight() const { return color_weight_.Unpack(); }
  [[nodiscard]] bool HasClipped() const { return !clipped_.Empty(); }
  /// Beside what its view takes.
  [[nodiscard]] std::size_t MemoryBytes() const { return bytes_; }

 private:
  renderer::Camera camera_;
  PackedImage photo_, mask_, clipped_, color_weight_;
  const View* view_ = nullptr;              ///< whose photo it is, if there is none of its own
  MaskMeaning masks_ = MaskMeaning::kNone;  ///< of those that change the photo
  std::size_t bytes_ = 0;
};

/// Intersection over union of a rendered coverage (> 1/2) and a mask (> 1/2), both of one channel
/// and the same size; 1 when both are empty.
double MaskIou(const renderer::Image& coverage, const renderer::Image& mask);

}  // namespace pathfit::optim
