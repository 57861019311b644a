#include "optim/observation/observation_stream.h"

#include <cstddef>
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
    visit(camera.vignetting);
    visit(camera.world_from_camera);
    visit(camera.rotation);
    visit(camera.filter);
    visit(camera.gain);
    visit(camera.lights_off);
  }
};

namespace {

// What travels as it is, once for both directions.
void VisitView(auto& view, const auto& visit) {
  visit(view.name);
  visit(view.camera);
  visit(view.file_width);
  visit(view.file_height);
  visit(view.straight_alpha);
  visit(view.validation);
  visit(view.exif_ev);
  visit(view.files.mask_source);
}
void VisitSet(auto& set, const auto& visit) {
  visit(set.mask_meaning);
  visit(set.mask_erode_px);
  visit(set.black_background);
  visit(set.metres_per_unit);
  visit(set.assumptions);
}

/// What stands for the images of a view.
struct SharedImages {
  std::string photo, mask;
  int width = 0, height = 0;  // of the photo as it is kept
  bool has_mask = false, has_clipped = false;

  static void VisitParts(auto& images, const auto& visit) {
    visit(images.photo);
    visit(images.mask);
    visit(images.width);
    visit(images.height);
    visit(images.has_mask);
    visit(images.has_clipped);
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

void ReadLater(const SharedImages& images,
               const std::shared_ptr<const ObservationOptions>& options,
               View& view) {
  view.files.photo = images.photo;
  view.files.mask = images.mask;
  const int width = images.width;
  const int height = images.height;
  const auto reader = std::make_shared<ColorReader>(view.files, options);
  view.photo = PackedImage::Later(width, height, 3, [reader] { return reader->Photo(); });
  if (images.has_clipped) {
    view.clipped = PackedImage::Later(width, height, 1, [reader] { return reader->Clipped(); });
  }
  if (images.has_mask) {
    view.mask = PackedImage::Later(
        width, height, 1, [reader, width, height] { return reader->Mask(width, height); });
  }
}

}  // namespace

Bytes EncodeObservations(const ObservationSet& observations) {
  ByteWriter writer;
  const auto put = [&writer](const auto& part) { writer.Put(part); };
  VisitSet(observations, put);
  writer.Put(observations.views.size());
  for (const View& view : observations.views) {
    VisitView(view, put);
    writer.Put(SharedImages{view.files.photo.string(),
                            view.files.mask.string(),
                            view.photo.width(),
                            view.photo.height(),
                            !view.mask.Empty(),
                            !view.clipped.Empty()});
  }
  return writer.Take();
}

ObservationSet DecodeObservations(const Bytes& bytes, const ObservationOptions& options) {
  ByteReader reader(bytes);
  const auto get = [&reader](auto& part) { reader.Get(part); };
  const auto kept = std::make_shared<const ObservationOptions>(options);
  ObservationSet set;
  VisitSet(set, get);
  std::size_t num_views = 0;
  reader.Get(num_views);
  for (; num_views > 0; --num_views) {
    View& view = set.views.emplace_back();
    VisitView(view, get);
    SharedImages images;
    reader.Get(images);
    ReadLater(images, kept, view);
  }
  return set;
}

}  // namespace pathfit::optim
