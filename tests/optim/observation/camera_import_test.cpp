#include "optim/observation/camera_import.h"

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/optim/observation/observation_files.h"

namespace pathfit::optim::camera_import_test {
namespace {

using renderer::CameraModel;
using renderer::IoError;
using renderer::Projection;

constexpr double kPixelTolerance = 1e-9;

// The pose of all cases turns the axes cyclically, x_camera = (Z, X, Y) + (1, 2, 3), so this point
// has the coordinates (0.5, 0.25, 2) in a camera with y down and z forward: u = 1/4, v = 1/8, r^2 =
// 5/64.
constexpr renderer::Vec3 kPoint{-1.75, -1.0, -0.5};
constexpr const char* kColmapPose = "0.5 0.5 0.5 0.5 1 2 3";
constexpr const char* kMatrix = "[[0,-1,0,-2],[0,0,-1,-3],[1,0,0,-1],[0,0,0,1]]";

void ExpectProjectsTo(const ImportedCamera& camera, double u, double v) {
  const CameraModel model(camera.camera);
  const std::optional<Projection> p = model.Project(kPoint);
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->u, u, kPixelTolerance);
  EXPECT_NEAR(p->v, v, kPixelTolerance);
  EXPECT_NEAR(p->depth, 2.0, 1e-12);
  const renderer::Ray ray = model.RayThrough(u, v);
  EXPECT_NEAR(Norm(Cross(ray.direction, kPoint - ray.origin)), 0.0, 1e-9);
}

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const IoError& error) {
    return error.what();
  }
  return "(no error)";
}

void ExpectContains(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
  }
}

/// A model in files that end in `ending`.
class ColmapFiles : public ::testing::Test {
 protected:
  explicit ColmapFiles(const std::string& ending)
      : cameras_name_("cameras" + ending), images_name_("images" + ending) {}
  void Write(const std::string& cameras, const std::string& images) {
    folder_.WriteText(cameras_name_, cameras);
    folder_.WriteText(images_name_, images);
  }
  ImportedCameras Read() { return ReadColmapModel(folder_.path() / cameras_name_); }
  void ExpectError(const std::string& cameras,
                   const std::string& images,
                   const std::vector<std::string>& parts) {
    Write(cameras, images);
    ExpectContains(MessageOf([&] { Read(); }), parts);
  }

  TempFolder folder_;

 private:
  std::string cameras_name_, images_name_;
};

class ColmapText : public ColmapFiles {
 protected:
  ColmapText() : ColmapFiles(".txt") {}
  void ExpectModel(const std::string& model_and_parameters, double u, double v) {
    Write("# comment\n7 " + model_and_parameters + "\n",
          std::string("1 ") + kColmapPose + " 7 a photo.jpg\n\n");
    const ImportedCameras cameras = Read();
    ASSERT_EQ(cameras.cameras.size(), 1U);
    EXPECT_EQ(cameras.cameras[0].image, "a photo.jpg");
    ExpectProjectsTo(cameras.cameras[0], u, v);
  }

  const std::string good_cameras_ = "7 SIMPLE_PINHOLE 200 120 200 100.5 60.25\n";
  const std::string good_images_ = std::string("1 ") + kColmapPose + " 7 a.jpg\n\n";
};

TEST_F(ColmapText, SimplePinholeLandsOnTheKnownPixel) {
  ExpectModel("SIMPLE_PINHOLE 200 120 200 100.5 60.25", 150.5, 85.25);
}
TEST_F(ColmapText, PinholeLandsOnTheKnownPixel) {
  ExpectModel("PINHOLE 200 120 200 400 100.5 60.25", 150.5, 110.25);
}
TEST_F(ColmapText, SimpleRadialLandsOnTheKnownPixel) {
  ExpectModel("SIMPLE_RADIAL 200 120 200 100.5 60.25 0.128", 151.0, 85.5);  // factor 1.01
}
TEST_F(ColmapText, RadialLandsOnTheKnownPixel) {
  ExpectModel("RADIAL 200 120 200 100.5 60.25 0.128 1.6384", 151.5, 85.75);  // factor 1.02
}
TEST_F(ColmapText, OpencvLandsOnTheKnownPixel) {
  // Tangential terms add (0.01 + 0.065, 0.0175 + 0.02) to (0.255, 0.1275).
  ExpectModel("OPENCV 200 120 200 400 100.5 60.25 0.128 1.6384 0.16 0.32", 166.5, 126.25);
}

TEST_F(ColmapText, KeepsImagesApartByTheirPointLines) {
  Write(good_cameras_,
        std::string("# c\n1 ") + kColmapPose +
            " 7 a.jpg\n1.5 2.5 -1 3 4 17\n\n2 1 0 0 0 0 0 0 7 b.jpg");
  const ImportedCameras cameras = Read();
  ASSERT_EQ(cameras.cameras.size(), 2U);
  EXPECT_EQ(cameras.cameras[1].image, "b.jpg");
  EXPECT_EQ(cameras.cameras[1].camera.world_from_camera.linear.y, (renderer::Vec3{0.0, -1.0, 0.0}));
}

TEST_F(ColmapText, FullOpencvWithoutDenominatorLandsOnTheKnownPixel) {
  // As OPENCV, with 0.01 more of the radial factor.
  ExpectModel("FULL_OPENCV 200 120 200 400 100.5 60.25 0.128 1.6384 0.16 0.32 20.97152 0 0 0",
              167.0,
              126.75);
}

TEST_F(ColmapText, RefusesOtherLensModelsWithTheWaysOut) {
  ExpectError(
      "3 OPENCV_FISHEYE 200 120 200 200 100 60 0 0 0 0\n",
      good_images_,
      {"cameras.txt:1", "camera 3", "OPENCV_FISHEYE", "OPENCV", "image_undistorter", "leave out"});
  ExpectError("3 FULL_OPENCV 200 120 200 200 100 60 0 0 0 0 0 0 0.1 0\n",
              good_images_,
              {"cameras.txt:1", "camera 3", "k5", "FULL_OPENCV", "image_undistorter"});
}

TEST_F(ColmapText, RefusesPlacesBeyondTheRayCastersReach) {
  for (const char* far : {"1e30", "1e300"}) {
    ExpectError(good_cameras_,
                std::string("1 1 0 0 0 ") + far + " 0 0 7 a.jpg\n\n",
                {"images.txt:1", "beyond 1e12"});
  }
}

TEST_F(ColmapText, NamesFileAndLineOfWhatIsMalformed) {
  ExpectError("", good_images_, {"cameras.txt", "no camera"});
  ExpectError("7 PINHOLE 200 120 200\n", good_images_, {"cameras.txt:1", "missing"});
  ExpectError(
      "\n7 SIMPLE_PINHOLE 200 120 200 1 1 1\n", good_images_, {"cameras.txt:2", "more than the 3"});
  ExpectError(
      "7 SIMPLE_PINHOLE 200 120 nan 1 1\n", good_images_, {"cameras.txt:1", "'nan'", "finite"});
  ExpectError("7 SIMPLE_PINHOLE 200 120 -5 1 1\n", good_images_, {"cameras.txt:1", "positive"});
  ExpectError("7 SIMPLE_PINHOLE 0 120 5 1 1\n", good_images_, {"cameras.txt:1", "width 0"});
  ExpectError(
      "x SIMPLE_PINHOLE 9 9 5 1 1\n", good_images_, {"cameras.txt:1", "'x'", "whole number"});
  ExpectError(good_cameras_ + good_cameras_, good_images_, {"cameras.txt:2", "twice"});
  ExpectError(good_cameras_, "", {"images.txt", "no image"});
  ExpectError(
      good_cameras_, "1 1 0 0 0 0 0 0 8 a.jpg\n\n", {"images.txt:1", "camera 8", "cameras.txt"});
  ExpectError(good_cameras_, "1 1 0 0 0 0 0 0 7\n\n", {"images.txt:1", "name is missing"});
  ExpectError(good_cameras_, "1 1 0 0 0 0 0\n\n", {"images.txt:1", "translation is missing"});
  ExpectError(
      good_cameras_, "1 0.9 0 0 0 0 0 0 7 a.jpg\n\n", {"images.txt:1", "quaternion", "0.9"});
  ExpectError(good_cameras_,
              "1 1 0 0 0 0 0 0 7 a.jpg\n2 1 0 0 0 0 0 0 7 b.jpg\n",
              {"images.txt:2", "2D points"});
}

/// Little-endian numbers one after the other, as COLMAP writes them.
class ColmapBinary : public ColmapFiles {
 protected:
  ColmapBinary() : ColmapFiles(".bin") {}
  template <class... Values>
  static std::string Bytes(Values... values) {
    std::string bytes;
    (bytes.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
    return bytes;
  }
  static std::string OneCamera(std::uint32_t id,
                               std::int32_t model,
                               const std::vector<double>& lens) {
    std::string bytes = Bytes(std::uint64_t{1}, id, model, std::uint64_t{200}, std::uint64_t{120});
    for (const double number : lens) bytes += Bytes(number);
    return bytes;
  }
  static std::string Image(std::uint32_t id, double w, std::uint32_t camera, std::string name) {
    std::string bytes = Bytes(id, w, 0.5, 0.5, 0.5, 1.0, 2.0, 3.0, camera);
    bytes.append(name.c_str(), name.size() + 1);
    // Two points: x, y and the id of the 3D point each.
    return bytes + Bytes(std::uint64_t{2}, 1.5, 2.5, ~std::uint64_t{0}, 3.5, 4.5, std::uint64_t{9});
  }
  static std::string Images(const std::vector<std::string>& images) {
    std::string bytes = Bytes(std::uint64_t{images.size()});
    for (const std::string& image : images) bytes += image;
    return bytes;
  }

  const std::string good_cameras_ = OneCamera(7, 0, {200.0, 100.5, 60.25});
  const std::string good_images_ = Images({Image(1, 0.5, 7, "a.jpg")});
};

class ColmapPoints : public ColmapBinary {
 protected:
  TempFolder own_;
  std::vector<renderer::Vec3> Points(const std::string& name, const std::string& text) {
    return ReadColmapPoints(own_.WriteText(name, text));
  }
  void ExpectNoPoints(const std::string& name,
                      const std::string& text,
                      const std::vector<std::string>& parts) {
    std::string message = "(no error)";
    try {
      static_cast<void>(Points(name, text));
    } catch (const renderer::IoError& error) {
      message = error.what();
    }
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
    }
  }
};

TEST_F(ColmapPoints, OfTextAreThoseOfNoTrackOrOfThreePhotos) {
  const std::vector<renderer::Vec3> points = Points("points3D.txt",
                                                    "# 3D points\n"
                                                    "1 1.5 -2 3e0 194 0 255 0.182\n"
                                                    "7 4 5 6 1 2 3 0.5 1 10 2 20\n\n"
                                                    "8 7 8 9 1 2 3 0.5 1 10 2 20 3 30\n");
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0], renderer::Vec3(1.5, -2, 3));
  EXPECT_EQ(points[1], renderer::Vec3(7, 8, 9));
  EXPECT_TRUE(Points("points3D.txt", "# none\n").empty());
  ExpectNoPoints("points3D.txt", "1 1 2 nan 1 2 3 0.1\n", {"points3D.txt:1", "position", "nan"});
  ExpectNoPoints("points3D.txt", "\n1 1 2\n", {"points3D.txt:2", "position", "missing"});
  ExpectNoPoints("points3D.txt", "1 1 2 3 1 2 3 0.1 4\n", {"number of the 2D point is missing"});
  ExpectNoPoints("points3D.txt", "1 1 2 1e300 1 2 3 0.1\n", {"points3D.txt:1"});
}

TEST_F(ColmapPoints, OfBinaryFilesToo) {
  const auto point = [](std::uint64_t id, renderer::Vec3 at, std::uint64_t photos) {
    std::string bytes = Bytes(id, at.x, at.y, at.z);
    bytes += std::string("\1\2\3", 3) + Bytes(std::nan(""), photos);
    return bytes + std::string(8 * photos, '\0');
  };
  const std::string two =
      Bytes(std::uint64_t{2}) + point(1, {1.5, -2, 3}, 3) + point(9, {4, 5, 6}, 2);
  const std::vector<renderer::Vec3> points = Points("points3D.bin", two);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0], renderer::Vec3(1.5, -2, 3));
  ExpectNoPoints("points3D.bin", two.substr(0, two.size() - 1), {"point 9", "ends too early"});
  ExpectNoPoints("points3D.bin", two + "x", {"1 bytes are left over"});
  ExpectNoPoints("points3D.bin", Bytes(std::uint64_t{1}) + point(1, {1e300, 0, 0}, 3), {"point 1"});
}

TEST_F(ColmapBinary, LensesLandOnTheKnownPixels) {
  const struct {
    std::int32_t model;
    std::vector<double> lens;
    double u, v;
  } cases[] = {
      {0, {200, 100.5, 60.25}, 150.5, 85.25},
      {1, {200, 400, 100.5, 60.25}, 150.5, 110.25},
      {2, {200, 100.5, 60.25, 0.128}, 151.0, 85.5},
      {3, {200, 100.5, 60.25, 0.128, 1.6384}, 151.5, 85.75},
      {4, {200, 400, 100.5, 60.25, 0.128, 1.6384, 0.16, 0.32}, 166.5, 126.25},
      {6, {200, 400, 100.5, 60.25, 0.128, 1.6384, 0.16, 0.32, 20.97152, 0, 0, 0}, 167.0, 126.75}};
  for (const auto& c : cases) {
    Write(OneCamera(7, c.model, c.lens),
          Images({Image(3, 0.5, 7, "a photo.jpg"), Image(4, 0.5, 7, "b.jpg")}));
    const ImportedCameras cameras = Read();
    ASSERT_EQ(cameras.cameras.size(), 2U);
    EXPECT_EQ(cameras.cameras[0].image, "a photo.jpg");
    EXPECT_EQ(cameras.cameras[1].image, "b.jpg");
    for (const ImportedCamera& camera : cameras.cameras) ExpectProjectsTo(camera, c.u, c.v);
  }
}

TEST_F(ColmapBinary, RefusesOtherLensModelsByName) {
  ExpectError(OneCamera(3, 5, {200, 200, 100, 60, 0, 0, 0, 0}),
              good_images_,
              {"cameras.bin: camera 3", "OPENCV_FISHEYE", "image_undistorter"});
  ExpectError(OneCamera(3, 99, {}), good_images_, {"cameras.bin: camera 3", "number 99"});
}

TEST_F(ColmapBinary, NamesFileAndImageOfWhatIsMalformed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ExpectError(Bytes(std::uint64_t{0}), good_images_, {"cameras.bin", "no camera"});
  ExpectError(good_cameras_ + "x", good_images_, {"cameras.bin", "1 bytes are left over"});
  ExpectError(good_cameras_.substr(0, 40), good_images_, {"cameras.bin: camera 7", "too early"});
  ExpectError(OneCamera(7, 0, {nan, 1, 1}), good_images_, {"camera 7", "finite", "byte 32"});
  ExpectError(OneCamera(7, 0, {-1, 1, 1}), good_images_, {"camera 7", "positive"});
  ExpectError(good_cameras_, Bytes(std::uint64_t{0}), {"images.bin", "no image"});
  ExpectError(good_cameras_, Bytes(~std::uint64_t{0}), {"images.bin", "too early"});
  ExpectError(good_cameras_, Images({Image(5, 0.4, 7, "a.jpg")}), {"image 5", "quaternion"});
  ExpectError(
      good_cameras_, Images({Image(5, 0.5, 8, "a.jpg")}), {"image 5", "camera 8", "cameras.bin"});
  ExpectError(good_cameras_, Images({Image(5, 0.5, 7, "")}), {"image 5", "name is missing"});
  // Every prefix is refused, and a number of points that overflows is one of them.
  for (std::size_t size = 0; size < good_images_.size(); ++size) {
    ExpectError(good_cameras_, good_images_.substr(0, size), {"images.bin", "too early"});
  }
  std::string many = good_images_;
  many.replace(many.size() - 56, 8, Bytes(~std::uint64_t{0} / 2));
  ExpectError(good_cameras_, many, {"image 1", "too early"});
}

TEST_F(ColmapBinary, ComesBeforeTextUnlessThatIsNamed) {
  Write(good_cameras_, good_images_);
  folder_.WriteText("cameras.txt", "7 SIMPLE_PINHOLE 200 120 200 100.5 60.25\n");
  folder_.WriteText("images.txt", std::string("1 ") + kColmapPose + " 7 of_text.jpg\n\n");
  EXPECT_EQ(ImportCameras(folder_.path(), "auto").cameras[0].image, "a.jpg");
  EXPECT_EQ(ImportCameras(folder_.path() / "images.txt", "auto").cameras[0].image, "of_text.jpg");
}

class TransformsJson : public ::testing::Test {
 protected:
  ImportedCameras ReadText(const std::string& text) {
    folder_.WriteText("transforms.json", text);
    return ReadTransformsJson(folder_.path() / "transforms.json");
  }
  /// One frame with the keys before and inside `frames`.
  ImportedCameras ReadFrame(const std::string& global, const std::string& frame) {
    return ReadText("{" + global + "\"frames\": [{\"file_path\": \"a.png\", " + frame + "}]}");
  }
  void ExpectError(const std::string& global,
                   const std::string& frame,
                   const std::vector<std::string>& parts) {
    ExpectContains(MessageOf([&] { ReadFrame(global, frame); }), parts);
  }

  TempFolder folder_;
  const std::string pose_ = std::string("\"transform_matrix\": ") + kMatrix;
  const std::string size_ = "\"w\": 200, \"h\": 120, ";
  const std::string pinhole_ =
      size_ + "\"fl_x\": 200, \"fl_y\": 400, \"cx\": 100.5, \"cy\": 60.25, ";
};

TEST_F(TransformsJson, PinholeLandsOnTheKnownPixel) {
  ExpectProjectsTo(ReadFrame(pinhole_, pose_).cameras[0], 150.5, 110.25);
  ExpectProjectsTo(ReadFrame("", pinhole_ + pose_).cameras[0], 150.5, 110.25);
}

TEST_F(TransformsJson, FrameOverridesTheFile) {
  ExpectProjectsTo(ReadFrame(pinhole_, "\"fl_y\": 200, " + pose_).cameras[0], 150.5, 85.25);
}

TEST_F(TransformsJson, OpencvDistortionLandsOnTheKnownPixel) {
  const std::string lens =
      "\"camera_model\": \"OPENCV\", \"k1\": 0.128, \"k2\": 1.6384, \"p1\": 0.16, \"p2\": 0.32, "
      "\"k4\": 0, ";
  ExpectProjectsTo(ReadFrame(pinhole_ + lens, pose_).cameras[0], 166.5, 126.25);
  const std::string third = "\"k1\": 0.128, \"k2\": 1.6384, \"k3\": 20.97152, ";  // factor 1.03
  ExpectProjectsTo(ReadFrame(pinhole_ + third, pose_).cameras[0], 152.0, 111.75);
}

TEST_F(TransformsJson, ViewAngleIsCompletedFromThePhoto) {
  const ImportedCamera camera =
      ReadFrame("\"camera_angle_x\": 0.9272952180016122, ", pose_).cameras[0];
  EXPECT_EQ(camera.camera.width, 0);
  const renderer::Camera complete = CompleteCamera(camera, 200, 120);
  EXPECT_NEAR(complete.fx, 200.0, 1e-9);  // half the angle has the tangent 1/2
  EXPECT_NEAR(complete.fy, 200.0, 1e-9);
  EXPECT_EQ(complete.cx, 100.0);
  EXPECT_EQ(complete.cy, 60.0);
  EXPECT_EQ(complete.height, 120);
  const std::string both =
      "\"camera_angle_x\": 0.9272952180016122, \"camera_angle_y\": 0.9272952180016122, ";
  EXPECT_NEAR(CompleteCamera(ReadFrame(both, pose_).cameras[0], 200, 120).fy, 120.0, 1e-9);
}

TEST_F(TransformsJson, AFocalLengthOfTheFrameItselfIsTheWholeOfIt) {
  const renderer::Camera own = ReadFrame(pinhole_, "\"fl_x\": 300, " + pose_).cameras[0].camera;
  EXPECT_EQ(own.fx, 300.0);
  EXPECT_EQ(own.fy, 300.0) << "not the file's";
  const ImportedCamera angle =
      ReadFrame(pinhole_, "\"camera_angle_x\": 0.9272952180016122, " + pose_).cameras[0];
  EXPECT_NEAR(CompleteCamera(angle, 1, 1).fx, 200.0, 1e-9);
  EXPECT_NEAR(CompleteCamera(angle, 1, 1).fy, 200.0, 1e-9);
}

TEST_F(TransformsJson, NearlyOrthonormalPosesAreMadeExact) {
  const std::string pose =
      "\"transform_matrix\": [[0,-1.00003,0,-2],[0,0.00002,-1,-3],[0.99998,0,0,-1],[0,0,0,1]]";
  const renderer::Mat3 m = ReadFrame(pinhole_, pose).cameras[0].camera.world_from_camera.linear;
  EXPECT_NEAR(Dot(m.x, m.x), 1.0, 1e-15);
  EXPECT_NEAR(Dot(m.y, m.y), 1.0, 1e-15);
  EXPECT_NEAR(Dot(m.y, m.z), 0.0, 1e-15);
  EXPECT_NEAR(Determinant(m), 1.0, 1e-15);
}

TEST_F(TransformsJson, KeepsMaskPathsAndScale) {
  const ImportedCameras cameras =
      ReadFrame(pinhole_ + "\"metres_per_unit\": 0.25, ", "\"mask_path\": \"m/a.png\", " + pose_);
  EXPECT_EQ(cameras.cameras[0].mask, "m/a.png");
  EXPECT_EQ(cameras.metres_per_unit, 0.25);
  EXPECT_EQ(cameras.cameras[0].camera.world_from_camera.translation,
            (renderer::Vec3{-2.0, -3.0, -1.0}));
}

TEST_F(TransformsJson, NamesTheKeyOfWhatIsMalformed) {
  ExpectContains(MessageOf([&] { ReadText("{\n\"frames\": [\n{,}]}"); }),
                 {"transforms.json:3", "byte"});
  ExpectContains(MessageOf([&] { ReadText(""); }), {"transforms.json:1", "not valid JSON"});
  ExpectContains(MessageOf([&] { ReadText("{\"w\": 1e999}"); }),
                 {"transforms.json", "out of range"});
  ExpectContains(MessageOf([&] { ReadText("[1]"); }), {"object"});
  ExpectContains(MessageOf([&] { ReadText("{\"frames\": []}"); }), {"frames", "at least one"});
  ExpectContains(MessageOf([&] { ReadText("{\"frames\": [3]}"); }), {"frames[0]", "object"});
  ExpectContains(MessageOf([&] { ReadText("{\"frames\": [{}]}"); }),
                 {"frames[0].file_path", "missing"});
  ExpectError(pinhole_, "\"x\": 0", {"frames[0].transform_matrix", "missing"});
  ExpectError(pinhole_, "\"transform_matrix\": [[1]]", {"frames[0].transform_matrix", "4 rows"});
  ExpectError(pinhole_, "\"transform_matrix\": [[1],[1],[1]]", {"transform_matrix[0]", "four"});
  ExpectError(pinhole_,
              "\"transform_matrix\": [[1,0,0,0],[0,1,0,1e300],[0,0,1,0],[0,0,0,1]]",
              {"frames[0]", "beyond 1e12"});
  ExpectError(pinhole_,
              "\"transform_matrix\": [[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]",
              {"frames[0].transform_matrix", "not a rotation", "determinant 8"});
  ExpectError(pinhole_,
              "\"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]",
              {"not a rotation", "determinant -1"});
  ExpectError(pinhole_,
              "\"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,2]]",
              {"last row 0 0 0 1"});
  for (const std::string far : {"1e30", "-1e300"}) {
    ExpectError(pinhole_,
                "\"transform_matrix\": [[1,0,0,0],[0,1,0," + far + "],[0,0,1,0],[0,0,0,1]]",
                {"frames[0].transform_matrix", "beyond 1e12"});
  }
  ExpectError(size_, pose_, {"frames[0]", "no focal length", "fl_x", "camera_angle_x"});
  ExpectError("\"fl_x\": -1, ", pose_, {"fl_x", "positive"});
  ExpectError("\"fl_x\": \"wide\", ", pose_, {"(file).fl_x", "\"wide\"", "finite number"});
  ExpectError("\"fl_x\": 200, \"w\": 10.5, \"h\": 3, ", pose_, {"w", "10.5", "image size"});
  ExpectError("\"fl_x\": 200, \"w\": 10, ", pose_, {"w and h"});
  ExpectError("\"fl_x\": 200, \"cx\": 10, ", pose_, {"cx and cy"});
  ExpectError("\"camera_angle_x\": 3.5, ", pose_, {"camera_angle_x", "below pi"});
  ExpectError(pinhole_ + "\"metres_per_unit\": 0, ", pose_, {"metres_per_unit", "positive"});
}

TEST_F(TransformsJson, DeepNestingIsRefusedWithoutRecursion) {
  const std::string deep = std::string(200000, '[') + std::string(200000, ']');
  ExpectError(pinhole_ + "\"k1\": " + deep + ", ", pose_, {"k1", "a list", "finite number"});
  ExpectContains(MessageOf([&] { ReadText(deep); }), {"object"});
}

TEST_F(TransformsJson, RefusesOtherLensModelsWithTheWaysOut) {
  ExpectError(pinhole_ + "\"camera_model\": \"OPENCV_FISHEYE\", ",
              pose_,
              {"frames[0]", "OPENCV_FISHEYE", "allowed", "undistort"});
  ExpectError(pinhole_ + "\"k4\": 0.01, ", pose_, {"frames[0].k4", "fisheye", "undistort"});
  for (const std::string key : {"k6", "ftheta_p1"}) {
    ExpectError(
        pinhole_ + "\"" + key + "\": 0.01, ", pose_, {"frames[0]." + key, "fisheye", "undistort"});
  }
  ExpectError(
      pinhole_ + "\"is_fisheye\": true, ", pose_, {"frames[0].is_fisheye", "fisheye", "undistort"});
  EXPECT_NO_THROW(ReadFrame(pinhole_ + "\"is_fisheye\": false, ", pose_));
  ExpectError(pinhole_ + "\"camera_model\": \"PINHOLE\", \"k1\": 0.01, ", pose_, {"PINHOLE", "k1"});
}

TEST(ImportCameras, FindsTheFormatByWhatIsThere) {
  TempFolder folder;
  folder.WriteText("workspace/sparse/0/cameras.txt", "7 SIMPLE_PINHOLE 200 120 200 100.5 60.25\n");
  folder.WriteText("workspace/sparse/0/images.txt", "1 1 0 0 0 0 0 0 7 a.jpg\n\n");
  folder.WriteText(
      "json/transforms.json",
      std::string("{\"fl_x\": 9, \"frames\": [{\"file_path\": \"a\", \"transform_matrix\": ") +
          kMatrix + "}]}");
  EXPECT_EQ(ImportCameras(folder.path() / "workspace", "auto").format, "COLMAP model");
  EXPECT_EQ(ImportCameras(folder.path() / "workspace/sparse/0/images.txt", "auto").format,
            "COLMAP model");
  EXPECT_EQ(ImportCameras(folder.path() / "json", "auto").format, "transforms.json");
  EXPECT_EQ(ImportCameras(folder.path() / "json", "transforms").format, "transforms.json");
}

TEST(ImportCameras, SaysWhatItLookedFor) {
  TempFolder folder;
  folder.WriteText("binary/cameras.bin", "x");
  const auto message = [&](const char* name, const char* format) {
    return MessageOf([&] { ImportCameras(folder.path() / name, format); });
  };
  ExpectContains(message("nothing", "auto"), {"nothing", "no such"});
  ExpectContains(message("", "auto"), {".json", "cameras.txt", "sparse/0"});
  ExpectContains(message("", "transforms"), {"no transforms.json"});
  ExpectContains(message("", "colmap"), {"no cameras.bin or cameras.txt"});
  ExpectContains(message("binary", "auto"), {"cameras.bin", "ends too early"});
}

}  // namespace
}  // namespace pathfit::optim::camera_import_test
