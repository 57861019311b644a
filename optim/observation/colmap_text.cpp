#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "optim/observation/camera_import.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::optim {
namespace {

using renderer::IoError;

constexpr std::int64_t kMaxImageSize = 100000;
constexpr double kLengthTolerance = 1e-4;

/// Lens models by COLMAP's names; each letter of `layout` is the meaning of one parameter in the
/// file: f both focal lengths, x y one of them, u v the principal point, 1 2 3 radial, p q
/// tangential, 0 a coefficient that must be zero.
struct LensModel {
  std::string_view name;
  std::string_view layout;
};
constexpr std::array<LensModel, 6> kLensModels = {{{"SIMPLE_PINHOLE", "fuv"},
                                                   {"PINHOLE", "xyuv"},
                                                   {"SIMPLE_RADIAL", "fuv1"},
                                                   {"RADIAL", "fuv12"},
                                                   {"OPENCV", "xyuv12pq"},
                                                   {"FULL_OPENCV", "xyuv12pq3000"}}};

/// The words of one line, taken one after the other; errors name file and line.
class Words {
 public:
  Words(std::string_view line, std::string place) : rest_(line), place_(std::move(place)) {}

  std::string_view Word(const char* what) {
    const std::string_view word = renderer::NextToken(rest_);
    if (word.empty()) throw IoError(place_ + ": " + what + " is missing");
    return word;
  }
  double Number(const char* what) {
    return Parsed(what, renderer::ParseReal, "is not a finite number");
  }
  std::int64_t Integer(const char* what) {
    return Parsed(what, renderer::ParseInteger, "is not a whole number");
  }
  bool AtEnd() { return Remainder().empty(); }
  /// Everything that is left, without blanks around it.
  std::string_view Remainder() {
    constexpr std::string_view kBlanks = " \t\r\v\f";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
    return rest_.substr(0, rest_.find_last_not_of(kBlanks) + 1);
  }

 private:
  template <class Value>
  Value Parsed(const char* what,
               std::optional<Value> (*parse)(std::string_view),
               const char* problem) {
    const std::string_view word = Word(what);
    const std::optional<Value> value = parse(word);
    if (value) return *value;
    throw IoError(place_ + ": " + what + ": '" + std::string(word.substr(0, 40)) + "' " + problem);
  }

  std::string_view rest_;
  std::string place_;
};

/// Lines of a text file with their numbers; comments are skipped on request only, as points may be
/// an empty line.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path)
      : name_(path.string()), text_(renderer::ReadWholeFile(path)), lines_(text_) {}

  bool NextLine(std::string_view& line) { return lines_.Next(line); }
  /// The next line that is neither empty nor a comment.
  bool NextRecord(std::string_view& line) {
    while (NextLine(line)) {
      std::string_view words = line;
      if (const auto first = renderer::NextToken(words); !first.empty() && first[0] != '#') {
        return true;
      }
    }
    return false;
  }
  [[nodiscard]] std::string Place() const {
    return name_ + ":" + std::to_string(lines_.LineNumber());
  }

 private:
  std::string name_;
  std::string text_;
  renderer::LineReader lines_;
};

int ReadImageSize(Words& line, const char* what, const std::string& place) {
  const std::int64_t size = line.Integer(what);
  if (size < 1 || size > kMaxImageSize) {
    throw IoError(place + ": " + what + " " + std::to_string(size) +
                  " is not an image size (1 to 100000)");
  }
  return static_cast<int>(size);
}

/// What to do about a lens that cannot be read.
constexpr const char* kWaysOut =
    "; either undistort the photos (colmap image_undistorter writes PINHOLE), or run the "
    "reconstruction again with --ImageReader.camera_model OPENCV, or leave out the images of this "
    "camera";

void SetParameter(char meaning, double value, const std::string& place, renderer::Camera& camera) {
  renderer::LensDistortion& lens = camera.distortion;
  switch (meaning) {
    case 'f':
      camera.fx = camera.fy = value;
      return;
    case '0':
      if (value == 0.0) return;
      throw IoError(place + " has one of k4, k5, k6 of FULL_OPENCV other than zero, which is not " +
                    "supported" + kWaysOut);
    default:
      const std::pair<char, double*> places[] = {{'x', &camera.fx},
                                                 {'y', &camera.fy},
                                                 {'u', &camera.cx},
                                                 {'v', &camera.cy},
                                                 {'1', &lens.k1},
                                                 {'2', &lens.k2},
                                                 {'3', &lens.k3},
                                                 {'p', &lens.p1},
                                                 {'q', &lens.p2}};
      for (const auto& [letter, number] : places) {
        if (letter == meaning) *number = value;
      }
  }
}

const LensModel& FindLensModel(std::string_view name, const std::string& camera_place) {
  std::string known;
  for (const LensModel& lens : kLensModels) {
    if (lens.name == name) return lens;
    known += (known.empty() ? "" : ", ") + std::string(lens.name);
  }
  throw IoError(camera_place + " uses the lens model " + std::string(name) +
                ", which is not supported (allowed: " + known + ")" + kWaysOut);
}

/// Rotation of a quaternion (w, x, y, z) of length 1.
renderer::Mat3 RotationFromQuaternion(
    double w, double x, double y, double z, const std::string& place) {
  const double norm = std::sqrt(w * w + x * x + y * y + z * z);
  if (!(std::abs(norm - 1.0) <= kLengthTolerance)) {
    char text[120];
    std::snprintf(text, sizeof text, ": the quaternion has length %.6g (allowed: 1 to 1e-4)", norm);
    throw IoError(place + text);
  }
  const double s = 2.0 / (norm * norm);
  return {{1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
          {s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)},
          {s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)}};
}

std::map<std::int64_t, renderer::Camera> ReadCameras(const std::filesystem::path& path) {
  std::map<std::int64_t, renderer::Camera> cameras;
  TextFile file(path);
  for (std::string_view text; file.NextRecord(text);) {
    const std::string place = file.Place();
    Words line(text, place);
    const std::int64_t id = line.Integer("camera id");
    const std::string camera_place = place + ": camera " + std::to_string(id);
    const LensModel& lens = FindLensModel(line.Word("camera model"), camera_place);
    renderer::Camera camera;
    camera.width = ReadImageSize(line, "width", place);
    camera.height = ReadImageSize(line, "height", place);
    for (const char meaning : lens.layout) {
      SetParameter(meaning, line.Number("lens parameter"), camera_place, camera);
    }
    if (!line.AtEnd()) {
      throw IoError(camera_place + ": more than the " + std::to_string(lens.layout.size()) +
                    " parameters of " + std::string(lens.name));
    }
    if (camera.fx <= 0.0 || camera.fy <= 0.0) {
      throw IoError(camera_place + ": the focal length must be positive");
    }
    if (!cameras.emplace(id, camera).second) throw IoError(camera_place + " is given twice");
  }
  if (cameras.empty()) throw IoError(path.string() + ": holds no camera");
  return cameras;
}

/// COLMAP's camera has y down and looks along +z; ours is turned by pi about x.
renderer::Transform ReadPose(Words& line, const std::string& place) {
  double q[4];
  for (double& component : q) component = line.Number("quaternion");
  const renderer::Mat3 camera_from_world = RotationFromQuaternion(q[0], q[1], q[2], q[3], place);
  renderer::Vec3 t;
  t.x = line.Number("translation");
  t.y = line.Number("translation");
  t.z = line.Number("translation");
  const renderer::Mat3 rotation = renderer::Transposed(camera_from_world);
  return {{rotation.x, -rotation.y, -rotation.z}, CheckedCentre(-(rotation * t), place)};
}

/// The second line of an image must be triples of numbers: anything else means that the empty lines
/// were lost, and with them every other image.
void CheckPointsLine(std::string_view text, const std::string& place) {
  Words line(text, place);
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
  ImportedCameras result;
  result.folder = folder;
  result.image_folders = {
      folder / "images", folder / ".." / "images", folder / ".." / ".." / "images"};
  result.has_own_photos = true;
  result.files = {cameras_path, images_path};
  TextFile file(images_path);
  for (std::string_view text; file.NextRecord(text);) {
    const std::string place = file.Place();
    Words line(text, place);
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
    if (imported.image.empty()) throw IoError(place + ": the image name is missing");
    imported.camera = camera->second;
    imported.camera.name = imported.image;
    imported.camera.world_from_camera = pose;
    result.cameras.push_back(std::move(imported));
    if (std::string_view points; file.NextLine(points)) CheckPointsLine(points, file.Place());
  }
  if (result.cameras.empty()) throw IoError(images_path.string() + ": holds no image");
  return result;
}

}  // namespace pathfit::optim
