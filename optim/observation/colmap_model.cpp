#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "optim/observation/camera_import.h"
#include "optim/observation/image_size.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::optim {
namespace {

using renderer::IoError;

constexpr double kLengthTolerance = 1e-4;

/// Lens models by COLMAP's names and numbers; each letter of `layout` is the meaning of one
/// parameter in the file: f both focal lengths, x y one of them, u v the principal point, 1 2 3
/// radial, p q tangential, 0 a coefficient that must be zero.
struct LensModel {
  std::string_view name;
  std::int32_t id;
  std::string_view layout;
};
constexpr std::array<LensModel, 6> kLensModels = {{{"SIMPLE_PINHOLE", 0, "fuv"},
                                                   {"PINHOLE", 1, "xyuv"},
                                                   {"SIMPLE_RADIAL", 2, "fuv1"},
                                                   {"RADIAL", 3, "fuv12"},
                                                   {"OPENCV", 4, "xyuv12pq"},
                                                   {"FULL_OPENCV", 6, "xyuv12pq3000"}}};
/// Names of the others, for messages.
constexpr std::array<std::pair<std::int32_t, std::string_view>, 7> kOtherLensModels = {
    {{5, "OPENCV_FISHEYE"},
     {7, "FOV"},
     {8, "SIMPLE_RADIAL_FISHEYE"},
     {9, "RADIAL_FISHEYE"},
     {10, "THIN_PRISM_FISHEYE"},
     {11, "RAD_TAN_THIN_PRISM_FISHEYE"},
     {12, "SIMPLE_DIVISION"}}};

using Cameras = std::map<std::int64_t, renderer::Camera>;

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

[[noreturn]] void RefuseLens(const std::string& name, const std::string& camera_place) {
  std::string known;
  for (const LensModel& lens : kLensModels) {
    known += (known.empty() ? "" : ", ") + std::string(lens.name);
  }
  throw IoError(camera_place + " uses the lens model " + name +
                ", which is not supported (allowed: " + known + ")" + kWaysOut);
}

const LensModel& LensNamed(std::string_view name, const std::string& camera_place) {
  const auto lens = std::ranges::find(kLensModels, name, &LensModel::name);
  if (lens == kLensModels.end()) RefuseLens(std::string(name), camera_place);
  return *lens;
}

const LensModel& LensNumbered(std::int32_t id, const std::string& camera_place) {
  const auto lens = std::ranges::find(kLensModels, id, &LensModel::id);
  if (lens != kLensModels.end()) return *lens;
  std::string name = "number " + std::to_string(id);
  for (const auto& [number, other] : kOtherLensModels) {
    if (number == id) name = other;
  }
  RefuseLens(name, camera_place);
}

void AddCamera(std::int64_t id,
               const renderer::Camera& camera,
               const std::string& camera_place,
               Cameras& cameras) {
  if (camera.fx <= 0.0 || camera.fy <= 0.0) {
    throw IoError(camera_place + ": the focal length must be positive");
  }
  if (!cameras.emplace(id, camera).second) throw IoError(camera_place + " is given twice");
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

Cameras ReadTextCameras(const std::filesystem::path& path) {
  Cameras cameras;
  TextFile file(path);
  for (std::string_view text; file.NextRecord(text);) {
    const std::string place = file.Place();
    Words line(text, place);
    const std::int64_t id = line.Integer("camera id");
    const std::string camera_place = place + ": camera " + std::to_string(id);
    const LensModel& lens = LensNamed(line.Word("camera model"), camera_place);
    renderer::Camera camera;
    camera.width = CheckedImageSize(static_cast<double>(line.Integer("width")), place + ": width");
    camera.height =
        CheckedImageSize(static_cast<double>(line.Integer("height")), place + ": height");
    for (const char meaning : lens.layout) {
      SetParameter(meaning, line.Number("lens parameter"), camera_place, camera);
    }
    if (!line.AtEnd()) {
      throw IoError(camera_place + ": more than the " + std::to_string(lens.layout.size()) +
                    " parameters of " + std::string(lens.name));
    }
    AddCamera(id, camera, camera_place, cameras);
  }
  return cameras;
}

/// World to camera as COLMAP writes it.
renderer::Transform PoseOf(const std::array<double, 7>& q_t, const std::string& place) {
  const renderer::Mat3 camera_from_world =
      RotationFromQuaternion(q_t[0], q_t[1], q_t[2], q_t[3], place);
  const renderer::Vec3 t{q_t[4], q_t[5], q_t[6]};
  const renderer::Mat3 rotation = renderer::Transposed(camera_from_world);
  return PoseFromForwardAxes(rotation, -(rotation * t), place);
}

/// Adds what a model says of an image, whose names are those of `imported`.
void AddImage(ImportedCamera imported,
              const renderer::Transform& pose,
              std::int64_t camera_id,
              const Cameras& cameras,
              ImportedCameras& result) {
  const auto camera = cameras.find(camera_id);
  if (camera == cameras.end()) {
    throw IoError(imported.place + ": camera " + std::to_string(camera_id) + " is not in " +
                  result.files.front().string());
  }
  if (imported.image.empty()) throw IoError(imported.place + ": the image name is missing");
  imported.camera = camera->second;
  imported.camera.name = imported.image;
  imported.camera.world_from_camera = pose;
  result.cameras.push_back(std::move(imported));
}

/// The second line of an image must be triples of numbers: anything else means that the empty lines
/// were lost, and with them every other image.
void CheckPointsLine(std::string_view text, const std::string& place) {
  Words line(text, place);
  while (!line.AtEnd()) {
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

void ReadTextImages(const std::filesystem::path& path,
                    const Cameras& cameras,
                    ImportedCameras& result) {
  TextFile file(path);
  for (std::string_view text; file.NextRecord(text);) {
    ImportedCamera imported;
    imported.place = file.Place();
    Words line(text, imported.place);
    line.Integer("image id");
    std::array<double, 7> q_t;
    for (std::size_t i = 0; i < q_t.size(); ++i) {
      q_t[i] = line.Number(i < 4 ? "quaternion" : "translation");
    }
    const renderer::Transform pose = PoseOf(q_t, imported.place);
    const std::int64_t camera_id = line.Integer("camera id");
    imported.image = line.Remainder();
    AddImage(std::move(imported), pose, camera_id, cameras, result);
    if (std::string_view points; file.NextLine(points)) CheckPointsLine(points, file.Place());
  }
}

/// The numbers of a binary file, little endian, taken one after the other; errors name the file and
/// the byte.
class Bytes {
 public:
  explicit Bytes(const std::filesystem::path& path)
      : name_(path.string()), bytes_(renderer::ReadWholeFile(path)) {
    static_assert(std::endian::native == std::endian::little);
  }

  template <class Value>
  Value Next(const std::string& place) {
    Value value;
    if (bytes_.size() - position_ < sizeof value) CutShort(place);
    std::memcpy(&value, bytes_.data() + position_, sizeof value);
    position_ += sizeof value;
    if constexpr (std::is_floating_point_v<Value>) {
      if (!std::isfinite(value)) {
        throw IoError(place + ": holds a number that is not finite (byte " +
                      std::to_string(position_ - sizeof value) + ")");
      }
    }
    return value;
  }
  /// Up to the next zero byte.
  std::string Text(const std::string& place) {
    const std::size_t end = bytes_.find('\0', position_);
    if (end == std::string::npos) CutShort(place);
    std::string text = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    return text;
  }
  void Skip(std::uint64_t count, std::uint64_t bytes_each, const std::string& place) {
    if (count > (bytes_.size() - position_) / bytes_each) CutShort(place);
    position_ += static_cast<std::size_t>(count * bytes_each);
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  void ExpectEnd() const {
    if (position_ == bytes_.size()) return;
    throw IoError(name_ + ": " + std::to_string(bytes_.size() - position_) +
                  " bytes are left over; this is no such file of a COLMAP model");
  }

 private:
  [[noreturn]] void CutShort(const std::string& place) const {
    throw IoError(place + ": the file ends too early (" + std::to_string(bytes_.size()) +
                  " bytes); this is no such file of a COLMAP model, or a damaged one");
  }

  std::string name_;
  std::string bytes_;
  std::size_t position_ = 0;
};

Cameras ReadBinaryCameras(const std::filesystem::path& path) {
  Cameras cameras;
  Bytes file(path);
  const auto count = file.Next<std::uint64_t>(file.name());
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto id = file.Next<std::uint32_t>(file.name());
    const std::string place = file.name() + ": camera " + std::to_string(id);
    const LensModel& lens = LensNumbered(file.Next<std::int32_t>(place), place);
    renderer::Camera camera;
    camera.width =
        CheckedImageSize(static_cast<double>(file.Next<std::int64_t>(place)), place + ": width");
    camera.height =
        CheckedImageSize(static_cast<double>(file.Next<std::int64_t>(place)), place + ": height");
    for (const char meaning : lens.layout) {
      SetParameter(meaning, file.Next<double>(place), place, camera);
    }
    AddCamera(id, camera, place, cameras);
  }
  file.ExpectEnd();
  return cameras;
}

/// Also of models with rigs and frames, whose images hold their whole pose too.
void ReadBinaryImages(const std::filesystem::path& path,
                      const Cameras& cameras,
                      ImportedCameras& result) {
  constexpr std::uint64_t kBytesOfPoint = 24;  // x, y, and the id of its 3D point
  Bytes file(path);
  const auto count = file.Next<std::uint64_t>(file.name());
  for (std::uint64_t i = 0; i < count; ++i) {
    ImportedCamera imported;
    imported.place =
        file.name() + ": image " + std::to_string(file.Next<std::uint32_t>(file.name()));
    std::array<double, 7> q_t;
    for (double& number : q_t) number = file.Next<double>(imported.place);
    const renderer::Transform pose = PoseOf(q_t, imported.place);
    const auto camera_id = file.Next<std::uint32_t>(imported.place);
    imported.image = file.Text(imported.place);
    file.Skip(file.Next<std::uint64_t>(imported.place), kBytesOfPoint, imported.place);
    AddImage(std::move(imported), pose, camera_id, cameras, result);
  }
  file.ExpectEnd();
}

std::vector<renderer::Vec3> ReadTextPoints(const std::filesystem::path& path) {
  std::vector<renderer::Vec3> points;
  TextFile file(path);
  for (std::string_view text; file.NextRecord(text);) {
    Words line(text, file.Place());
    line.Integer("point id");
    renderer::Vec3 point;
    for (int k = 0; k < 3; ++k) point[k] = line.Number("position");
    for (const char* what : {"red", "green", "blue"}) line.Integer(what);
    line.Number("error");
    std::uint64_t photos = 0;
    for (; !line.AtEnd(); ++photos) {
      line.Integer("image id");
      line.Integer("number of the 2D point");
    }
    if (IsSurePoint(photos)) points.push_back(CheckedCentre(point, file.Place()));
  }
  return points;
}

std::vector<renderer::Vec3> ReadBinaryPoints(const std::filesystem::path& path) {
  constexpr std::uint64_t kBytesOfColor = 3, kBytesOfTrack = 8;
  std::vector<renderer::Vec3> points;
  Bytes file(path);
  const auto count = file.Next<std::uint64_t>(file.name());
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string place =
        file.name() + ": point " + std::to_string(file.Next<std::uint64_t>(file.name()));
    renderer::Vec3 point;
    for (int k = 0; k < 3; ++k) point[k] = file.Next<double>(place);
    file.Skip(1, kBytesOfColor, place);
    file.Skip(1, sizeof(double), place);  // error, not a number where it is not known
    const auto photos = file.Next<std::uint64_t>(place);
    file.Skip(photos, kBytesOfTrack, place);
    if (IsSurePoint(photos)) points.push_back(CheckedCentre(point, place));
  }
  file.ExpectEnd();
  return points;
}

}  // namespace

std::vector<renderer::Vec3> ReadColmapPoints(const std::filesystem::path& path) {
  return path.extension() == ".bin" ? ReadBinaryPoints(path) : ReadTextPoints(path);
}

ImportedCameras ReadColmapModel(const std::filesystem::path& cameras_file) {
  const std::filesystem::path ending = cameras_file.extension();
  const bool is_binary = ending == ".bin";
  const std::filesystem::path folder = cameras_file.parent_path();
  ImportedCameras result;
  result.folder = folder;
  result.image_folders = {
      folder / "images", folder / ".." / "images", folder / ".." / ".." / "images"};
  result.has_own_photos = true;
  result.files = {cameras_file, (folder / "images").replace_extension(ending)};
  const std::filesystem::path points = (folder / "points3D").replace_extension(ending);
  if (std::filesystem::exists(points)) result.points = points;
  const Cameras cameras = (is_binary ? ReadBinaryCameras : ReadTextCameras)(result.files[0]);
  if (cameras.empty()) throw IoError(result.files[0].string() + ": holds no camera");
  (is_binary ? ReadBinaryImages : ReadTextImages)(result.files[1], cameras, result);
  if (result.cameras.empty()) throw IoError(result.files[1].string() + ": holds no image");
  return result;
}

}  // namespace pathfit::optim
