#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>

#include "optim/observation/camera_import.h"
#include "optim/observation/rotation.h"
#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

using renderer::IoError;

constexpr std::int64_t kMaxImageSize = 100000;

/// Lens models by COLMAP's names; each letter of `layout` is the meaning of one parameter in the
/// file: f both focal lengths, x y one of them, u v the principal point, 1 2 radial, p q
/// tangential.
struct LensModel {
  std::string_view name;
  std::string_view layout;
};
constexpr std::array<LensModel, 5> kLensModels = {{{"SIMPLE_PINHOLE", "fuv"},
                                                   {"PINHOLE", "xyuv"},
                                                   {"SIMPLE_RADIAL", "fuv1"},
                                                   {"RADIAL", "fuv12"},
                                                   {"OPENCV", "xyuv12pq"}}};

/// The words of one line, taken one after the other; errors name file and line.
class LineReader {
 public:
  LineReader(std::string_view line, std::string place) : rest_(line), place_(std::move(place)) {}

  std::string_view Word(const char* what) {
    SkipBlanks();
    const std::size_t length = std::min(rest_.find_first_of(kBlanks), rest_.size());
    if (length == 0) {
      throw IoError(place_ + ": " + what + " is missing");
    }
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }
  double Number(const char* what) {
    double value = 0.0;
    const std::string_view word = Word(what);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      throw IoError(place_ + ": " + what + ": '" + std::string(word.substr(0, 40)) +
                    "' is not a finite number");
    }
    return value;
  }
  std::int64_t Integer(const char* what) {
    std::int64_t value = 0;
    const std::string_view word = Word(what);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      throw IoError(place_ + ": " + what + ": '" + std::string(word.substr(0, 40)) +
                    "' is not a whole number");
    }
    return value;
  }
  bool AtEnd() {
    SkipBlanks();
    return rest_.empty();
  }
  /// Everything that is left, without blanks around it.
  std::string_view Remainder() {
    SkipBlanks();
    return rest_.substr(0, rest_.find_last_not_of(kBlanks) + 1);
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r\v\f";
  void SkipBlanks() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
  }

  std::string_view rest_;
  std::string place_;
};

/// Lines of a text file with their numbers; comments are skipped on request only, as points may be
/// an empty line.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path) : name_(path.string()), stream_(path) {
    if (!stream_) {
      throw IoError(name_ + ": cannot be read");
    }
  }
  bool NextLine(std::string& line) {
    ++number_;
    return static_cast<bool>(std::getline(stream_, line));
  }
  /// The next line that is neither empty nor a comment.
  bool NextRecord(std::string& line) {
    while (NextLine(line)) {
      const std::size_t first = line.find_first_not_of(" \t\r\v\f");
      if (first != std::string::npos && line[first] != '#') {
        return true;
      }
    }
    return false;
  }
  [[nodiscard]] std::string Place() const { return name_ + ":" + std::to_string(number_); }

 private:
  std::string name_;
  std::ifstream stream_;
  int number_ = 0;
};

int ReadImageSize(LineReader& line, const char* what, const std::string& place) {
  const std::int64_t size = line.Integer(what);
  if (size < 1 || size > kMaxImageSize) {
    throw IoError(place + ": " + what + " " + std::to_string(size) +
                  " is not an image size (1 to 100000)");
  }
  return static_cast<int>(size);
}

void SetParameter(char meaning, double value, renderer::Camera& camera) {
  switch (meaning) {
    case 'f':
      camera.fx = camera.fy = value;
      break;
    case 'x':
      camera.fx = value;
      break;
    case 'y':
      camera.fy = value;
      break;
    case 'u':
      camera.cx = value;
      break;
    case 'v':
      camera.cy = value;
      break;
    case '1':
      camera.distortion.k1 = value;
      break;
    case '2':
      camera.distortion.k2 = value;
      break;
    case 'p':
      camera.distortion.p1 = value;
      break;
    default:
      camera.distortion.p2 = value;
      break;
  }
}

const LensModel& FindLensModel(std::string_view name, const std::string& camera_place) {
  for (const LensModel& lens : kLensModels) {
    if (lens.name == name) {
      return lens;
    }
  }
  throw IoError(
      camera_place + " uses the lens model " + std::string(name) +
      ", which is not supported (allowed: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, "
      "OPENCV); either undistort the photos (colmap image_undistorter writes PINHOLE), or "
      "run the reconstruction again with --ImageReader.camera_model OPENCV, or leave out "
      "the images of this camera");
}

std::map<std::int64_t, renderer::Camera> ReadCameras(const std::filesystem::path& path) {
  std::map<std::int64_t, renderer::Camera> cameras;
  TextFile file(path);
  for (std::string text; file.NextRecord(text);) {
    const std::string place = file.Place();
    LineReader line(text, place);
    const std::int64_t id = line.Integer("camera id");
    const std::string camera_place = place + ": camera " + std::to_string(id);
    const LensModel& lens = FindLensModel(line.Word("camera model"), camera_place);
    renderer::Camera camera;
    camera.width = ReadImageSize(line, "width", place);
    camera.height = ReadImageSize(line, "height", place);
    for (const char meaning : lens.layout) {
      SetParameter(meaning, line.Number("lens parameter"), camera);
    }
    if (!line.AtEnd()) {
      throw IoError(camera_place + ": more than the " + std::to_string(lens.layout.size()) +
                    " parameters of " + std::string(lens.name));
    }
    if (camera.fx <= 0.0 || camera.fy <= 0.0) {
      throw IoError(camera_place + ": the focal length must be positive");
    }
    if (!cameras.emplace(id, camera).second) {
      throw IoError(camera_place + " is given twice");
    }
  }
  if (cameras.empty()) {
    throw IoError(path.string() + ": holds no camera");
  }
  return cameras;
}

/// COLMAP's camera has y down and looks along +z; ours is turned by pi about x.
renderer::Transform ReadPose(LineReader& line, const std::string& place) {
  double q[4];
  for (double& component : q) {
    component = line.Number("quaternion");
  }
  const renderer::Mat3 camera_from_world = RotationFromQuaternion(q[0], q[1], q[2], q[3], place);
  renderer::Vec3 t;
  t.x = line.Number("translation");
  t.y = line.Number("translation");
  t.z = line.Number("translation");
  const renderer::Mat3 rotation = renderer::Transposed(camera_from_world);
  return {{rotation.x, -rotation.y, -rotation.z}, -(rotation * t)};
}

/// The second line of an image must be triples of numbers: anything else means that the empty lines
/// were lost, and with them every other image.
void CheckPointsLine(const std::string& text, const std::string& place) {
  LineReader line(text, place);
  for (int i = 0; !line.AtEnd(); ++i) {
    try {
      line.Number("x");
      line.Number("y");
      line.Integer("point id");
    } catch (const IoError&) {
      throw IoError(
          place +
          ": expected the 2D points of the image above (triples x y id; the line may be empty, "
          "but it must be there)");
    }
  }
}

}  // namespace

ImportedCameras ReadColmapText(const std::filesystem::path& folder) {
  const std::filesystem::path cameras_path = folder / "cameras.txt";
  const std::filesystem::path images_path = folder / "images.txt";
  const std::map<std::int64_t, renderer::Camera> cameras = ReadCameras(cameras_path);
  ImportedCameras result{.format = kColmapFormat,
                         .folder = folder,
                         .files = {cameras_path, images_path},
                         .cameras = {},
                         .metres_per_unit = 0.0};
  TextFile file(images_path);
  for (std::string text; file.NextRecord(text);) {
    const std::string place = file.Place();
    LineReader line(text, place);
    ImportedCamera imported;
    imported.place = place;
    line.Integer("image id");
    const renderer::Transform pose = ReadPose(line, place);
    const std::int64_t camera_id = line.Integer("camera id");
    imported.image = line.Remainder();
    const auto camera = cameras.find(camera_id);
    if (camera == cameras.end()) {
      throw IoError(place + ": camera " + std::to_string(camera_id) + " is not in " +
                    cameras_path.string());
    }
    if (imported.image.empty()) {
      throw IoError(place + ": the image name is missing");
    }
    imported.camera = camera->second;
    imported.camera.name = imported.image;
    imported.camera.world_from_camera = pose;
    result.cameras.push_back(std::move(imported));
    if (std::string points; file.NextLine(points)) {
      CheckPointsLine(points, file.Place());
    }
  }
  if (result.cameras.empty()) {
    throw IoError(images_path.string() + ": holds no image");
  }
  return result;
}

}  // namespace pathfit::optim
