#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include <pugixml.hpp>

#include "optim/observation/camera_import.h"
#include "optim/observation/image_size.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using pugi::xml_node;
using renderer::IoError;
using renderer::Mat3;
using renderer::Vec3;

/// Where a local frame of the file stands in the frame that Metashape shows.
struct Placing {
  Mat3 rotation;
  Vec3 translation;
  double scale = 1.0;
};

class MetashapeReader {
 public:
  explicit MetashapeReader(const fs::path& path)
      : path_(path), name_(path.string()), text_(renderer::ReadWholeFile(path)) {}

  ImportedCameras Read() {
    pugi::xml_document document;
    const pugi::xml_parse_result parsed = document.load_buffer(text_.data(), text_.size());
    if (!parsed) {
      throw IoError(PlaceAt(parsed.offset) + ": not valid XML (" + parsed.description() + ")");
    }
    const xml_node root = document.child("document");
    const xml_node chunk = root.child("chunk");
    if (!chunk) throw IoError(name_ + ": has no document/chunk; export the cameras of one chunk");
    if (const xml_node second = chunk.next_sibling("chunk")) {
      throw IoError(Place(second) + ": a second chunk; export the cameras of one chunk");
    }
    ReadSensors(chunk.child("sensors"));
    result_.folder = path_.parent_path();
    result_.image_folders = {result_.folder, result_.folder / "images", result_.folder / "photos"};
    result_.files = {path_};
    const xml_node cameras = chunk.child("cameras");
    ReadCameras(cameras);
    for (const xml_node group : cameras.children("group")) ReadCameras(group);
    if (result_.cameras.empty()) throw IoError(name_ + ": no camera has a pose (transform)");
    if (left_out_ > 0) {
      result_.notes.push_back("Left out: " + std::to_string(left_out_) +
                              " cameras of the file that are not aligned or switched off.");
    }
    Place(chunk, FindPlacing(chunk));
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::string PlaceAt(std::ptrdiff_t offset) const {
    const auto end = std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text_));
    return name_ + ":" + std::to_string(1 + std::count(text_.begin(), text_.begin() + end, '\n'));
  }
  [[nodiscard]] std::string Place(const xml_node& node) const {
    std::string place = PlaceAt(node.offset_debug()) + ": " + node.name();
    if (const auto label = node.attribute("label"))
      place += " '" + std::string(label.value()) + "'";
    return place;
  }

  [[nodiscard]] std::vector<double> Numbers(const xml_node& node, std::size_t count) const {
    std::string_view text = node.child_value();
    std::vector<double> numbers;
    for (std::string_view word = renderer::NextToken(text); !word.empty();
         word = renderer::NextToken(text)) {
      const std::optional<double> number = renderer::ParseReal(word);
      if (!number) {
        throw IoError(Place(node) + ": '" + std::string(word.substr(0, 40)) +
                      "' is not a finite number");
      }
      numbers.push_back(*number);
    }
    if (numbers.size() != count) {
      throw IoError(Place(node) + ": holds " + std::to_string(numbers.size()) + " numbers, not " +
                    std::to_string(count));
    }
    return numbers;
  }
  [[nodiscard]] double NumberOr(const xml_node& parent, const char* name, double otherwise) const {
    const xml_node node = parent.child(name);
    return node ? Numbers(node, 1)[0] : otherwise;
  }
  [[nodiscard]] int ImageSize(const xml_node& node, const char* attribute) const {
    const auto size = renderer::ParseReal(node.attribute(attribute).value());
    return CheckedImageSize(size.value_or(0.0), Place(node) + ": " + attribute);
  }

  void ReadSensors(const xml_node& sensors) {
    for (const xml_node sensor : sensors.children("sensor")) {
      if (!sensors_.emplace(sensor.attribute("id").value(), sensor).second) {
        throw IoError(Place(sensor) + ": its id is given twice");
      }
    }
  }

  /// The adjusted calibration, or the initial one where there is no other.
  [[nodiscard]] renderer::Camera ReadLens(const xml_node& sensor) const {
    const xml_node adjusted = sensor.find_child_by_attribute("calibration", "class", "adjusted");
    const xml_node calibration = adjusted ? adjusted : sensor.child("calibration");
    if (!calibration) throw IoError(Place(sensor) + ": has no calibration");
    for (const xml_node& node : {sensor, calibration}) {
      const std::string_view type = node.attribute("type").value();
      if (!type.empty() && type != "frame") {
        throw IoError(Place(node) + ": the camera type " + std::string(type) +
                      " is not supported (allowed: frame); export undistorted photos instead");
      }
    }
    for (const char* other : {"b2", "k4", "p3", "p4"}) {
      if (NumberOr(calibration, other, 0.0) != 0.0) {
        throw IoError(Place(calibration.child(other)) +
                      " is not zero, which is not supported; fix it at zero (Optimize Cameras) and "
                      "export again");
      }
    }
    const xml_node resolution = calibration.child("resolution");
    const xml_node size = resolution ? resolution : sensor.child("resolution");
    if (!size) throw IoError(Place(sensor) + ": has no resolution");
    renderer::Camera camera;
    camera.width = ImageSize(size, "width");
    camera.height = ImageSize(size, "height");
    if (!calibration.child("f")) throw IoError(Place(calibration) + ": has no f");
    camera.fy = NumberOr(calibration, "f", 0.0);
    camera.fx = camera.fy + NumberOr(calibration, "b1", 0.0);
    if (!(camera.fx > 0.0 && camera.fy > 0.0)) {
      throw IoError(Place(calibration) + ": the focal length must be positive");
    }
    camera.cx = 0.5 * camera.width + NumberOr(calibration, "cx", 0.0);
    camera.cy = 0.5 * camera.height + NumberOr(calibration, "cy", 0.0);
    // The tangential terms have each other's names.
    camera.distortion = {.k1 = NumberOr(calibration, "k1", 0.0),
                         .k2 = NumberOr(calibration, "k2", 0.0),
                         .k3 = NumberOr(calibration, "k3", 0.0),
                         .p1 = NumberOr(calibration, "p2", 0.0),
                         .p2 = NumberOr(calibration, "p1", 0.0)};
    return camera;
  }

  void ReadCameras(const xml_node& cameras) {
    for (const xml_node node : cameras.children("camera")) {
      const xml_node transform = node.child("transform");
      const std::string_view enabled = node.attribute("enabled").value();
      if (!transform || enabled == "0" || enabled == "false") {
        ++left_out_;
        continue;
      }
      ImportedCamera imported;
      imported.place = Place(node);
      imported.image = node.attribute("label").value();
      if (imported.image.empty()) throw IoError(imported.place + ": has no label");
      const std::string id = node.attribute("sensor_id").value();
      const auto sensor = sensors_.find(id);
      if (sensor == sensors_.end()) {
        throw IoError(imported.place + ": sensor '" + id + "' is not in the file");
      }
      imported.camera = ReadLens(sensor->second);
      imported.camera.name = imported.image;
      const std::vector<double> m = Numbers(transform, 16);
      if (m[12] != 0.0 || m[13] != 0.0 || m[14] != 0.0 || m[15] != 1.0) {
        throw IoError(Place(transform) + ": its last row must be 0 0 0 1");
      }
      imported.camera.world_from_camera = PoseFromForwardAxes(
          ExactRotation({{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}},
                        Place(transform)),
          {m[3], m[7], m[11]},
          Place(transform));
      components_.insert(node.attribute("component_id").value());
      result_.cameras.push_back(std::move(imported));
    }
  }

  [[nodiscard]] std::optional<Placing> ReadPlacing(const xml_node& transform) const {
    if (!transform || !transform.first_child()) return std::nullopt;
    Placing placing;
    if (const xml_node rotation = transform.child("rotation")) {
      const std::vector<double> r = Numbers(rotation, 9);
      placing.rotation = ExactRotation({{r[0], r[3], r[6]}, {r[1], r[4], r[7]}, {r[2], r[5], r[8]}},
                                       Place(rotation));
    }
    if (const xml_node translation = transform.child("translation")) {
      const std::vector<double> t = Numbers(translation, 3);
      placing.translation = {t[0], t[1], t[2]};
    }
    placing.scale = NumberOr(transform, "scale", 1.0);
    if (!(placing.scale > 0.0)) throw IoError(Place(transform) + ": the scale must be positive");
    return placing;
  }

  /// Of the component of all cameras, or of the chunk in older files.
  [[nodiscard]] std::optional<Placing> FindPlacing(const xml_node& chunk) const {
    if (components_.size() > 1) {
      throw IoError(Place(chunk.child("cameras")) +
                    ": the cameras belong to several components, which do not share a frame; "
                    "export one");
    }
    const xml_node component =
        chunk.child("components")
            .find_child_by_attribute("component", "id", components_.begin()->c_str());
    const std::optional<Placing> placing = ReadPlacing(component.child("transform"));
    return placing ? placing : ReadPlacing(chunk.child("transform"));
  }

  /// Moves all poses to the frame of the local coordinate system; a geographic one is left.
  void Place(const xml_node& chunk, const std::optional<Placing>& placing) {
    if (!placing) return;
    const std::string_view reference = chunk.child("reference").child_value();
    if (!reference.empty() && !reference.starts_with("LOCAL_CS")) {
      result_.metres_per_unit = placing->scale;
      result_.notes.emplace_back(
          "Frame: the file is georeferenced; positions stay in the chunk's own frame. Start meshes "
          "must be exported in local coordinates of a chunk without such a reference.");
      return;
    }
    if (!reference.empty()) {
      const std::size_t unit = reference.find("UNIT[");
      std::string_view rest = unit == std::string_view::npos ? "" : reference.substr(unit);
      rest.remove_prefix(std::min(rest.find(',') + 1, rest.size()));
      const auto metres = renderer::ParseReal(rest.substr(0, rest.find_first_of(",]")));
      if (metres && *metres > 0.0) result_.metres_per_unit = *metres;
    }
    for (ImportedCamera& imported : result_.cameras) {
      renderer::Transform& pose = imported.camera.world_from_camera;
      pose = {placing->rotation * pose.linear,
              CheckedCentre(
                  placing->rotation * (pose.translation * placing->scale) + placing->translation,
                  imported.place)};
    }
  }

  fs::path path_;
  std::string name_, text_;
  std::map<std::string, xml_node> sensors_;
  std::set<std::string> components_;  ///< of cameras with a pose
  std::size_t left_out_ = 0;
  ImportedCameras result_;
};

}  // namespace

ImportedCameras ReadMetashapeXml(const fs::path& path) { return MetashapeReader(path).Read(); }

}  // namespace pathfit::optim
