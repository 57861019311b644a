#include "optim/observation/observation_stream.h"

#include <memory>
#include <string>
#include <utility>

#include "optim/observation/photo_file.h"
#include "renderer/image/image.h"
#include "renderer/io/image_filter.h"

namespace pathfit::optim {

template <>
struct Parts<renderer::Camera> {
  static void Visit(auto& camera, const auto& visit) {
    visit(camera.name);
    visit(camera.projection);
    visit(camera.width);
    visit(camera.height);
    visit(camera.fx);
    visit(camera.fy);
    visit(camera.cx);
    visit(camera.cy);
    visit(camera.distortion);
    visit(camera.world_from_camera);
    visit(camera.rotation);
    visit(camera.filter);
    visit(camera.gain);
    visit(camera.lights_off);
  }
};

namespace {

struct SharedView {
  std::string name, photo, mask;
  renderer::Camera camera;
  MaskSource mask_source = MaskSource::kNone;
  int width = 0, height = 0;  // of the photo as it is kept
  int file_width = 0, file_height = 0;
  bool has_mask = false, has_clipped = false, straight_alpha = false, validation = false;
  float exif_ev = 0.0F;

  static void VisitParts(auto& view, const auto& visit) {
    visit(view.name);
    visit(view.photo);
    visit(view.mask);
    visit(view.camera);
    visit(view.mask_source);
    visit(view.width);
    visit(view.height);
    visit(view.file_width);
    visit(view.file_height);
    visit(view.has_mask);
    visit(view.has_clipped);
    visit(view.straight_alpha);
    visit(view.validation);
    visit(view.exif_ev);
  }
};

struct SharedSet {
  std::vector<SharedView> views;
  MaskMeaning mask_meaning = MaskMeaning::kNone;
  int mask_erode_px = 0;
  bool black_background = false;
  double metres_per_unit = 0.0;
  std::vector<std::string> assumptions;

  static void VisitParts(auto& set, const auto& visit) {
    visit(set.views);
    visit(set.mask_meaning);
    visit(set.mask_erode_px);
    visit(set.black_background);
    visit(set.metres_per_unit);
    visit(set.assumptions);
  }
};

/// Photo and clipping of a view, which come from one file.
class ColorReader {
 public:
  ColorReader(ViewFiles files, std::shared_ptr<const ObservationOptions> options)
      : files_(std::move(files)), options_(std::move(options)) {}

  const PackedImage& Photo() { return Read().photo; }
  const PackedImage& Clipped() { return Read().clipped; }
  /// The mask alone: visual hulls need all masks and no photo.
  [[nodiscard]] PackedImage Mask(int width, int height) const {
    renderer::Image mask = files_.mask_source == MaskSource::kAlpha
                               ? ReadPhotoFile(files_.photo, *options_).alpha
                               : ReadMaskFile(files_.mask, options_->apply_exif_orientation);
    FinishMask(options_->masks, mask);
    if (!mask.Empty() && (mask.width != width || mask.height != height)) {
      mask = renderer::ResizeArea(mask, width, height);
    }
    return mask;
  }

 private:
  struct Colors {
    PackedImage photo, clipped;
  };
  const Colors& Read() {
    std::call_once(once_, [this] {
      PhotoFile file = ReadPhotoFile(files_.photo, *options_);
      ReducePhoto(*options_, file);
      colors_ = {file.photo, file.clipped};
    });
    return colors_;
  }

  ViewFiles files_;
  std::shared_ptr<const ObservationOptions> options_;
  std::once_flag once_;
  Colors colors_;
};

View ReadLater(const SharedView& shared, const std::shared_ptr<const ObservationOptions>& options) {
  View view;
  view.name = shared.name;
  view.camera = shared.camera;
  view.file_width = shared.file_width;
  view.file_height = shared.file_height;
  view.straight_alpha = shared.straight_alpha;
  view.validation = shared.validation;
  view.exif_ev = shared.exif_ev;
  view.files = {shared.photo, shared.mask_source, shared.mask};
  const int width = shared.width;
  const int height = shared.height;
  const auto reader = std::make_shared<ColorReader>(view.files, options);
  view.photo = PackedImage::Later(width, height, 3, [reader] { return reader->Photo(); });
  if (shared.has_clipped) {
    view.clipped = PackedImage::Later(width, height, 1, [reader] { return reader->Clipped(); });
  }
  if (shared.has_mask) {
    view.mask = PackedImage::Later(
        width, height, 1, [reader, width, height] { return reader->Mask(width, height); });
  }
  return view;
}

}  // namespace

Bytes EncodeObservations(const ObservationSet& observations) {
  SharedSet set;
  for (const View& view : observations.views) {
    set.views.push_back({view.name,
                         view.files.photo.string(),
                         view.files.mask.string(),
                         view.camera,
                         view.files.mask_source,
                         view.photo.width(),
                         view.photo.height(),
                         view.file_width,
                         view.file_height,
                         !view.mask.Empty(),
                         !view.clipped.Empty(),
                         view.straight_alpha,
                         view.validation,
                         view.exif_ev});
  }
  set.mask_meaning = observations.mask_meaning;
  set.mask_erode_px = observations.mask_erode_px;
  set.black_background = observations.black_background;
  set.metres_per_unit = observations.metres_per_unit;
  set.assumptions = observations.assumptions;
  ByteWriter writer;
  writer.Put(set);
  return writer.Take();
}

ObservationSet DecodeObservations(const Bytes& bytes, const ObservationOptions& options) {
  SharedSet shared;
  ByteReader(bytes).Get(shared);
  const auto kept = std::make_shared<const ObservationOptions>(options);
  ObservationSet set;
  for (const SharedView& view : shared.views) set.views.push_back(ReadLater(view, kept));
  set.mask_meaning = shared.mask_meaning;
  set.mask_erode_px = shared.mask_erode_px;
  set.black_background = shared.black_background;
  set.metres_per_unit = shared.metres_per_unit;
  set.assumptions = shared.assumptions;
  return set;
}

}  // namespace pathfit::optim
