// Camera files of other programs, made by hand: their documentation tells where a point is seen.
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "optim/observation/camera_import.h"
#include "optim/observation/load_observations.h"
#include "renderer/core/error.h"
#include "renderer/io/image_file.h"
#include "tests/optim/observation/camera_texts.h"
#include "tests/optim/observation/observation_files.h"

namespace pathfit::optim::camera_formats_test {
namespace {

using renderer::Vec3;
using tests::kAliceVision;
using tests::kMetashape;
using tests::kOpencvXml;
using tests::kOpencvYaml;

constexpr double kPixelTolerance = 1e-9;
// x_camera = (Z, X, Y) + (1, 2, 3) with y down and z forward: (0.5, 0.25, 2) there, that is 1/4 and
// 1/8 off the axis, whose square is 5/64.
constexpr Vec3 kPoint{-1.75, -1.0, -0.5};

void ExpectProjectsTo(const ImportedCamera& camera, double u, double v, Vec3 point = kPoint) {
  const std::optional<renderer::Projection> p = renderer::CameraModel(camera.camera).Project(point);
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->u, u, kPixelTolerance);
  EXPECT_NEAR(p->v, v, kPixelTolerance);
}

class CameraFormats : public ::testing::Test {
 protected:
  std::filesystem::path Write(const std::string& name, const std::string& text) {
    return folder_.WriteText(name, text);
  }
  ImportedCameras Read(const std::string& name, const std::string& text) {
    return ImportCameras(Write(name, text), "auto");
  }
  void ExpectError(const std::string& name,
                   const std::string& text,
                   const std::vector<std::string>& parts) {
    std::string message = "(no error)";
    try {
      Read(name, text);
    } catch (const renderer::IoError& error) {
      message = error.what();
    }
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
    }
  }
  /// The text with `from`, which must be there, replaced.
  static std::string With(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  [[nodiscard]] const std::filesystem::path& top() const { return folder_.path(); }
  void WritePicture(const std::string& name) const {
    std::filesystem::create_directories((top() / name).parent_path());
    renderer::WritePng8(top() / name, ConstantImage(4, 2, 3, 0.5F));
  }

  TempFolder folder_;
};

// --- LLFF ---------------------------------------------------------------------------------------

class Llff : public CameraFormats {
 protected:
  template <class Real>
  static std::string Npy(const std::vector<std::vector<double>>& rows,
                         bool by_columns = false,
                         const std::string& shape = "") {
    std::string header = std::string("{'descr': '<f") + (sizeof(Real) == 8 ? "8" : "4") +
                         "', 'fortran_order': " + (by_columns ? "True" : "False") + ", 'shape': " +
                         (shape.empty() ? "(" + std::to_string(rows.size()) + ", 17)" : shape) +
                         ", }";
    header.resize(117, ' ');
    header += '\n';
    std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) +
                        std::string(1, '\0') + header;
    const auto append = [&](double value) {
      const auto number = static_cast<Real>(value);
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    };
    if (by_columns) {
      for (std::size_t c = 0; c < 17; ++c) {
        for (const auto& row : rows) append(row[c]);
      }
    } else {
      for (const auto& row : rows) {
        for (const double value : row) append(value);
      }
    }
    return bytes;
  }
  /// The pose of kPoint by columns down, right, backwards: x_world = (y, z, x) of the camera with y
  /// down, less (2, 3, 1); then height, width, focal length; then depths.
  const std::vector<double> row_ = {1, 0, 0, -2, 120, 0, 0, -1, -3, 200, 0, 1, 0, -1, 100, 0.5, 9};
};

TEST_F(Llff, LandsOnTheKnownPixelInTheOrderOfNames) {
  std::vector<double> second = row_;
  second[3] = -2.5;  // half a unit up: the point is at (0.5, 0.75, 2)
  WritePicture("images/b.png");
  WritePicture("images/a.png");
  for (const bool by_columns : {false, true}) {
    for (const bool is_double : {false, true}) {
      const auto npy = is_double ? Npy<double>({row_, second}, by_columns)
                                 : Npy<float>({row_, second}, by_columns);
      Write("poses_bounds.npy", npy);
      const ImportedCameras cameras = ImportCameras(top(), "auto");
      EXPECT_EQ(cameras.format, "LLFF poses");
      ASSERT_EQ(cameras.cameras.size(), 2U);
      EXPECT_EQ(cameras.cameras[0].image, "a.png");
      EXPECT_EQ(cameras.cameras[1].image, "b.png");
      ImportedCamera first = cameras.cameras[0], other = cameras.cameras[1];
      first.camera = CompleteCamera(first, 1, 1);
      other.camera = CompleteCamera(other, 1, 1);
      EXPECT_EQ(first.camera.width, 200);
      ExpectProjectsTo(first, 125.0, 72.5);
      ExpectProjectsTo(other, 125.0, 97.5);
    }
  }
}

TEST_F(Llff, PhotosMayLieElsewhere) {
  WritePicture("small/a.png");
  Write("poses_bounds.npy", Npy<double>({row_}));
  EXPECT_EQ(ImportCameras(top(), "llff", top() / "small").cameras[0].image, "a.png");
  ObservationOptions options;
  options.cameras = top();
  options.images_dir = top() / "small";
  options.validation_every = 0;
  const ObservationSet set = LoadObservations(options);  // 200 x 120 is 50 times too large: 4 x 2
  EXPECT_EQ(set.views.at(0).name, "a.png");
}

TEST_F(Llff, NamesFileAndRowOfWhatIsMalformed) {
  WritePicture("images/a.png");
  const std::string good = Npy<double>({row_});
  ExpectError("poses_bounds.npy", "", {"poses_bounds.npy", ".npy file of numpy"});
  ExpectError("poses_bounds.npy", good.substr(0, 30), {"ends in its header"});
  ExpectError("poses_bounds.npy", With(good, "descr", "desce"), {"no 'descr'"});
  ExpectError("poses_bounds.npy", With(good, "<f8", "<i8"), {"'<i8'", "not floats"});
  ExpectError("poses_bounds.npy", Npy<double>({row_}, false, "(1, 15)"), {"(1, 15)", "17"});
  ExpectError("poses_bounds.npy", Npy<double>({row_}, false, "(17,)"), {"shape", "17"});
  ExpectError("poses_bounds.npy", Npy<double>({row_}, false, "(99999999999, 17)"), {"shape"});
  ExpectError("poses_bounds.npy", good.substr(0, good.size() - 1), {"135 bytes", "need 136"});
  ExpectError("poses_bounds.npy", Npy<double>({row_, row_}), {"2 poses", "1 pictures", "images"});
  for (const auto& [column, value, part] :
       std::vector<std::tuple<std::size_t, double, std::string>>{
           {0, 2.0, "not a rotation"},
           {3, std::nan(""), "row 0 holds a number that is not finite"},
           {3, 1e300, "beyond 1e12"},
           {4, 0.5, "image size"},
           {14, 0.0, "focal length"}}) {
    std::vector<double> row = row_;
    row[column] = value;
    ExpectError("poses_bounds.npy", Npy<double>({row}), {"row 0", part});
  }
}

// --- OpenCV -------------------------------------------------------------------------------------

using Opencv = CameraFormats;

// As COLMAP's OPENCV case, with principal points that count from the first pixel's centre.
TEST_F(Opencv, YamlAndXmlLandOnTheKnownPixelHalfAPixelOn) {
  for (const auto& [name, text] : {std::pair{"calib.yml", kOpencvYaml}, {"c.xml", kOpencvXml}}) {
    const ImportedCameras cameras = Read(name, text);
    EXPECT_EQ(cameras.format, "OpenCV calibration");
    EXPECT_EQ(cameras.pixel_shift, 0.5);
    ASSERT_EQ(cameras.cameras.size(), 1U);
    EXPECT_EQ(cameras.cameras[0].image, "a photo.png");
    EXPECT_EQ(cameras.cameras[0].camera.width, 200);
    ExpectProjectsTo(cameras.cameras[0], 166.5, 126.25);
  }
}

TEST_F(Opencv, PhotosWithoutNamesGoByTheirOrder) {
  const std::string text = With(kOpencvYaml, "images: [ \"a photo.png\" ]\n", "");
  ExpectError("set/calib.yml", text, {"calib.yml", "1 poses", "0 pictures"});
  WritePicture("set/z.png");
  EXPECT_EQ(Read("set/calib.yml", text).cameras[0].image, "z.png");
}

TEST_F(Opencv, CalibrationReplacesTheLensOfOtherCameras) {
  WritePicture("a.png");
  Write("transforms.json",
        R"({"camera_angle_x": 1, "frames": [{"file_path": "a.png", "transform_matrix":
        [[0,-1,0,-2],[0,0,-1,-3],[1,0,0,-1],[0,0,0,1]]}]})");
  // camera_info of ROS.
  const auto calibration =
      Write("info.yaml",
            "camera_matrix: {rows: 3, cols: 3, data: [200, 0, 100, 0, 400, "
            "59.75, 0, 0, 1]}\ndistortion_model: plumb_bob\n"
            "distortion_coefficients: {rows: 1, cols: 5, data: [0.128, 1.6384, "
            "0.16, 0.32, 0]}\nimage_width: 200\nimage_height: 120\n");
  ImportedCameras cameras = ImportCameras(top(), "auto");
  UseCalibration(calibration, cameras);
  cameras.cameras[0].camera = CompleteCamera(cameras.cameras[0], 1, 1);
  ExpectProjectsTo(cameras.cameras[0], 166.5, 126.25);
  ObservationOptions options;
  options.cameras = top();
  options.calibration = calibration;
  options.validation_every = 0;
  const ObservationSet set = LoadObservations(options);
  EXPECT_NEAR(set.views.at(0).camera.fx, 200.0 * 4 / 200, 1e-12);
  bool is_said = false;
  for (const std::string& line : set.assumptions) is_said |= line.starts_with("Calibration:");
  EXPECT_TRUE(is_said);
  // Other programs' keys; what it does not say is said.
  const auto other =
      Write("cam.yaml",
            "CameraMatrix: [[200, 0, 100], [0, 400, 59.75], [0, 0, 1]]\n"
            "DistortionCoeffs: [0.128, 1.6384, 0.16, 0.32]\nWidth: 200\nHeight: 120\n");
  cameras = ImportCameras(top(), "auto");
  UseCalibration(other, cameras);
  cameras.cameras[0].camera = CompleteCamera(cameras.cameras[0], 1, 1);
  ExpectProjectsTo(cameras.cameras[0], 166.5, 126.25);
  EXPECT_EQ(cameras.notes.back().find("It says no"), std::string::npos) << cameras.notes.back();
  UseCalibration(Write("bare.yaml", "K: [[200, 0, 100], [0, 400, 59.75], [0, 0, 1]]\n"), cameras);
  EXPECT_NE(cameras.notes.back().find("no size"), std::string::npos) << cameras.notes.back();
  EXPECT_NE(cameras.notes.back().find("no distortion"), std::string::npos) << cameras.notes.back();
  // By itself it has no pose.
  ExpectError("info.yaml",
              "camera_matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n",
              {"info.yaml", "no poses", "input.cameras.calibration"});
}

TEST_F(Opencv, NamesFileLineAndKeyOfWhatIsMalformed) {
  ExpectError("c.yml", "a: [", {"c.yml:", "not valid YAML"});
  ExpectError("c.yml", "- 1", {"c.yml", "no keys"});
  ExpectError("c.yml", "a: 1", {"c.yml", "no camera_matrix"});
  ExpectError("c.yml", With(kOpencvYaml, "200., 0.", "200., 1."), {"c.yml:6", "skew"});
  ExpectError("c.yml", With(kOpencvYaml, "200., 0.", "-1, 0."), {"c.yml:6", "positive"});
  ExpectError("c.yml", With(kOpencvYaml, "200., 0.", ".nan, 0."), {"c.yml:6", "'.nan'"});
  ExpectError("c.yml", With(kOpencvYaml, "0.32, 0. ", "0.32, 0., 1. "), {"c.yml:12", "rational"});
  ExpectError(
      "c.yml", With(kOpencvYaml, "image_width: 200", "image_width: 0"), {"c.yml:4", "size"});
  ExpectError("c.yml", With(kOpencvYaml, "image_width: 200\n", ""), {"c.yml:4", "together"});
  ExpectError("c.yml", With(kOpencvYaml, "1., 2., 3. ", "1., 2. "), {"c.yml:17", "5 numbers"});
  ExpectError("c.yml", With(kOpencvYaml, "\"a photo.png\"", "a, b"), {"2 photos", "1 poses"});
  ExpectError("c.yml", std::string(kOpencvYaml) + "fisheye_model: 1\n", {"c.yml:23", "fisheye"});
  ExpectError("c.xml", With(kOpencvXml, "</rvecs>", ""), {"c.xml:", "not valid XML"});
  ExpectError("c.xml", With(kOpencvXml, "<data>1. 2. 3.", "<data>1. 2. x"), {"c.xml:11", "'x'"});
  ExpectError("c.xml",
              With(kOpencvXml, "<data>1. 2. 3.", "<data>1 2 3 4 5 6"),
              {"c.xml:11: tvecs", "2 vectors", "1 rotations"});
  ExpectError("deep.yml",
              "camera_matrix: " + std::string(60, '[') + std::string(60, ']'),
              {"deep.yml:1", "deeply"});
}

// --- A plain list -------------------------------------------------------------------------------

constexpr const char* kList = R"(size_px: [200, 120]
focal_px: [200, 400]
principal_point_px: [100.5, 60.25]
metres_per_unit: 0.5
cameras:
- image: a photo.png
  mask: m/a.png
  world_from_camera: [[0, -1, 0, -2], [0, 0, -1, -3], [1, 0, 0, -1], [0, 0, 0, 1]]
- image: b.png
  focal_px: 200
  axes: opencv
  vignetting: {v1: -0.25, v3: 0.125}
  distortion: {k1: 0.128, k2: 1.6384, p1: 0.16, p2: 0.32}
  world_from_camera:
  - [0, 1, 0, -2]
  - [0, 0, 1, -3]
  - [1, 0, 0, -1]
- image: c.png
  type: orthographic
  focal_px: 10
  look_at: {origin: [-2, -3, -1], target: [-2, -3, 5], up: [-1, 0, 0]}
)";

using List = CameraFormats;

TEST_F(List, LandsOnTheKnownPixel) {
  const ImportedCameras cameras = Read("poses.yaml", kList);
  EXPECT_EQ(cameras.format, "list of cameras");
  EXPECT_EQ(cameras.metres_per_unit, 0.5);
  ASSERT_EQ(cameras.cameras.size(), 3U);
  EXPECT_EQ(cameras.cameras[0].image, "a photo.png");
  EXPECT_EQ(cameras.cameras[0].mask, "m/a.png");
  EXPECT_EQ(cameras.cameras[0].camera.width, 200);
  EXPECT_TRUE(cameras.cameras[0].has_principal_point);
  ExpectProjectsTo(cameras.cameras[0], 150.5, 110.25);
  ExpectProjectsTo(cameras.cameras[1], 166.5, 93.25);  // with the lens
  EXPECT_EQ(cameras.cameras[1].camera.vignetting, (renderer::Vignetting{-0.25, 0.0, 0.125}));
  ExpectProjectsTo(cameras.cameras[2], 80.5, 62.75);  // right is -y, up -x
  Write("set/cameras.yml", kList);
  EXPECT_EQ(ImportCameras(top() / "set", "auto").cameras.size(), 3U);
}

TEST_F(List, PhotosCompleteWhatIsLeftOpen) {
  const ImportedCameras cameras = Read(
      "l.yml",
      "cameras:\n- {image: a.png, focal_px: 5, look_at: {origin: [0, 0, 3], target: [0, 0, 0]}}\n");
  const renderer::Camera camera = CompleteCamera(cameras.cameras[0], 8, 6);
  EXPECT_EQ(camera.width, 8);
  EXPECT_EQ(camera.cx, 4.0);
  EXPECT_EQ(camera.cy, 3.0);
}

TEST_F(List, NamesFileLineColumnAndKeyOfWhatIsMalformed) {
  ExpectError("l.yaml", "cameras:\n- [", {"l.yaml:", "not valid YAML"});
  ExpectError("l.yaml", "cameras: 1", {"l.yaml:1:10: cameras", "at least one camera"});
  ExpectError("l.yaml", "cameras: []", {"l.yaml:1:10: cameras", "at least one camera"});
  ExpectError("l.yaml", "cameras:\n- 1", {"l.yaml:2:3: cameras[0] must be a map"});
  for (const auto& [from, to, parts] :
       std::vector<std::tuple<std::string, std::string, std::vector<std::string>>>{
           {"mask: m", "masks: m", {"l.yaml:7:3: cameras[0].masks is no key", "world_from_camera"}},
           {"mask: m/a.png", "image: x", {"l.yaml:7:3: cameras[0].image is there twice"}},
           {"image: b.png", "mask: b.png", {"l.yaml:9:3: cameras[1] has no image"}},
           {"image: b.png", "image: [b.png]", {"l.yaml:9:10: cameras[1].image must be a text"}},
           {"focal_px: 10", "focal_px: x", {"l.yaml:20:13: cameras[2].focal_px: 'x'"}},
           {"focal_px: 10", "focal_px: -1", {"cameras[2].focal_px must be positive"}},
           {"focal_px: 10", "focal_px: [1, 2, 3]", {"must be a list of 2"}},
           {"focal_px: [200, 400]\n", "", {"cameras[0] has no focal_px"}},
           {"[200, 120]", "[200, 1.5]", {"l.yaml:1:16: size_px[1] 1.5 is not an image size"}},
           {"metres_per_unit: 0.5", "metres_per_unit: 0", {"metres_per_unit must be positive"}},
           {"[0, -1, 0, -2]", "[0, -2, 0, -2]", {"world_from_camera", "not a rotation"}},
           {"[0, -1, 0, -2]", "[0, -1, 0, 1e13]", {"world_from_camera", "beyond 1e12"}},
           {"[0, -1, 0, -2]", "[0, -1, 0]", {"world_from_camera[0] must be a list of 4"}},
           {"[0, 0, 0, 1]", "[0, 0, 1, 1]", {"the last row must be 0 0 0 1"}},
           {"type: ortho", "type: Ortho", {"'Orthographic' is neither perspective nor ortho"}},
           {"axes: opencv", "axes: cv", {"'cv' is neither opengl nor opencv"}},
           {"{k1: 0.128", "{k4: 0.128", {"cameras[1].distortion.k4 is no key here"}},
           {"target: [-2, -3, 5], ", "", {"cameras[2].look_at needs origin and target"}},
           {"[-2, -3, 5]", "[-2, -3, -1]", {"l.yaml:21:12: cameras[2].look_at: "}},
           {"  look_at:", "  world_from_camera: [[1]]\n  look_at:", {"needs one of"}}}) {
    ExpectError("l.yaml", With(kList, from, to), parts);
  }
  ExpectError("deep.yaml", "cameras: " + std::string(9000, '['), {"deep.yaml:1", "YAML"});
  // Asked for by name, in a flow.
  const auto flow = Write("flow.yaml", "{cameras: 3}");
  EXPECT_THROW(ImportCameras(flow, "list"), renderer::IoError);
}

// --- nerfstudio ---------------------------------------------------------------------------------

using Nerfstudio = CameraFormats;

// (x, y, z) was made (x, z, -y), moved by (1, 0, 0) and doubled in size.
TEST_F(Nerfstudio, AppliedTransformIsUndone) {
  const std::string lens =
      R"("w": 200, "h": 120, "fl_x": 200, "fl_y": 400, "cx": 100.5, "cy": 60.25)";
  const std::string applied =
      R"("applied_transform": [[1,0,0,1],[0,0,1,0],[0,-1,0,0]], "applied_scale": 2,
         "ply_file_path": "sparse_pc.ply", "metres_per_unit": 0.25)";
  // Rows x, z, -y of the pose that the other tests have; then its place.
  const std::string frames =
      R"("frames": [{"file_path": "a.png", "transform_matrix":
      [[0,-1,0,-2],[1,0,0,-2],[0,0,1,6],[0,0,0,1]]}])";
  const ImportedCameras cameras =
      Read("transforms.json", "{" + lens + ", " + applied + ", " + frames + "}");
  ExpectProjectsTo(cameras.cameras[0], 150.5, 110.25);
  EXPECT_EQ(cameras.metres_per_unit, 0.5);
  ASSERT_EQ(cameras.notes.size(), 2U);
  EXPECT_NE(cameras.notes[0].find("applied_transform"), std::string::npos);
  EXPECT_NE(cameras.notes[1].find("sparse_pc.ply"), std::string::npos);
  // Nothing applied: the same bits, and no word of it.
  const ImportedCameras as_is = Read(
      "transforms.json",
      "{" + lens + R"(, "applied_transform": [[1,0,0,0],[0,1,0,0],[0,0,1,0]], )" + frames + "}");
  EXPECT_TRUE(as_is.notes.empty());
  EXPECT_EQ(as_is.cameras[0].camera.world_from_camera.translation, (Vec3{-2, -2, 6}));

  ExpectError(
      "transforms.json",
      "{" + lens + R"(, "applied_transform": [[2,0,0,0],[0,2,0,0],[0,0,2,0]], )" + frames + "}",
      {"applied_transform", "not a rotation"});
  ExpectError("transforms.json",
              "{" + lens + R"(, "applied_scale": 0, )" + frames + "}",
              {"applied_scale", "positive"});
}

// --- Metashape ----------------------------------------------------------------------------------

using Metashape = CameraFormats;

// As COLMAP's OPENCV case: f + b1 = 200 and f = 400, the principal point counts from the centre,
// and Agisoft's p1 is the other's p2.
TEST_F(Metashape, LandsOnTheKnownPixel) {
  const ImportedCameras cameras = Read("cameras.xml", kMetashape);
  EXPECT_EQ(cameras.format, "Metashape cameras");
  EXPECT_EQ(ImportCameras(top(), "auto").format, "Metashape cameras");
  ASSERT_EQ(cameras.cameras.size(), 2U);
  EXPECT_EQ(cameras.cameras[0].image, "a photo");
  EXPECT_EQ(cameras.cameras[1].image, "b.jpg");
  for (const ImportedCamera& camera : cameras.cameras) ExpectProjectsTo(camera, 166.5, 126.25);
  ASSERT_EQ(cameras.notes.size(), 1U);
  EXPECT_NE(cameras.notes[0].find("1 cameras"), std::string::npos);
  EXPECT_EQ(cameras.metres_per_unit, 0.0);
}

TEST_F(Metashape, LocalCoordinatesAreThoseOfTheComponent) {
  const std::string placed = With(kMetashape,
                                  "label=\"Component 1\">",
                                  "label=\"Component 1\"><transform><rotation>0 -1 0 1 0 0 0 0 "
                                  "1</rotation><translation>1 2 3</translation><scale>2</scale>"
                                  "</transform>");
  // A quarter turn about z, twice the size, then moved.
  const Vec3 point{1 - 2 * kPoint.y, 2 + 2 * kPoint.x, 3 + 2 * kPoint.z};
  ExpectProjectsTo(Read("cameras.xml", placed).cameras[0], 166.5, 126.25, point);
  const ImportedCameras local =
      Read("cameras.xml",
           With(placed,
                "</cameras>",
                "</cameras><reference>LOCAL_CS[\"Local Coordinates (cm)\",LOCAL_DATUM[\"L\",0],"
                "UNIT[\"centimetre\",0.01]]</reference>"));
  ExpectProjectsTo(local.cameras[0], 166.5, 126.25, point);
  EXPECT_EQ(local.metres_per_unit, 0.01);
  const ImportedCameras geographic =
      Read("cameras.xml",
           With(placed, "</cameras>", "</cameras><reference>GEOGCS[\"WGS 84\"]</reference>"));
  ExpectProjectsTo(geographic.cameras[0], 166.5, 126.25);
  EXPECT_EQ(geographic.metres_per_unit, 2.0);
}

TEST_F(Metashape, NamesFileLineAndElementOfWhatIsMalformed) {
  const std::string good = kMetashape;
  ExpectError("c.xml", With(good, "</document>", ""), {"c.xml:", "not valid XML"});
  ExpectError("c.xml", "<document/>", {"c.xml", "no document/chunk"});
  ExpectError("c.xml", With(good, "</chunk>", "</chunk><chunk/>"), {"c.xml:24", "second chunk"});
  ExpectError("c.xml", With(good, "<f>400</f>", ""), {"c.xml:8: calibration", "no f"});
  ExpectError("c.xml", With(good, "<f>400</f>", "<f>4x</f>"), {"c.xml:10: f", "'4x'"});
  ExpectError("c.xml", With(good, "<f>400</f>", "<f>1</f>"), {"calibration", "positive"});
  ExpectError("c.xml", With(good, "<b1>", "<b2>1</b2><b1>"), {"c.xml:11: b2", "not zero"});
  ExpectError("c.xml",
              With(good, "type=\"frame\">", "type=\"fisheye\">"),
              {"c.xml:5: sensor 'unknown'", "fisheye"});
  ExpectError("c.xml",
              With(good, "          <resolution width=\"200\"", "<resolution width=\"2x\""),
              {"c.xml:9: resolution", "width"});
  ExpectError("c.xml",
              With(good, "sensor_id=\"0\"", "sensor_id=\"7\""),
              {"c.xml:17: camera 'a photo'", "sensor '7'"});
  ExpectError("c.xml", With(good, "0 1 0 -2 0 0", "0 1 0 -2 0"), {"c.xml:18: transform", "15"});
  ExpectError("c.xml", With(good, "0 1 0 -2", "0 3 0 -2"), {"c.xml:18", "not a rotation"});
  ExpectError("c.xml", With(good, "0 1 0 -2", "0 1 0 1e300"), {"c.xml:18", "1e12"});
  ExpectError("c.xml",
              With(good, "component_id=\"0\"", "component_id=\"1\""),
              {"c.xml:16: cameras", "components"});
}

// --- AliceVision --------------------------------------------------------------------------------

using AliceVision = CameraFormats;

TEST_F(AliceVision, LandsOnTheKnownPixel) {
  const ImportedCameras cameras = Read("cameras.sfm", kAliceVision);
  EXPECT_EQ(cameras.format, "AliceVision SfM");
  EXPECT_EQ(ImportCameras(top(), "auto").format, "AliceVision SfM");
  EXPECT_EQ(Read("sfm_out.json", kAliceVision).format, "AliceVision SfM");
  ASSERT_EQ(cameras.cameras.size(), 1U);
  EXPECT_EQ(cameras.cameras[0].image, "a photo.jpg");
  ExpectProjectsTo(cameras.cameras[0], 166.5, 126.25);
  EXPECT_EQ(cameras.notes.size(), 1U);  // b.jpg has no pose
}

TEST_F(AliceVision, LandmarksOfThreePhotosAreSparsePoints) {
  EXPECT_TRUE(Read("cameras.sfm", kAliceVision).points.empty());
  const auto with = [](const std::string& landmarks) {
    std::string text = kAliceVision;
    return text.insert(text.rfind('}'), ", \"structure\": [" + landmarks + "]");
  };
  const std::string two = R"({"X": ["1.5", "-2", 3], "observations": [{}, {}, {}]},
                             {"X": ["4", "5", "6"], "observations": [{}, {}]})";
  const ImportedCameras cameras = Read("cameras.sfm", with(two));
  EXPECT_EQ(cameras.points, top() / "cameras.sfm");
  const std::vector<Vec3> points = ReadSparsePoints(cameras.points);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0], Vec3(1.5, -2, 3));
  EXPECT_TRUE(Read("cameras.sfm", with("")).points.empty());
  const auto path = Write("cameras.sfm", with(R"({"X": ["1", "2", "nan"]})"));
  try {
    static_cast<void>(ReadSparsePoints(path));
    ADD_FAILURE() << "not a number";
  } catch (const renderer::IoError& error) {
    EXPECT_NE(std::string(error.what()).find("structure[0].X"), std::string::npos) << error.what();
  }
}

TEST_F(AliceVision, OlderVersionsMeanOtherThings) {
  const std::string focal = R"("focalLength": "36", "pixelRatio": "2")";
  const std::string centre = R"(["0.5", "0.25"])";
  const auto expect = [&](const std::string& version, const std::string& f, const std::string& c) {
    const std::string text =
        With(With(With(kAliceVision, R"("1", "2", "6")", version), focal, f), centre, c);
    ExpectProjectsTo(Read("cameras.sfm", text).cameras[0], 166.5, 126.25);
  };
  expect(R"("1", "2", "2")", R"("focalLength": "36", "pixelRatio": "0.5")", centre);
  expect(R"("1", "2", "1")", R"("pxFocalLength": ["200", "400"])", centre);
  expect(R"("1", "2", "0")", R"("pxFocalLength": ["200", "400"])", R"(["100.5", "60.25"])");
  const std::string one = With(With(With(With(kAliceVision, R"("1", "2", "6")", R"("1", "0", "0")"),
                                         focal,
                                         R"("pxFocalLength": "200")"),
                                    centre,
                                    R"(["100.5", "60.25"])"),
                               R"("brown")",
                               R"("radial3")");
  ExpectProjectsTo(
      Read("cameras.sfm", With(one, R"("1.6384", "0", "0.16", "0.32")", R"("1.6384", "20.97152")"))
          .cameras[0],
      100.5 + 51.5,  // a factor of 1.03
      60.25 + 25.75);
}

TEST_F(AliceVision, NamesFileAndElementOfWhatIsMalformed) {
  const std::string good = kAliceVision;
  ExpectError("c.sfm", "{\n", {"c.sfm:2", "not valid JSON"});
  ExpectError("c.sfm", "[]", {"c.sfm", "object"});
  ExpectError("c.sfm", With(good, R"("1", "2", "6")", R"("2", "0", "0")"), {"version", "only 1"});
  ExpectError("c.sfm", With(good, R"("poses")", R"("posed")"), {"poses is missing"});
  ExpectError("c.sfm",
              With(good, R"("brown")", R"("fisheye4")"),
              {"intrinsics[0]", "fisheye4", "undistort"});
  ExpectError("c.sfm", With(good, R"(, "0.32")", ""), {"distortionParams", "5 numbers, not 4"});
  ExpectError("c.sfm",
              With(good, R"("focalLength": "36")", R"("focalLength": "wide")"),
              {"intrinsics[0].focalLength", "\"wide\""});
  ExpectError("c.sfm",
              With(good, R"("sensorWidth": "36")", R"("sensorWidth": "0")"),
              {"intrinsics[0]", "positive"});
  ExpectError("c.sfm",
              With(good, R"("intrinsicId": "9", "path")", R"("intrinsicId": "8", "path")"),
              {"views[0]", "intrinsic 8"});
  ExpectError("c.sfm",
              With(good, R"("viewId": "5",)", R"("viewId": "5", "rigId": "1",)"),
              {"views[0]", "rigs"});
  ExpectError("c.sfm",
              With(good, R"(["0", "1", "0", "0")", R"(["1", "1", "0", "0")"),
              {"poses[0].pose.transform.rotation", "not a rotation"});
  ExpectError("c.sfm", With(good, R"(["-2", "-3")", R"(["1e300", "-3")"), {"center", "1e12"});
  ExpectError("c.sfm",
              With(good, R"("poseId": "5", "pose")", R"("poseId": "4", "pose")"),
              {"no view has a pose"});
}

}  // namespace
}  // namespace pathfit::optim::camera_formats_test
