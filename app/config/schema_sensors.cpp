#include "app/config/schema_builders.h"

namespace pathfit::app {
namespace {

SchemaNode PoseSchema() {
  return Map("pose",
             {Map("look_at",
                  {Vector("origin_m", "Place of the camera.").Unit("metres").Required(),
                   Vector("target_m", "What is in the middle of the picture.")
                       .Unit("metres")
                       .Required(),
                   Vector("up", "What is up in the picture.").Default("[0, 1, 0]")},
                  "Pose by what is looked at.")
                  .OneOf("pose"),
              List("world_from_camera",
                   List("", Number("", ""), "").Items(4, 4),
                   "4 rows of a rigid transform; camera: x right, y up, looking along -z.")
                  .Items(4, 4)
                  .OneOf("pose")},
             "Where the camera is.")
      .Required();
}

SchemaNode FilterSchema() {
  constexpr double kMaxRadius = 16.0;
  const std::vector<std::string> shapes = {"box", "tent", "gaussian"};
  return Either("filter",
                {Choice("", shapes, ""),
                 Map("",
                     {Choice("type", shapes, "Shape.").Required(),
                      Number("radius_px", "Half its width.")
                          .From(0.5, kMaxRadius)
                          .Unit("pixels")
                          .DefaultIs("1 for a tent, 2 for a Gaussian")
                          .When("type", {"tent", "gaussian"}),
                      Number("sigma_px", "Standard deviation; it is cut at the radius.")
                          .From(0.1, kMaxRadius)
                          .Unit("pixels")
                          .Default("0.5")
                          .When("type", {"gaussian"})},
                     "")},
                "How samples become pixels: `box` is the mean over the pixel, `tent` and "
                "`gaussian` reach into its neighbours. A name, or a map of the following.")
      .Default("box");
}

SchemaNode DistortionSchema() {
  const auto coefficient = [](const char* key) {
    return Number(key, "Coefficient of OpenCV's model.").Default("0");
  };
  return Map("distortion",
             {coefficient("k1"),
              coefficient("k2"),
              coefficient("k3"),
              coefficient("p1"),
              coefficient("p2")},
             "Brown's lens distortion.")
      .Always()
      .When("type", {"perspective"});
}

}  // namespace

SchemaNode SensorsSchema() {
  return NamedMap(
      "sensors",
      "SENSOR",
      Map("",
          {Choice("type",
                  {"perspective", "orthographic"},
                  "`orthographic`: parallel rays from the plane of the camera.")
               .Default("perspective"),
           Size("size_px", "Size of the whole picture.").Required(),
           Either("focal_px",
                  {Number("", "").Above(0.0), List("", Number("", "").Above(0.0), "").Items(2, 2)},
                  "Focal length, or one for x and one for y.")
               .Unit("pixels")
               .OneOf("focal")
               .When("type", {"perspective"}),
           Number("fov_deg", "Angle of view.")
               .Between(0.0, 180.0)
               .Unit("degrees")
               .OneOf("focal")
               .When("type", {"perspective"}),
           Choice("fov_axis",
                  {"x", "y", "smaller", "larger", "diagonal"},
                  "Along which side of the picture `fov_deg` is measured.")
               .Default("smaller")
               .Needs("fov_deg")
               .When("type", {"perspective"}),
           Number("height_m", "Height of what is seen; pixels are square.")
               .Above(0.0)
               .Unit("metres")
               .Required()
               .When("type", {"orthographic"}),
           List("principal_point_px",
                Number("", ""),
                "From the top-left corner of the picture; the first pixel's centre is 0.5, 0.5.")
               .Items(2, 2)
               .Unit("pixels")
               .DefaultIs("middle of the picture"),
           DistortionSchema(),
           PoseSchema(),
           List("crop_px", Integer("", "").From(0, 32768), "Part to render: x, y, width, height.")
               .Items(4, 4)
               .Unit("pixels")
               .DefaultIs("the whole picture"),
           FilterSchema(),
           Number("exposure_ev", "Brightness factor as a power of two.")
               .From(-20, 20)
               .Unit("EV")
               .Default("0")},
          "A camera."),
      "Cameras of a scene without photos.");
}

}  // namespace pathfit::app
