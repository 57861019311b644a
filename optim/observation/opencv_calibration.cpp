#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include <pugixml.hpp>
#include <yaml-cpp/yaml.h>

#include "optim/observation/camera_import.h"
#include "optim/observation/image_size.h"
#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;
using renderer::Vec3;

constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20U;
constexpr int kMaxDepth = 8;
/// k1 k2 p1 p2 k3; what follows are other terms of the lens.
constexpr std::size_t kBrownTerms = 5;

/// What stands behind a key: the words of a scalar, a list or a matrix by rows.
struct Value {
  std::string place;
  std::vector<std::string> words;
};
/// By PlainKey.
using Values = std::map<std::string, Value>;

/// Programs differ in case and underscores: "Distortion_Coefficients", "distortionCoefficients".
std::string PlainKey(const std::string& key) {
  std::string plain = renderer::LowerCase(key);
  std::erase_if(plain, [](char c) { return c == '_' || c == '-'; });
  return plain;
}

void AppendWords(const YAML::Node& node, int depth, Value& value) {
  if (depth > kMaxDepth) throw IoError(value.place + ": is nested too deeply");
  if (node.IsScalar()) {
    value.words.push_back(node.Scalar());
  } else if (node.IsSequence()) {
    for (const YAML::Node& item : node) AppendWords(item, depth + 1, value);
  } else if (node.IsMap() && node["data"]) {
    AppendWords(node["data"], depth + 1, value);  // a matrix: rows, cols, dt, data
  }
}

Values ReadYaml(const std::string& text, const std::string& name) {
  Values values;
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) throw IoError(name + ": holds no keys");
    for (const auto& entry : root) {
      if (!entry.first.IsScalar()) continue;
      const std::string& key = entry.first.Scalar();
      Value& value = values[PlainKey(key)];
      value.place = name + ":" + std::to_string(entry.first.Mark().line + 1) + ": " + key;
      AppendWords(entry.second, 0, value);
    }
  } catch (const YAML::Exception& error) {
    throw IoError(name + ":" + std::to_string(error.mark.line + 1) + ": not valid YAML (" +
                  error.msg + ")");
  }
  return values;
}

void AppendWords(const pugi::xml_node& node, int depth, Value& value) {
  if (depth > kMaxDepth) throw IoError(value.place + ": is nested too deeply");
  if (const pugi::xml_node data = node.child("data")) return AppendWords(data, depth + 1, value);
  std::string_view text = node.child_value();
  while (!text.empty()) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    if (text.starts_with('"')) {  // a name with blanks
      const std::size_t end = std::min(text.find('"', 1), text.size());
      value.words.emplace_back(text.substr(1, end - 1));
      text.remove_prefix(std::min(end + 1, text.size()));
    } else if (const std::string_view word = renderer::NextToken(text); !word.empty()) {
      value.words.emplace_back(word);
    }
  }
  for (const pugi::xml_node item : node.children("_")) AppendWords(item, depth + 1, value);
}

Values ReadXml(const std::string& text, const std::string& name) {
  const auto place_at = [&](std::ptrdiff_t offset) {
    const auto end = std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text));
    return name + ":" + std::to_string(1 + std::count(text.begin(), text.begin() + end, '\n'));
  };
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (!parsed) {
    throw IoError(place_at(parsed.offset) + ": not valid XML (" + parsed.description() + ")");
  }
  const pugi::xml_node root = document.child("opencv_storage");
  if (!root) throw IoError(name + ": has no opencv_storage");
  Values values;
  for (const pugi::xml_node node : root.children()) {
    Value& value = values[PlainKey(node.name())];
    value.place = place_at(node.offset_debug()) + ": " + node.name();
    value.words.clear();
    AppendWords(node, 0, value);
  }
  return values;
}

/// A calibration with the spellings its programs use.
class CalibrationFile {
 public:
  explicit CalibrationFile(const fs::path& path) : name_(path.string()) {
    const std::string text = renderer::ReadWholeFile(path);
    if (text.size() > kMaxFileBytes) throw IoError(name_ + ": is larger than 16 MiB");
    const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    const bool is_xml = first != std::string::npos && text[first] == '<';
    values_ = is_xml ? ReadXml(text, name_) : ReadYaml(text, name_);
  }

  [[nodiscard]] renderer::Camera Intrinsics() const {
    RefuseFisheye();
    renderer::Camera camera;
    const Value* matrix = Find({"cameramatrix", "k", "mtx"});
    if (matrix == nullptr) throw IoError(name_ + ": has no camera_matrix");
    const std::vector<double> k = Numbers(*matrix);
    if (k.size() != 9 || k[3] != 0.0 || k[6] != 0.0 || k[7] != 0.0 || k[8] != 1.0) {
      throw IoError(matrix->place + " must be 3 x 3 numbers: fx 0 cx, 0 fy cy, 0 0 1");
    }
    if (k[1] != 0.0) throw IoError(matrix->place + ": skew is not supported");
    if (!(k[0] > 0.0 && k[4] > 0.0)) {
      throw IoError(matrix->place + ": the focal lengths must be positive");
    }
    camera.fx = k[0];
    camera.fy = k[4];
    camera.cx = k[2] + 0.5;  // the first pixel's centre is (0, 0) there
    camera.cy = k[5] + 0.5;
    ReadLens(camera.distortion);
    ReadSize(camera);
    return camera;
  }

  /// camera_from_world as rotation vectors and translations, six numbers each.
  [[nodiscard]] std::vector<std::vector<double>> Poses() const {
    std::vector<std::vector<double>> poses;
    if (const Value* both = Find({"extrinsicparameters"})) {
      const std::vector<double> numbers = Triples(*both, 2);
      for (std::size_t i = 0; i + 6 <= numbers.size(); i += 6) {
        poses.emplace_back(numbers.begin() + static_cast<std::ptrdiff_t>(i),
                           numbers.begin() + static_cast<std::ptrdiff_t>(i + 6));
      }
      return poses;
    }
    const Value* turns = Find({"rvecs", "rotationvectors", "rvec"});
    const Value* shifts = Find({"tvecs", "translationvectors", "tvec"});
    if (turns == nullptr || shifts == nullptr) {
      throw IoError(
          name_ +
          ": has no poses of photos (extrinsic_parameters, or rvecs and tvecs); with poses "
          "from another file, give this one as its calibration "
          "(input.cameras.calibration, --calibration)");
    }
    const std::vector<double> r = Triples(*turns, 1), t = Triples(*shifts, 1);
    if (r.size() != t.size()) {
      throw IoError(shifts->place + ": has " + std::to_string(t.size() / 3) + " vectors, but " +
                    std::to_string(r.size() / 3) + " rotations are given");
    }
    for (std::size_t i = 0; i + 3 <= r.size(); i += 3) {
      poses.push_back({r[i], r[i + 1], r[i + 2], t[i], t[i + 1], t[i + 2]});
    }
    return poses;
  }

  /// Of the photos; empty if the file does not name them.
  [[nodiscard]] std::vector<std::string> Names() const {
    const Value* names = Find({"imagenames", "images", "imagelist", "imagepaths", "imagefiles"});
    return names == nullptr ? std::vector<std::string>() : names->words;
  }

 private:
  /// Keys as PlainKey writes them.
  [[nodiscard]] const Value* Find(std::initializer_list<const char*> keys) const {
    for (const char* key : keys) {
      if (const auto found = values_.find(key); found != values_.end()) return &found->second;
    }
    return nullptr;
  }
  [[nodiscard]] static std::vector<double> Numbers(const Value& value) {
    std::vector<double> numbers;
    for (const std::string& word : value.words) {
      const std::optional<double> number = renderer::ParseReal(word);
      if (!number) {
        throw IoError(value.place + ": '" + word.substr(0, 40) + "' is not a finite number");
      }
      numbers.push_back(*number);
    }
    return numbers;
  }
  [[nodiscard]] static std::vector<double> Triples(const Value& value, std::size_t each) {
    std::vector<double> numbers = Numbers(value);
    if (numbers.empty() || numbers.size() % (3 * each) != 0) {
      throw IoError(value.place + ": holds " + std::to_string(numbers.size()) +
                    " numbers, which are not " + std::to_string(3 * each) + " for each photo");
    }
    return numbers;
  }

  void RefuseFisheye() const {
    const Value* model = Find({"distortionmodel", "cameramodel"});
    const Value* flag = Find({"fisheyemodel"});
    const bool is_flagged = flag != nullptr && !flag->words.empty() && flag->words[0] != "0";
    const std::string name = model == nullptr || model->words.empty() ? "" : model->words[0];
    if (is_flagged || name.find("fisheye") != std::string::npos || name == "equidistant") {
      throw IoError((is_flagged ? flag : model)->place +
                    ": a fisheye lens is not supported; undistort the photos "
                    "(cv::fisheye::undistortImage)");
    }
  }

  void ReadLens(renderer::LensDistortion& lens) const {
    const Value* value = Find({"distortioncoefficients",
                               "distortioncoeffs",
                               "distcoefficients",
                               "distcoeffs",
                               "distcoeff",
                               "distcoefs",
                               "distortion",
                               "dist",
                               "d"});
    if (value == nullptr) return;
    std::vector<double> d = Numbers(*value);
    for (std::size_t i = kBrownTerms; i < d.size(); ++i) {
      if (d[i] != 0.0) {
        throw IoError(
            value->place +
            ": more than k1 k2 p1 p2 k3 is not supported; calibrate without the rational, "
            "thin prism and tilted models, or undistort the photos (cv::undistort)");
      }
    }
    if (d.size() == 1 || d.size() == 3) {
      throw IoError(value->place + ": holds " + std::to_string(d.size()) +
                    " numbers, not k1 k2 p1 p2 and perhaps k3");
    }
    d.resize(kBrownTerms, 0.0);
    lens = {.k1 = d[0], .k2 = d[1], .k3 = d[4], .p1 = d[2], .p2 = d[3]};
  }

  void ReadSize(renderer::Camera& camera) const {
    const Value* width = Find({"imagewidth", "width"});
    const Value* height = Find({"imageheight", "height"});
    if (const Value* both = Find({"imagesize"}); both != nullptr && width == nullptr) {
      const std::vector<double> size = Numbers(*both);
      if (size.size() != 2) throw IoError(both->place + " must be width and height");
      camera.width = CheckedImageSize(size[0], both->place);
      camera.height = CheckedImageSize(size[1], both->place);
    } else if (width != nullptr && height != nullptr) {
      for (const Value* value : {width, height}) {
        const std::vector<double> size = Numbers(*value);
        if (size.size() != 1) throw IoError(value->place + " must be one number");
        (value == width ? camera.width : camera.height) = CheckedImageSize(size[0], value->place);
      }
    } else if (width != nullptr || height != nullptr) {
      throw IoError((width != nullptr ? width : height)->place +
                    ": image_width and image_height must be given together");
    }
  }

  std::string name_;
  Values values_;
};

}  // namespace

renderer::Camera ReadOpencvIntrinsics(const fs::path& path) {
  return CalibrationFile(path).Intrinsics();
}

ImportedCameras ReadOpencvCalibration(const fs::path& path, const fs::path& photos) {
  const CalibrationFile file(path);
  const renderer::Camera camera = file.Intrinsics();
  const std::vector<std::vector<double>> poses = file.Poses();
  std::vector<std::string> names = file.Names();
  ImportedCameras result;
  result.folder = path.parent_path();
  result.image_folders = {result.folder, result.folder / "images"};
  result.files = {path};
  result.pixel_shift = 0.5;
  if (names.empty()) {
    for (const fs::path& picture : PicturesOf(path, photos, poses.size())) {
      names.push_back(picture.filename().string());
      result.image_folders = {picture.parent_path()};
    }
    result.notes.emplace_back(
        "Photos: the calibration names none; its poses belong to the pictures in " +
        result.image_folders.front().string() + " in the order of their names.");
  } else if (names.size() != poses.size()) {
    throw IoError(path.string() + ": names " + std::to_string(names.size()) + " photos, but has " +
                  std::to_string(poses.size()) + " poses");
  }
  result.notes.emplace_back("Frame: that of the calibration's board, in its unit of length.");
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::vector<double>& p = poses[i];
    ImportedCamera& imported = result.cameras.emplace_back();
    imported.place = path.string() + ": pose " + std::to_string(i);
    imported.image = names[i];
    if (imported.image.empty()) throw IoError(imported.place + ": the name of its photo is empty");
    imported.camera = camera;
    imported.camera.name = names[i];
    const renderer::Mat3 rotation =
        ExactRotation(Transposed(renderer::RotationFromVector({p[0], p[1], p[2]})), imported.place);
    imported.camera.world_from_camera =
        PoseFromForwardAxes(rotation, -(rotation * Vec3{p[3], p[4], p[5]}), imported.place);
  }
  return result;
}

}  // namespace pathfit::optim
